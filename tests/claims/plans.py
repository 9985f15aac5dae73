"""Plans of the shipped scenes, made once a session, and what is measured on them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np

from stplan import load_scene
from stplan.certify.pair_clearance import nearest_moments
from stplan.planner import Plan, find_initial_curves, prepare
from stplan.problem.world_lines import WorldLines
from stplan.replanning.execution import plan

SCENES = Path(__file__).parents[2] / "scenes"


@cache
def planned(name: str, *overrides: str) -> Plan:
    """The plan of a shipped scene (`family/scene`), made once; it holds its certificate."""
    result = plan(load_scene(SCENES / f"{name}.yaml", overrides=overrides))
    assert result.exit_status == 0, result.advice
    assert result.certificate.holds
    return result


@cache
def raw_seed(name: str) -> WorldLines:
    """The initial curves of a shipped scene as search finds them, before any shortcut."""
    as_found = ("seeding.shortcuts=false", "solver.effort=quick", "solver.starts=1")
    scene = load_scene(SCENES / f"{name}.yaml", overrides=as_found)
    return find_initial_curves(prepare(scene))[0].world_lines


def curves(name: str, *overrides: str) -> dict[str, np.ndarray]:
    """Optimised curves (n, 3) by agent id."""
    lines = planned(name, *overrides).trajectories
    assert lines is not None
    return dict(zip(lines.agent_ids, lines.curves(), strict=True))


def places(curve: np.ndarray, times: np.ndarray) -> np.ndarray:
    """(T, 2) where an agent is at `times`, standing before its first and after its last knot."""
    return np.column_stack([np.interp(times, curve[:, 2], curve[:, axis]) for axis in range(2)])


def offsets(curve: np.ndarray) -> np.ndarray:
    """(n,) signed distance of every knot from the straight line from start to goal, m."""
    along = (curve[-1, :2] - curve[0, :2]) / np.linalg.norm(curve[-1, :2] - curve[0, :2])
    away = curve[:, :2] - curve[0, :2]
    return away[:, 0] * along[1] - away[:, 1] * along[0]


def deviation(curve: np.ndarray) -> float:
    """Largest distance of an agent from its straight line, m."""
    return float(np.abs(offsets(curve)).max())


def path_length(curve: np.ndarray) -> float:
    """Length of the path on the ground, m."""
    return float(np.hypot(*np.diff(curve[:, :2], axis=0).T).sum())


def straight_length(curve: np.ndarray) -> float:
    """Distance from start to goal, m."""
    return float(np.hypot(*(curve[-1, :2] - curve[0, :2])))


def turned(curve: np.ndarray) -> float:
    """All changes of direction on the ground added up, degrees; once around is 360."""
    step = np.diff(curve[:, :2], axis=0)
    step = step[np.hypot(*step.T) > 1e-6]
    cross = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
    return float(np.degrees(np.abs(np.arctan2(cross, (step[:-1] * step[1:]).sum(axis=1))).sum()))


def sharpest_turn(curve: np.ndarray) -> float:
    """Greatest change of direction from one segment to the next while moving faster than 0.1 m/s, degrees."""
    step = np.diff(curve[:, :2], axis=0)
    moving = np.hypot(*step.T) / np.diff(curve[:, 2]) > 0.1
    cross = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
    angles = np.degrees(np.abs(np.arctan2(cross, (step[:-1] * step[1:]).sum(axis=1))))
    return float(angles[moving[:-1] & moving[1:]].max(initial=0.0))


def strongest_acceleration(curve: np.ndarray) -> float:
    """Greatest change of velocity over the time between the middles of two segments, m/s^2."""
    dt = np.diff(curve[:, 2])
    velocity = np.diff(curve[:, :2], axis=0) / dt[:, None]
    return float((np.hypot(*np.diff(velocity, axis=0).T) / (0.5 * (dt[1:] + dt[:-1]))).max())


def distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Distances of two agents while both are on their way, m, at 2000 equal steps."""
    times = np.linspace(max(first[0, 2], second[0, 2]), min(first[-1, 2], second[-1, 2]), 2000)
    return np.hypot(*(places(first, times) - places(second, times)).T)


def mean_distance(first: np.ndarray, second: np.ndarray, until: float) -> float:
    """Mean distance of two agents from the first start to `until` (s), standing once they have arrived, m."""
    times = np.linspace(min(first[0, 2], second[0, 2]), until, 4000)
    return float(np.hypot(*(places(first, times) - places(second, times)).T).mean())


def nearest(first: np.ndarray, second: np.ndarray) -> float:
    """Least distance of two agents while both are on their way, m, exactly."""
    lines = WorldLines.from_curves(["first", "second"], [first, second])
    leaves = np.array([first[-1, 2], second[-1, 2]])
    found = nearest_moments(lines, leaves, np.ones((2, 2), dtype=bool))
    return float(found.distance[0])


def arrival(curve: np.ndarray) -> float:
    """When the agent arrives, s."""
    return float(curve[-1, 2])


def presence(curve: np.ndarray, box: Sequence[float], until: float) -> np.ndarray:
    """(K, 2) when an agent enters and leaves a box [xmin, ymin, xmax, ymax], s, to 1 ms."""
    times = np.arange(curve[0, 2], until, 1e-3)
    x, y = places(curve, times).T
    inside = (x > box[0]) & (x < box[2]) & (y > box[1]) & (y < box[3])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return times[np.minimum(edges, len(times) - 1)].reshape(-1, 2)


def smallest_gap(visits: Sequence[np.ndarray]) -> float:
    """Least time between one agent's leaving and another one's entering, s; negative: both inside."""
    return min(
        max(b[0] - a[1], a[0] - b[1])
        for first, second in combinations(visits, 2)
        for a in first
        for b in second
    )


def heeded(visits: Sequence[np.ndarray]) -> int:
    """How many agents come by at all."""
    return sum(len(own) > 0 for own in visits)


def slowest_over_fastest(curve: np.ndarray) -> float:
    """Least speed over greatest speed along a curve, each over a twentieth of its duration."""
    times = np.linspace(curve[0, 2], curve[-1, 2], 21)
    lengths = np.append(0.0, np.cumsum(np.hypot(*np.diff(curve[:, :2], axis=0).T)))
    speed = np.diff(np.interp(times, curve[:, 2], lengths))
    return float(speed.min() / speed.max())


def close_calls(name: str) -> int:
    """How many pairs would collide if everyone went straight at constant speed."""
    scene = planned(name).scene
    straight = []
    for agent, own in zip(scene.agents, curves(name).values(), strict=True):
        straight.append(np.array([[*agent.start, agent.start_time], [*agent.goal, arrival(own)]]))
    return sum(
        nearest(a, b) < scene.agents[i].radius + scene.agents[j].radius
        for (i, a), (j, b) in combinations(enumerate(straight), 2)
    )
