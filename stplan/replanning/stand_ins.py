"""Scenes with agents that only stand in for others, and the plans that are left when they are taken out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stplan import planner
from stplan.analysis.arrival_gap import arrival_gap
from stplan.analysis.cost_bound import cost_bound
from stplan.analysis.metrics import metrics
from stplan.arrays import BoolArray, FloatArray
from stplan.certify.certificate import certify
from stplan.errors import BrokenSeedError
from stplan.planned import Plan
from stplan.problem.ends import ending_as, fixed_at
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import space_of
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Agent, PairRule, Scene, Weights


@dataclass(frozen=True)
class StandIns:
    """What stands in for an agent.

    Attributes:
        agent: index of whom.
        paths: (n, 3) prescribed motions; whoever makes them vanishes or stays as the agent does.
        heeded: (A,) who keeps its distance from them, as from the agent.
        wider: what is added to these distances, m.
        stays: whether they stay at the end of their paths.
    """

    agent: int
    paths: Sequence[FloatArray]
    heeded: BoolArray
    wider: float = 0.0
    stays: bool = True


def with_stand_ins(scene: Scene, groups: Sequence[StandIns]) -> Scene:
    """`scene` with stand-ins after all others: they cost nothing, and keep no distance from each other."""
    everyone = np.arange(len(scene.agents))
    settings = PairSettings(scene)
    added: list[Agent] = []
    rules: list[PairRule] = []
    for group in groups:
        a, first = group.agent, len(everyone) + len(added)
        own = tuple(range(first, first + len(group.paths)))
        added += [_stand_in(scene.agents[a], group, k) for k in range(len(group.paths))]
        pairs = settings.between(np.array([a]), everyone)
        distances, weights = pairs.distance[0] + group.wider, pairs.collision_weight[0]
        heeded = np.flatnonzero(pairs.collides[0] & group.heeded).tolist()
        for distance, weight in sorted({(distances[b], weights[b]) for b in heeded}):
            members = tuple(b for b in heeded if (distances[b], weights[b]) == (distance, weight))
            rules.append(
                PairRule(own, members, float(distance), collide=True, collision=float(weight))
            )
    every = tuple(range(len(everyone) + len(added)))
    alone = PairRule(every[len(everyone) :], every, collide=False)
    return replace(
        scene,
        agents=(*scene.agents, *added),
        pairs=(*scene.pairs, alone, *rules),
        agent_paths=(
            *(scene.agent_path(a) for a in everyone.tolist()), *(one.id for one in added)
        ),
    )  # fmt: skip


def _stand_in(agent: Agent, group: StandIns, number: int) -> Agent:
    path = group.paths[number]
    (x, y, t), (u, v, end) = path[0].tolist(), path[-1].tolist()
    nothing = Weights(kinetic=0.0, regularity=0.0, wall=0.0, clearance=0.0)
    return replace(
        agent, id=f"{agent.id}, {number + 1}", path=tuple(map(tuple, path.tolist())),
        start=(x, y), goal=(u, v), start_time=t, max_time=end, preferred_time=None, weights=nothing,
        clearance=0.0, after_arrival=agent.after_arrival if group.stays else "vanish", goal_places=(),
        waypoints=(), visits=(), max_speed=None, max_acceleration=None, start_velocity=None,
        start_duration=0.0,
    )  # fmt: skip


def as_planned(scene: Scene, found: Plan, seed: WorldLines, lines: WorldLines | None) -> Plan:
    """The plan of `scene` that is left of one with stand-ins: certified anew, with figures of its own.

    Args:
        seed, lines: of the agents of `scene`, in its order.

    Raises:
        BrokenSeedError: they do not hold their certificate.
    """
    ends = {agent.id: agent.goal for agent in found.scene.agents}
    settled = replace(
        found.scene,
        agents=tuple(replace(agent, goal=ends[agent.id]) for agent in scene.agents),
        pairs=scene.pairs,
        agent_paths=scene.agent_paths,
        seeding=scene.seeding,
        overlap=scene.overlap,
    )
    best, space = seed if lines is None else lines, space_of(scene)
    certificate = certify(settled, space, best)
    if not certificate.holds:
        raise BrokenSeedError(certificate.violations)
    tightest = certify(settled, space, seed).smallest
    first = replace(
        found.report.seed,
        smallest_clearance=None if tightest is None else tightest.clearance,
        metrics=metrics(ending_as(settled, seed), seed),
    )
    content = replace(
        found.report, scene=settled, certificate=certificate, metrics=metrics(ending_as(settled, best), best),
        seed=first,
    )  # fmt: skip
    if content.bound is not None or content.arrivals is not None:
        problem = planner.prepare(fixed_at(settled, best))
        content = replace(
            content,
            bound=None if content.bound is None else cost_bound(problem, best),
            arrivals=None if content.arrivals is None else arrival_gap(problem, best),
        )
    return Plan(seed, lines, content, found.run)


def first_lines(lines: WorldLines, count: int) -> WorldLines:
    """Those of the first `count` agents."""
    return WorldLines.from_curves(lines.agent_ids[:count], list(lines.curves())[:count])
