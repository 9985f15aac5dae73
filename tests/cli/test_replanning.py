"""The command replan, and the page on it, followed to the letter."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "replanning.md"
TWO = """\
stplan: 1
name: two
horizon: 12
defaults: {radius: 0.3}
agents:
  - {id: ann, start: [-5, 0], goal: [5, 0]}
  - {id: bob, start: [0, -4], goal: [0.5, 4]}
"""


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
    assert "white catches hare at 7.381 s" in said["stplan explain outputs/two-wolves"]
    slow = said["stplan solve scenes/chases/slow-wolf.yaml"]
    assert "hare is never caught; grey comes within 1.326 m of it" in slow
    tram = said["stplan solve scenes/changes/tram.yaml"]
    assert "any one agent may stop for 2 s if all keep the order of passing" in tram
    assert "any one agent may stop for 2 s" in said["stplan check outputs/tram"]
    (survived,) = (out for command, out in said.items() if "--delay" in command)
    assert "any one agent may stop for 2 s if all keep the order of passing" in survived
    order = json.loads(Path("order.json").read_text(encoding="utf-8"))
    assert order["passings"]
    assert not order["touching"]
    assert all(one["slack"] >= 0.0 for one in order["passings"])
    assert run("check", "plans/bottleneck", "--delay", "-1").status == 2
    assert "there at 12.64 s on average" in said["stplan solve scenes/chases/mist.yaml"]
    (hidden,) = (out for command, out in said.items() if "line_of_sight" in command)
    assert "there at 14.19 s on average" in hidden
    assert "36 tasks done in" in said["stplan explain outputs/order-picking"]


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


HUNT = """\
stplan: 1
name: hunt
horizon: 3
map: {rectangle: [0, 0, 8, 6]}
defaults: {radius: 0.3, max_speed: 2}
agents:
  - {id: fox, start: [1, 1], goal: {pursue: hare}}
  - {id: hare, start: [3, 2], goal: {evade: fox}, max_speed: 0.5}
"""


def test_what_was_played_is_looked_at_but_neither_replanned_nor_improved(
    run, monkeypatch, tmp_path
):
    monkeypatch.chdir(tmp_path)
    Path("hunt.yaml").write_text(HUNT, encoding="utf-8")
    assert "fox pursues hare, and catches within 0.9 m" in run("explain", "hunt.yaml").out
    assert "fox catches hare at" in run("solve", "hunt.yaml", "-o", "runs").out
    assert "certificate holds" in run("check", "runs/hunt").out
    before = sorted(path.stat().st_mtime_ns for path in Path("runs").rglob("*"))
    for words, sentence in {
        ("seed", "hunt.yaml", "-o", "runs"): "`stplan solve` plays it",
        ("solve", "hunt.yaml", "-o", "runs", "--improve", "1"): "past improvement",
        ("improve", "runs/hunt", "--budget", "1"): "past improvement",
        ("replan", "runs/hunt", "--at", "1", "--set", "agents.fox.max_speed=1"): "was played",
    }.items():
        result = run(*words)
        assert result.status == 2
        assert sentence in result.err
    assert sorted(path.stat().st_mtime_ns for path in Path("runs").rglob("*")) == before
    assert run("plot", "runs/hunt", "-o", "hunt.svg").status == 0


def test_killing_a_replan_leaves_the_run_whole(run, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.yaml").write_text(TWO, encoding="utf-8")
    assert run("solve", "two.yaml", "-o", "plans").status == 0
    before = {path: path.read_bytes() for path in Path("plans").rglob("*") if path.is_file()}
    words = ("replan", "plans/two", "--at", "3", "--set", "agents.ann.goal=[4,1]", "-o", "plans")
    process = subprocess.Popen(
        [sys.executable, "-m", "stplan", *words], stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    with process:
        assert process.stderr is not None
        said = next((line for line in process.stderr if "planning 1 of 2" in line), None)
        process.kill()
    assert said is not None
    assert process.returncode != 0
    after = {path: path.read_bytes() for path in Path("plans").rglob("*") if path.is_file()}
    assert after == before
    assert run("check", "plans/two").status == 0
    assert run(*words).status == 0
    assert run("check", "plans/two").status == 0


IN_THE_WAY = """\
stplan: 1
name: tram
horizon: 16
defaults: {radius: 0.4}
seeding: {time_limit: 4}
agents:
  - {id: ann, start: [0, 0.5], goal: [0, 4]}
  - {id: tram, radius: 0.8, path: [[-7, 0, 0], [7, 0, 14]]}
robust: {delay: 9}
"""


def test_a_plan_that_forgives_less_is_written_and_says_so(run, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tram.yaml").write_text(IN_THE_WAY, encoding="utf-8")
    solved = run("solve", "tram.yaml")
    assert solved.status == 4
    assert "no plan was found that survives the delay asked for" in solved.err
    assert "s of the 9 s asked" in solved.out
    report = json.loads(Path("outputs/tram/report.json").read_text(encoding="utf-8"))
    assert report["status"] == "fragile"
    proven = report["robustness"]["proven_delay"]
    assert 0.0 < proven < 5.5
    checked = run("check", "outputs/tram")
    assert checked.status == 1
    assert f"a stop of 9 s is not survived, one of {proven:.4g} s is" in checked.out
    assert run("check", "outputs/tram", "--delay", f"{0.99 * proven}").status == 0
    told = run("explain", "outputs/tram").out
    assert f"survives a stop of {proven:.4g} s of the 9 s asked" in told
    asked = run("explain", "tram.yaml", "--time-limit", "0").out
    assert "tram cannot wait, so spots are free that long before" in asked
    improved = run("solve", "tram.yaml", "--improve", "1")
    assert improved.status == 2
    assert "robust.delay" in improved.err


TOO_NEAR = """\
stplan: 1
name: near
horizon: 12
overlap: ease
defaults: {radius: 0.4}
agents:
  - {id: ann, start: [0, 0], goal: [5, 4]}
  - {id: bob, start: [0.3, 0], goal: [-5, -4]}
"""


def test_who_starts_too_near_is_named_wherever_the_plan_is(run, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    Path("near.yaml").write_text(TOO_NEAR, encoding="utf-8")
    sentence = "ann and bob start 0.3 m apart, too near: clear from"
    for command in (("solve", "near.yaml"), ("check", "outputs/near"), ("explain", "outputs/near")):
        result = run(*command)
        assert result.status == 0, result.err
        assert sentence in result.out
    asked = run("explain", "near.yaml")
    assert asked.status == 0
    assert "ann and bob: 0.3 m apart of 0.8 m" in asked.out
    assert run("seed", "near.yaml", "-o", "seeds").status == 0
    improved = run("improve", "outputs/near", "-o", "better", "--budget", "1")
    assert improved.status == 2
    refused = run("solve", "near.yaml", "--set", "overlap=refuse")
    assert refused.status == 2
    assert "agents[1].start: is 0.3 m from the start of 'ann'" in refused.err
