"""A run in words."""

from __future__ import annotations

from stplan.amounts import amount
from stplan.analysis.arrival_gap import arrival_gap
from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.crowd import Crowd
from stplan.analysis.detours import ways_alone
from stplan.analysis.robustness import robustness
from stplan.callbacks import Progress, unheard
from stplan.certify.certificate import Certificate, certify
from stplan.certify.history import certify_history
from stplan.certify.play import certify_play
from stplan.explain.arrivals import arrival_section
from stplan.explain.chases import done_section, outcome_section
from stplan.explain.costs import cost_section
from stplan.explain.curves import curve_sections
from stplan.explain.explanation import Explanation, Fact, Section
from stplan.files.recorded import RecordedReport
from stplan.problem.continuation import curves_of
from stplan.problem.ends import ending_as
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import space_of, spaces_of, whole_scene
from stplan.scene.model import Robust, Scene
from stplan.scene.moving_goals import is_play
from stplan.wording import count
from stplan.world import fitted_free_space, warnings_of

# Sections about ways to goals, of which there are none where goals move.
ON_THEIR_WAY = ("waits", "late", "detours")


def explain_run(
    scene: Scene,
    lines: WorldLines,
    report: RecordedReport | None = None,
    *,
    progress: Progress = unheard,
) -> tuple[Explanation, Certificate]:
    """What `lines` (in any order of agents) look like, and their certificate.

    Args:
        report: what report.json says of them, where they are those of a run.
        progress: called with what there is to know about the map.

    Raises:
        SceneError: the scene does not fit its map.
    """
    happened = scene
    scene = whole_scene(scene, curves_of(lines)) if scene.changes else ending_as(scene, lines)
    space = space_of(scene) if happened.changes else fitted_free_space(scene)
    problem = PlanningProblem.from_scene(scene, space)
    for line in warnings_of(scene, problem.free_space):
        progress(line)
    if is_play(happened):
        certificate = certify_play(happened, problem.free_space, lines)
    elif happened.changes:
        certificate = certify_history(happened, spaces_of(happened), lines)
    else:
        certificate = certify(scene, problem.free_space, lines)
    verdict = "holds" if certificate.holds else "IS BROKEN"
    headline = f"{scene.name}: {count(len(scene.agents), 'agent')}, the certificate {verdict}."
    report = report or RecordedReport()
    if report.status is not None:
        headline = f"{scene.name}: planning ended as '{report.status}'; the certificate {verdict}."
    sections = []
    if happened.changes:
        facts = [
            Fact(f"At {amount(change.at)} s {', '.join(change.causes)}.")
            for change in happened.changes
        ]
        sections.append(Section("events", "What happened on the way", "", facts))
    if happened.tasks:
        sections.append(done_section(happened, problem.free_space, lines))
    elif is_play(happened):
        sections.append(outcome_section(happened, lines))
    if certificate.eased:
        lead = "They are eased apart, and certified from the moment they are clear:"
        facts = [Fact(f"{one}.") for one in certificate.eased]
        sections.append(Section("eased", "Too near at the start", lead, facts))
    if scene.robust != Robust() and certificate.holds:
        facts = [*map(Fact, robustness(scene, lines).sentences)]
        sections.append(Section("robust", "What it forgives", "", facts))
    if certificate.violations:
        lead = f"{count(len(certificate.violations), 'promise')} of the scene not kept:"
        facts = [*map(Fact, certificate.violations)]
        sections.append(Section("violations", "Broken promises", lead, facts))
    if report.advice:
        sections.append(
            Section("advice", "Advice", report.advice[0].upper() + report.advice[1:] + ".")
        )
    if certificate.pairs or certificate.walls or certificate.holds:
        crowd = Crowd.of_problem(problem, _in_scene_order(problem, lines))
        found = curve_sections(crowd, certificate, ways_alone(problem))
        sections += [one for one in found if not (is_play(happened) and one.key in ON_THEIR_WAY)]
    if certificate.holds and not happened.changes and not is_play(happened):
        ordered = _in_scene_order(problem, lines)
        if scene.minimise == "energy":
            sections.append(cost_section(cost_bound(problem.in_frame, ordered)))
        else:
            sections.append(arrival_section(arrival_gap(problem.in_frame, ordered)))
    return Explanation(headline, tuple(sections)), certificate


def _in_scene_order(problem: PlanningProblem, lines: WorldLines) -> WorldLines:
    place = {agent_id: a for a, agent_id in enumerate(lines.agent_ids)}
    curves = [lines.curve(place[agent_id]) for agent_id in problem.agent_ids]
    return WorldLines.from_curves(problem.agent_ids, curves)
