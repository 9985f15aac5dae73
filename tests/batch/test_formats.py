"""What continuous integration reads."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from stplan.batch.formats import github, junit
from stplan.batch.outcome import RunState
from stplan.batch.result import Batch, Result
from stplan.batch.runs import Run


def result(name: str, state: str, *messages: str, **more) -> Result:
    source = Path(f"scenes/{name}.yaml")
    run = Run(name, source, Path("/scenes"), "", ())
    return Result(run, Path("results") / name, RunState(state), messages, **more)


BATCH = Batch(
    (
        result("good", "certified", seconds=1.5),
        result("limit", "certified", "raise solver.max_iterations", seconds=0.25),
        result(
            "bad", "refused", "scenes/bad.yaml:3:7: horizon: is 'a:b,c'", "scenes/bad.yaml: 2\n"
        ),
        result("stuck", "no seed", "sam & <ann> \x00 block\none another"),
        result("slow", "timeout", "stopped after 1 s"),
        result("lost", "died", "its worker was killed by SIGKILL"),
        result("left", "not run"),
    ),
    interrupted=True,
)


def test_junit_has_a_case_a_run():
    root = ElementTree.fromstring(junit(BATCH))
    (suite,) = root
    figures = {key: suite.get(key) for key in ("tests", "failures", "errors", "skipped", "time")}
    assert figures == {
        "tests": "7", "failures": "2", "errors": "2", "skipped": "1", "time": "1.750",
    }  # fmt: skip
    cases = {case.get("name"): case for case in suite}
    problems = {
        name: [(child.tag, child.get("type")) for child in case if child.tag != "system-out"]
        for name, case in cases.items()
    }
    assert problems == {
        "good": [],
        "limit": [],
        "bad": [("error", "refused")],
        "stuck": [("failure", "no seed")],
        "slow": [("failure", "timeout")],
        "lost": [("error", "died")],
        "left": [("skipped", None)],
    }
    assert cases["bad"].get("classname") == "scenes/bad.yaml"
    assert cases["stuck"].findtext("failure") == "sam & <ann> \ufffd block\none another"


def test_github_annotates_the_line_of_the_scene():
    assert github(BATCH).splitlines() == [
        "::notice file=scenes/limit.yaml,title=limit%3A certified::raise solver.max_iterations",
        "::error file=scenes/bad.yaml,title=bad%3A refused,line=3,col=7::horizon: is 'a:b,c'",
        "::error file=scenes/bad.yaml,title=bad%3A refused::scenes/bad.yaml: 2%0A",
        "::error file=scenes/stuck.yaml,title=stuck%3A no seed::sam & <ann> \x00 block%0Aone another",
        "::error file=scenes/slow.yaml,title=slow%3A timeout::stopped after 1 s",
        "::error file=scenes/lost.yaml,title=lost%3A died::its worker was killed by SIGKILL",
        "::warning title=left::not run: the batch ended before",
        "7 runs: 2 certified, 1 refused, 1 no seed, 1 timeout, 1 died, 1 not run",
    ]


def test_runs_not_begun_count_as_the_interruption_only():
    assert BATCH.exit_statuses == [0, 0, 2, 3, 4, 4, 130]
    assert Batch(BATCH.results[-1:]).exit_statuses == []
