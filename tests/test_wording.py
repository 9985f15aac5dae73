"""Lengths, places and lists as one says them; reasons in words, which claim no more than is proven."""

from __future__ import annotations

import pickle
from typing import get_args

import pytest

from stplan.errors import SeedingError
from stplan.reasons import Kind, Reason
from stplan.wording import at, count, headline, in_words, metres, names, sentence, sentences

# Figures of every kind, as the seeders fill them in.
FIGURES: dict[str, dict[str, float]] = {
    "start": {"distance": 0.5, "required": 0.6},
    "goal": {"distance": 0.5, "required": 0.6},
    "not connected": {"stops": 2, "widest": 0.25, "radius": 0.3},
    "limits of time": {"latest": 20.0, "earliest": 25.5, "length": 9.0, "speed": 0.4},
    "limit of acceleration": {"latest": 20.0, "length": 9.0, "acceleration": 0.04},
    "layers": {"layers": 4},
    "order": {"orders": 7},
    "blocked": {"vertices": 125},
    "time limit": {"limit": 60.0},
    "unprepared": {"limit": 60.0},
    "time scale": {"speed": 15.0},
    "margin": {"margin": 1.2},
}


def reason(kind: str, *agents: str, proven: bool = False) -> Reason:
    return Reason(kind, agents, proven, figures=FIGURES.get(kind, {}))  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", get_args(Kind))
def test_every_kind_has_a_sentence_with_its_agents_and_figures(kind: str) -> None:
    said = sentence(reason(kind, "sam", "ann"))
    assert said == said.strip()
    general = ("time limit", "unprepared", "time scale", "method", "margin", "more time")
    assert "sam and ann" in said or kind in general
    shown = [figure for name, figure in FIGURES.get(kind, {}).items() if name != "stops"]
    assert all(f"{figure:g}" in said for figure in shown)


def test_what_was_not_found_is_not_said_to_be_impossible() -> None:
    proven, limit = (
        reason("goal", "a", "b", proven=True),
        reason("limits of time", "a", proven=True),
    )
    open_ones = [reason("layers", "a"), reason("time limit")]
    assert headline([proven]) == "no collision-free curves exist"
    assert headline([limit]) == "no curves keep the limits of the scene"
    assert headline([proven, limit]) == "no collision-free curves exist"
    assert headline([proven, *open_ones]) == "no collision-free initial curves"
    assert headline(open_ones) == "no collision-free initial curves"
    assert "not found within the limit" in sentence(open_ones[0])


def test_the_same_is_said_once() -> None:
    twice = [reason("layers", "a"), reason("layers", "b"), reason("layers", "a")]
    assert len(sentences(twice)) == 2
    assert in_words(twice).splitlines() == [
        f"no collision-free initial curves: {sentence(twice[0])}",
        f"  {sentence(twice[1])}",
    ]


def test_places_and_times_are_told_where_they_are_known() -> None:
    near = Reason("touching", ("a", "b"), place=(1.0, 2.5), times=(3.0, 4.0))
    assert "a and b still block each other near (1, 2.5) at 3.0 to 4.0 s" in sentence(near)
    many = Reason("touching", ("a", "b", "c"), figures={"pairs": 7})
    assert "7 pairs of 3 agents touch" in sentence(many)
    early = Reason("start", ("a", "b"), True, times=(0.0, 1.0), figures=FIGURES["start"])
    assert "a larger one keeps their times further apart" in sentence(early)
    assert "time_scale" not in sentence(reason("start", "a", "b"))


def test_numbers_that_differ_are_shown_to_differ() -> None:
    near = {"distance": 0.59999999, "required": 0.6}
    assert "0.59999999 m apart in space-time, not over 0.6 m" in sentence(
        Reason("start", ("a", "b"), figures=near)
    )
    assert "0.59999999 m apart, not over 0.6 m" in sentence(
        Reason("goal", ("a", "b"), figures=near)
    )
    narrow = {"stops": 2, "widest": 0.2999, "radius": 0.29991}
    said = sentence(Reason("not connected", ("a",), figures=narrow))
    assert "a radius of 0.2999 m through, the agent's is 0.29991 m" in said


@pytest.mark.parametrize("rounding", [0.0, 4e-16, -4e-16])
def test_what_is_the_same_is_not_said_to_differ(rounding: float) -> None:
    same = Reason("start", ("a", "b"), figures={"distance": 0.6 + rounding, "required": 0.6})
    text = "a and b start 0.6 m apart in space-time, and more than that is needed"
    assert sentence(same) == text


def test_cracks_and_what_closes_them() -> None:
    figures = {"stops": 2, "widest": 0.0, "radius": 0.3, "distance": 0.00132}
    said = sentence(Reason("not connected", ("a",), figures=figures))
    assert "cracks in the mesh up to 0.00132 m wide" in said
    assert said.endswith("map.weld: 0.003 closes them")


def test_waypoints_and_speeds_are_told_where_they_matter() -> None:
    late = {"latest": 5.0, "earliest": 6.0, "length": 4.0}
    visit = Reason("limits of time", ("a",), True, figures={**late, "waypoint": 2, "speed": 1.5})
    assert "have visited waypoint 2 by 5 s" in sentence(visit)
    assert "at 1.5 m/s that takes until 6 s" in sentence(visit)
    dwells = Reason("limits of time", ("a",), True, figures=late)
    assert "reach its goal by 5 s" in sentence(dwells)
    assert "m/s" not in sentence(dwells)


def test_an_error_keeps_its_reasons_in_another_process() -> None:
    error = SeedingError([reason("goal", "a", "b", proven=True)])
    again = pickle.loads(pickle.dumps(error))
    assert again.reasons == error.reasons
    assert str(again) == str(error) == in_words(error.reasons)
    assert str(pickle.loads(pickle.dumps(SeedingError("too tight")))) == "too tight"
    assert SeedingError("too tight").reasons == ()


@pytest.mark.parametrize(
    ("length", "words"),
    [
        (0.0004, "0.4 mm"),
        (0.0004501, "0.45 mm"),
        (-0.02, "-20 mm"),
        (0.09996, "100 mm"),
        (0.233333, "0.233 m"),
        (0.996, "0.996 m"),
        (1.25, "1.25 m"),
        (1.5, "1.5 m"),
        (395_300.0, "395000 m"),
        (5e-8, "0.00005 mm"),
    ],
)
def test_lengths_in_words(length, words):
    assert metres(length) == words


def test_lists_counts_and_places():
    assert names(["a"]) == "a"
    assert names(["a", "b", "c"]) == "a, b and c"
    assert names(list("abcdefg")) == "a, b, c, d and 3 more"
    assert (count(1, "agent"), count(2, "agent")) == ("1 agent", "2 agents")
    assert at((-0.001, 2.126)) == "(0, 2.13)"
    assert at((395_300.257, -9_900_000.0)) == "(395300.26, -9900000)"
    assert at((0.0000123, -0.04)) == "(0.000012, -0.04)"
