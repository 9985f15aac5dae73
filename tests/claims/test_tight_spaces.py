"""Passages, lanes, seats and mazes: what happens where only one agent fits."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest

from tests.claims.plans import (
    arrival,
    curves,
    path_length,
    places,
    planned,
    presence,
    slowest_over_fastest,
    smallest_gap,
    straight_length,
)

PASSAGE = (10.0, 4.7, 12.0, 6.3)


@pytest.mark.parametrize(
    "name", [pytest.param("platform", marks=pytest.mark.claims), "platform-tight"]
)
def test_one_at_a_time_through_the_subway_passage(name, claim):
    """In the subway "only one agent can move through the intersection at a time"."""
    scene = f"subway/{name}"
    until = planned(scene).scene.final_time
    found = curves(scene)
    visits = {agent: presence(own, PASSAGE, until) for agent, own in found.items()}
    assert all(len(own) == 1 for own in visits.values())
    down = {agent for agent, own in found.items() if own[0, 1] > own[-1, 1]}
    opposed = [(a, b) for a, b in combinations(visits, 2) if (a in down) != (b in down)]
    assert len(opposed) >= 3
    # The passage fits one, so opposed traffic has to change its direction; how often is the planner's choice.
    order = [agent in down for agent in sorted(visits, key=lambda agent: visits[agent][0, 0])]
    turns = sum(before != after for before, after in pairwise(order))
    claim(planned(scene).scene.name, f"changes of direction in the passage, of {len(order)} agents", turns,
          at_most=len(order) // 2)  # fmt: skip
    gap = min(smallest_gap([visits[a], visits[b]]) for a, b in opposed)
    alone = np.mean([np.ptp(own[0]) for own in visits.values()])
    claim(planned(scene).scene.name, "shortest pause between opposed agents over a mean passing", gap / alone,
          at_most=1.5)  # fmt: skip
    by_itself = curves(scene, "pairs=[{between: [all, all], collide: false}]")
    slowed = min(
        slowest_over_fastest(own) / slowest_over_fastest(by_itself[agent])
        for agent, own in found.items()
    )
    claim(planned(scene).scene.name, "slowest over fastest of whoever waits most, over its own alone",
          slowed, at_most=0.7)  # fmt: skip


def test_robots_wait_for_one_another_in_the_maze(claim):
    """Roombas in a maze take turns at its crossing, and nobody gets stuck."""
    found = curves("roomba/roomba")
    claim("roomba", "longest path over straight", max(
        path_length(own) / straight_length(own) for own in found.values()
    ), at_most=2.0)  # fmt: skip
    slowest = min(slowest_over_fastest(own) for own in found.values())
    claim("roomba", "slowest over fastest of whoever waits longest", slowest, at_most=0.9)


def test_in_the_bottleneck_someone_is_late_by_as_much_as_needed(claim):
    """At a bottleneck agents "simply cannot arrive at their destinations by their preferred times"."""
    name = "bottleneck/bottleneck"
    agents = planned(name).scene.agents
    together = curves(name)
    alone = curves(name, "pairs=[{between: [all, all], collide: false}]")
    through = sorted(_passes(own, 10.0) for own in together.values())
    late = [arrival(together[agent.id]) - arrival(alone[agent.id]) for agent in agents]
    # One after another, R = 0.9 m apart in space and time: nobody can pass sooner after the one before.
    headways = np.diff(through)
    claim("bottleneck", "least time between two in the gap, s", headways.min(), at_least=0.3)
    claim(
        "bottleneck", "time from the first to the last in the gap, s", np.ptp(through), at_most=5.0
    )
    claim("bottleneck", "delay by the others: least of all, s", min(late), at_most=0.5)
    claim("bottleneck", "delay by the others: most of all, s", max(late), at_least=0.5, at_most=4.0)


def _passes(curve: np.ndarray, x: float) -> float:
    """When an agent that walks to the right passes `x`."""
    return float(np.interp(x, curve[:, 0], curve[:, 2]))


def test_in_the_tunnel_the_heavy_wagon_moves_aside_less(claim):
    """Masses count in tight spaces too: the lighter agent squeezes past the heavier."""
    aside = {agent: np.abs(own[:, 1] - 1.2).max() for agent, own in curves("tunnel/tunnel").items()}
    claim("tunnel", "wagon's over miner's deviation", aside["wagon"] / aside["miner"], at_most=0.5)


def test_in_the_lane_one_backs_into_the_pocket(claim):
    """Lanes fit "only a single agent and agents have to take turns to pass through"."""
    found = curves("tight/pocket-swap")
    deep = [own[:, 1].max() for own in found.values()]
    claim("pocket-swap", "how far one backs into the pocket, m", max(deep) - 0.35, at_least=0.5)
    claim("pocket-swap", "how far the other one does, m", min(deep) - 0.35, at_most=0.1)


@pytest.mark.claims
def test_robots_take_turns_in_the_warehouse(claim):
    """In a "tight warehouse of robots" agents take turns in the lanes "to avoid locking"."""
    found = curves("tight/warehouse")
    until = planned("tight/warehouse").scene.final_time
    # Between two crossings a lane of 0.8 m holds one robot of 0.6 m across.
    lanes = [(x, y, x + 1.2, y + 0.8) for x in (1.0, 3.4, 5.8, 8.2, 10.6) for y in (1.7, 3.4, 5.1)]
    opposed = []
    for lane in lanes:
        for (_, first), (_, second) in combinations(found.items(), 2):
            for a in presence(first, lane, until):
                for b in presence(second, lane, until):
                    if _direction(first, a) * _direction(second, b) < 0:
                        opposed.append(max(b[0] - a[1], a[0] - b[1]))
    assert min(opposed) > 0.0
    claim("warehouse", "opposed robots that share a lane one after the other, pairs", len(opposed),
          at_least=1)  # fmt: skip
    alone = curves("tight/warehouse", "pairs=[{between: [all, all], collide: false}]")
    longer = sum(map(path_length, found.values())) / sum(map(path_length, alone.values()))
    claim("warehouse", "all paths over those of the robots alone", longer, at_most=1.6)


def _direction(curve: np.ndarray, visit: np.ndarray) -> float:
    """Sign of the way through a lane along x, 0 for whoever comes out where it went in."""
    enters, leaves = places(curve, visit)[:, 0]
    return float(np.sign(leaves - enters)) if abs(leaves - enters) > 0.6 else 0.0


@pytest.mark.claims
@pytest.mark.parametrize("name", ["tight/cabin", "aircraft/first-class"])
def test_passengers_find_their_seats(name, claim):
    """Passengers of an aircraft, "all in incorrect seats", reach theirs through the aisle."""
    scene = planned(name).scene
    assert all(agent.start != agent.goal for agent in scene.agents)
    found = curves(name)
    alone = curves(name, "pairs=[{between: [all, all], collide: false}]")
    longer = [path_length(found[agent.id]) / path_length(alone[agent.id]) for agent in scene.agents]
    claim(scene.name, "median path over that of the passenger alone", float(np.median(longer)),
          at_most=1.1)  # fmt: skip
    # In an aisle that fits one, who sits further in goes first, or the others step out of its way.
    cost = [sum(one.kinetic_energy for one in planned(name, *settings).report.metrics.agents)
            for settings in ((), ("pairs=[{between: [all, all], collide: false}]",))]  # fmt: skip
    claim(scene.name, "energy over that of everybody alone", cost[0] / cost[1], at_most=4.0)


@pytest.mark.claims
@pytest.mark.parametrize("name", ["mazes/corn", "mazes/rings"])
def test_mazes_are_navigated(name, claim):
    """Agents "navigate the mazes while avoiding collisions with each other at the bottlenecks"."""
    scene = planned(name).scene
    alone = curves(name, "pairs=[{between: [all, all], collide: false}]")
    longer = max(
        path_length(own) / path_length(alone[agent]) for agent, own in curves(name).items()
    )
    claim(scene.name, "longest path over that of the agent alone", longer, at_most=1.05)
