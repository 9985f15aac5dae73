"""Scenes made in code are those of files, arrays are as good as lists, and faults name their key."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.api.building import AgentSpec, build_scene, scene_text
from stplan.errors import SceneError
from stplan.scene import parse_scene

RING = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [0.0, 4.0]])


def test_a_scene_of_arrays_is_the_scene_of_its_file():
    agents = [
        AgentSpec("sam", np.array([1, 1]), (7.0, 1.0), radius=np.float64(0.4), waypoints=[[4, 2]]),
        AgentSpec("bus", path=np.array([[1, 3, 0], [7, 3, 1e-05 + 5]]), weights={"kinetic": 2}),
        {"id": "ann", "start": [7, 2], "goal": [1, 2], "mass": np.int64(80)},
    ]  # fmt: skip
    scene = build_scene(agents, map=RING, horizon=9, name="room", pairs=[
        {"between": ["sam", "ann"], "distance": 1.5},
    ])  # fmt: skip
    sam, bus, ann = scene.agents
    assert (sam.start, sam.radius, sam.waypoints) == ((1.0, 1.0), 0.4, ((4.0, 2.0),))
    assert bus.path == ((1.0, 3.0, 0.0), (7.0, 3.0, 5.00001))
    assert (bus.weights.kinetic, ann.mass, ann.max_time) == (2.0, 80.0, 9.0)
    assert scene.pairs[0].distance == 1.5
    text = scene_text(agents, map=RING.tolist(), horizon=9, name="room", pairs=[
        {"between": ["sam", "ann"], "distance": 1.5},
    ])  # fmt: skip
    assert parse_scene(text).content_hash == scene.content_hash


def test_map_files_are_looked_for_where_asked(tmp_path):
    (tmp_path / "room.wkt").write_text("POLYGON ((0 0, 9 0, 9 5, 0 5, 0 0))")
    agents = [AgentSpec("sam", (1, 1), (8, 4))]
    scene = build_scene(agents, map={"file": "room.wkt"}, horizon=9, directory=tmp_path)
    assert scene.map is not None
    with pytest.raises(SceneError, match=r"room\.wkt"):
        build_scene(agents, map={"file": "room.wkt"}, horizon=9, directory=tmp_path / "none")


def test_faults_name_agent_and_key():
    agents = [AgentSpec("sam", (0, 0), (4, 0)), AgentSpec("ann", (0, 2), (4, 2), radius=-1)]
    with pytest.raises(SceneError) as caught:
        build_scene(agents, horizon=9, solver={"knotz": 4})
    messages = "\n".join(caught.value.messages)
    assert "agents[1].radius" in messages
    assert "solver.knotz" in messages
    with pytest.raises(TypeError, match="set is no value"):
        build_scene([AgentSpec("sam", {0, 1}, (4, 0))], horizon=9)
