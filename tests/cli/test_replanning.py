"""The command replan, and the page on it, followed to the letter."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "replanning.md"


def test_the_page_does_what_it_says(run, monkeypatch, tmp_path) -> None:
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    said = {}
    for block in re.findall(r"```bash\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        for command in block.splitlines():
            result = run(*shlex.split(command)[1:])
            assert result.status == 0, (command, result.err)
            said[command] = result.out
    assert "At 8 s eve broke down." in said["stplan explain outputs/late-robot"]
    assert "certificate holds" in said["stplan check outputs/closed-door"]
    assert "certificate holds" in said["stplan check mended/bottleneck"]


def test_a_wish_without_a_way_leaves_everything_and_says_why(run, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    scene = (ROOT / "scenes" / "changes" / "closed-door.yaml").read_text(encoding="utf-8")
    Path("door.yaml").write_text(scene.partition("events:")[0], encoding="utf-8")
    assert run("solve", "door.yaml", "-o", "plans").status == 0
    wall = "map.obstacles=[{rectangle: [0, 4.8, 12, 5.2]}]"
    words = ("replan", "plans/closed-door", "--at", "10", "--set", wall, "-o", "mended")
    result = run(*words)
    assert result.status == 3
    assert "the old plan does not stay clear after 10 s: ann: leaves the free space" in result.err
    assert "ann: its start and goal lie in separate parts of the map" in result.err
    assert not Path("mended").exists()
    for wrong in (words[:2], (*words[:2], "--at", "3"), (*words[:2], "--set", wall)):
        assert run(*wrong).status == 2
    assert run("improve", "plans/closed-door", "--budget", "1").status == 0
