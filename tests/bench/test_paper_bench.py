"""The paper's scenes and plots: what is chosen, what is measured, and how it is shown."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from stplan.bench import deviations, paper, paper_table
from stplan.bench.named_scenes import chosen_scenes
from stplan.errors import UsageError
from stplan.scene import load_scene

SCENES = Path(__file__).parents[2] / "scenes"
NOWHERE = deviations.Snapping(0, 0.0, 0)
_chosen = partial(chosen_scenes, SCENES, small=paper.SMALL_FIGURES, every=tuple(paper.FIGURES))


def test_every_scene_of_the_paper_is_shipped() -> None:
    assert len(_chosen([], full=True)) == len(paper.FIGURES) > 20
    assert list(_chosen(["tunnel"], full=False)) == ["tunnel/tunnel"]
    with pytest.raises(UsageError, match="no scene 'moon'"):
        _chosen(["moon"], full=True)


def test_both_recipes_plan_a_scene_of_the_paper_at_about_the_same_cost() -> None:
    files = _chosen(["three-agents/symmetric"], full=True)
    (one,) = paper.compare(files, 60.0, progress=lambda line: None)
    assert one.default.figures.certified
    assert one.paper.figures.certified
    assert one.paper.figures.found_by == "dijkstra"
    assert 1.0 <= one.paper.cost / one.default.cost < 1.01
    text = paper_table.files([one], [], [], NOWHERE)["paper.md"].decode()
    assert "plans 1 of 1 scenes" in text


def test_a_plot_shows_every_way_and_how_it_grows() -> None:
    timings = [
        paper.IterationTimes(
            "paper-knots",
            size,
            dict(zip(paper.WAYS, seconds, strict=True)),
            dict(zip(paper.WAYS, (size, size**2, size**3), strict=True)),
        )
        for size, *seconds in ((30, 30e-3, 900e-6, np.nan), (60, 60e-3, 3600e-6, np.nan))
    ]
    powers = paper.growths(timings, "paper-knots")
    assert powers["default"] == pytest.approx((1.0, 1.0))
    assert powers["paper"] == pytest.approx((2.0, 2.0))
    assert powers["all pairs"] == pytest.approx((np.nan, 3.0), nan_ok=True)
    files = paper_table.files([], timings, [], NOWHERE)
    assert files["paper-knots.png"].startswith(b"\x89PNG")
    assert "| exponent" in files["paper.md"].decode()


@pytest.mark.parametrize(
    ("plot", "sizes", "power"),
    [
        ("paper-agents", (4, 8), 2.0),
        ("paper-knots", (30, 60), 2.0),
        ("paper-walls", (840, 1680), 1.0),
    ],
)
def test_the_broad_phase_saves_a_power(plot, sizes, power) -> None:
    """Counted, not timed: without it everything is listed that there is, with it what is near."""
    (sweep,) = (one for one in paper.PLOTS if one.name == plot)
    counts = [paper.count_contacts(sweep.scene(size, 0)) for size in sizes]
    grows = {way: np.log2(counts[1][way] / counts[0][way]) for way in paper.WAYS}
    assert grows["all pairs"] == pytest.approx(power, abs=0.25)
    assert grows["default"] < grows["all pairs"] - 0.25
    assert counts[1]["default"] < 0.02 * counts[1]["all pairs"]
    assert counts[1]["paper"] < 0.2 * counts[1]["all pairs"]


def test_a_deviation_is_measured_over_the_default() -> None:
    def outcome(variant: str, scene: str, cost: float, seconds: float) -> deviations.Trial:
        return deviations.Trial(variant, scene, cost, 10, seconds)

    outcomes = [
        outcome(variant, scene, 2.0, 1.0) for scene in "ab" for variant in deviations.VARIANTS
    ]
    outcomes[1] = outcome("initial curves", "a", 8.0, 4.0)
    outcomes[-1] = outcome("all of them", "b", np.nan, 1.0)
    found = {one.variant: one for one in deviations.gains(outcomes)}
    assert found[deviations.DEFAULT].cost == found[deviations.DEFAULT].seconds == 1.0
    curves = found["initial curves"]
    assert (curves.planned, curves.cost, curves.worst) == (2, pytest.approx(2.0), 4.0)
    assert curves.seconds == pytest.approx(2.0)
    assert (found["all of them"].planned, found["all of them"].cost) == (1, 1.0)
    text = deviations.deviations_text(outcomes, deviations.Snapping(4, 0.25, 1))
    assert "| initial curves " in text
    assert "up to 0.25 m away, and at 1 of them" in text


def test_every_deviation_is_a_choice_of_the_scene_that_changes_it() -> None:
    file = SCENES / "subway" / "platform.yaml"
    plain = load_scene(file)
    for variant, settings in deviations.VARIANTS.items():
        scene = load_scene(file, list(settings))
        same = (scene.solver, scene.seeding, scene.time_scale) == (
            plain.solver, plain.seeding, plain.time_scale
        )  # fmt: skip
        # A stated number is another metric than one that is chosen, even where it is the same.
        assert (same and scene.metric == plain.metric) == (variant == deviations.DEFAULT), variant


def test_meshes_have_no_vertex_where_agents_want_to_be() -> None:
    found = deviations.snap_places(_chosen(["bottleneck", "tunnel"], full=True))
    assert found.places > 0
    assert found.away > 0.01
