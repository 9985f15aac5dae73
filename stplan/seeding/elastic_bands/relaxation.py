"""Relaxation: elastic bands in space-time, pushed apart until all rods are clear.

In (x, y, c t) straight lines of constant speed hardly ever meet, so they are where every agent
starts from (or from the geodesics it is given where there are walls), each with a small seeded
bow. Contact springs then push rods apart at full distance while the bands' tension, high at
first, decays: high tension parts tangles as a whole, low tension lets the last ones give way.
There is no search and there are no priorities. Single-lane deadlocks are beyond it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.callbacks import Stop
from stplan.deadline import passed
from stplan.problem.clearance import wall_clearance
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.requirement import Requirement
from stplan.problem.verification import verify
from stplan.seeding.elastic_bands.band_neighbours import (
    Bodies,
    Neighbours,
    near_edges,
    near_rows,
    tight_pairs,
    widest_reach,
)
from stplan.seeding.elastic_bands.bands import Bands, initial_curves
from stplan.seeding.elastic_bands.simultaneous import near_agents, rounds
from stplan.seeding.elastic_bands.sweeps import (
    Contacts,
    WallContacts,
    band_crosses,
    sweep_bands,
)
from stplan.seeding.seeder import SeedAttempt, SeedRecord
from stplan.threads import num_threads, runs, together

NAME = "relaxation"
# Knots of a band while it relaxes, and sweeps at most.
RELAXATION_KNOTS = 40
MOST_SWEEPS = 4000
# Springs aim this much beyond what is required, so that they get there in finite time.
AIM = 1.015
# Tension starts high, the higher the more of their ways agents touch somebody at first; it is held for
# some sweeps and then decays to nearly nothing.
TENSION = 5.0
TENSION_CROWDED = 50.0
MOST_TENSION = 30.0
# Rods grow to their full radius within so many sweeps: neighbours part gently, on the cheaper side.
GROWING_SWEEPS = 20
HELD_SWEEPS = 8
DECAY = 0.97
LEAST_TENSION = 0.005
# Few that touch are soon parted: an agent's tension decays up to so many times as fast, at the plain
# pace where it touches at least so many others.
FASTEST_PACE = 5.0
PLAIN_PACE_CONTACTS = 6.0
# Agents that touch nobody are left alone after so many sweeps.
IDLE_SWEEPS = 20
# Look for success this often; without progress for so long, pull the stuck bands tight again.
CHECK_EVERY = 4
PATIENCE = 80
# A re-tensioned band is knocked aside by about this many radii.
KNOCK = 1.5
# After this part of the sweeps, so many touching pairs an agent mean that there is no room to part them: far
# fewer are left wherever all get clear.
JAMMED_AFTER, JAMMED_PAIRS = 0.25, 4.0
# Neighbours are listed within a skin of so many radii, more of them where lists last for less than
# SOON sweeps, fewer where they last for more than LATE.
SKINS = (0.7, 2.0)
SKIN_STEP = 1.4
SOON, LATE = 2, 5


def relax(
    problem: PlanningProblem,
    required: Requirement,
    initial: Sequence[FloatArray] | None = None,
    *,
    num_knots: int = RELAXATION_KNOTS,
    rng_seed: int = 0,
    max_sweeps: int = MOST_SWEEPS,
    stopped: Stop = passed,
) -> SeedAttempt:
    """Push rods apart until they hold what is `required`, until the sweeps are used up, or until `stopped`.

    It is given up early where far too many are touching after a part of the sweeps.

    `initial` curves (n, 3) must not cross walls and have to pass the waypoints; without them the
    bands start straight.
    """
    rng = np.random.default_rng(rng_seed)
    curves = initial_curves(problem, initial, num_knots, rng)
    relaxation = _Relaxation(problem, curves, _attainable(problem, curves, required), rng)
    touching: list[tuple[int, int]] = []
    clear = jammed = False
    look = CHECK_EVERY * math.ceil(JAMMED_AFTER * max_sweeps / CHECK_EVERY)
    while not (clear or jammed) and relaxation.sweeps < max_sweeps:
        relaxation.sweep()
        if relaxation.sweeps % CHECK_EVERY == 0:
            touching = relaxation.stuck_pairs()
            clear = not touching and relaxation.verified()
            jammed = relaxation.sweeps == look and relaxation.is_jammed(touching)
            if not clear:
                relaxation.retension_if_stuck(touching)
        if stopped():
            break
    record = SeedRecord(sweeps=relaxation.sweeps, retensions=relaxation.retensions)
    found = relaxation.bands.curves(problem)
    pairs = tuple(touching)
    return SeedAttempt(NAME, found, clear=clear, record=record, touching=pairs, jammed=jammed)


def _attainable(
    problem: PlanningProblem, curves: Sequence[FloatArray], required: Requirement
) -> Requirement:
    """What is `required`, with no more room to walls than half of what the first curves have."""
    walls = required.walls.copy()
    for agent, curve in enumerate(curves):
        radius = float(problem.radii[agent])
        gap = wall_clearance(problem, agent, curve, 2.0 * float(walls[agent]))
        if gap > radius:
            walls[agent] = min(walls[agent], radius + 0.5 * (gap - radius))
    return Requirement(required.rods, walls)


def middle_of(square: FloatArray) -> FloatArray:
    """(2,) the values in the middle of all of a square in order of size; the same one if they are odd."""
    middle = [(square.size - 1) // 2, square.size // 2]
    # Mostly nearly all are the same, which is soon counted, while sorting millions takes its time.
    guess = float(np.partition(square[0], len(square) // 2)[len(square) // 2])
    below = np.count_nonzero(square < guess)
    if below <= middle[0] and middle[1] < below + np.count_nonzero(square == guess):
        return np.array([guess, guess])
    found: FloatArray = np.partition(square, middle, axis=None)[middle]
    return found


class _Relaxation:
    """The bands, their neighbours and how far each one's tension has decayed."""

    def __init__(
        self,
        problem: PlanningProblem,
        curves: Sequence[FloatArray],
        required: Requirement,
        rng: np.random.Generator,
    ) -> None:
        self.problem = problem
        self.required = required
        self.rng = rng
        self.bands = Bands.build(problem, curves)
        self.first_positions = self.bands.positions.copy()
        self.movable = np.flatnonzero(~problem.prescribed)
        self.rod_target = AIM * required.rods
        # The mean of both is the median.
        self.usual_targets = middle_of(self.rod_target)
        self.widest = widest_reach(problem.collides, self.rod_target)
        heeds = problem.heeds_walls & (problem.boundary is not None)
        self.wall_target = np.where(heeds, AIM * required.walls, 0.0)
        self.body = float(np.median(problem.radii))
        self.skin = self.body
        self.age = np.zeros(problem.num_agents)
        self.pace = np.ones(problem.num_agents)
        self.sweeps = self.retensions = self.progress_at = 0
        self.fewest = np.inf
        self.guarded = np.zeros(problem.num_agents, dtype=bool)
        self._related: Neighbours | None = None
        self._list_neighbours()
        self.guarded[:] = self._clear_of_walls()
        self.tension = float(np.clip(TENSION_CROWDED * self._crowding(), TENSION, MOST_TENSION))

    def verified(self) -> bool:
        """Whether the curves are proven to hold what is required."""
        return not verify(self.problem, self.bands.curves(self.problem), self.required)

    def sweep(self) -> None:
        """One sweep in random order; neighbours are listed anew when somebody has moved far."""
        grown = min(1.0, (self.sweeps + 1) / GROWING_SWEEPS)
        decayed = self.tension * DECAY ** np.maximum(self.age - HELD_SWEEPS, 0.0)
        moved = self._move(self.rng.permutation(self.movable), decayed, grown)
        if grown == 1.0:
            self.age += self.pace
        self.sweeps += 1
        if moved > 0.5 * self.skin:
            self._adapt_skin()
            self._list_neighbours()

    def _move(self, order: IntArray, tension: FloatArray, grown: float) -> float:
        """Move all in `order`, at once where that is the same; returns the largest move since listing, m."""
        settings = (
            self.bands, self.contacts, self.wall_contacts, np.maximum(tension, LEAST_TENSION), grown,
            self.sweeps > IDLE_SWEEPS,
        )  # fmt: skip
        count = num_threads(len(self.bands.positions))
        if count == 1:
            return sweep_bands(order, *settings)
        moved = [0.0]
        if self._related is None:
            near, owners = self.contacts, self.bands.agents
            self._related = Neighbours(
                *near_agents(owners, near.rows, near.members, self.problem.num_agents)
            )
        for chosen, at_once in rounds(order, self._related):
            cut = runs(len(chosen), count if at_once else 1)
            moved += together(sweep_bands, [(chosen[i:j], *settings) for i, j in cut])
        return max(moved)

    def _crowding(self) -> float:
        """The part of their ways on which agents touch somebody at first, roughly."""
        bands = self.bands
        ends = bands.segments[: bands.num_moving]
        length = np.linalg.norm(bands.positions[ends[:, 1]] - bands.positions[ends[:, 0]], axis=1)
        touched = sum(2.0 * self.problem.distance[pair] for pair in self.stuck_pairs())
        return float(touched / max(float(length.sum()), 1e-12))

    def _adapt_skin(self) -> None:
        """Longer lists where they would soon be made anew, shorter ones where they last."""
        lasted = self.sweeps - self.listed_at
        if lasted < SOON:
            self.skin = min(self.skin * SKIN_STEP, SKINS[1] * self.body)
        elif lasted > LATE:
            self.skin = max(self.skin / SKIN_STEP, SKINS[0] * self.body)

    def stuck_pairs(self) -> list[tuple[int, int]]:
        """Pairs of agents a < b that are not clear, sorted."""
        bands = self.bands
        found = tight_pairs(
            bands.positions, bands.segments, bands.agents, self.contacts.rows,
            self.contacts.members, self.required.rods,
        )  # fmt: skip
        count = self.problem.num_agents
        codes = np.unique(found.min(axis=1) * count + found.max(axis=1))
        pairs = np.column_stack([codes // count, codes % count])
        contacts = np.bincount(pairs.ravel(), minlength=count)
        self.pace = np.clip(PLAIN_PACE_CONTACTS / np.maximum(contacts, 1), 1.0, FASTEST_PACE)
        return [(a, b) for a, b in pairs.tolist()]

    def is_jammed(self, stuck: Sequence[tuple[int, int]]) -> bool:
        """Whether so many pairs are not clear that there is no room; none of them was pulled tight again."""
        return self.retensions == 0 and len(stuck) > JAMMED_PAIRS * len(self.movable)

    def retension_if_stuck(self, stuck: list[tuple[int, int]]) -> None:
        """After long without fewer stuck pairs, pull their bands tight and knock one aside."""
        if len(stuck) < 0.9 * self.fewest:
            self.fewest = len(stuck)
            self.progress_at = self.sweeps
        if self.sweeps - self.progress_at < PATIENCE:
            return
        self.retensions += 1
        self.progress_at = self.sweeps
        self.fewest = np.inf
        knocked: set[int] = set()
        for agent in sorted({agent for pair in stuck for agent in pair}):
            self.age[agent] = 0.0
            self._put_off(agent)
        for pair in stuck:
            if knocked.isdisjoint(pair):
                one = pair[int(self.rng.random() < 0.5)]
                one = one if self.problem.paths[one] is None else sum(pair) - one
                knocked.add(one)
                self._knock(one)
        self._list_neighbours()

    def _put_off(self, agent: int) -> None:
        """Aim at the latest arrival where the preferred one is earlier: its tail is in the way."""
        problem, bands = self.problem, self.bands
        late = problem.preferred_times[agent] < problem.max_times[agent]
        if not late or not problem.stays[agent] or problem.prescribed[agent]:
            return
        knots = bands.knots(agent)
        rise = bands.ceilings[agent] - knots[0, 2]
        knots[:, 2] = knots[0, 2] + (knots[:, 2] - knots[0, 2]) * (
            rise / (knots[-1, 2] - knots[0, 2])
        )
        bands.rest_rises[agent] = rise / (len(knots) - 1)

    def _knock(self, agent: int) -> None:
        """Push a part of a band (as it is, or as it was at first) aside by a radius or so."""
        if self.problem.paths[agent] is not None:
            return
        bands = self.bands
        begin, count = bands.first_knot[agent], bands.num_knots[agent]
        own = slice(begin, begin + count)
        along = np.linspace(0.0, 1.0, count)
        for _ in range(5):
            middle, width = self.rng.uniform(0.1, 0.9), self.rng.choice([0.15, 0.3, 1.0])
            wave = np.sin(np.pi * along) * np.exp(-(((along - middle) / width) ** 2))
            base = self.first_positions if self.rng.random() < 0.5 else bands.positions
            aside = self.rng.normal(size=3) * self.problem.radii[agent] * KNOCK
            knots = base[own] + np.where(bands.hold[own, None] == 0, wave[:, None] * aside, 0.0)
            if (np.diff(knots[:, 2]) > 1e-3 * np.ptp(knots[:, 2]) / count).all() and not (
                self.guarded[agent] and self._crosses(knots)
            ):
                bands.positions[own] = knots
                return

    def _crosses(self, knots: FloatArray) -> bool:
        """Whether a band would cross any wall."""
        boundary = self.problem.boundary
        if boundary is None:
            return False
        near = near_edges(boundary, knots[:-1], knots[1:], np.zeros(len(knots) - 1))
        return band_crosses(knots, near, boundary.edges)

    def _list_neighbours(self) -> None:
        """List segments and boundary edges that may come within their targets."""
        bands, problem = self.bands, self.problem
        self.listed_at = self.sweeps
        self._related = None
        heads = bands.positions[bands.segments[:, 0]]
        tails = bands.positions[bands.segments[:, 1]]
        # Tails are listed too: they push nothing, but may stand in the way of a given path.
        asking = ~problem.prescribed[bands.agents]
        extent = np.abs(tails - heads).max(axis=1)
        cell = max(float(np.median(extent)), float((self.usual_targets + self.skin).mean()))
        bodies = Bodies(bands.positions, bands.segments, bands.agents, asking)
        near = near_rows(
            bodies, problem.collides, self.rod_target, cell, skin=self.skin, widest=self.widest
        )
        self.contacts = Contacts(
            *near, self.rod_target, self.problem.masses, bands.positions.copy()
        )
        self.wall_contacts = None
        if problem.boundary is not None:
            moving = np.arange(len(bands.segments)) < bands.num_moving
            room = self.wall_target + np.maximum(self.skin, problem.radii)
            reach = np.where(moving, room[bands.agents], 0.0)
            near = near_edges(problem.boundary, heads, tails, reach)
            self.wall_contacts = WallContacts(
                *near, problem.boundary.edges, self.wall_target, self.guarded
            )

    def _clear_of_walls(self) -> BoolArray:
        """(A,) agents whose band crosses no wall at first: they are kept from doing so."""
        return np.array(
            [
                bool(self.wall_target[a] > 0.0) and not self._crosses(self.bands.knots(a))
                for a in range(self.problem.num_agents)
            ]
        )
