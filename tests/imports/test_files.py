"""Scenes made of foreign files say what the files say, and what was left out is named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from stplan.errors import UsageError
from stplan.imports.files import draft_of_files
from stplan.imports.people import CrowdOptions
from stplan.maps.formats.drawing import FileOptions
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.world import fitted_free_space
from tests.maps.formats.samples import (
    ROOMS,
    building,
    ccbs,
    jupedsim,
    mappit,
    menge,
    movingai,
    vadere,
)

SCEN = "version 1\n" + "".join(
    f"0\trooms.map\t12\t8\t{x}\t{y}\t{11 - x}\t{y}\t9.5\n"
    for x, y in ((1, 0), (1, 3), (1, 3), (6, 0), (3, 7))
)


def made(
    folder: Path,
    names: list[str],
    crowd: CrowdOptions | None = None,
    options: FileOptions | None = None,
) -> tuple[Scene, list[str]]:
    paths = [folder / name for name in names]
    draft, notes = draft_of_files(
        paths, options or FileOptions(), crowd or CrowdOptions(), folder, "by a test"
    )
    return parse_scene(draft.text(), directory=folder), notes


def test_a_grid_scenario_counts_rows_from_the_top(tmp_path: Path) -> None:
    movingai(tmp_path)
    (tmp_path / "rooms.scen").write_text(SCEN)
    scene, notes = made(tmp_path, ["rooms.scen"])
    assert [agent.start for agent in scene.agents] == [(1.5, 7.5), (1.5, 4.5), (3.5, 0.5)]
    assert [agent.goal for agent in scene.agents] == [(10.5, 7.5), (10.5, 4.5), (8.5, 0.5)]
    assert {agent.radius for agent in scene.agents} == {0.3}
    assert [note.partition(":")[0] for note in notes] == ["1 agents are left out"] * 2
    larger, _ = made(tmp_path, ["rooms.map", "rooms.scen"], options=FileOptions(scale=2.0))
    assert larger.agents[0].start == (3.0, 15.0)
    assert larger.agents[0].radius == 0.6


def test_rows_and_columns_of_ccbs_agents_lie_on_their_map(tmp_path: Path) -> None:
    scene, _ = made(tmp_path, [ccbs(tmp_path), "agents.xml"])
    assert scene.agents[0].start == (1.5, 7.5)
    assert scene.agents[0].goal == (10.5, 0.5)


def test_a_flipped_map_takes_its_agents_along(tmp_path: Path) -> None:
    movingai(tmp_path)
    (tmp_path / "rooms.scen").write_text(SCEN)
    scene, _ = made(tmp_path, ["rooms.scen"], options=FileOptions(flip="y"))
    assert scene.agents[0].start == (1.5, 0.5)
    assert fitted_free_space(scene) is not None


def test_sources_and_targets_hold_their_agents(tmp_path: Path) -> None:
    scene, _ = made(tmp_path, [vadere(tmp_path)])
    starts, goals = (
        np.array([getattr(agent, key) for agent in scene.agents]) for key in ("start", "goal")
    )
    assert len(scene.agents) == 10
    assert shapely.contains_xy(shapely.box(1.5, 1.5, 5.5, 7.5), starts).all()
    assert shapely.contains_xy(shapely.box(10.5, 1.5, 12.5, 7.5), goals).all()
    assert {agent.radius for agent in scene.agents} == {0.2}
    assert {agent.after_arrival for agent in scene.agents} == {"vanish"}
    other, _ = made(tmp_path, ["rooms.scenario"], CrowdOptions(rng_seed=1))
    assert other.agents[0].start != scene.agents[0].start
    again, _ = made(tmp_path, ["rooms.scenario"])
    assert again == scene


def test_a_scenario_of_jupedsim_is_put_on_a_map_of_its_own(tmp_path: Path) -> None:
    tree = json.loads((tmp_path / jupedsim(tmp_path)).read_text())
    (tmp_path / "geometry.wkt").write_text(tree.pop("walkable_area_wkt"))
    (tmp_path / "config.json").write_text(json.dumps(tree))
    scene, _ = made(tmp_path, ["config.json", "geometry.wkt"])
    assert len(scene.agents) == 10
    assert all(agent.goal[0] > 10 for agent in scene.agents)
    assert fitted_free_space(scene).area.equals(ROOMS)


def test_agents_are_placed_between_named_regions(tmp_path: Path) -> None:
    crowd = CrowdOptions(5, sources=("target-7",), goals=("source-3",))
    scene, _ = made(tmp_path, [vadere(tmp_path)], crowd)
    assert all(agent.start[0] > 10 and agent.goal[0] < 6 for agent in scene.agents)
    with pytest.raises(UsageError, match="no region 'nowhere'; there are: source-3, target-7"):
        made(tmp_path, ["rooms.scenario"], CrowdOptions(5, sources=("nowhere",)))


def test_agents_without_goals_go_to_the_goals_of_the_behaviour(tmp_path: Path) -> None:
    scene, notes = made(tmp_path, [menge(tmp_path), "roomsB.xml"])
    assert len(scene.agents) == 10
    assert all(8 <= agent.goal[0] <= 11.5 for agent in scene.agents)
    assert any("drawn in its goals at random" in note for note in notes)


def test_robots_go_to_named_spots(tmp_path: Path) -> None:
    scene, notes = made(tmp_path, [building(tmp_path)])
    (robot,) = scene.agents
    assert (robot.id, robot.start) == ("cart", (2.0, -4.0))
    assert robot.goal in {(10.0, -4.0), (7.0, -5.0)}
    assert any("map.level chooses among the others: L2" in note for note in notes)


def test_the_authors_scenes_keep_weights_and_friends(tmp_path: Path) -> None:
    scene, _ = made(tmp_path, [mappit(tmp_path)])
    assert scene.agents[0].weights.regularity == 10
    assert scene.agents[0].max_time == 30
    assert [rule.grouping for rule in scene.pairs] == [1.0]


def test_those_who_do_not_fit_are_refused(tmp_path: Path) -> None:
    movingai(tmp_path)
    with pytest.raises(UsageError, match=r"only \d+ of 400 agents of radius 0\.3 m fit"):
        made(tmp_path, ["rooms.map"], CrowdOptions(400))
    with pytest.raises(UsageError, match="carries no agents"):
        made(tmp_path, ["rooms.map"])


def test_placed_agents_have_room_and_a_way(tmp_path: Path) -> None:
    movingai(tmp_path)
    scene, _ = made(tmp_path, ["rooms.map"], CrowdOptions(20, 5))
    assert fitted_free_space(scene) is not None
    assert len(scene.agents) == 20
