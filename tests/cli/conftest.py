"""A stand-in for planning, so that what the command line adds is tested alone and at once."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from unittest.mock import create_autospec

import pytest

import stplan.scene
from stplan import planner
from stplan.cli.app import main
from stplan.planner import Plan
from stplan.scene.model import Scene
from stplan.status import Status
from tests.files.examples import straight_lines

SCENE = """\
stplan: 1
horizon: 5.0
agents:
  - {id: sam, start: [0.0, 0.0], goal: [4.0, 0.0], radius: 0.25}
  - {id: ann, start: [0.0, 9.0], goal: [4.0, 9.0], radius: 0.25}
"""


@dataclass
class Result:
    """How a command ended."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


@pytest.fixture
def run(capsys) -> Callable[..., Result]:
    """Run a command line in this process."""

    def command(*arguments: object) -> Result:
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main([str(argument) for argument in arguments])
        code = left.value.code
        out, err = capsys.readouterr()
        return Result(int(code or 0), out, err)

    return command


@dataclass
class Stage:
    """What the stand-in does with a real plan: errors to raise and outcomes to give, by scene name."""

    example: Plan
    raises: dict[str, BaseException] = field(default_factory=dict)
    outcomes: dict[str, Status] = field(default_factory=dict)
    overrides: list[tuple[str, ...]] = field(default_factory=list)
    planned: list[str] = field(default_factory=list)

    def load_scene(self, path: Path, *, overrides: tuple[str, ...] = ()) -> Scene:
        self.overrides.append(tuple(overrides))
        return _load_scene(path, overrides=overrides)

    def plan(self, scene: Scene, *, progress: Callable[[str], None], **options: Any) -> Plan:
        self.planned.append(scene.name)
        progress("outer iteration 1")
        if scene.name in self.raises:
            raise self.raises[scene.name]
        status = self.outcomes.get(scene.name, Status.CONVERGED)
        lines = straight_lines(scene)
        report = replace(self.example.report, scene=scene, status=status)
        return replace(self.example, seed=lines, trajectories=lines, report=report)


_load_scene = stplan.scene.load_scene


@pytest.fixture(scope="session")
def example(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    """Two agents that never meet, planned in earnest."""
    path = tmp_path_factory.mktemp("example") / "example.yaml"
    path.write_text(SCENE)
    return planner.plan(_load_scene(path))


@pytest.fixture
def stage(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, example: Plan) -> Stage:
    """Replace planning, as it would be called in earnest; the working directory is new."""
    acting = Stage(example)
    for name in ("plan", "seed"):
        stand_in = create_autospec(getattr(planner, name), side_effect=acting.plan)
        monkeypatch.setattr(planner, name, stand_in)
    monkeypatch.setattr(stplan.scene, "load_scene", acting.load_scene)
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two", "three"):
        Path(f"{name}.yaml").write_text(SCENE)
    Path("bad.yaml").write_text(SCENE.replace("5.0", "five").replace("radius", "radios", 1))
    return acting
