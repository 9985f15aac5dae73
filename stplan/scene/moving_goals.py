"""Goals that move: others, whom an agent follows, pursues or evades. Lengths in m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from stplan.scene.places import Place

if TYPE_CHECKING:
    from stplan.scene.model import Scene

# How often everybody thinks again where a scene does not say so, s.
REPLAN_EVERY = 0.5


@dataclass(frozen=True)
class MovingGoal:
    """What an agent wants of others.

    Attributes:
        others: their ids: of whom it follows, pursues (the nearest one that is left) or evades (all).
        within: how near it stays to whom it follows, between centres.
        capture: how near it has to come to whom it pursues, between centres.
        places: where it looks for safety; anywhere without any.
    """

    kind: Literal["follow", "pursue", "evade"]
    others: tuple[str, ...]
    within: float = 0.0
    capture: float = 0.0
    places: tuple[Place, ...] = ()


def is_play(scene: Scene) -> bool:
    """Whether a scene has goals that move, tasks, or agents that do not see all others."""
    return bool(scene.tasks) or any(
        agent.moving_goal is not None or agent.sight is not None for agent in scene.agents
    )


def captures(scene: Scene) -> list[tuple[int, int, float]]:
    """(pursuer, prey, distance between centres at which it is caught), all in the order of the scene."""
    place = {agent.id: a for a, agent in enumerate(scene.agents)}
    return [
        (a, place[name], goal.capture)
        for a, agent in enumerate(scene.agents)
        if (goal := agent.moving_goal) is not None and goal.kind == "pursue"
        for name in goal.others
    ]
