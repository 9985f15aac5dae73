"""The commands about scene files, validate and schema, and how all commands read one."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stplan.cli.command import command, group
from stplan.cli.console import Console, note_failure, worst, write
from stplan.cli.options import Overrides, ScenePaths
from stplan.errors import UsageError

if TYPE_CHECKING:
    from stplan.scene.model import Scene

app = group()


def read_scene(path: Path, overrides: Sequence[str]) -> Scene:
    """The scene in a file, or on stdin for ``-``.

    Raises:
        UsageError: there is none.
        SceneError: it has faults.
    """
    if path == Path("-"):
        from stplan.scene.reading.load import read_standard_input

        return read_standard_input(sys.stdin.buffer, tuple(overrides))
    if path.is_dir():
        raise UsageError(f"{path} is a folder; expected a scene file")
    if not path.exists():
        raise UsageError(f"cannot read {path}: no such file")
    from stplan.scene import load_scene

    return load_scene(path, overrides=tuple(overrides))


@command(app)
def validate(console: Console, scenes: ScenePaths, *, overrides: Overrides = None) -> int:
    """Check scenes and their maps without planning.

    All faults are named at once, each as FILE:LINE:COLUMN: path: what is wrong, what is expected.
    Exit status 0 when every scene is valid, 2 otherwise.

    \b
    Example:
      stplan validate scenes/*/*.yaml
    """
    records = []
    for path in scenes:
        record: dict[str, Any] = {"scene": str(path), "exit_status": 0}
        records.append(record)
        try:
            scene = read_scene(path, overrides or [])
            if scene.map is not None or any(agent.goal_places for agent in scene.agents):
                from stplan.world import fitted_free_space, warnings_of

                record["warnings"] = warnings_of(scene, fitted_free_space(scene))
                for line in record["warnings"]:
                    console.progress(line)
        except Exception as error:
            note_failure(console, record, error)
        else:
            record |= {"name": scene.name, "status": "valid"}
            console.result(f"{path}: valid, {scene.name} with {len(scene.agents)} agents")
    status = worst([record["exit_status"] for record in records])
    console.result_json({"exit_status": status, "scenes": records})
    return status


@command(app, without=("quiet", "verbose", "as_json"))
def schema(console: Console) -> int:
    """Print the JSON Schema of scene files.

    It is made from the model that validates scenes. Editors complete and check scene files with it,
    for example by a first line `# yaml-language-server: $schema=stplan.schema.json`.

    \b
    Example:
      stplan schema > stplan.schema.json
    """
    del console
    from stplan.files.json_file import json_bytes
    from stplan.scene import scene_schema

    write(sys.stdout, json_bytes(scene_schema()).decode())
    return 0
