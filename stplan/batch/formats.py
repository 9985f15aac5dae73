"""The results of a batch as continuous integration reads them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

from stplan.batch.outcome import RunState
from stplan.batch.result import Batch, Result

# What XML 1.0 cannot hold, not even escaped.
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
# `path:line:column: text`, as every message about a scene file begins.
_PLACE = re.compile(r"(?P<file>.+?):(?P<line>[0-9]+):(?P<column>[0-9]+): (?P<text>.*)", re.DOTALL)
# The states that a scene or its planning is to blame for; the others are errors of the run.
_FAILURES = (RunState.NO_SEED, RunState.FAILED, RunState.TIMEOUT)


def junit(batch: Batch) -> str:
    """JUnit XML: a test case a run, passed when it is certified."""
    results = batch.results
    failed = [result for result in results if result.state in _FAILURES]
    skipped = [result for result in results if result.state is RunState.NOT_RUN]
    passed = [result for result in results if result.exit_status == 0]
    seconds = sum(result.seconds or 0.0 for result in results)
    root = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(
        root,
        "testsuite",
        name="stplan batch",
        tests=str(len(results)),
        failures=str(len(failed)),
        errors=str(len(results) - len(failed) - len(skipped) - len(passed)),
        skipped=str(len(skipped)),
        time=f"{seconds:.3f}",
    )
    for result in results:
        _add_case(suite, result)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True)


def _add_case(suite: ElementTree.Element, result: Result) -> None:
    case = ElementTree.SubElement(
        suite,
        "testcase",
        classname=_xml(str(result.run.source)),
        name=_xml(result.run.name),
        time=f"{result.seconds or 0.0:.3f}",
    )
    text = _xml("\n".join(result.messages))
    if result.state is RunState.NOT_RUN:
        ElementTree.SubElement(case, "skipped", message="the batch ended before")
    elif result.exit_status:
        kind = "failure" if result.state in _FAILURES else "error"
        problem = ElementTree.SubElement(
            case, kind, type=result.state, message=text.partition("\n")[0]
        )
        problem.text = text
    ElementTree.SubElement(case, "system-out").text = _xml(result.sentence)


def _xml(text: str) -> str:
    return _NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


def github(batch: Batch) -> str:
    """Workflow commands of GitHub Actions: an annotation a problem, at its line of the scene file."""
    lines = [line for result in batch.results for line in _annotations(result)]
    return "\n".join([*lines, batch.sentence])


def _annotations(result: Result) -> Sequence[str]:
    if result.state is RunState.NOT_RUN:
        return [_command("warning", {"title": result.run.name}, "not run: the batch ended before")]
    level = "notice" if result.exit_status == 0 else "error"
    messages = result.messages or (() if level == "notice" else (result.state,))
    lines = []
    for message in messages:
        fields = {"file": str(result.run.source), "title": f"{result.run.name}: {result.state}"}
        place = _PLACE.fullmatch(message)
        if place is None:
            lines.append(_command(level, fields, message))
            continue
        fields |= {"file": place["file"], "line": place["line"], "col": place["column"]}
        lines.append(_command(level, fields, place["text"]))
    return lines


def _command(level: str, fields: dict[str, str], message: str) -> str:
    listed = ",".join(f"{key}={_escaped(value, more=True)}" for key, value in fields.items())
    return f"::{level} {listed}::{_escaped(message)}"


def _escaped(text: str, more: bool = False) -> str:
    codes = {"%": "%25", "\r": "%0D", "\n": "%0A"} | ({":": "%3A", ",": "%2C"} if more else {})
    return "".join(codes.get(letter, letter) for letter in text)
