"""Against what one would write instead: CasADi and Ipopt with positions on a common grid of times.

The rival keeps the discs apart at the times of the grid, so between them they can meet. Its distances
are enlarged step by step until its result holds our certificate, and only that last run is timed:
as if one had known the right enlargement. Both start from nothing and are timed in the same process.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.analysis.metrics import metrics
from stplan.arrays import FloatArray
from stplan.bench import families_open as wide
from stplan.bench.solves import run, warm_up
from stplan.callbacks import Progress
from stplan.certify.certificate import Certificate, certify
from stplan.optional import require
from stplan.problem.world_lines import WorldLines
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import Scene

SMALL_SIZES, SIZES = (8, 16), (8, 16, 32)
FULL_DRAWS = 3
# Knots of the grid after the start, and the enlargements of its distances that are tried in turn.
INTERVALS = 40
PADDINGS = (0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
SMALL_SECONDS, FULL_SECONDS = 40.0, 300.0
# How many times faster the planner is asked to be, and how much dearer it may be.
ASKED_FASTER = {8: 1.0, 16: 3.0, 32: 30.0}
ASKED_COST = 1.01


@dataclass(frozen=True)
class RivalAttempt:
    """One run of the rival.

    Attributes:
        seconds: of building and solving (s).
        kinetic: its kinetic cost over that of straight lines.
    """

    padding: float
    seconds: float
    iterations: int
    status: str
    kinetic: float
    clearance: float
    certified: bool


@dataclass(frozen=True)
class Duel:
    """Ours against the rival's last attempt; `unpadded` is its first one."""

    agents: int
    draw: int
    seconds: float
    kinetic: float
    clearance: float
    certified: bool
    rival: RivalAttempt
    unpadded: RivalAttempt

    @property
    def faster(self) -> float:
        """How many times faster ours is; a lower bound where the rival found no clear result."""
        return self.rival.seconds / self.seconds

    @property
    def dearer(self) -> float:
        """Our kinetic cost over the rival's, nan where it found no clear result."""
        return self.kinetic / self.rival.kinetic if self.rival.certified else np.nan


def require_casadi() -> None:
    """Ask for CasADi before anything is measured.

    Raises:
        UsageError: it is not installed.
    """
    require("casadi", "the rival", extra="rivals")


def field(agents: int, draw: int) -> Scene:
    """Two flows of random places that cross at 1 m/s."""
    return wide.crossing_flows(agents, 1.0, draw)


def measure(
    sizes: tuple[int, ...], draws: int, time_limit: float, *, progress: Progress
) -> list[Duel]:
    """Ours and the rival's plan of every field, after untimed ones of both."""
    progress("rival: warm-up")
    warm_up()
    attempt(field(4, 0), 0.0, time_limit)
    found = []
    for agents in sizes:
        for draw in range(draws):
            one = duel(field(agents, draw), draw, time_limit)
            found.append(one)
            progress(f"rival: {agents} agents, draw {draw + 1}: {outcome(one)}")
    return found


def duel(scene: Scene, draw: int, time_limit: float) -> Duel:
    """Plan `scene` with ours, then with the rival until its result is clear or its time is up."""
    ours, _ = run(scene)
    attempts: list[RivalAttempt] = []
    for padding in PADDINGS:
        attempts.append(attempt(scene, padding, time_limit))
        # Whoever ran out of time at one distance does not get a larger one in time either.
        if attempts[-1].certified or attempts[-1].seconds >= time_limit:
            break
    return Duel(
        ours.agents,
        draw,
        ours.total_seconds,
        ours.kinetic_end,
        ours.clearance,
        ours.certified,
        attempts[-1],
        attempts[0],
    )


def attempt(scene: Scene, padding: float, time_limit: float) -> RivalAttempt:
    """The rival's plan with distances enlarged by the share `padding`, judged by our certificate."""
    started = time.perf_counter()
    lines, stats = rival_plan(scene, padding, time_limit)
    seconds = time.perf_counter() - started
    certificate: Certificate = certify(scene, None, lines)
    smallest = certificate.smallest
    return RivalAttempt(
        padding,
        seconds,
        int(stats["iter_count"]),
        str(stats["return_status"]),
        metrics(scene, lines).kinetic_over_straight or np.nan,
        np.inf if smallest is None else smallest.clearance,
        certificate.holds,
    )


def rival_plan(
    scene: Scene, padding: float, time_limit: float
) -> tuple[WorldLines, dict[str, Any]]:
    """Least kinetic cost with discs apart at common times, from straight lines, and Ipopt's record.

    All agents of `scene` start and arrive at the same times, in the open plane.
    """
    import casadi

    starts = np.array([one.start for one in scene.agents])
    goals = np.array([one.goal for one in scene.agents])
    first, last = scene.agents[0].start_time, scene.agents[0].max_time
    times = np.linspace(first, last, INTERVALS + 1)
    masses = casadi.DM([one.mass for one in scene.agents])
    interactions = scene_interactions(scene)
    left, right = np.nonzero(np.triu(interactions.collides))
    shape = (len(starts), INTERVALS - 1)

    axes = [casadi.SX.sym(name, *shape) for name in ("x", "y")]
    cost = 0.0
    squares: Any = 0.0
    for k, axis in enumerate(axes):
        whole = casadi.horzcat(casadi.DM(starts[:, k]), axis, casadi.DM(goals[:, k]))
        steps = whole[:, 1:] - whole[:, :-1]
        cost += casadi.sum1(masses * casadi.sum2(steps**2)) / (2.0 * (times[1] - times[0]))
        squares += (axis[left.tolist(), :] - axis[right.tolist(), :]) ** 2
    least = ((1.0 + padding) * interactions.distance[left, right]) ** 2
    solver = casadi.nlpsol(
        "rival",
        "ipopt",
        {
            "x": casadi.vertcat(*(casadi.vec(axis) for axis in axes)),
            "f": cost,
            "g": casadi.vec(squares),
        },
        {
            "print_time": False,
            "ipopt": {
                "print_level": 0, "sb": "yes", "max_iter": 3000, "max_wall_time": time_limit,
            },
        },
    )  # fmt: skip
    share = (times[1:-1] - first) / (last - first)
    guess = starts[:, None] + share[:, None] * (goals - starts)[:, None]
    answer = solver(
        x0=np.concatenate([guess[:, :, k].ravel(order="F") for k in range(2)]),
        lbg=np.tile(least, INTERVALS - 1),
        ubg=np.inf,
    )
    inner = np.array(answer["x"]).reshape(2, shape[1], shape[0]).transpose(2, 1, 0)
    return _lines(scene, starts, inner, goals, times), solver.stats()


def _lines(
    scene: Scene, starts: FloatArray, inner: FloatArray, goals: FloatArray, times: FloatArray
) -> WorldLines:
    places = np.concatenate([starts[:, None], inner, goals[:, None]], axis=1)
    curves = [np.column_stack([place, times]) for place in places]
    return WorldLines.from_curves([one.id for one in scene.agents], curves)


def outcome(one: Duel) -> str:
    """A duel in one line."""
    rival = one.rival
    line = f"ours {one.seconds:.2f} s, rival {rival.seconds:.2f} s"
    if rival.certified:
        line += (
            f" with distances enlarged by {100 * rival.padding:.0f} %, cost {one.dearer:.4f} of its"
        )
    else:
        line += f" without a clear result ({rival.status})"
    return f"{line}; as asked it comes {1e3 * one.unpadded.clearance:.0f} mm near"
