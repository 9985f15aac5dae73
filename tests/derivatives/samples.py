"""One generic sample of every cost room: unequal masses and weights, both sides of every switch."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.contacts.shares import knot_shares, rod_shares
from stplan.costs.contacts.smooth_minimum import SmoothMinimum
from stplan.costs.contacts.wall_candidates import EdgeSearch, WallCandidates
from stplan.costs.limit import LimitBarrier, LimitPenalty
from stplan.costs.terms.acceleration import Acceleration
from stplan.costs.terms.acceleration_limit import AccelerationLimit, RestLimit
from stplan.costs.terms.arrival import Arrival
from stplan.costs.terms.clearance_wish import PairClearance, WallClearance
from stplan.costs.terms.collision import Collision
from stplan.costs.terms.grouping import Grouping
from stplan.costs.terms.haste import Haste
from stplan.costs.terms.kinetic import Kinetic
from stplan.costs.terms.meeting import MeetingLimit
from stplan.costs.terms.regularity import Regularity
from stplan.costs.terms.speed_limit import SpeedLimit
from stplan.costs.terms.timing import NONE, Intervals, Timing
from stplan.costs.terms.wall import Wall
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.nlp.term import Term
from stplan.problem.layout import KnotLayout
from stplan.problem.rods import Rods
from stplan.scene.interactions import Interactions

OFFSETS = np.array([0, 6, 12, 19])
LAYOUT = KnotLayout.from_offsets(OFFSETS)
VELOCITIES = np.array([[0.3, 0.1], [0.5, -0.4], [-0.2, 0.7]])
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


# One tail only: two upright tails have no unique closest points when their feet are moved.
RODS = Rods.build(LAYOUT, sample_knots(), np.array([2]), 12.0, 1.3)
BOUNDARY = BoundaryGrid.from_segments(np.hstack([CORNERS[EDGES[:, 0]], CORNERS[EDGES[:, 1]]]))
WEIGHTS = np.array([2.0, 3.0, 0.7])
# The penalty's aim lies below some of the vectors and above others.
PROFILES = (LimitBarrier(0.7, 0.9), LimitBarrier(0.7, np.inf), LimitPenalty(1.3, 0.4))
REACHES = (1.5, np.inf)
SMOOTH = (None, SmoothMinimum(8.0))


def _timing() -> Timing:
    timed = np.array([[2, 8], [8, 2], [3, 4], [NONE, 9], [NONE, 14], [9, 10]])
    aim = Intervals(
        np.array([0.5, 0.1, 2.0, 0.0, 9.0, 0.1]), np.array([0.7, 0.2, 3.0, 2.0, 12.0, 5.0])
    )
    return Timing(timed, aim, 1.7, LAYOUT.num_knots)


def sample_collision(reach: float, smooth: SmoothMinimum | None) -> Collision:
    """All three rods of `sample_knots()`; the outer two are out of a finite reach."""
    reaches = np.full((3, 3), reach)
    if np.isfinite(reach):
        reaches[0, 2] = reaches[2, 0] = 0.3
    return Collision(sample_knots(), RODS, sample_interactions(), 0.7, reaches, smooth=smooth)


def sample_wall(
    reach: float, smooth: SmoothMinimum | None, search: EdgeSearch | None = None
) -> Wall:
    """The room and its pillar; the second agent minds no walls, the third is out of a finite reach."""
    reaches = np.array([reach, reach, 0.2 if np.isfinite(reach) else reach])
    return Wall(
        sample_knots(), LAYOUT, BOUNDARY, CORNERS, EDGES, RADII, np.array([1.0, 0.0, 2.0]), 0.7,
        reaches, smooth=smooth, search=search,
    )  # fmt: skip


def _pair_clearance() -> PairClearance:
    interactions = sample_interactions()
    wish = np.array([[0.0, 2.5, 0.4], [2.5, 0.0, 1.5], [0.4, 1.5, 0.0]])
    return PairClearance(
        sample_knots(), RODS, interactions.collides, interactions.distance, wish, 3.0 * wish,
        rod_shares(RODS, LAYOUT.num_knots),
    )  # fmt: skip


def _wall_clearance() -> WallClearance:
    wish = np.array([1.5, 0.0, 2.0])
    candidates = WallCandidates(
        LAYOUT, LAYOUT.segment, CORNERS, EDGES, RADII + wish, BOUNDARY
    )  # fmt: skip
    return WallClearance(
        sample_knots(), candidates, RADII, wish, WEIGHTS, knot_shares(LAYOUT, len(CORNERS))
    )


def samples() -> dict[str, dict[str, Callable[[], Term]]]:
    """By the name of every registered term: its variants, ready to be differentiated at `sample_knots()`."""
    speeds, accelerations = np.array([2.5, np.inf, 4.0]), np.array([np.inf, 0.5, 2.5])
    starts = np.array([np.inf, 4.5, 6.5])
    links, within = np.array([[2, 8], [7, 14]]), np.array([5.5, 4.0])
    models = {
        f"range {reach}, {'contacts' if smooth is None else 'smooth minimum'}": (reach, smooth)
        for reach in REACHES
        for smooth in SMOOTH
    }
    return {
        "kinetic": {"": lambda: Kinetic(LAYOUT, WEIGHTS, np.array([1.0, 5.0, 2.0]))},
        "acceleration": {"": lambda: Acceleration(LAYOUT, np.array([2.0, 0.0, 0.7]), 1.7)},
        "arrival": {"": lambda: Arrival(LAYOUT, WEIGHTS, np.array([3.0, 4.0, 9.0]))},
        "haste": {
            f"power {power:g}": partial(
                Haste, LAYOUT, WEIGHTS, np.array([0.5, 1.0, -0.3]), 6.5, power
            )
            for power in (3.0, 8.0)
        },
        "regularity": {"": lambda: Regularity(LAYOUT, WEIGHTS, np.array([0.1, 0.2, 0.0]))},
        "grouping": {"": lambda: Grouping(sample_knots(), RODS, sample_interactions(), 3.0)},
        "timing": {"": _timing},
        "speed limit": {str(one): partial(SpeedLimit, LAYOUT, speeds, one) for one in PROFILES},
        "acceleration limit": {
            str(one): partial(AccelerationLimit, LAYOUT, accelerations, one) for one in PROFILES
        },
        "rest limit": {
            f"{one}, {'from rest' if before is None else 'in motion'}": partial(
                RestLimit, LAYOUT, starts, one, None, before
            )
            for one in PROFILES
            for before in (None, VELOCITIES)
        },
        "meeting": {
            str(one): partial(MeetingLimit, links, within, one, LAYOUT.num_knots)
            for one in PROFILES
        },
        "pair clearance": {"": _pair_clearance},
        "wall clearance": {"": _wall_clearance},
        "collision": {label: partial(sample_collision, *model) for label, model in models.items()},
        "wall": {label: partial(sample_wall, *model) for label, model in models.items()},
    }
