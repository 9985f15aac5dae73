"""Emptying: those nearest their goals go first, and everyone not planned yet stands where it starts.

A crowd behind a door blocks itself when everybody's way is sought at once. Here an agent is planned among the
rods of those that went before it, while all others stand on their starts for as long as it takes them to
be planned: the start of each is reserved until its own turn. Agents take turns by the length of their ways;
one that finds no way yet waits for the next round.

Where agents vanish at their goals this cannot fail on a floor that can be emptied one by one: if some agent
has a way to its goal among all others standing still, it may take it before anybody else moves, then it is
gone, and the rest is a smaller scene of the same kind. What it needs is time enough for all, one after
another; as rods planned later fit in between those planned before, it mostly needs far less.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from stplan.arrays import FloatArray
from stplan.deadline import heed
from stplan.problem.verification import verify
from stplan.reasons import Reason
from stplan.seeding.margins import margin_ladder
from stplan.seeding.search.levels import Levels, off_roadmap, out_of_layers
from stplan.seeding.search.planner import LayeredPlanner
from stplan.seeding.seeder import Budget, SeedAttempt, SeedRecord

# Margins (by their place on the ladder) and multiples of the level's layers that are tried.
STAGES = ((0, 1), (1, 1), (1, 2))
# Ways sought at most, for every agent: where nobody can leave, looking again and again takes long.
WAYS_AN_AGENT = 3


@dataclass(frozen=True)
class Emptying:
    """Clear curves of a crowd that leaves by few ways."""

    name: ClassVar = "emptying"
    levels: Levels

    def attempt(self, budget: Budget) -> SeedAttempt:
        """Rounds on ever smaller margins and more layers, until everybody has a way."""
        reasons: tuple[Reason, ...] = ()
        tries = 0
        problem = self.levels.problem
        margins = margin_ladder(problem.scene.seeding.margin)
        for place, layers in STAGES:
            if budget.spent() or place >= len(margins):
                break
            level = self.levels.at(margins[place])
            if level.journeys.stranded():
                reasons = reasons or off_roadmap(level)
                continue
            planner = level.planner(layers)
            if planner.too_late():
                reasons = reasons or out_of_layers(planner)
                continue
            curves, tried = _empty(planner, budget)
            tries += tried
            if curves is not None and not verify(problem, curves, planner.required):
                record = SeedRecord(margin=level.margin, tries=tries)
                return SeedAttempt(f"search ({self.name})", curves, clear=True, record=record)
        return SeedAttempt(f"search ({self.name})", record=SeedRecord(tries=tries), reasons=reasons)


def _empty(planner: LayeredPlanner, budget: Budget) -> tuple[list[FloatArray] | None, int]:
    """Curves of all agents, None where somebody finds none; and how many ways were sought."""
    planner.reset()
    left = _turns(planner)
    guards = {}
    for agent in left:
        heed()
        guards[agent] = planner.guard(agent, planner.grid.count)
        planner.add(guards[agent])
    curves = [path if path is not None else np.empty((0, 3)) for path in planner.problem.paths]
    tries = 0
    while left:
        for agent in left:
            if budget.spent() or tries >= WAYS_AN_AGENT * len(planner.movers):
                return None, tries
            tries += 1
            planner.remove(guards[agent])
            path = planner.path(agent)
            if path is not None:
                curves[agent] = planner.curve(agent, path)
                planner.add(planner.blocks(agent, curves[agent]))
                left.remove(agent)
                break
            planner.add(guards[agent])
        else:
            return None, tries
    return curves, tries


def _turns(planner: LayeredPlanner) -> list[int]:
    """All agents in the order of their turns: nearest first.

    Where some stay in places, those who vanish come before them, and of those who stay the ones with spots
    furthest from where anybody of them starts come first: nobody stands in the way to a spot behind its own.
    """
    problem, distance = planner.problem, planner.journeys.distance
    filling = [
        agent
        for agent in planner.movers
        if problem.stays[agent] and problem.scene.agents[agent].goal_places
    ]
    nearest = {agent: int(distance[agent]) for agent in planner.movers}
    others = [agent for agent in planner.movers if agent not in filling]
    first = sorted(others, key=nearest.__getitem__)
    if not filling:
        return first
    step = problem.goals[filling, None] - problem.starts[None, filling]
    depth = np.hypot(step[:, :, 0], step[:, :, 1]).min(axis=1)
    return first + [filling[k] for k in np.argsort(-depth, kind="stable")]
