"""What two agents pay at least that have to meet.

Agent i comes through a point p_i, and j through p_j within w of it, so that their ways are no shorter than
|p - s| + |g - p|. On a way of length L in D an agent pays at least c L^2 / D with c = K^K m / 2, and for any
rate r, as the square of L - r D is not negative,

    c L^2 / D + K^T (D - a)^2 / 2  >=  2 c r L + min_D [K^T (D - a)^2 / 2 - c r^2 D].

Then for any vectors u_i, v_i no longer than 1 it is L_i >= u_i . (p_i - s_i) + v_i . (p_i - g_i), and where
q = 2 c_i r_i (u_i + v_i) is the opposite of j's, the sum over both agents of 2 c r L is at least

    - sum_k 2 c_k r_k (u_k . s_k + v_k . g_k) - w |q|.

So every choice of rates and vectors is a bound, and the best one is read from where the two would meet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import FloatArray
from stplan.problem.planning_problem import PlanningProblem

# Steps towards the cheapest places to meet, and the least length that is divided by, as a share of the ways.
STEPS, TINY = 200, 1e-12


@dataclass(frozen=True)
class _Walker:
    """One of the two: c, start and goal (2,), longest duration, preferred one and its weight."""

    stiffness: float
    start: FloatArray
    goal: FloatArray
    longest: float
    aim: float
    weight: float

    def duration(self, rate: float) -> float:
        """The best one at so many m/s."""
        if self.weight <= 0.0:
            return self.longest
        return min(self.aim + self.stiffness * rate**2 / self.weight, self.longest)

    def least(self, rate: float) -> float:
        """What is paid at least beyond 2 c r L, J s."""
        duration = self.duration(rate)
        late = 0.5 * self.weight * (duration - self.aim) ** 2 if self.weight > 0.0 else 0.0
        return late - self.stiffness * rate**2 * duration

    def rate(self, length: float) -> float:
        """Of a way of so many m: L / D, found by bisection as L = r D(r) grows with r."""
        low, high = 0.0, length / min(self.longest, self.aim if self.weight > 0.0 else np.inf)
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if middle * self.duration(middle) < length else (low, middle)
        return high

    def length(self, point: FloatArray) -> float:
        """Of the way through a point, m."""
        return float(np.linalg.norm(point - self.start) + np.linalg.norm(self.goal - point))


def meeting_bound(problem: PlanningProblem, first: int, second: int, within: float) -> float | None:
    """What both agents pay at least together that have to come `within` m of each other, J s.

    None where one of them has a motion prescribed, stops on its way, several goals, or no time to prefer.
    """
    walkers = [_walker(problem, agent) for agent in (first, second)]
    one, other = walkers
    if one is None or other is None:
        return None
    both = (one, other)
    points = _cheapest_places(both, within)
    rates = [own.rate(own.length(point)) for own, point in zip(both, points, strict=True)]
    prices = [2.0 * own.stiffness * rate for own, rate in zip(both, rates, strict=True)]
    if min(prices) <= 0.0:
        return None
    pulls = [
        np.stack([_unit(point - own.start), _unit(point - own.goal)])
        for own, point in zip(both, points, strict=True)
    ]
    sums = [price * pull.sum(axis=0) for price, pull in zip(prices, pulls, strict=True)]
    # Both draw with the same strength: what their sums lack to that is shared by their vectors.
    drawn = 0.5 * (sums[0] - sums[1])
    balanced = [
        pull + 0.5 * (sign * drawn / price - pull.sum(axis=0))
        for pull, price, sign in zip(pulls, prices, (1.0, -1.0), strict=True)
    ]
    longest = max(1.0, *(float(np.linalg.norm(pull, axis=1).max()) for pull in balanced))
    total = -within * float(np.linalg.norm(drawn)) / longest
    for own, pull, price, rate in zip(both, balanced, prices, rates, strict=True):
        u, v = pull / longest
        total += own.least(rate) - price * float(u @ own.start + v @ own.goal)
    return total


def _walker(problem: PlanningProblem, index: int) -> _Walker | None:
    agent = problem.scene.agents[index]
    assigned = any(index in one.members for one in problem.scene.assignments)
    if agent.path is not None or agent.waypoints or agent.goal_places or assigned:
        return None
    weight = agent.weights.arrival if agent.preferred_time is not None else 0.0
    aim = 0.0 if agent.preferred_time is None else agent.preferred_time - agent.start_time
    longest = agent.max_time - agent.start_time
    if agent.weights.kinetic <= 0.0 or (weight > 0.0 and aim <= 0.0):
        return None
    stiffness = 0.5 * agent.weights.kinetic * agent.mass
    return _Walker(stiffness, problem.starts[index], problem.goals[index], longest, aim, weight)


def _cheapest_places(both: tuple[_Walker, _Walker], within: float) -> list[FloatArray]:
    """About where both would meet, (2,) each: no bound depends on how near the best this is."""
    places = [0.5 * (own.start + own.goal) for own in both]
    step = 0.25
    size = max(own.length(place) for own, place in zip(both, places, strict=True))
    best, least = places, np.inf
    for _ in range(STEPS):
        places = _brought_within(places, within)
        lengths = [own.length(place) for own, place in zip(both, places, strict=True)]
        prices = [
            2.0 * own.stiffness * own.rate(length)
            for own, length in zip(both, lengths, strict=True)
        ]
        cost = sum(
            own.least(own.rate(length)) + price * length
            for own, length, price in zip(both, lengths, prices, strict=True)
        )
        if cost < least:
            best, least = places, cost
        else:
            step *= 0.8
            places = best
        slopes = [
            price * (_unit(place - own.start) + _unit(place - own.goal))
            for own, place, price in zip(both, places, prices, strict=True)
        ]
        steepest = max(float(np.linalg.norm(slope)) for slope in slopes)
        places = [
            place - step * size * slope / max(steepest, TINY)
            for place, slope in zip(places, slopes, strict=True)
        ]
    return best


def _brought_within(places: list[FloatArray], within: float) -> list[FloatArray]:
    """The nearest two points that are no further apart than `within`."""
    apart = places[1] - places[0]
    gap = float(np.linalg.norm(apart))
    if gap <= within:
        return places
    moved = 0.5 * (gap - within) * apart / gap
    return [places[0] + moved, places[1] - moved]


def _unit(vector: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else np.zeros(2)
