"""Three agents, one of whom waits for another: scenes, their curves, and crowds of them."""

from __future__ import annotations

import numpy as np

from stplan.analysis.crowd import Crowd
from stplan.problem.planning_problem import prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.scene.reading.load import parse_scene

SAM = "id: sam, start: [-5, 0], goal: [5, 0], after_arrival: vanish"
ANN = "id: ann, start: [0, -4], goal: [0, 4], preferred_time: 9"
EVE = "id: eve, start: [-5, 9], goal: [5, 9]"
CURVES = {
    "sam": [[-5, 0, 0], [5, 0, 10]],
    # Half way to sam's line ann stands for five seconds, until he has passed.
    "ann": [[0, -4, 0], [0, -2, 2], [0, -2, 7], [0, 4, 13]],
    "eve": [[-5, 9, 0], [0, 10, 8], [5, 9, 20]],
}


def scene_of(*agents: str, top: str = "") -> Scene:
    listed = "".join(f"  - {{{agent}, radius: 0.5}}\n" for agent in agents)
    return parse_scene(f"stplan: 1\nname: small\nhorizon: 20\n{top}agents:\n{listed}")


def lines_of(scene: Scene, **other: list[list[float]]) -> WorldLines:
    ids = [agent.id for agent in scene.agents]
    return WorldLines.from_curves(ids, [np.array((CURVES | other)[i], dtype=float) for i in ids])


def crowd_of(scene: Scene, **other: list[list[float]]) -> Crowd:
    return Crowd.of_problem(prepare(scene), lines_of(scene, **other))
