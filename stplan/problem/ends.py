"""Scenes whose goals are where given curves end: of agents that end in places, or on assigned points."""

from __future__ import annotations

from dataclasses import replace

from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, Scene


def ending_as(scene: Scene, lines: WorldLines) -> Scene:
    """`scene` with the ends of `lines` (in any order) as goals of those who may end in several points.

    Their places stay what they are.
    """
    assigned = {a for assignment in scene.assignments for a in assignment.members}
    free = [a for a, agent in enumerate(scene.agents) if agent.goal_places or a in assigned]
    if not free:
        return scene
    curve_of = dict(zip(lines.agent_ids, lines.curves(), strict=True))
    agents = list(scene.agents)
    for a in free:
        curve = curve_of.get(agents[a].id)
        if curve is not None and len(curve):
            agents[a] = replace(agents[a], goal=(float(curve[-1, 0]), float(curve[-1, 1])))
    return replace(scene, agents=tuple(agents))


def fixed_at(scene: Scene, lines: WorldLines) -> Scene:
    """`scene` in which everybody has to end where `lines` do."""
    agents: tuple[Agent, ...] = tuple(
        replace(agent, goal_places=()) for agent in ending_as(scene, lines).agents
    )
    return replace(scene, agents=agents, assignments=())
