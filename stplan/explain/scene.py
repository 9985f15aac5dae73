"""A scene in words, before it is planned: who is there, what interacts, what is narrow, what cannot be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stplan.arrays import FloatArray
from stplan.certify.pair_clearance import nearest_moments
from stplan.errors import BROKEN_SEED, BrokenSeedError, SeedingError
from stplan.explain.detours import ways_alone
from stplan.explain.explanation import Explanation, Fact, Remark, Section, at, count, metres
from stplan.explain.passages import passages
from stplan.explain.run import motion
from stplan.planner import find_initial_curves, prepare
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import Scene
from stplan.wording import headline, sentences


@dataclass(frozen=True)
class Encounter:
    """Two agents that would come too near if everybody went as if alone: m, s."""

    who: tuple[str, str]
    overlap: float
    time: float
    place: tuple[float, float]

    def sentence(self) -> str:
        """In words."""
        return (
            f"{self.who[0]} and {self.who[1]} would be {metres(self.overlap)} too near at "
            f"t = {self.time:.2f} s, {at(self.place)}"
        )


def explain_scene(
    scene: Scene,
    *,
    time_limit: float,
    progress: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
) -> tuple[Explanation, bool]:
    """What is to be said of a scene, and whether it can be planned: exactly where `planner.plan` can.

    Args:
        time_limit: longest search for initial curves, s; 0 leaves them out.

    Raises:
        SceneError, SolverError, StoppedError: as `planner.plan`.
    """
    seeding = replace(scene.seeding, time_limit=min(time_limit, scene.seeding.time_limit))
    problem = prepare(scene if time_limit <= 0 else replace(scene, seeding=seeding))
    alone = ways_alone(problem)
    sections = [_population(scene), passages(scene, problem.free_space), _encounters(scene, alone)]
    if time_limit <= 0:
        return Explanation(f"{scene.name}: a valid scene.", tuple(sections)), True
    try:
        initial = find_initial_curves(problem, progress=progress, stop=stop)
    except SeedingError as error:
        title = f"{scene.name}: a valid scene, but there is no way to start."
        return Explanation(title, (*sections, _refusal(error))), False
    lead = (
        f"Found by {initial.seed.found_by}. What follows is about them; planning makes them smooth."
    )
    sections.append(Section("seeding", "Initial curves", lead))
    sections += motion(scene, initial.seed.world_lines, initial.certificate, alone)
    return Explanation(f"{scene.name}: a valid scene.", tuple(sections)), True


def _refusal(error: SeedingError) -> Section:
    """Why there are no initial curves."""
    if isinstance(error, BrokenSeedError):
        head, facts = BROKEN_SEED, error.violations
    else:
        head, facts = headline(error.reasons), tuple(sentences(error.reasons))
    return Section("seeding", "Initial curves", f"{head.capitalize()}:", [*map(Remark, facts)])


def _population(scene: Scene) -> Section:
    agents = scene.agents
    interactions = scene_interactions(scene)
    collide = int(np.triu(interactions.collides).sum())
    total = len(agents) * (len(agents) - 1) // 2
    told = sum(agent.path is not None for agent in agents)
    grouped = int(np.triu(interactions.grouping > 0).sum())
    facts: list[Fact] = []
    if total:
        facts.append(Remark(f"{collide} of {count(total, 'pair')} of agents may not touch"))
    if grouped:
        facts.append(Remark(f"{count(grouped, 'pair')} of agents are drawn together"))
    if told:
        facts.append(Remark(f"{count(told, 'agent')} moves as told" if told == 1
                            else f"{told} agents move as told"))  # fmt: skip
    ignoring = sum(agent.weights.wall == 0 for agent in agents)
    if scene.map is not None and ignoring:
        facts.append(Remark(f"{ignoring} of {count(len(agents), 'agent')} ignore the walls"))
    lead = (
        f"{count(len(agents), 'agent')} {_span('of radius', [a.radius for a in agents], 'm')} and "
        f"{_span('mass', [a.mass for a in agents], 'kg')}, within {scene.final_time:g} s"
    )
    return Section("population", "The scene", f"{lead}:" if facts else f"{lead}.", facts)


def _span(word: str, values: Sequence[float], unit: str) -> str:
    low, high = min(values), max(values)
    return f"{word} {low:g} {unit}" if low == high else f"{word} {low:g} to {high:g} {unit}"


def _encounters(scene: Scene, alone: Sequence[FloatArray | None]) -> Section:
    """Who would meet whom if everybody took its way alone, at constant speed."""
    title = "Encounters"
    able = [a for a, way in enumerate(alone) if way is not None]
    curves = [way for way in alone if way is not None]
    interactions = scene_interactions(scene)
    wanted = np.ascontiguousarray(interactions.collides[np.ix_(able, able)])
    total = int(np.triu(wanted).sum())
    if not total:
        which = "agents" if len(able) == len(alone) else "agents that can reach their goals"
        return Section("encounters", title, f"No two {which} have to keep apart.")
    lines = WorldLines.from_curves([scene.agents[a].id for a in able], curves)
    leaves = np.array(
        [
            scene.final_time if scene.agents[a].after_arrival == "stay" else curve[-1, 2]
            for a, curve in zip(able, curves, strict=True)
        ]
    )
    found = nearest_moments(lines, leaves, wanted)
    overlap = interactions.distance[np.ix_(able, able)][tuple(found.pairs.T)] - found.distance
    facts = []
    for k in np.argsort(-overlap, kind="stable").tolist():
        if overlap[k] <= 0:
            break
        a, b = found.pairs[k].tolist()
        x, y = found.middle[k].tolist()
        who = (lines.agent_ids[a], lines.agent_ids[b])
        facts.append(Encounter(who, float(overlap[k]), float(found.instant[k]), (x, y)))
    if not facts:
        return Section(
            "encounters",
            title,
            "Everybody can take its shortest way at constant speed: nobody meets.",
        )
    lead = (
        f"If everybody took its shortest way at constant speed, {len(facts)} of "
        f"{count(total, 'pair')} would come too near:"
    )
    return Section("encounters", title, lead, facts)
