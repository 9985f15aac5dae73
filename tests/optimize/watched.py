"""Backends that look on while Ipopt works."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from stplan.arrays import FloatArray
from stplan.costs.formulation import Formulation
from stplan.nlp.backend import Backend
from stplan.nlp.solution import Iteration, Solution, WarmStart
from stplan.nlp.step_control import StepControl
from stplan.optimize.assembly import sharpness_of
from stplan.optimize.continuation import ipopt
from stplan.optimize.cost_scales import CostScales, written_costs
from stplan.problem.world_lines import WorldLines
from stplan.status import Status
from tests.optimize.recomputed import BruteForce


class _Control:
    """A step control that tells `asked` what was asked of it and what it said."""

    def __init__(self, control: StepControl, asked: Callable[[FloatArray, float], None]) -> None:
        self._control, self._asked = control, asked

    def value(self, x: FloatArray) -> float:
        found = self._control.value(x)
        self._asked(x, found)
        return found

    def __getattr__(self, name: str) -> Any:
        return getattr(self._control, name)


@dataclass
class Audit:
    """A backend that computes every value anew by brute force, and counts.

    Attributes:
        inner: who solves.
        formulation: of the seed `lines`.
        brute: knows the scene as YAML gives it.
        mu: of the present outer iteration; whoever follows the outer loop changes it.
        evaluations: values asked for.
        refused, touching: those of clear curves where no step may lead, and of curves that touch.
        renewals: values for which terms over contacts were given other lists than before.
        sharpness: of every program's smooth minima.
    """

    formulation: Formulation
    lines: WorldLines
    brute: BruteForce
    mu: float
    inner: Backend = field(init=False)
    evaluations: int = 0
    refused: int = 0
    touching: int = 0
    renewals: int = 0
    sharpness: list[Mapping[str, FloatArray]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.inner = ipopt(self.formulation.problem.scene)

    def next_mu(self) -> None:
        """The outer loop goes on."""
        self.mu *= self.formulation.problem.scene.solver.mu_decay

    def solve(
        self,
        control: StepControl,
        knots: FloatArray,
        *,
        max_iterations: int,
        objective_scale: float,
        stop: Callable[[Iteration], bool],
        warm_start: WarmStart | None = None,
    ) -> Solution:
        """What `inner` finds; AssertionError where a value is wrong."""
        program = control.program
        self.sharpness.append(sharpness_of(program.terms))
        self.brute.weigh(CostScales(self.formulation, self.mu, self.sharpness[-1]).as_dict())
        before = control.terms

        def asked(x: FloatArray, found: float) -> None:
            nonlocal before
            self.evaluations += 1
            self.renewals += any(a is not b for a, b in zip(before, control.terms, strict=True))
            before = control.terms
            knots = x.reshape(-1, 3)
            if not program.constraints.admits(program.layout, knots):
                assert found == np.inf
                return
            problem = self.formulation.problem
            lines = problem.written.outside(self.lines.with_knots(knots))
            expected = self.brute.costs(dict(zip(lines.agent_ids, lines.curves(), strict=True)))
            shift, unit = float(np.log(problem.frame.length)), problem.frame.cost
            # Logarithms of lengths are shifted by their unit.
            shifted = shift * sum(term.unbounded_weight(knots) for term in control.terms)
            total = pytest.approx(sum(expected.values()) / unit + shifted, rel=1e-9)
            # A pure function of the knots, whatever list of contacts its terms have.
            assert program.value(knots) == total
            if total == np.inf:
                self.touching += 1
                assert found == np.inf
                return
            if found == np.inf:
                self.refused += 1
                return
            assert found == total
            for name, cost in written_costs(control.terms, knots, problem.frame).items():
                assert cost == pytest.approx(expected[name], rel=1e-6, abs=1e-9), name

        watched: Any = _Control(control, asked)
        return self.inner.solve(
            watched, knots, max_iterations=max_iterations, objective_scale=objective_scale,
            stop=stop, warm_start=warm_start,
        )  # fmt: skip


@dataclass
class Failing:
    """A backend of whose runs some fail, after so many iterations.

    Attributes:
        inner: who solves.
        after: iterations by the run's number, counted from 0, for those that fail.
        runs: what every run started from, its control afterwards, and how it ended.
    """

    inner: Backend
    after: Mapping[int, int] = field(default_factory=dict)
    runs: list[tuple[FloatArray, StepControl, Solution]] = field(default_factory=list)

    def solve(
        self,
        control: StepControl,
        knots: FloatArray,
        *,
        max_iterations: int,
        objective_scale: float,
        stop: Callable[[Iteration], bool],
        warm_start: WarmStart | None = None,
    ) -> Solution:
        """What `inner` finds, or how far it got before it failed; then `stop` is never asked."""
        given = self.after.get(len(self.runs))
        if given == 0:
            found = Solution(control.iterate, Status.FAILED, 0, None)
        else:
            found = self.inner.solve(
                control, knots, max_iterations=max_iterations if given is None else given,
                objective_scale=objective_scale,
                stop=stop if given is None else lambda _: False, warm_start=warm_start,
            )  # fmt: skip
            if given is not None:
                found = replace(found, status=Status.FAILED)
        self.runs.append((knots.copy(), control, found))
        return found
