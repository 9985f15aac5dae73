"""Entries of `agents` that stand for a crowd: where each of it starts and ends."""

from __future__ import annotations

from typing import Any

from stplan.maps.obstacles import exactly_one
from stplan.scene.format.agents import CrowdFile
from stplan.scene.format.places import SHAPES, CrowdGoalFile
from stplan.schema.mapping import Fault


def crowd_ends(entry: CrowdFile, path: str, faults: list[Fault]) -> tuple[list[Any], list[Any]]:
    """Starts and goals of a crowd at `path`: points, or what the file says of places."""
    count = entry.count
    starts: list[Any] = [entry.start] * count
    goals: list[Any] = [entry.goal] * count
    points = entry.start.points
    if points is not None:
        exactly_one(entry.start, ("place", "points", *SHAPES), f"{path}.start", faults)
        if len(points) != count:
            text = f"is a list of {len(points)}; one of {count}, as many as `count`, is expected"
            faults.append((f"{path}.start.points", text))
        starts = [*points, *([points[0]] * count)][:count]
    assigned = assigned_points(entry)
    if assigned:
        if len(assigned) < count:
            text = (
                f"is a list of {len(assigned)}; one of at least {count}, an agent each, is expected"
            )
            faults.append((f"{path}.goal.assign", text))
        goals = [*assigned, *([assigned[0]] * count)][:count]
    return starts, goals


def assigned_points(entry: CrowdFile) -> list[list[float]]:
    """The points of which everybody gets one, none where the crowd has another goal."""
    goal = entry.goal
    return (goal.assign or []) if isinstance(goal, CrowdGoalFile) else []
