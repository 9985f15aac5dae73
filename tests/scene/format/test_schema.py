"""The JSON Schema says what the reader accepts, and the page on the format what both do."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from stplan.scene import parse_scene, scene_schema
from stplan.scene.format.file import SceneFile
from stplan.scene.model import SeedingSettings, SolverSettings, Weights

SCHEMA = scene_schema()
PARTS = {"SceneFile": SCHEMA, **SCHEMA["$defs"]}
PAGE = Path(__file__).parents[3] / "docs" / "scene-format.md"
BLOCKS = re.findall(r"^```yaml\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def _keys(schema):
    """Every key of every mapping."""
    return {
        key
        for part in [schema, *schema.get("$defs", {}).values()]
        for key in part.get("properties", {})
    }


def test_plain_json_of_a_known_dialect():
    schema = scene_schema()
    text = json.dumps(schema, allow_nan=False)
    assert json.loads(text) == schema
    assert '"null"' not in text
    assert "json-schema.org" in schema["$schema"]
    assert set(schema["required"]) == {"stplan", "agents"}


def test_references_lead_somewhere():
    schema = scene_schema()
    found = set(re.findall(r'"#/\$defs/(\w+)"', json.dumps(schema)))
    assert found <= set(schema["$defs"])


def test_bounds_and_words():
    definitions = scene_schema()["$defs"]
    agent = json.dumps(definitions["AgentFile"]["properties"])
    assert '"exclusiveMinimum": 0' in agent
    assert '"stay"' in agent
    assert '"smooth-minimum"' in json.dumps(definitions["SolverFile"])
    assert '"auto"' in json.dumps(definitions["SolverFile"]["properties"]["mu"])


def test_the_page_names_every_key():
    text = PAGE.read_text(encoding="utf-8")
    missing = {key for key in _keys(scene_schema()) if f"`{key}`" not in text}
    assert not missing


def test_the_page_has_examples():
    assert len(BLOCKS) >= 5


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_examples_of_the_page_are_read(block, tmp_path):
    for mesh in re.findall(r"mesh: (\S+?)[,}\s]", block):
        path = tmp_path / mesh
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n", encoding="utf-8")
    for table in re.findall(r"file: (\S+?)[,}\s]", block):
        text = "id,start_x,start_y,goal_x,goal_y\ntom,0,-9,9,-9\n"
        (tmp_path / table).write_text(text, encoding="utf-8")
    head = "" if block.startswith("stplan:") else "stplan: 1\n"
    if not re.search(r"^horizon:", block, re.M):
        head += "horizon: 20\n"
    if not re.search(r"^agents:", block, re.M):
        head += (
            "agents:\n  - {id: sam, start: [0, 0], goal: [9, 0]}\n"
            "  - {id: ann, start: [0, 3], goal: [9, 3]}\n"
        )
    assert parse_scene(head + block, directory=tmp_path).agents


@pytest.mark.parametrize("part", PARTS)
def test_every_key_is_described_and_no_other_allowed(part):
    assert PARTS[part]["additionalProperties"] is False
    assert PARTS[part]["description"]
    for key, schema in PARTS[part]["properties"].items():
        assert schema.get("description"), f"{part}.{key}"


def test_schema_describes_without_changing_itself():
    assert scene_schema() == SCHEMA
    assert SCHEMA["required"] == ["stplan", "agents"]


def test_defaults_are_those_of_the_model():
    seeding, solver, weights = SeedingSettings(), SolverSettings(), Weights()
    for part, model in (("SeedingFile", seeding), ("SolverFile", solver), ("WeightsFile", weights)):
        for key, schema in PARTS[part]["properties"].items():
            default = getattr(model, key)
            assert schema["default"] == ("auto" if default is None else default), key


def test_model_is_strict():
    assert SceneFile.model_config["strict"]
    assert SceneFile.model_config["extra"] == "forbid"
