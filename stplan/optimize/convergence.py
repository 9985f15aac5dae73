"""When an outer iteration is over: judged by the objective, and agent by agent.

The objective alone would not do: where one agent is a thousand times as dear as another, it has stopped
falling long before that one has arrived at its best.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray
from stplan.callbacks import Stop
from stplan.costs.formulation import Formulation
from stplan.nlp.solution import Iteration
from stplan.nlp.step_control import StepControl
from stplan.optimize.payments import Payments
from stplan.status import Status

# A stale structure is rebuilt after at least this many iterations.
REBUILD_EVERY = 8
# What an agent pays may still change by so many times what the objective may; by fewer times where it
# minds when it arrives, and so may then its duration.
AGENT_SHARE, PUNCTUAL_SHARE = 10.0, 2.0
# Steps that are cut to less than this share of the full one count as so long.
LEAST_TAKEN = 0.01


@dataclass(frozen=True)
class Patience:
    """A run ends when the objective's relative fall over `window` iterations is below `share` of
    the optimality tolerance."""

    window: int
    share: float


# The last mu decides the plan; on the way to it the central path is only followed roughly.
ON_THE_WAY = Patience(window=2, share=1e-1)
AT_THE_END = Patience(window=4, share=1e-2)


class Judge:
    """Decides after every iteration whether an outer iteration is over, and remembers why.

    Runs that are only cut short for a new structure count as one: `control` is the present one's.

    Args:
        formulation: what is optimised.
        patience: how much longer to go on.
        interrupted: whether the caller has had enough.
    """

    def __init__(self, formulation: Formulation, patience: Patience, interrupted: Stop) -> None:
        scales, scene = formulation.scales, formulation.problem.scene
        self._solver = scene.solver
        self._layout = formulation.layout
        self._payments = Payments(formulation.problem, formulation.layout, scales.span)
        self._own_scale = scales.own
        # What the regularity term costs at its best: no part of the objective worth converging.
        self._floor = float((scales.regularity * formulation.layout.num_segments).sum())
        self._patience = patience
        self._interrupted = interrupted
        # The paper's centimetre suits people; a maze of vacuum cleaners needs a share of their size.
        self._step_unit = min(1.0, *(agent.radius for agent in scene.agents))
        self._values: list[float] = []
        self._shares: list[float] = []
        self._paid: list[FloatArray] = []
        self._durations: list[FloatArray] = []
        self.control: StepControl | None = None
        self.status: Status | None = None
        self.stale = False

    def __call__(self, iteration: Iteration) -> bool:
        """Whether to stop here; `status` says why, None where only the structure is stale."""
        if iteration.number or not self._values:
            self._remember(iteration)
        self.stale = False
        if self._interrupted():
            self.status = Status.INTERRUPTED
        elif iteration.number >= REBUILD_EVERY and self.control and self.control.is_stale():
            self.stale = True
        elif self._has_converged(iteration):
            self.status = Status.CONVERGED
        return self.stale or self.status is not None

    def _remember(self, iteration: Iteration) -> None:
        self._values.append(iteration.objective)
        self._shares.append(iteration.share)
        times = iteration.knots[:, 2]
        self._durations.append(times[self._layout.last] - times[self._layout.first])
        self._paid.append(self._payments.paid(iteration.knots))

    def _has_converged(self, iteration: Iteration) -> bool:
        if iteration.number < 1:
            return False
        small = self._solver.step_tolerance * self._step_unit
        if iteration.step <= small and not iteration.damped:
            return True
        if self._solver.convergence == "first-order":
            least = self._patience.share * self._solver.optimality_tolerance
            return iteration.optimality <= least
        window = self._patience.window
        if len(self._values) <= window:
            return False
        fall = self._values[-1 - window] - self._values[-1]
        scale = max(abs(self._values[-1] - self._floor), 1e-12)
        # What is cut short changes little without being near its end.
        taken = float(np.mean(self._shares[-window:]))
        least = self._patience.share * self._solver.optimality_tolerance * max(taken, LEAST_TAKEN)
        return fall <= least * scale and bool(self._settled(least).all())

    def _settled(self, share: float) -> BoolArray:
        """(A,) who pays and takes the same as a window ago, but for some times a `share`."""
        punctual = self._payments.punctual
        share_of = share * np.where(punctual, PUNCTUAL_SHARE, AGENT_SHARE)
        ago = -1 - self._patience.window
        paid, duration = self._paid[-1], self._durations[-1]
        change = np.abs(paid - self._paid[ago])
        settled: BoolArray = change <= share_of * np.maximum(paid, self._own_scale)
        moved = np.abs(duration - self._durations[ago])
        return settled & ((moved <= share_of * duration) | ~punctual)
