"""Programs over `sample_knots()` that have every term of the registry, and the scenes they are made from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stplan.costs.formulation import Formulation, Penalties
from stplan.nlp.program import NonlinearProgram
from stplan.nlp.step_control import StepControl
from stplan.optimize.assembly import assemble
from stplan.optimize.constraints import build_constraints
from stplan.optimize.scales import derive_scales
from stplan.optimize.timed_constraints import find_timed_constraints
from stplan.problem.planning_problem import PlanningProblem
from stplan.problem.rods import Rods
from stplan.scene.model import (
    Agent,
    Meet,
    PairRule,
    Scene,
    SeedingSettings,
    SolverSettings,
    Weights,
)
from tests.derivatives.samples import (
    BOUNDARY,
    CORNERS,
    EDGES,
    LAYOUT,
    OFFSETS,
    RADII,
    sample_knots,
)


class _Walls:
    boundary_vertices = CORNERS
    boundary_edges = EDGES


def sample_scene(**solver: object) -> Scene:
    """Three unequal agents whose seed is `sample_knots()`."""
    knots = sample_knots()
    agents = []
    for a in range(3):
        own = knots[OFFSETS[a] : OFFSETS[a + 1]]
        agents.append(
            Agent(
                id=f"agent{a}",
                start=tuple(own[0, :2]),
                goal=tuple(own[-1, :2]),
                start_time=float(own[0, 2]),
                max_time=float(own[-1, 2]) + 1,
                preferred_time=float(own[-1, 2]) - 0.5,
                radius=float(RADII[a]),
                mass=1.0 + a,
                after_arrival="stay" if a == 2 else "vanish",
                clearance=0.8 if a == 2 else 0.0,
                waypoints=(),
                # Without a regularity cost, the first agent's time is kept running by constraints.
                weights=Weights(
                    acceleration=0.3 * a,
                    arrival=0.2,
                    regularity=0.0 if a == 0 else None,
                    wall=float(a != 1),
                ),
            )
        )
    rules = (
        PairRule((0, 1, 2), (0, 1, 2), distance=0.5),
        PairRule((0,), (1,), grouping=0.1),
    )
    return Scene(
        "sample", "", None, "", None, 15.0, 1.3, tuple(agents), rules, SeedingSettings(),
        SolverSettings(barrier_range=1.5, **solver),  # type: ignore[arg-type]
    )  # fmt: skip


def limited_scene(**solver: object) -> Scene:
    """The same with limits of motion that the seed keeps and a meeting, to be over early."""
    scene = sample_scene(**solver)
    agents = tuple(
        replace(agent, max_speed=4.0, max_acceleration=9.0 if a else None)
        for a, agent in enumerate(scene.agents)
    )
    meet = PairRule((0,), (2,), meet=Meet(9.0))
    return replace(scene, agents=agents, pairs=(*scene.pairs, meet), minimise="makespan")


def sample_program(
    limited: bool = False, penalties: Penalties | None = None, **solver: object
) -> NonlinearProgram:
    """A program at mu = 0.3, or one that restores feasibility with `penalties`."""
    solver = {"mu": 0.3} | solver
    scene = limited_scene(**solver) if limited else sample_scene(**solver)
    knots = sample_knots()
    plane = PlanningProblem.from_scene(scene, None)
    problem = replace(plane, free_space=_Walls(), boundary=BOUNDARY)  # type: ignore[arg-type]
    timed = find_timed_constraints(plane, LAYOUT, knots)
    stays = np.flatnonzero(problem.stays)
    formulation = Formulation(
        problem, LAYOUT, Rods.build(LAYOUT, knots, stays, scene.final_time, scene.time_scale),
        derive_scales(problem, LAYOUT, knots), timed, 1e-4,
    )  # fmt: skip
    constraints = build_constraints(problem, LAYOUT, knots, timed)
    return assemble(formulation, constraints, knots, 0.3, sharpness={}, penalties=penalties)


def sample_control(limited: bool = False, **solver: object) -> StepControl:
    """The same, about to be solved from `sample_knots()`."""
    return StepControl(sample_program(limited, **solver), sample_knots())
