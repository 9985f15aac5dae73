"""The tutorials, followed to the letter."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[2] / "docs" / "tutorial.md"


def test_every_step_does_what_the_page_says(run, monkeypatch, tmp_path):
    text = PAGE.read_text(encoding="utf-8")
    (scene,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    Path("door.yaml").write_text(scene, encoding="utf-8")
    said = {}
    for block in re.findall(r"```bash\n(.*?)```", text, re.DOTALL):
        for command in block.splitlines():
            words = shlex.split(command)[1:]
            result = run(*words)
            assert result.status == (1 if words[0] == "diff" else 0), (command, result.err)
            said[command] = result.out
    assert "hold" in said["stplan explain outputs/door"]
    assert "bob holds back for cart" in said["stplan explain outputs/door"]

    def arrival(folder: str) -> float:
        with np.load(Path(folder) / "trajectories.npz") as plan:
            bob = list(plan["agent_ids"]).index("bob")
            return float(plan["knots"][plan["offsets"][bob + 1] - 1, 2])

    assert arrival("outputs/door") > 19
    assert arrival("hurry/door") < 9
    assert len(list(Path("sweep").glob("door*/trajectories.csv"))) == 3
    # Through the door of a metre nobody gets who is wider than that.
    too_wide = run("solve", "door.yaml", "--set", "agents.bob.radius=0.6")
    assert too_wide.status == 3
    assert "the widest lets a radius of 0.50" in too_wide.err


FOLDER = PAGE.parent / "site" / "tutorials"
MADE = {
    "crowds": ["samples.csv", "hall.txt", "study/batch.csv", "wide/hall/measure/density.png", "both.html"],
    "animation": ["takes.webp", "street.mp4", "street.glb", "street.csv", "splines.json", "street.usda"],
    "fleets": ["order.json", "delay.html", "orders.json", "paths.txt", "golden/depot/trajectories.csv"],
}  # fmt: skip
# What is said before a block, its language, its text.
_BLOCK = re.compile(r"([^\n]*)\n\n```(\w+)\n(.*?)```", re.DOTALL)


@pytest.mark.parametrize("name", MADE)
def test_every_user_ends_with_what_the_page_promises(run, monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    page = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    for before, language, block in _BLOCK.findall(page):
        if saved := re.search(r"as `(\S+)`:$", before):
            Path(saved[1]).write_text(block, encoding="utf-8")
        elif language == "python":
            exec(compile(block, name, "exec"), {"__name__": "__example__"})
        else:
            for command in block.splitlines():
                program, *words = shlex.split(command, comments=True)
                announced = re.search(r"# exit status (\d)", command)
                if program == "stplan":
                    result = run(*words)
                    assert result.status == int(announced[1] if announced else 0), command
    assert [file for file in MADE[name] if not Path(file).is_file()] == []
