"""Repulsive curves: the energy's derivative, the length they take, and the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stplan.bench import repulsion
from stplan.bench.rivals import repulsive

SCENES = Path(__file__).parents[2] / "scenes"


def _apart(count, segments):
    owner, place = np.divmod(np.arange(count * segments), segments)
    near = np.abs(np.subtract.outer(place, place)) <= 1
    return ~(np.equal.outer(owner, owner) & near)


def test_the_derivative_of_the_energy_is_that_of_its_differences():
    rng = np.random.default_rng(1)
    rods = 2.0 * rng.normal(size=(3, 6, 3))
    slope = repulsive.tangent_point_energy(rods, _apart(3, 5))[1]
    step = 1e-6
    for place in [(0, 0, 0), (1, 3, 1), (2, 5, 2), (2, 2, 0)]:
        ends = []
        for sign in (1.0, -1.0):
            moved = rods.copy()
            moved[place] += sign * step
            ends.append(repulsive.tangent_point_energy(moved, _apart(3, 5))[0])
        assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(slope[place], rel=1e-6)


def test_a_straight_rod_alone_has_no_energy_and_scale_counts_as_a_power():
    straight = np.linspace(0.0, 1.0, 6)[None, :, None] * np.array([3.0, 4.0, 5.0])
    assert repulsive.tangent_point_energy(straight, _apart(1, 5))[0] == pytest.approx(
        0.0, abs=1e-12
    )
    rods = np.random.default_rng(2).normal(size=(2, 6, 3))
    once, twice = (repulsive.tangent_point_energy(k * rods, _apart(2, 5))[0] for k in (1.0, 2.0))
    assert twice / once == pytest.approx(2.0 ** (4.0 - repulsive.BETA))


@pytest.mark.parametrize("budget", [1.05, 1.2])
def test_rods_take_all_the_length_there_is(budget):
    starts, goals = np.array([[-8.0, 0.0], [8.0, 0.2]]), np.array([[8.0, 0.0], [-8.0, 0.2]])
    curves = repulsive.repel(starts, goals, np.array([12.0, 12.0]), 1.0, budget)
    for curve, start, goal in zip(curves, starts, goals, strict=True):
        assert curve[[0, -1], :2] == pytest.approx(np.array([start, goal]))
        assert np.diff(curve[:, 2]) == pytest.approx(12.0 / repulsive.SEGMENTS)
        length = np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()
        straight = np.linalg.norm(curve[-1] - curve[0])
        assert length / straight == pytest.approx(budget, rel=2e-3)


def test_the_table_has_our_plan_and_every_length():
    files = {"three-agents/symmetric": SCENES / "three-agents" / "symmetric.yaml"}
    ours, theirs = repulsion.measure(files, (1.1,), progress=lambda line: None)
    assert ours.planner == repulsion.OURS
    assert ours.length < 1.01 < theirs.length
    assert ours.mean < theirs.mean
    text = repulsion.files([ours, theirs])["repulsion.md"].decode()
    assert "rods 10 % longer" in text
