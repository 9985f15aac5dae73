"""Whether every agent that heeds walls keeps its radius from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stplan.amounts import distinct, place
from stplan.arrays import FloatArray
from stplan.certify.local_frame import LocalFrame
from stplan.certify.tightest import Tightest
from stplan.scene.model import Agent, Scene

if TYPE_CHECKING:
    from stplan.world import FreeSpace


@dataclass(frozen=True)
class WallFindings:
    """What is said of walls: rows, how many agents do not heed them, broken promises."""

    spots: tuple[Tightest, ...] = ()
    ignored: int = 0
    violations: tuple[str, ...] = ()


def check_walls(
    scene: Scene, free_space: FreeSpace | None, curves: Sequence[FloatArray], frame: LocalFrame
) -> WallFindings:
    """Distances of `curves`, in scene order, to the walls; `frame` is that of both."""
    heeds = [a for a, agent in enumerate(scene.agents) if agent.weights.wall != 0]
    if free_space is None:
        return WallFindings()
    if not heeds:
        return WallFindings(ignored=len(curves))
    from stplan.certify.wall_clearance import time_at, wall_distances

    found = wall_distances(free_space, [curves[a] for a in heeds], frame)
    spots, sentences = [], []
    for a, distance, point in zip(heeds, found.distance.tolist(), found.place, strict=True):
        agent = scene.agents[a]
        where = (float(point[0]), float(point[1]))
        spot = Tightest((agent.id,), distance - agent.radius, time_at(curves[a], point), where)
        spots.append(spot)
        if distance <= agent.radius + frame.rounding:
            sentences.append(_sentence(agent, spot, distance, frame))
    return WallFindings(tuple(spots), len(curves) - len(heeds), tuple(sentences))


def _sentence(agent: Agent, spot: Tightest, distance: float, frame: LocalFrame) -> str:
    where = f"at t = {spot.time:.6g} s, {place(*spot.place)}"
    if distance < 0:
        return f"{agent.id}: leaves the free space {where}"
    apart, least = distinct(distance, agent.radius, digits=6)
    sentence = (
        f"{agent.id}: {apart} m from a wall {where}; more than its radius {least} m is needed"
    )
    return (
        sentence
        if distance <= agent.radius
        else f"{sentence}, by more than rounding ({frame.rounding:.2g} m)"
    )
