"""The JSON Schema tells what the validation does, and every key says what it means."""

from __future__ import annotations

import json

import pytest

from stplan.scene import scene_schema
from stplan.scene.format import SceneFile
from stplan.scene.model import SeedingSettings, SolverSettings, Weights

SCHEMA = scene_schema()
PARTS = {"SceneFile": SCHEMA, **SCHEMA["$defs"]}


def test_schema_is_json_without_null():
    text = json.dumps(SCHEMA, allow_nan=False)
    assert json.loads(text) == SCHEMA
    assert '"null"' not in text


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
