"""One generic sample of every cost room: unequal masses and weights, both sides of every switch."""

from __future__ import annotations

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.acceleration import Acceleration
from stplan.costs.acceleration_limit import AccelerationLimit, RestLimit
from stplan.costs.arrival import Arrival
from stplan.costs.collision import Collision
from stplan.costs.grouping import Grouping
from stplan.costs.kinetic import Kinetic
from stplan.costs.limit import Barrier, Penalty
from stplan.costs.meeting import MeetingLimit
from stplan.costs.regularity import Regularity
from stplan.costs.speed_limit import SpeedLimit
from stplan.costs.term import Term
from stplan.costs.timing import NONE, Timing
from stplan.costs.wall import Wall
from stplan.problem.layout import KnotLayout
from stplan.problem.rods import Rods
from stplan.scene.interactions import Interactions

OFFSETS = np.array([0, 6, 12, 19])
LAYOUT = KnotLayout.from_offsets(OFFSETS)
RADII = np.array([0.02, 0.03, 0.04])
CORNERS = np.array(
    [[-1, -1.2], [7, -1], [7.5, 3], [3, 2.9], [-1, 3.2], [2.9, 0.45], [3, 0.55], [3.2, 0.4]]
)
EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0], [5, 6], [6, 7], [7, 5]])


def sample_knots(rng_seed: int = 3) -> FloatArray:
    """(19, 3) three agents that pass each other in a room with a pillar."""
    rng = np.random.default_rng(rng_seed)
    knots = np.zeros((LAYOUT.num_knots, 3))
    for a in range(3):
        own = slice(OFFSETS[a], OFFSETS[a + 1])
        count = OFFSETS[a + 1] - OFFSETS[a]
        along = np.linspace(0, 6, count)
        knots[own, 0] = (along if a % 2 else 6 - along) + rng.normal(size=count) * 0.2
        knots[own, 1] = a + rng.normal(size=count) * 0.1
        knots[own, 2] = np.cumsum(rng.uniform(0.7, 1.3, count))
    return knots


def sample_interactions() -> Interactions:
    """All collide at 0.5 m with unequal weights; agent 0 is grouped with both others."""
    weight = np.array([[0, 1.2, 1.7], [1.2, 0, 0.9], [1.7, 0.9, 0]])
    grouping = np.array([[0, 2.0, 0.5], [2.0, 0, 0], [0.5, 0, 0]])
    return Interactions(~np.eye(3, dtype=bool), np.full((3, 3), 0.5), weight, grouping)


def sample_terms(exact: bool = True) -> dict[str, Term]:
    """Every room under a label, ready to be differentiated at `sample_knots()`."""
    knots = sample_knots()
    weights = np.array([2.0, 3.0, 0.7])
    interactions = sample_interactions()
    # One tail only: two upright tails have no unique closest points when their feet are moved.
    rods = Rods.build(LAYOUT, knots, np.array([2]), 12.0, 1.3)
    terms: dict[str, Term] = {
        "kinetic": Kinetic(LAYOUT, weights, np.array([1.0, 5.0, 2.0])),
        "acceleration": Acceleration(LAYOUT, np.array([2.0, 0.0, 0.7]), 1.7),
        "arrival": Arrival(LAYOUT, weights, np.array([3.0, 4.0, 9.0])),
        "regularity": Regularity(LAYOUT, weights, np.array([0.1, 0.2, 0.0]), exact=exact),
        "grouping": Grouping(knots, rods, interactions, 3.0, exact=exact),
    }
    timed = np.array([[2, 8], [8, 2], [3, 4], [NONE, 9], [NONE, 14], [9, 10]])
    terms["timing"] = Timing(
        timed,
        np.array([0.5, 0.1, 2.0, 0.0, 9.0, 0.1]),
        np.array([0.7, 0.2, 3.0, 2.0, 12.0, 5.0]),
        1.7,
        len(knots),
    )
    speeds, accelerations = np.array([2.5, np.inf, 4.0]), np.array([np.inf, 0.5, 2.5])
    starts = np.array([np.inf, 4.5, 6.5])
    links, within = np.array([[2, 8], [7, 14]]), np.array([4.5, 4.0])
    # The penalty's aim lies below some of the vectors and above others.
    for profile in (Barrier(0.7, 0.9), Barrier(0.7, np.inf), Penalty(1.3, 0.4)):
        label = str(profile)
        terms[f"speed limit, {label}"] = SpeedLimit(LAYOUT, speeds, profile)
        terms[f"acceleration limit, {label}"] = AccelerationLimit(LAYOUT, accelerations, profile)
        terms[f"rest limit, {label}"] = RestLimit(LAYOUT, starts, profile)
        terms[f"meeting, {label}"] = MeetingLimit(links, within, profile, len(knots))
    for reach in (1.5, np.inf):
        for alpha_0 in (None, 8.0):
            label = f"range {reach}, {'contacts' if alpha_0 is None else 'smooth minimum'}"
            terms[f"collision, {label}"] = Collision(
                knots, rods, interactions, 0.7, np.full((3, 3), reach),
                alpha_0=alpha_0, exact=exact,
            )  # fmt: skip
            terms[f"wall, {label}"] = Wall(
                knots, LAYOUT, CORNERS, EDGES, RADII, np.array([1.0, 0.0, 2.0]), 0.7,
                np.full(3, reach), alpha_0=alpha_0, exact=exact,
            )  # fmt: skip
    return terms
