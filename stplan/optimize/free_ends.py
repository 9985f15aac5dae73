"""Ends that are variables: the convex part of a place around the point where a curve ends.

An agent that vanishes in a place may end anywhere in it. What holds it there are linear constraints, so it
is held in a convex part: the whole place where that is convex, else what is left of it beyond no edge of its
outline. On a polyline it is the straight piece on which the end lies. Walls need no constraints of their
own, their barriers keep the radius.

Agents that stay end on their spots: where they stand is part of everybody's surroundings.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.nlp.constraints import UNBOUNDED, Constraints, HalfPlanes
from stplan.problem.layout import KnotLayout
from stplan.problem.planning_problem import PlanningProblem
from stplan.scene.places import Place

# Normals this close to an axis are that axis: then a constraint is a bound of a variable.
ALONG_AXIS = 1e-12
# Ends lie on a place up to this share of its extent.
ON_PLACE = 1e-9
# How often ends are moved back onto half-planes and into bounds; what is left then is rounding.
PROJECTIONS = 5


def ends_freely(problem: PlanningProblem, agent: int) -> bool:
    """Whether the end of an agent is a variable."""
    return bool(problem.scene.agents[agent].goal_places) and not problem.stays[agent]


def free_ends(problem: PlanningProblem, layout: KnotLayout, seed: FloatArray) -> HalfPlanes:
    """What holds the last knots of `seed` (M, 3) that may move in their places."""
    parts = []
    for a, agent in enumerate(problem.scene.agents):
        if not ends_freely(problem, a):
            continue
        last = int(layout.last[a])
        end = seed[last, :2]
        place = min(agent.goal_places, key=lambda one: _off(one, end))
        normals, least, greatest = convex_part(place, end)
        parts.append(HalfPlanes(np.full(len(least), last), normals, least, greatest))
    if not parts:
        return HalfPlanes.none()
    return HalfPlanes(
        np.concatenate([part.knots for part in parts]),
        np.vstack([part.normals for part in parts]),
        np.concatenate([part.least for part in parts]),
        np.concatenate([part.greatest for part in parts]),
    )


def convex_part(place: Place, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normals (H, 2), least and greatest (H,) of a convex part of `place` around `point` (2,), m."""
    corners = np.array(place.points)
    return _area_part(corners, point) if place.area else _line_part(corners, point)


def as_bounds(planes: HalfPlanes, lower: FloatArray, upper: FloatArray) -> HalfPlanes:
    """Enter half-planes along the axes into bounds (M, 3) of the knots; what is left are the others."""
    along = np.abs(planes.normals).max(axis=1, initial=0.0) > 1.0 - ALONG_AXIS
    for k, normal, least, greatest in zip(
        planes.knots[along].tolist(), planes.normals[along], planes.least[along],
        planes.greatest[along], strict=True,
    ):  # fmt: skip
        axis = int(np.abs(normal).argmax())
        low, high = (least, greatest) if normal[axis] > 0 else (-greatest, -least)
        lower[k, axis], upper[k, axis] = max(lower[k, axis], low), min(upper[k, axis], high)
    return planes.chosen(~along)


def into_place(constraints: Constraints, knots: FloatArray) -> FloatArray:
    """Knots (M, 3), those that a solver's tolerance left outside their half-planes moved back onto them.

    They also keep their bounds: the two are enforced in turn.
    """
    planes = constraints.planes
    own = np.unique(planes.knots)
    for _ in range(PROJECTIONS):
        at = (planes.normals * knots[planes.knots, :2]).sum(axis=1)
        off = np.clip(at, planes.least, planes.greatest) - at
        if not off.any():
            break
        knots = knots.copy()
        for k, normal, step in zip(planes.knots.tolist(), planes.normals, off, strict=True):
            knots[k, :2] += step * normal
        knots[own] = np.clip(knots[own], constraints.lower[own], constraints.upper[own])
    return knots


def _off(place: Place, point: FloatArray) -> float:
    """Distance of a point to a place, m."""
    import shapely

    return float(shapely.distance(place.shape(), shapely.points(point)))


def _line_part(corners: FloatArray, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The straight piece of a polyline nearest to `point`."""
    head, step = corners[:-1], np.diff(corners, axis=0)
    length = np.hypot(*step.T)
    tangent = step / length[:, None]
    along = np.clip(((point - head) * tangent).sum(axis=1), 0.0, length)
    gap = np.hypot(*(point - head - along[:, None] * tangent).T)
    k = int(gap.argmin())
    normal = np.array([-tangent[k, 1], tangent[k, 0]])
    across, begin = float(normal @ head[k]), float(tangent[k] @ head[k])
    return (
        np.array([normal, tangent[k]]),
        np.array([across, begin]),
        np.array([across, begin + length[k]]),
    )


def _area_part(corners: FloatArray, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A convex part of the area inside a ring around `point`.

    Edges are gone through, nearest first: where what is left of one still lies in the part found so far, the
    part is cut along its line where the point sees its inner side, else across the nearest point of it.
    """
    head, tail = corners, np.roll(corners, -1, axis=0)
    turn = float((head[:, 0] * tail[:, 1] - head[:, 1] * tail[:, 0]).sum())
    step = tail - head if turn > 0 else head - tail
    outward = np.column_stack([step[:, 1], -step[:, 0]])
    outward /= np.hypot(*outward.T)[:, None]
    squared = (step**2).sum(axis=1)
    share = np.clip(((point - head) * (tail - head)).sum(axis=1) / squared, 0.0, 1.0)
    nearest = head + share[:, None] * (tail - head)
    gap = np.hypot(*(point - nearest).T)
    rounding = ON_PLACE * float(np.ptp(corners, axis=0).max())
    normals: list[FloatArray] = []
    greatest: list[float] = []
    for k in np.argsort(gap, kind="stable").tolist():
        piece = _clipped(head[k], tail[k], normals, greatest, rounding)
        if piece is None:
            continue
        inside = float(outward[k] @ (head[k] - point)) >= -rounding
        if not inside:
            # The edge turns its back: cut across the nearest point of what is left of it.
            way = piece[1] - piece[0]
            at = min(max(float((point - piece[0]) @ way) / float(way @ way), 0.0), 1.0)
            spot = piece[0] + at * way
            normal = (spot - point) / max(float(np.hypot(*(spot - point))), 1e-300)
            bound = float(normal @ spot)
        else:
            normal, bound = outward[k], float(outward[k] @ head[k])
        normals.append(normal)
        greatest.append(bound)
    found = np.array(normals)
    return found, np.full(len(found), -UNBOUNDED), np.array(greatest)


def _clipped(
    head: FloatArray,
    tail: FloatArray,
    normals: list[FloatArray],
    greatest: list[float],
    rounding: float,
) -> tuple[FloatArray, FloatArray] | None:
    """The part of a segment strictly inside half-planes, None where there is none."""
    low, high = 0.0, 1.0
    for normal, bound in zip(normals, greatest, strict=True):
        start, end = (
            float(normal @ head) - bound + rounding,
            float(normal @ tail) - bound + rounding,
        )
        if start >= 0.0 and end >= 0.0:
            return None
        if start * end < 0.0:
            cut = start / (start - end)
            low, high = (max(low, cut), high) if start > 0.0 else (low, min(high, cut))
    return None if low >= high else (head + low * (tail - head), head + high * (tail - head))
