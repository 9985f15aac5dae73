"""Ten agents are planned on the map of every format, from the file to a certificate."""

from __future__ import annotations

from pathlib import Path

import pytest

from stplan import planner
from stplan.imports.files import draft_of_files
from stplan.imports.people import CrowdOptions
from stplan.maps.formats.drawing import FileOptions
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from tests.maps.formats.samples import SAMPLES, lif

QUICK = ("solver.effort=quick", "solver.outer_iterations=1", "solver.max_iterations=20")
# Files whose agents are planned; in all others ten are placed at random.
BESIDE = {"menge": ["roomsB.xml"], "ccbs": ["agents.xml"]}


def imported(folder: Path, names: list[str], options: FileOptions, crowd: CrowdOptions) -> Scene:
    paths = [folder / name for name in names]
    draft, _ = draft_of_files(paths, options, crowd, folder, "made by a test")
    return parse_scene(draft.text(), directory=folder, overrides=QUICK)


@pytest.mark.parametrize("name", [*SAMPLES, "lif"])
def test_ten_agents_are_planned(name: str, tmp_path: Path) -> None:
    chosen = {"lif": lif}[name] if name == "lif" else SAMPLES[name].write
    options = {} if name == "lif" else SAMPLES[name].options
    file_options = FileOptions(
        scale=options.get("scale"),
        layers=tuple(options.get("layers", ())),
        thickness=3.0 if name == "lif" else None,
    )
    files = [chosen(tmp_path), *BESIDE.get(name, ())]
    scene = imported(
        tmp_path, files, file_options, CrowdOptions(10, 3, 0.25 if name != "ccbs" else None)
    )
    assert len(scene.agents) == 10
    plan = planner.plan(scene)
    assert plan.certificate.holds
