"""A run in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from stplan.arrays import FloatArray
from stplan.certify.certificate import Certificate, certify
from stplan.explain.detours import detours, ways_alone
from stplan.explain.explanation import Explanation, Remark, Section, count
from stplan.explain.lateness import lateness
from stplan.explain.tightness import limits_and_meetings, tight_pairs, tight_walls
from stplan.explain.waiting import waiting, waits
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene
from stplan.world import fitted_free_space


def explain_run(
    scene: Scene,
    lines: WorldLines,
    report: Mapping[str, Any] | None = None,
) -> tuple[Explanation, Certificate]:
    """What `lines` (in any order of agents) look like, and their certificate.

    Args:
        report: what report.json says of them, where they are those of a run.

    Raises:
        SceneError: the scene does not fit its map.
    """
    problem = PlanningProblem.from_scene(scene, fitted_free_space(scene))
    certificate = certify(scene, problem.free_space, lines)
    verdict = "holds" if certificate.holds else "IS BROKEN"
    headline = f"{scene.name}: {count(len(scene.agents), 'agent')}, the certificate {verdict}."
    status = (report or {}).get("status")
    if isinstance(status, str):
        headline = f"{scene.name}: planning ended as '{status}'; the certificate {verdict}."
    sections = []
    if certificate.violations:
        sections.append(
            Section(
                "violations", "Broken promises",
                f"{count(len(certificate.violations), 'promise')} of the scene not kept:",
                [Remark(sentence) for sentence in certificate.violations],
            )
        )  # fmt: skip
    advice = (report or {}).get("advice")
    if isinstance(advice, str) and advice:
        sections.append(Section("advice", "Advice", advice[0].upper() + advice[1:] + "."))
    if certificate.pairs or certificate.walls or certificate.holds:
        sections += motion(scene, lines, certificate, ways_alone(problem))
    return Explanation(headline, tuple(sections)), certificate


def motion(
    scene: Scene,
    lines: WorldLines,
    certificate: Certificate,
    alone: Sequence[FloatArray | None],
) -> list[Section]:
    """What is tight, who waits, who is late and who goes further, of curves with sound ends.

    Args:
        alone: the way of every agent without the others.
    """
    lines = _in_scene_order(scene, lines)
    found = waits(scene, lines)
    return [
        tight_pairs(scene, certificate),
        tight_walls(scene, certificate),
        *limits_and_meetings(certificate),
        waiting(scene, found),
        lateness(scene, lines, found),
        detours(scene, lines, alone),
    ]


def _in_scene_order(scene: Scene, lines: WorldLines) -> WorldLines:
    place = {agent_id: a for a, agent_id in enumerate(lines.agent_ids)}
    ids = [agent.id for agent in scene.agents]
    return WorldLines.from_curves(ids, [lines.curve(place[agent_id]) for agent_id in ids])
