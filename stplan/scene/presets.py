"""Settings by the name of a recipe: what a scene leaves out is as the recipe has it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True)
class Preset:
    """Defaults of the mappings `seeding` and `solver` of a scene, and of its time_scale.

    Attributes:
        time_scale: c, m/s.
    """

    seeding: Mapping[str, Any]
    solver: Mapping[str, Any]
    time_scale: float


# The recipe as the paper prints it. It is silent about: the first alpha, the number of nodes of most scenes
# (100 where it names one), the first mu, how often mu shrinks, and c of the metric (1 is none). Of what its
# cutoff of 0.2 cuts from the Hessian it does not say either: here contacts 0.2 m further than the nearest,
# which weigh exp(-0.2 alpha). A fifth of the heaviest one's weight would cut what bends the objective most.
PAPER = Preset(
    seeding=MappingProxyType({"method": "dijkstra", "shortcuts": False}),
    solver=MappingProxyType(
        {
            "knots": 100,
            "effort": "quick",
            "starts": 1,
            "mu_decay": 0.75,
            "clearance_model": "smooth-minimum",
            "alpha_rule": "stepped",
            "barrier_range": math.inf,
            "hessian_cutoff": 4.5e-5,
            "convergence": "first-order",
        }
    ),
    time_scale=1.0,
)

PRESETS: Mapping[str, Preset] = MappingProxyType({"paper": PAPER})
