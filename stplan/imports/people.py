"""Who is in an imported scene: the files' agents that fit, and those placed at random."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from stplan.errors import UsageError
from stplan.imports.crowd import Placer, apart, no_room
from stplan.maps.formats.drawing import Drawing, DrawnAgent
from stplan.world import FreeSpace, cut_off_agents

# Of grids, the radius of agents as a share of a cell.
CELL_SHARE = 0.3
RADIUS = 0.3


@dataclass(frozen=True)
class CrowdOptions:
    """Who is to be in the scene; None is what the files say.

    Attributes:
        agents: how many.
        rng_seed: of what is drawn at random.
        radius: of everybody, m.
        horizon: s.
        sources, goals: names of regions between which agents are placed.
        own: whether the files' agents are used.
    """

    agents: int | None = None
    rng_seed: int = 0
    radius: float | None = None
    horizon: float | None = None
    sources: tuple[str, ...] = ()
    goals: tuple[str, ...] = ()
    own: bool = True


@dataclass
class ReadFiles:
    """Everything that the files hold together.

    Attributes:
        drawing: in m.
        map_file: the one with the floor or walls.
        obstacles: polygons that others add to it, m.
    """

    drawing: Drawing
    map_file: Path | None
    obstacles: tuple[Any, ...] = ()
    notes: list[str] = field(default_factory=list)


def people(
    read: ReadFiles, free_space: FreeSpace | None, options: CrowdOptions
) -> list[DrawnAgent]:
    """The files' agents that fit, and those that are placed at random.

    Raises:
        UsageError: they do not fit.
    """
    drawing = read.drawing
    radius = options.radius or (CELL_SHARE * drawing.grid if drawing.grid else RADIUS)
    own = list(drawing.agents) if options.own and not (options.sources or options.goals) else []
    placer = None
    if free_space is not None:
        placer = Placer(
            free_space,
            _widest(own, drawing, options, radius),
            np.random.default_rng(options.rng_seed),
        )
    agents = [replace(agent, radius=options.radius or agent.radius or radius) for agent in own]
    agents = _with_goals(agents, placer, read)
    if options.agents is not None and len(agents) > 2 * options.agents:
        agents = agents[: 2 * options.agents]
    agents = _fitting(agents, free_space, read)
    if options.agents is not None:
        agents = agents[: options.agents]
    if placer is None:
        return agents
    for agent in agents:
        placer.take(agent.start, agent.goal or agent.start)
    agents += _flowing(drawing, options, placer, radius, len(agents), read)
    wanted = options.agents
    if wanted is not None and len(agents) < wanted:
        if agents:
            more = wanted - len(agents)
            read.notes.append(
                f"{len(agents)} agents of the files fit; {more} more are placed at random"
            )
        placed = _placed(placer, wanted - len(agents), radius, options, drawing, len(agents))
        agents += placed
        if len(agents) < wanted:
            raise no_room(len(agents), wanted, radius)
    return agents


def _widest(
    agents: list[DrawnAgent], drawing: Drawing, options: CrowdOptions, radius: float
) -> float:
    """The largest radius of anybody that is placed."""
    sizes = [agent.radius for agent in agents] + [
        options.radius or flow.radius or radius for flow in drawing.flows if options.own
    ]
    # Those who are asked for beyond the files' own have the usual radius.
    usual = radius if options.agents is not None else 0.0
    return max((size for size in (*sizes, usual) if size), default=radius)


def _with_goals(
    agents: list[DrawnAgent], placer: Placer | None, read: ReadFiles
) -> list[DrawnAgent]:
    """Agents without a goal get one at random: a goal or a named spot of the file, or anywhere."""
    if all(agent.goal is not None for agent in agents):
        return agents
    missing = sum(agent.goal is None for agent in agents)
    if placer is None:
        raise UsageError(f"{missing} agents have no goals, and there is no floor to draw any from")
    goals = [shape for name, shape in read.drawing.regions.items() if name.startswith("goal")]
    spots = [*read.drawing.spots.values()]
    found = []
    for agent in agents:
        goal = agent.goal or placer.goal_for(agent.start, goals, spots)
        if goal is not None:
            found.append(replace(agent, goal=goal))
    where = "in its goals " if goals else "among its named spots " if spots else ""
    read.notes.append(
        f"{missing} agents have no goals in the file; theirs are drawn {where}at random"
    )
    return found


def _fitting(
    agents: list[DrawnAgent], free_space: FreeSpace | None, read: ReadFiles
) -> list[DrawnAgent]:
    """Agents that stand free of walls and of each other, and can get where they want."""
    if not agents:
        return []
    starts = np.array([agent.start for agent in agents])
    goals = np.array([agent.goal for agent in agents])
    sizes = np.array([agent.radius for agent in agents], dtype=np.float64)
    keep = np.ones(len(agents), dtype=bool)
    if free_space is not None:
        keep &= (free_space.clearance(starts) > sizes) & (free_space.clearance(goals) > sizes)
    _left_out(read, int((~keep).sum()), "start or end in a wall or too near one")
    for places, what in ((starts, "start"), (goals, "end")):
        # Those that vanish may share a goal.
        asked = keep & np.array([what == "start" or not agent.vanishes for agent in agents])
        index = np.flatnonzero(asked)
        kept = set(index[apart(places[index], 2 * sizes[index])].tolist())
        crowded = asked & ~np.isin(np.arange(len(agents)), list(kept))
        keep &= ~crowded
        _left_out(read, int(crowded.sum()), f"{what} where another one does")
    index = np.flatnonzero(keep)
    stops = [np.stack([starts[k], goals[k]]) for k in index]
    cut_off = index[cut_off_agents(free_space, stops, sizes[index])]
    keep[cut_off] = False
    _left_out(read, len(cut_off), "cannot get to their goals at their radius")
    return [agent for agent, kept in zip(agents, keep.tolist(), strict=True) if kept]


def _left_out(read: ReadFiles, count: int, why: str) -> None:
    if count:
        read.notes.append(f"{count} agents are left out: they {why}")


def _flowing(
    drawing: Drawing,
    options: CrowdOptions,
    placer: Placer,
    radius: float,
    before: int,
    read: ReadFiles,
) -> list[DrawnAgent]:
    """Agents of sources, at random places in them."""
    if not options.own or options.sources or options.goals:
        return []
    found: list[DrawnAgent] = []
    for number, flow in enumerate(drawing.flows):
        wanted = flow.count or 0
        if options.agents is not None:
            left = options.agents - before - len(found)
            wanted = min(flow.count or left, math.ceil(left / (len(drawing.flows) - number)))
        sources = [drawing.regions[name] for name in flow.sources if name in drawing.regions]
        goals = [drawing.regions[name] for name in flow.goals if name in drawing.regions]
        placed = placer.trips(wanted, sources, goals, share_goals=flow.vanishes)
        if len(placed) < wanted:
            read.notes.append(
                f"{len(placed)} of {wanted} agents fit into {', '.join(flow.sources)}"
            )
        found += [
            DrawnAgent(
                f"a{before + len(found) + k}", one.start, one.goal, options.radius or flow.radius or radius,
                max_speed=flow.max_speed, vanishes=flow.vanishes,
            )
            for k, one in enumerate(placed, 1)
        ]  # fmt: skip
    return found


def _placed(
    placer: Placer, count: int, radius: float, options: CrowdOptions, drawing: Drawing, before: int
) -> list[DrawnAgent]:
    """Agents at random places, between named regions where any are named."""
    areas = []
    for names in (options.sources, options.goals):
        missing = [name for name in names if name not in drawing.regions]
        if missing:
            known = ", ".join(drawing.regions) or "none"
            raise UsageError(f"there is no region {missing[0]!r}; there are: {known}")
        areas.append([drawing.regions[name] for name in names])
    trips = placer.trips(count, *areas)
    return [
        DrawnAgent(f"a{before + k}", one.start, one.goal, radius) for k, one in enumerate(trips, 1)
    ]
