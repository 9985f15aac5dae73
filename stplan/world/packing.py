"""Places with too little room for all who stay in them, by proof.

Centres of discs that stay are pairwise at least d apart once the last one has come. A compact convex set of
area A and perimeter P holds at most 2 A / (sqrt(3) d^2) + P / (2 d) + 1 such points (Oler, *An inequality
in the geometry of numbers*, 1961), and the perimeter of a line is twice its length. Other places hold no more
than the convex hulls of their parts together, nor than the one hull of all. Along a line of length l, bent or
not, at most l / d + 1 points are d apart.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stplan.amounts import amount
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene
from stplan.scene.places import Place

if TYPE_CHECKING:
    import shapely

    from stplan.world.places import StandingRoom

# Pairs of more agents than this are not looked at: so many are too many already, or few enough.
MOST_STAYING = 1000
# Distances are taken to be smaller by this share, against rounding.
ROUNDING = 1e-6


def most_apart(room: shapely.Geometry, distance: float) -> float:
    """No more points of `room` than this are pairwise `distance` (m) apart; at least 1 unless it is empty."""
    import shapely

    parts = [part for part in shapely.get_parts(room) if not part.is_empty]
    if not parts:
        return 0.0
    whole = _in_hull(shapely.union_all(parts), distance)
    apart = distance * (1.0 - ROUNDING)
    bent = (
        shapely.length(part) / apart + 1.0 if shapely.area(part) == 0.0 else math.inf
        for part in parts
    )
    each = sum(
        math.floor(min(_in_hull(part, distance), along))
        for part, along in zip(parts, bent, strict=True)
    )
    return float(min(math.floor(whole), each))


def _in_hull(part: shapely.Geometry, distance: float) -> float:
    """The bound for its convex hull."""
    import shapely

    hull, apart = shapely.convex_hull(part), distance * (1.0 - ROUNDING)
    flat = shapely.area(hull) == 0.0
    perimeter = (2.0 if flat else 1.0) * shapely.length(hull)
    area = float(shapely.area(hull))
    return float(2.0 * area / (math.sqrt(3.0) * apart**2) + perimeter / (2.0 * apart) + 1.0)


def overfull_places(scene: Scene, room: StandingRoom) -> list[str]:
    """One located message for every choice of places in which more agents stay than can."""
    staying: dict[tuple[Place, ...], list[int]] = {}
    for a, agent in enumerate(scene.agents):
        if agent.goal_places and agent.after_arrival == "stay":
            staying.setdefault(agent.goal_places, []).append(a)
    choices_of: dict[Place, dict[tuple[Place, ...], None]] = {}
    for places in staying:
        for place in places:
            choices_of.setdefault(place, {})[places] = None
    settings = PairSettings(scene)
    messages = []
    for places, members in staying.items():
        known = frozenset(places)
        beside = dict.fromkeys(other for place in places for other in choices_of[place])
        within = (other for other in beside if known.issuperset(other))
        everyone = [a for other in within for a in staying[other]]
        own = everyone[:MOST_STAYING]
        if len(own) < 2:
            continue
        pairs = settings.between(np.array(own), np.array(own))
        others = ~np.eye(len(own), dtype=bool)
        if not pairs.collides[others].all():
            continue
        apart = float(pairs.distance[others].min())
        agents = [scene.agents[a] for a in own]
        radius = min(agent.radius if agent.weights.wall > 0 else 0.0 for agent in agents)
        most = sum(most_apart(room.within(place, radius), apart) for place in known)
        if len(own) > most:
            which = " and ".join(dict.fromkeys(str(place) for place in places))
            verb = "has" if len(known) == 1 else "have"
            text = (
                f"{which} {verb} room for at most {most:.0f} who stay {amount(apart)} m apart, "
                f"not for {len(everyone)}"
            )
            messages.append(scene.located(f"{scene.entry_path(members[0])}.goal", text))
    return messages
