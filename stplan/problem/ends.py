"""Scenes that leave ends open, as given curves end: in places, on assigned points, when caught, or late."""

from __future__ import annotations

from dataclasses import replace

from stplan.problem.world_lines import WorldLines
from stplan.scene.horizon import with_chosen_horizon
from stplan.scene.model import Agent, Scene
from stplan.scene.moving_goals import is_play


def ending_as(scene: Scene, lines: WorldLines) -> Scene:
    """`scene` with the ends of `lines` (in any order) as goals of those who may end in several points.

    Their places stay what they are. A horizon that is open ends with the latest arrival.
    """
    scene = lasting_as(scene, lines)
    if is_play(scene):
        return _played_as(scene, lines)
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


def last_moment(lines: WorldLines) -> float:
    """Until when anybody is there, s."""
    return float(lines.knots[:, 2].max())


def _played_as(scene: Scene, lines: WorldLines) -> Scene:
    """A scene whose goals move, as if everybody had wanted to end as `lines` do: who is caught vanishes."""
    curve_of = dict(zip(lines.agent_ids, lines.curves(), strict=True))
    end = last_moment(lines)
    agents = []
    for agent in scene.agents:
        curve = curve_of.get(agent.id)
        own = agent
        if curve is not None and len(curve):
            x, y, t = curve[-1].tolist()
            if t < end:
                own = replace(own, after_arrival="vanish")
            if t < end or agent.moving_goal is not None:
                own = replace(own, goal=(x, y))
        agents.append(replace(own, moving_goal=None, sight=None, line_of_sight=False))
    return replace(scene, agents=tuple(agents), replan_every=None, tasks=())


def lasting_as(scene: Scene, lines: WorldLines) -> Scene:
    """`scene` until the latest arrival of `lines`, where its horizon is open."""
    if scene.horizon_rule != "auto" or not len(lines.knots):
        return scene
    return with_chosen_horizon(scene, float(lines.knots[:, 2].max()))


def fixed_at(scene: Scene, lines: WorldLines) -> Scene:
    """`scene` in which everybody has to end where `lines` do."""
    agents: tuple[Agent, ...] = tuple(
        replace(agent, goal_places=()) for agent in ending_as(scene, lines).agents
    )
    return replace(scene, agents=agents, assignments=())
