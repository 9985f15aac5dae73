"""What agents pay at least that pass a gate one after another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from stplan.analysis import queues
from stplan.analysis.gates import Gate
from stplan.analysis.queues import Passers, least_asides, queue_bound


def passers(count: int, rng: np.random.Generator, end: float = 30.0) -> Passers:
    before, after = rng.uniform(2.0, 4.0, (2, count))
    return Passers(
        stiffness=rng.uniform(0.5, 2.0, count),
        begin=rng.uniform(0.0, 5.0, count),
        end=rng.uniform(0.8, 1.0, count) * end,
        aside=rng.uniform(0.3, 0.7, count),
        before=before - 0.1,
        after=after - 0.1,
        whole=before + after,
    )


def least_by_search(own: Passers, i: int, e: float, f: float) -> float:
    """C_i(e, f) by a general solver, an agent that is not there yet or any more being cut off."""
    before, after = own.before[i] + own.aside[i], own.after[i] + own.aside[i]
    asked = np.array([2 * own.aside[i], before, after, own.whole[i]])
    rows = np.array([[0, 1, 0], [1, 1, 0], [0, 1, 1], [1, 1, 1]])
    e, f = np.clip([e, f], own.begin[i], own.end[i])
    spans = np.array([e - own.begin[i], f - e, own.end[i] - f])
    # In lengths over roots of durations: the nearest point of a polyhedron to the origin.
    rows = rows * np.sqrt(spans)
    found = minimize(
        lambda y: y @ y,
        np.full(3, 10.0),
        jac=lambda y: 2.0 * y,
        constraints={"type": "ineq", "fun": lambda y: rows @ y - asked, "jac": lambda y: rows},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 200},
    )
    return own.stiffness[i] * found.fun


@pytest.mark.parametrize("seed", range(3))
def test_functions_below_the_least_cost_are_below_and_touch_it(seed):
    rng = np.random.default_rng(seed)
    own = passers(3, rng)
    pieces = queues._Pieces.of(own, 24)
    edges = own.begin.min() + pieces.width * np.arange(25)
    for _ in range(60):
        i, p = int(rng.integers(3)), int(rng.integers(len(pieces.first)))
        spot = rng.uniform(0.0, 1.0, 2) if rng.random() < 0.7 else pieces.at[i, p]
        e, f = edges[pieces.first[p]], edges[pieces.last[p]]
        e, f = e + spot[0] * pieces.width, f + spot[1] * pieces.width
        if f <= e + 0.05 or f <= own.begin[i] or e >= own.end[i]:
            continue
        true = least_by_search(own, i, e, f)
        assert pieces.least[i, p] <= true * (1.0 + 1e-6)
        if pieces.whole[i, p]:
            moved = (spot - pieces.at[i, p]) @ pieces.slopes[i, p] * pieces.width
            low = pieces.value[i, p] + moved
            assert low <= true * (1.0 + 1e-6)
            if (spot == pieces.at[i, p]).all():
                assert low == pytest.approx(true, rel=2e-2)


def schedule_cost(own: Passers, times: np.ndarray) -> float:
    """Of passing one after another at `times`, the first and last keeping their distance as they like."""
    order = np.argsort(times)
    total = 0.0
    for place, i in enumerate(order):
        e = times[order[place - 1]] if place else own.begin[i]
        f = times[order[place + 1]] if place + 1 < len(order) else own.end[i]
        # At the ends of the queue any instants that are good for the agent.
        options = [(e, f)]
        if not place:
            options += [(x, f) for x in np.linspace(own.begin[i], times[i], 12)]
        if place + 1 == len(order):
            options += [
                (first, y) for first, _ in options for y in np.linspace(times[i], own.end[i], 12)
            ]
        total += min(
            least_by_search(own, i, *option) for option in options if option[0] < option[1]
        )
    return total


@pytest.mark.parametrize("seed", range(4))
def test_no_order_of_passing_costs_less_than_the_bound(seed):
    rng = np.random.default_rng(seed)
    own = passers(int(rng.integers(2, 6)), rng, end=14.0)
    bound = queue_bound(own)
    assert bound >= own.alone.sum() * (1.0 - 1e-9)
    for _ in range(6):
        times = rng.uniform(own.begin + 0.3 * (own.end - own.begin), own.end - 1.0)
        assert schedule_cost(own, times) >= bound


def test_the_bound_is_near_the_best_schedule_of_agents_alike():
    """A queue of four; the search over schedules is by hand."""
    ones = np.ones(4)
    own = Passers(ones, 0.0 * ones, 10.0 * ones, 0.6 * ones, 2.9 * ones, 2.9 * ones, 6.0 * ones)
    best = min(
        schedule_cost(own, 5.0 + gap * (np.arange(4) - 1.5)) for gap in np.linspace(0.4, 1.4, 11)
    )
    alone = own.alone.sum()
    bound = queue_bound(own)
    assert alone < bound <= best
    assert bound - alone > 0.6 * (best - alone)
    # Were agents further aside than they have to be, the best schedule would be refuted.
    assert queue_bound(replace(own, aside=1.5 * own.aside)) > best


@pytest.mark.parametrize("seed", range(5))
def test_asides_are_kept_by_all_discs_and_reached_by_some(seed):
    rng = np.random.default_rng(seed)
    radii = rng.uniform(0.3, 0.5, 2)
    width = 2.0 * radii.max() * rng.uniform(1.02, 1.4)
    distance = np.full((2, 2), radii.sum())
    far = np.full(2, 9.0)
    gate = Gate(np.array([[0.0, 0.0], [0.0, width]]), width, np.arange(2), far, far, 2 * far)
    asides = least_asides(gate, radii, distance)
    # The first agent anywhere, the second one on the gate.
    points = rng.uniform([-1.5, -1.5], [1.5, width + 1.5], (200_000, 2))
    for corner in gate.ends:
        points = points[np.hypot(*(points - corner).T) >= radii[0]]
    on_gate = rng.uniform(radii[1], width - radii[1], len(points))
    on_gate[::2] = width - radii[1]
    apart = np.hypot(points[:, 0], points[:, 1] - on_gate) >= radii.sum()
    nearest = np.clip(points[:, 1], radii[0], width - radii[0])
    gaps = np.hypot(points[:, 0], points[:, 1] - nearest)[apart]
    assert gaps.min() >= asides[0] > 0.0
    assert gaps.min() <= asides[0] + 0.05
