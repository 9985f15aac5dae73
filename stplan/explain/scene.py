"""A scene in words, before it is planned: who is there, what interacts, what is narrow, what cannot be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stplan.amounts import amount, distinct
from stplan.analysis.arrival_gap import arrival_gap
from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.crowd import Crowd
from stplan.analysis.detours import ways_alone
from stplan.analysis.encounters import Encounter, encounters
from stplan.analysis.passages import WIDE, Passage, passages
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.certify.easing import too_near_at_start
from stplan.certify.places import distance_outside
from stplan.errors import BROKEN_SEED, BrokenSeedError, SeedingError
from stplan.explain.arrivals import arrival_section
from stplan.explain.chases import tasks_section, wishes_section
from stplan.explain.costs import cost_section
from stplan.explain.curves import curve_sections
from stplan.explain.explanation import Explanation, Fact, Section
from stplan.planner import find_initial_curves, prepare
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.planning_problem import prepare as prepare_written
from stplan.scene.model import Agent, Scene, SeedingSettings
from stplan.scene.moving_goals import is_play
from stplan.scene.places import Place
from stplan.wording import at, count, headline, metres, names, sentences


def explain_scene(
    scene: Scene,
    *,
    time_limit: float,
    progress: Progress = unheard,
    stop: Stop = never,
) -> tuple[Explanation, bool]:
    """What is to be said of a scene, and whether it can be planned: exactly where `planner.plan` can.

    Args:
        time_limit: longest search for initial curves, s; 0 leaves them out.

    Raises:
        SceneError, SolverError, StoppedError: as `planner.plan`.
    """
    seeding = replace(scene.seeding, time_limit=min(time_limit, scene.seeding.time_limit))
    scene = replace(scene, changes=())  # What happens on the way is not known when planning begins.
    if is_play(scene):
        wishes = tasks_section(scene) if scene.tasks else wishes_section(scene)
        sections = [
            population(prepare_written(scene)),
            *robust_sections(scene),
            wishes,
        ]
        return Explanation(f"{scene.name}: a valid scene.", tuple(sections)), True
    eased = eased_sections(scene)
    if eased:
        sections = [population(prepare_written(scene)), *robust_sections(scene), *eased]
        return Explanation(f"{scene.name}: a valid scene.", tuple(sections)), True
    problem = prepare(scene if time_limit <= 0 else replace(scene, seeding=seeding), progress)
    seen = problem.as_written
    alone = ways_alone(seen)
    sections = [population(seen), *robust_sections(scene), passage_section(seen)]
    sections.append(encounter_section(seen, alone))
    if time_limit <= 0:
        return Explanation(f"{scene.name}: a valid scene.", tuple(sections)), True
    try:
        (initial,) = find_initial_curves(problem, progress=progress, stop=stop)
    except SeedingError as error:
        title = f"{scene.name}: a valid scene, but {_how_it_ended(error, seeding, scene.seeding)}."
        return Explanation(title, (*sections, _refusal(error))), False
    found_by = initial.seed.found_by
    lead = f"Found by {found_by}. What follows is about them; planning makes them smooth."
    sections.append(Section("seeding", "Initial curves", lead))
    crowd = Crowd.of_problem(seen, initial.world_lines)
    sections += curve_sections(crowd, initial.certificate, alone)
    if scene.minimise == "energy":
        sections.append(cost_section(cost_bound(problem, initial.world_lines)))
    else:
        sections.append(arrival_section(arrival_gap(problem, initial.world_lines)))
    return Explanation(f"{scene.name}: a valid scene.", tuple(sections)), True


def _how_it_ended(error: SeedingError, looked: SeedingSettings, own: SeedingSettings) -> str:
    """What a failed search comes to: a proof, or only that this one, shorter than its `own`, found none."""
    if error.reasons and all(reason.proven for reason in error.reasons):
        return "there is no way to start"
    ended = "no initial curves were found"
    if looked.time_limit < own.time_limit and any(
        one.kind == "time limit" for one in error.reasons
    ):
        ended += (
            f" within {looked.time_limit:g} s; `stplan solve` looks for {own.time_limit:g} s, "
            f"as does --time-limit {own.time_limit:g}"
        )
    return ended


def _refusal(error: SeedingError) -> Section:
    """Why there are no initial curves."""
    if isinstance(error, BrokenSeedError):
        head, facts = BROKEN_SEED, error.violations
    else:
        head, facts = headline(error.reasons), tuple(sentences(error.reasons))
    return Section("seeding", "Initial curves", f"{head.capitalize()}:", [*map(Fact, facts)])


def eased_sections(scene: Scene) -> list[Section]:
    """Who starts too near whom, and is eased apart; no section where nobody does."""
    if scene.overlap != "ease":
        return []
    pairs, needs = too_near_at_start(scene)
    facts = []
    for (a, b), need in zip(pairs.tolist(), needs.tolist(), strict=True):
        one, other = scene.agents[a], scene.agents[b]
        gap = float(np.hypot(one.start[0] - other.start[0], one.start[1] - other.start[1]))
        facts.append(Fact(f"{one.id} and {other.id}: {metres(gap)} apart of {metres(need)}."))
    lead = "They are eased apart before they go, and certified from the moment they are clear:"
    return [Section("eased", "Too near at the start", lead, facts)] if facts else []


def robust_sections(scene: Scene) -> list[Section]:
    """What a plan has to forgive; no section where nothing is asked."""
    asked, facts = scene.robust, []
    if asked.tracking:
        off = metres(asked.tracking)
        facts.append(Fact(f"Errors of up to {off}: all radii are larger by that, as shown here."))
    if asked.delay:
        fixed = [agent.id for agent in scene.agents if agent.path is not None]
        stop = f"A stop of {amount(asked.delay)} s of any one agent"
        wait = f"; {names(fixed)} cannot wait, so spots are free that long before" if fixed else ""
        facts.append(Fact(f"{stop}, if all keep the order of passing{wait}."))
    return [Section("robust", "What it has to forgive", "", facts)] if facts else []


def population(problem: PlanningProblem) -> Section:
    """Who is there, and who has to do with whom."""
    collide = int(np.triu(problem.collides).sum())
    total = problem.num_agents * (problem.num_agents - 1) // 2
    prescribed = int(problem.prescribed.sum())
    grouped = int(np.triu(problem.interactions.grouping > 0).sum())
    facts = []
    if total:
        facts.append(f"{collide} of {count(total, 'pair')} of agents may not touch")
    if grouped:
        facts.append(f"{count(grouped, 'pair')} of agents are drawn together")
    if prescribed:
        verb = "moves" if prescribed == 1 else "move"
        facts.append(f"{count(prescribed, 'agent')} {verb} as prescribed")
    facts += _destinations(problem.scene)
    ignoring = int((~problem.heeds_walls).sum())
    if problem.scene.map is not None and ignoring:
        facts.append(f"{ignoring} of {count(problem.num_agents, 'agent')} ignore the walls")
    lead = (
        f"{count(problem.num_agents, 'agent')} {_span('of radius', problem.radii, 'm')} and "
        f"{_span('mass', problem.masses, 'kg')}, {_goals_in_time(problem)}"
    )
    return Section(
        "population", "The scene", f"{lead}:" if facts else f"{lead}.", [*map(Fact, facts)]
    )


def _goals_in_time(problem: PlanningProblem) -> str:
    """How much time there is, and what it is to be used for."""
    scene = problem.scene
    asked = {"arrivals": "the sum of arrival times", "makespan": "the latest arrival"}
    within = "" if scene.horizon_rule == "auto" else f"within {problem.final_time:g} s"
    early = f"{asked[scene.minimise]} to be least" if scene.minimise in asked else ""
    return ", ".join(part for part in (within, early) if part)


def _destinations(scene: Scene) -> list[str]:
    """Who may end in several points, and how many of them are to end in which place."""
    places: dict[str, list[Agent]] = {}
    for agent in scene.agents:
        if agent.goal_places:
            which = " or ".join(dict.fromkeys(str(place) for place in agent.goal_places))
            places.setdefault(which, []).append(agent)
    facts = []
    for which, agents in places.items():
        fact = f"{count(len(agents), 'agent')} may end anywhere in {which}"
        if len(agents[0].goal_places) > 1:
            shares = [
                f"{sum(_in(place, agent) for agent in agents)} in {place}"
                for place in dict.fromkeys(agents[0].goal_places)
            ]
            fact += f"; planning begins with {', '.join(shares)}"
        facts.append(fact)
    for assignment in scene.assignments:
        among = f"{len(assignment.points)} points, one each"
        facts.append(f"{count(len(assignment.members), 'agent')} may end on any of {among}")
    return facts


def _in(place: Place, agent: Agent) -> bool:
    """Whether a goal lies in a place (to rounding)."""
    return distance_outside(place, np.array(agent.goal)) <= 1e-6 * agent.radius


def _span(word: str, values: FloatArray, unit: str) -> str:
    low, high = float(values.min()), float(values.max())
    if low == high:
        return f"{word} {amount(low)} {unit}"
    least, most = distinct(low, high)
    return f"{word} {least} to {most} {unit}"


def passage_section(problem: PlanningProblem) -> Section:
    """Narrow places, the tightest for the radii that have to pass them first."""
    title, found = "Passages", passages(problem)
    if found is None:
        return Section("passages", title, "No agent has walls to mind.")
    if not found:
        wide = f"Nobody has to pass a place narrower than {2 * WIDE:g} of its radii."
        return Section("passages", title, wide)
    blocked = sum(bool(passage.blocked) for passage in found)
    lead = f"{count(len(found), 'narrow place')} on the widest ways"
    lead += f", {blocked} of them too narrow" if blocked else ""
    return Section("passages", title, lead + ":", [*map(_passage, found)])


def _passage(passage: Passage) -> Fact:
    spare = passage.half_width - passage.radius
    radius = metres(passage.radius)
    where = (
        f"the stop {at(passage.place)} of {names(passage.agents)} is {metres(passage.half_width)} "
        "from a wall"
        if passage.stop
        else f"the way of {names(passage.agents)} is {metres(2 * passage.half_width)} wide near "
        f"{at(passage.place)}"
    )
    if passage.blocked:
        who, more = names(passage.blocked), metres(-2 * spare)
        return Fact(
            f"{where}, too narrow for {who}: a radius of {radius} needs {more} more", passage
        )
    sides = "beyond" if passage.stop else "on either side of"
    alone = len(passage.agents) > 1 and not passage.stop and not passage.side_by_side
    room = f"which leaves {metres(spare)} {sides} a radius of {radius}"
    return Fact(f"{where}, {room}" + ("; one at a time" if alone else ""), passage)


def encounter_section(problem: PlanningProblem, alone: Sequence[FloatArray | None]) -> Section:
    """Who would meet whom if everybody took its way alone, at constant speed."""
    title, found = "Encounters", encounters(problem, alone)
    if not found.num_pairs:
        which = "agents" if found.all_able else "agents that can reach their goals"
        return Section("encounters", title, f"No two {which} have to keep apart.")
    if not found.found:
        lead = "On their shortest ways, at constant speed, no two would come too near."
        return Section("encounters", title, lead)
    lead = (
        f"If everybody took its shortest way at constant speed, {len(found.found)} of "
        f"{count(found.num_pairs, 'pair')} would come too near:"
    )
    return Section("encounters", title, lead, [*map(_encounter, found.found)])


def _encounter(encounter: Encounter) -> Fact:
    return Fact(
        f"{encounter.who[0]} and {encounter.who[1]} would be {metres(encounter.overlap)} too near at "
        f"t = {encounter.time:.2f} s, {at(encounter.place)}",
        encounter,
    )
