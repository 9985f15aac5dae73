"""What the costs of a plan were weighed with: with scene and curves, all it takes to compute each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stplan.arrays import FloatArray
from stplan.costs.contacts.shares import REFERENCE_SEGMENTS
from stplan.costs.formulation import Formulation
from stplan.costs.limit import LimitBarrier
from stplan.nlp.term import Term
from stplan.optimize.scales import RANGE_SHARE
from stplan.problem.planning_frame import PlanningFrame


def written_costs(
    terms: Sequence[Term], knots: FloatArray, frame: PlanningFrame
) -> dict[str, float]:
    """The cost of every term at local `knots` (M, 3) as the user's, by name.

    Costs scale with the unit of `frame`; logarithms of lengths are shifted by that of its unit of length.
    """
    shift = float(np.log(frame.length))
    return {
        term.name: frame.cost * (term.value(knots) - shift * term.unbounded_weight(knots))
        for term in terms
    }


@dataclass(frozen=True)
class CostScales:
    """Weights, ranges and sharpness of a formulation at one mu.

    Attributes:
        mu: the barrier weight that the costs are given for.
        sharpness: alpha (1/m) of the smooth minima by the name of their term: of pairs by a A + b, of
            walls by agent; nan where alpha_0 does, and no entry where clearances are those of contacts.
    """

    formulation: Formulation
    mu: float
    sharpness: Mapping[str, FloatArray]

    def as_dict(self) -> dict[str, Any]:
        """For report.json, in the user's units; agents by their ids, knots counted from 0."""
        formulation = self.formulation
        scales, ids = formulation.scales, formulation.problem.agent_ids
        frame = formulation.problem.frame
        regularity = (frame.cost * scales.regularity).tolist()
        content: dict[str, Any] = {
            "energy": frame.cost * scales.energy,
            "mu": frame.cost * self.mu,
            "barrier": dict(zip(ids, scales.barrier.tolist(), strict=True)),
            "padding": formulation.padding,
            "barrier_range": self._barrier_range(),
            "limit_range": LimitBarrier(self.mu).reach,
            "reference_segments": REFERENCE_SEGMENTS,
            "regularity": dict(zip(ids, regularity, strict=True)),
        }
        if formulation.problem.scene.minimise != "energy":
            content["arrival_span"] = frame.time * scales.span
        if formulation.smooth_minimum is not None:
            content["alpha_0"] = formulation.smooth_minimum.alpha_0 / frame.length
        if formulation.problem.interactions.grouping.any():
            content["grouping_alpha"] = formulation.problem.scene.solver.alpha / frame.length
        if "collision" in self.sharpness:
            alphas = self.sharpness["collision"] / frame.length
            content["pair_alphas"] = {
                "columns": ["a", "b", "alpha"],
                "rows": [
                    [ids[key // len(ids)], ids[key % len(ids)], alphas[key]]
                    for key in np.flatnonzero(~np.isnan(alphas)).tolist()
                ],
            }
        if "wall" in self.sharpness:
            alphas = self.sharpness["wall"] / frame.length
            met = np.flatnonzero(~np.isnan(alphas)).tolist()
            content["wall_alphas"] = {ids[agent]: alphas[agent] for agent in met}
        if len(formulation.timed.links):
            content["meetings"] = self._meetings()
        return content

    def _barrier_range(self) -> dict[str, float] | float | str:
        """In m where the scene says so, else as shares of a pair's distance and of an agent's radius."""
        given = self.formulation.problem.written.scene.solver.barrier_range
        if given is None:
            return {"share_of_distance": RANGE_SHARE, "share_of_radius": 2 * RANGE_SHARE}
        return given if np.isfinite(given) else "unbounded"

    def _meetings(self) -> dict[str, Any]:
        """Which knots meet."""
        layout, timed = self.formulation.layout, self.formulation.timed
        ids = self.formulation.problem.agent_ids
        distances = self.formulation.problem.frame.length * timed.within
        rows = []
        for link, within in zip(timed.links, distances.tolist(), strict=True):
            agents = layout.agent_of_knot[link]
            knots = link - layout.first[agents]
            first, second = zip(agents.tolist(), knots.tolist(), strict=True)
            rows.append([ids[first[0]], first[1], ids[second[0]], second[1], within])
        return {"columns": ["a", "knot_a", "b", "knot_b", "within"], "rows": rows}
