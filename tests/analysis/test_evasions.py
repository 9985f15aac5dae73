"""What agents pay for getting out of each other's way: no motion that keeps them apart pays less."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis import evasions
from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.evasions import Movers, evading_groups
from stplan.bench import families_open as wide
from stplan.planner import plan, prepare
from stplan.scene import parse_scene


def movers(count: int, rng: np.random.Generator, vanishes=False) -> Movers:
    angles = 2.0 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
    starts = 4.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    distance = np.full((count, count), 0.8)
    np.fill_diagonal(distance, 0.0)
    goals = -starts + rng.uniform(-0.3, 0.3, (count, 2))
    stiffness = rng.uniform(0.5, 2.0, count)
    return Movers(starts, goals, stiffness, np.full(count, vanishes), distance, 10.0)


def cost(own: Movers, curves: np.ndarray) -> float:
    """Of curves (n, steps + 1, 2) at an even clock."""
    steps = curves.shape[1] - 1
    squares = (np.diff(curves, axis=1) ** 2).sum(axis=(1, 2))
    return float(0.5 * (own.stiffness * squares).sum() * steps / own.duration)


def random_motion(own: Movers, rng: np.random.Generator, steps: int = 60) -> np.ndarray:
    """Smooth curves that are pushed apart until all keep their distance at all steps, and a little more."""
    share = np.linspace(0.0, 1.0, steps + 1)[None, :, None]
    curves = own.starts[:, None] + share * (own.goals - own.starts)[:, None]
    for wave in (1, 2):
        curves = curves + np.sin(wave * np.pi * share) * rng.normal(0.0, 0.4, (len(curves), 1, 2))
    for _ in range(4000):
        step = curves[None, :] - curves[:, None]
        gap = np.sqrt((step**2).sum(axis=-1)) + np.eye(len(curves))[..., None]
        short = np.maximum(1.08 * own.distance[..., None] - gap, 0.0)
        if not short.any():
            break
        push = (short / gap)[..., None] * step
        moved = curves + 0.3 * (push.sum(axis=0) - push.sum(axis=1)) * 0.5
        moved[:, 1:-1] = 0.9 * moved[:, 1:-1] + 0.05 * (moved[:, 2:] + moved[:, :-2])
        moved[:, [0, -1]] = curves[:, [0, -1]]
        curves = moved
    return curves


def keeps_apart(own: Movers, curves: np.ndarray) -> bool:
    step = curves[None, :] - curves[:, None]
    begin, way = step[:, :, :-1], np.diff(step, axis=2)
    share = np.clip(-(begin * way).sum(-1) / np.maximum((way**2).sum(-1), 1e-300), 0.0, 1.0)
    gap = np.sqrt(((begin + share[..., None] * way) ** 2).sum(-1)).min(axis=-1)
    return bool((gap + np.eye(len(curves)) >= own.distance).all())


@pytest.mark.parametrize("seed", range(4))
def test_no_motion_that_keeps_apart_costs_less(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    own = movers(int(rng.integers(2, 7)), rng)
    groups = evading_groups(own)
    least = own.straight.sum() + sum(extra for _, extra in groups)
    assert groups
    assert least > own.straight.sum()
    found = [
        curves
        for curves in (random_motion(own, rng) for _ in range(12))
        if keeps_apart(own, curves)
    ]
    assert len(found) > 3
    assert min(cost(own, curves) for curves in found) >= least


def test_two_head_on_pay_for_the_way_round_each_other_and_reach_it():
    starts = np.array([[-4.0, 0.0], [4.0, 0.0]])
    stiffness = np.array([1.0, 3.0])
    distance = np.array([[0.0, 0.8], [0.8, 0.0]])
    own = Movers(starts, -starts, stiffness, np.zeros(2, dtype=bool), distance, 10.0)
    ((group, extra),) = evading_groups(own)
    assert group.tolist() == [0, 1]
    way = 2.0 * np.sqrt(64.0 - 0.64) + 0.8 * (np.pi - 2.0 * np.arccos(0.1))
    assert extra == pytest.approx(0.75 * (way**2 - 256.0) / 20.0)
    # At one instant, as where somebody vanishes, it is nearly as much.
    ((_, instant),) = evading_groups(replace(own, vanishes=np.array([True, False])))
    assert 0.95 * extra < instant <= extra


def test_who_can_vanish_in_time_is_worth_no_more_than_hurrying():
    starts = np.array([[-0.2, 0.0], [6.0, 0.0]])
    goals = np.array([[0.0, 0.0], [-6.0, 0.0]])
    distance = np.array([[0.0, 2.0], [2.0, 0.0]])
    own = Movers(starts, goals, np.ones(2), np.array([True, False]), distance, 10.0)
    ((_, extra),) = evading_groups(own)
    ((_, stays),) = evading_groups(replace(own, vanishes=np.zeros(2, dtype=bool)))
    # It arrives before half of the time, and the other one passes where it was.
    assert extra <= (1.0 + 1e-9) * own.straight[0] < stays


def test_all_on_one_spot_pay_more_than_pairs_of_them():
    rng = np.random.default_rng(1)
    own = replace(movers(6, rng), stiffness=np.ones(6))
    own = replace(own, goals=-own.starts)
    groups = evading_groups(own)
    assert max(len(group) for group, _ in groups) == 6
    ((_, pair),) = evading_groups(
        Movers(
            *(
                x[:2] if np.ndim(x) else x
                for x in (own.starts, own.goals, own.stiffness, own.vanishes)
            ),
            own.distance[:2, :2],
            own.duration,
        )
    )
    assert sum(extra for _, extra in groups) > 3.0 * pair


@pytest.mark.parametrize("after", ["stay", "vanish"])
def test_plans_in_the_open_are_never_below_and_near_the_bound(after, monkeypatch):
    scene = wide.circle(5, 3.0, 20.0, radius=0.4)
    scene = replace(
        scene,
        agents=tuple(replace(agent, after_arrival=after) for agent in scene.agents),
        solver=replace(scene.solver, knots=25, effort="quick", starts=1),
    )
    found = plan(scene)
    bound = found.report.bound
    assert found.certificate.holds
    assert bound.least.sum() < bound.total <= bound.cost
    assert bound.cost - bound.total < 0.75 * (bound.cost - bound.least.sum())
    # Were all to keep twice as far apart, this plan would be impossible.
    round_disc = evasions._pair_costs
    monkeypatch.setattr(
        evasions,
        "_pair_costs",
        lambda own: round_disc(replace(own, distance=2.0 * own.distance)),
    )
    assert cost_bound(prepare(scene), found.trajectories).total > bound.cost


def test_pairs_that_may_touch_and_agents_at_other_times_force_nothing():
    text = """\
stplan: 1
horizon: 20
defaults: {radius: 0.4}
agents:
  - {id: a, start: [-4, 0], goal: [4, 0]}
  - {id: b, start: [4, 0], goal: [-4, 0]MORE}
"""
    for more, pairs in (
        (", start_time: 1", ""),
        ("", "pairs: [{between: [a, b], collide: false}]\n"),
    ):
        scene = parse_scene(text.replace("MORE", more) + pairs)
        found = plan(replace(scene, solver=replace(scene.solver, knots=20, effort="quick")))
        assert found.report.bound.together == ()
    assert plan(parse_scene(text.replace("MORE", ""))).report.bound.together[0].kind == "crossing"
