"""How far a point lies outside a place, from the place's own points. Lengths in m."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stplan.amounts import amount
from stplan.amounts import place as in_full
from stplan.arrays import FloatArray
from stplan.scene.model import Scene
from stplan.scene.places import Assignment, Place


def distance_outside(place: Place, point: FloatArray) -> float:
    """Distance of `point` (2,) to a place, 0 in it."""
    corners = np.array(place.points)
    head = corners
    tail = np.roll(corners, -1, axis=0)
    if not place.area:
        head, tail = head[:-1], tail[:-1]
    step = tail - head
    squared = (step**2).sum(axis=1)
    along = ((point - head) * step).sum(axis=1) / np.where(squared > 0, squared, 1.0)
    nearest = head + np.clip(along, 0.0, 1.0)[:, None] * step
    distance = float(np.hypot(*(point - nearest).T).min())
    if not place.area:
        return distance
    # Even-odd rule: how many edges a ray to the right crosses.
    above = (head[:, 1] > point[1]) != (tail[:, 1] > point[1])
    rise = np.where(above, tail[:, 1] - head[:, 1], 1.0)
    crossing = head[:, 0] + (point[1] - head[:, 1]) * step[:, 0] / rise
    inside = bool((above & (crossing > point[0])).sum() % 2)
    return 0.0 if inside else distance


def outside_all(places: Sequence[Place], point: FloatArray, tolerance: float) -> str:
    """What is wrong with an end at `point` (2,) that has to lie in one of `places`, or ""."""
    gaps = [distance_outside(place, point) for place in places]
    if min(gaps) <= tolerance:
        return ""
    names = " or ".join(dict.fromkeys(str(place) for place in places))
    return f"ends at {in_full(*point.tolist())}, {amount(min(gaps), 3)} m outside {names}"


def broken_assignments(scene: Scene, ends: FloatArray) -> list[str]:
    """A sentence for every agent whose end (A, 2) is none of its crowd's points, or another's already."""
    return [
        sentence
        for assignment in scene.assignments
        for sentence in _broken(scene, assignment, ends)
    ]


def _broken(scene: Scene, assignment: Assignment, ends: FloatArray) -> list[str]:
    left = list(assignment.points)
    sentences = []
    for a in assignment.members:
        end = tuple(ends[a].tolist())
        if end in left:
            left.remove(end)
            continue
        what = (
            "is another's already" if end in assignment.points else "is none of its crowd's points"
        )
        sentences.append(f"{scene.agents[a].id}: ends at {end}, which {what}")
    return sentences
