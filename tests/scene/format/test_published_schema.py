"""The JSON Schema that editors fetch is the one that validates, and editors find it."""

from __future__ import annotations

from pathlib import Path

from stplan.files.json_file import json_bytes
from stplan.scene import scene_schema

ROOT = Path(__file__).parents[3]
PUBLISHED = ROOT / "docs" / "stplan.schema.json"


def test_it_is_current():
    current = json_bytes(scene_schema())
    assert PUBLISHED.read_bytes() == current, "stplan schema > docs/stplan.schema.json"


def test_editors_are_told_where_it_is():
    page = (ROOT / "docs" / "scene-format.md").read_text(encoding="utf-8")
    assert "# yaml-language-server: $schema=" in page
    assert "stplan.schema.json" in page
