"""What a plan has to forgive: room for errors of tracking, and where delays cannot be forgiven.

Two agents that are at most e off their trajectories keep R if these keep R + 2 e; from a wall one keeps r if
its trajectory keeps r + e. So radii are larger by e, and distances that pairs have set by 2 e.
"""

from __future__ import annotations

from dataclasses import replace

from stplan.scene.format.file import RobustFile
from stplan.scene.model import Robust, Scene
from stplan.scene.moving_goals import is_play
from stplan.schema.mapping import Fault


def with_robustness(scene: Scene, file: RobustFile) -> Scene:
    """`scene` whose distances hold what its file allows for errors of tracking."""
    error = file.tracking
    if error:
        agents = tuple(replace(agent, radius=agent.radius + error) for agent in scene.agents)
        pairs = tuple(
            rule if rule.distance is None else replace(rule, distance=rule.distance + 2.0 * error)
            for rule in scene.pairs
        )
        scene = replace(scene, agents=agents, pairs=pairs)
    return replace(scene, robust=Robust(file.delay, error))


def robust_faults(scene: Scene) -> list[Fault]:
    """Delays are forgiven, and those who start too near each other parted, in plans: plays have none."""
    if not is_play(scene):
        return []
    text = "is for plans, and goals that move or perception are played, round by round"
    given = {"robust.delay": bool(scene.robust.delay), "overlap": scene.overlap == "ease"}
    return [(path, text) for path, asked in given.items() if asked]
