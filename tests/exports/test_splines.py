"""Smooth curves through the knots: continuous to the second derivative, and clear of everything."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stplan.errors import UsageError
from stplan.exports.settings import ExportSettings
from stplan.exports.splines import splines_bytes
from stplan.viewing.run_view import open_run
from tests.viewing.runs import hall_run, write_run

HEAD = "stplan: 1\nname: two\nhorizon: 12\ndefaults: {radius: 0.5}\n"
BENT = np.array([[0.0, 0.0, 0.0], [4.0, 1.0, 3.0], [7.0, -1.0, 6.0], [10.0, 0.0, 10.0]])


def splines(folder):
    document = json.loads(splines_bytes(open_run(folder), ExportSettings()))
    assert document["certificate"]["holds"]
    return {agent["agent"]: agent for agent in document["agents"]}


def run_of(tmp_path, curves, agent: str = "", other: str = "", head: str = ""):
    more = (agent, other)
    agents = "".join(
        f"  - {{id: a{k}, start: {c[0, :2].tolist()}, goal: {c[-1, :2].tolist()}{more[k]}}}\n"
        for k, c in enumerate(curves)
    )
    return write_run(tmp_path, f"{HEAD}{head}agents:\n{agents}", curves)


def at(agent, times, derivative: int = 0):
    """(T, 2) place or derivative at `times`, by numpy's own polynomials."""
    knots = np.array(agent["times"])
    found = np.empty((len(times), 2))
    for k, t in enumerate(times):
        i = int(np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2))
        for axis, name in enumerate("xy"):
            piece = np.polynomial.Polynomial(agent[name][i])
            found[k, axis] = (
                piece.deriv(derivative)(t - knots[i]) if derivative else piece(t - knots[i])
            )
    return found


def test_velocity_and_acceleration_are_continuous_and_knots_are_passed(tmp_path) -> None:
    agent = splines(run_of(tmp_path, [BENT]))["a0"]
    assert agent["curve"] == "spline"
    np.testing.assert_allclose(at(agent, BENT[:, 2]), BENT[:, :2], atol=1e-12)
    for knot in BENT[1:-1, 2]:
        for derivative in (0, 1, 2):
            before, after = at(agent, [knot - 1e-9, knot + 1e-9], derivative)
            np.testing.assert_allclose(before, after, atol=1e-7)


def test_a_spline_that_would_swing_into_another_keeps_closer_to_the_segments(tmp_path) -> None:
    """Somebody stands 1.16 m from the straight segments, 0.93 m from the spline; 1 m is asked."""
    standing = np.array([[3.2, 2.0, 0.0], [3.2, 2.0, 1.0]])
    found = splines(run_of(tmp_path, [BENT, standing]))
    closer = found["a0"]
    assert (closer["curve"], len(closer["times"])) == ("spline", 2 * len(BENT) - 1)
    further = np.array([[3.2, 2.1, 0.0], [3.2, 2.1, 1.0]])
    found = splines(run_of(tmp_path / "further", [BENT, further]))
    assert len(found["a0"]["times"]) == len(BENT)


def test_segments_stay_where_no_spline_is_clear(tmp_path) -> None:
    """Somebody stands so near a knot that any swing would touch."""
    standing = np.array([[3.8, 1.99, 0.0], [3.8, 1.99, 1.0]])
    gap = np.hypot(*(standing[0, :2] - BENT[1, :2]))
    standing[:, :2] = BENT[1, :2] + (standing[0, :2] - BENT[1, :2]) * (1.0 + 1e-7) / gap
    assert splines(run_of(tmp_path, [BENT, standing]))["a0"]["curve"] == "segments"


def test_a_spline_that_would_swing_into_a_wall_keeps_closer_to_the_segments(tmp_path) -> None:
    def points(top: float) -> int:
        head = f"map: {{rectangle: [-1, -2, 11, {top}]}}\n"
        folder = run_of(tmp_path / f"{top}", [BENT], head=head)
        return len(splines(folder)["a0"]["times"])

    assert points(1.55) > points(1.6) == len(BENT)


@pytest.mark.parametrize(
    ("limits", "kind"),
    [
        ("max_speed: 1.6", "spline"), ("max_speed: 1.5", "segments"),
        ("max_acceleration: 1.9", "spline"), ("max_acceleration: 1.8", "segments"),
    ],
)  # fmt: skip
def test_limits_are_those_of_the_spline_itself(limits: str, kind: str, tmp_path) -> None:
    agent = splines(run_of(tmp_path, [BENT], f", {limits}"))["a0"]
    assert agent["curve"] == kind
    if kind == "spline":
        times = np.linspace(0.0, 10.0, 2001)
        derivative = 1 if "speed" in limits else 2
        most = np.hypot(*at(agent, times, derivative).T).max()
        assert most <= float(limits.split(": ")[1])


def test_samples_of_splines_are_clear(tmp_path) -> None:
    """Two walk side by side, never straight: whatever is written keeps them apart."""
    rng = np.random.default_rng(5)
    points = set()
    times = np.linspace(0.0, 10.0, 2001)
    for draw in range(8):
        low, high = rng.uniform(-0.2, 0.2, (2, 11))
        high += 1.001 + 0.04 * draw - (high - low).min()
        curves = [np.column_stack([np.arange(11), y, np.arange(11)]) for y in (low, high)]
        found = splines(run_of(tmp_path / str(draw), curves))
        points |= {len(agent["times"]) for agent in found.values()}
        gap = at(found["a0"], times) - at(found["a1"], times)
        assert np.hypot(*gap.T).min() > 1.0
    assert {11, 21} <= points


def test_the_scene_has_to_be_known(tmp_path) -> None:
    folder = hall_run(tmp_path)
    (tmp_path / "scene.yaml").unlink()
    with pytest.raises(UsageError, match="--scene FILE"):
        splines_bytes(open_run(folder / "trajectories.npz"), ExportSettings())


def test_curves_that_touch_are_refused(tmp_path) -> None:
    through = np.array([[10.0, 0.0, 0.0], [0.0, 0.0, 10.0]])
    folder = run_of(tmp_path, [BENT, through])
    with pytest.raises(UsageError, match="stplan check"):
        splines_bytes(open_run(folder), ExportSettings())
