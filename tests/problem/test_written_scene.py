"""The way between a scene as it is written and its local frame."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from stplan.planner import prepare
from stplan.problem.world_lines import WorldLines
from stplan.problem.written_scene import WrittenScene
from stplan.reasons import Reason
from stplan.scene import parse_scene
from stplan.scene.model import Agent, PairRule, Scene, SolverSettings, Weights
from tests.test_commuting import DETAILED, Copy

# What has no unit, or is no business of planning.
BARE = {
    Agent: {"id", "after_arrival", "moving_goal", "sight", "line_of_sight"},
    Weights: {"kinetic", "collision", "wall", "clearance"},
    PairRule: {"left", "right", "collide", "collision"},
    SolverSettings: {
        "knots", "effort", "starts", "mu_decay", "outer_iterations", "max_iterations", "step_tolerance",
        "optimality_tolerance", "clearance_model", "hessian", "linear_solver", "ipopt", "alpha_rule",
        "hessian_cutoff", "convergence", "blocks",
    },
    Scene: {
        "name", "description", "source", "content_hash", "seeding", "locations", "overridden",
        "overrides", "agent_paths", "places", "assignments", "metric", "turning", "minimise",
        "horizon_rule", "changes", "replan_every", "overlap", "tasks",
    },
}  # fmt: skip
EVERYTHING = (
    DETAILED.replace("arrival: 1.0", "arrival: 1.0, acceleration: 2.0")
    .replace("goal: [9, -5]", "goal: {polygon: [[8, -5.5], [9, -5.5], [9, -4.5]]}")
    .replace("{between: [b, c], grouping: 0.5}", "{between: [b, c], grouping: 0.5, clearance: 0.2}")
    + "robust: {delay: 1.0, tracking: 0.01}\n"
)


def written(text: str) -> WrittenScene:
    return prepare(parse_scene(text)).written


@pytest.mark.parametrize("kind", BARE, ids=lambda kind: kind.__name__)
def test_every_setting_with_a_unit_is_converted(kind: type) -> None:
    """A setting that the way into the frame does not know would keep the user's unit there."""
    copy = Copy(length=7.0, time=3.0, mass=5.0, shift=(100.0, 50.0))
    scene = written(copy.of(EVERYTHING))
    given, local = scene.scene, scene.local_scene
    of = {
        Scene: lambda one: [one],
        Agent: lambda one: one.agents,
        Weights: lambda one: [agent.weights for agent in one.agents],
        PairRule: lambda one: one.pairs,
        SolverSettings: lambda one: [one.solver],
    }[kind]
    for field in fields(kind):
        pairs = [
            (getattr(a, field.name), getattr(b, field.name))
            for a, b in zip(of(given), of(local), strict=True)
        ]
        if field.name in BARE[kind]:
            assert all(a == b for a, b in pairs), field.name
        else:
            assert any(a != b for a, b in pairs), field.name


def test_fixed_points_and_times_come_back_to_the_last_bit() -> None:
    scene = written(Copy(angle=1.0, length=1e3, shift=(3e8, 7e8)).of(DETAILED))
    problem = prepare(scene.scene)
    curves = []
    for agent in problem.scene.agents:
        stops = np.array([agent.start, *agent.waypoints, agent.goal])
        times = np.linspace(agent.start_time, agent.max_time, len(stops))
        straight = np.column_stack([stops, times])
        curves.append(straight if agent.path is None else np.array(agent.path))
    lines = problem.written.outside(WorldLines.from_curves(problem.agent_ids, curves))
    for agent, curve in zip(scene.scene.agents, lines.curves(), strict=True):
        if agent.path is not None:
            assert [tuple(knot) for knot in curve.tolist()] == list(agent.path)
            continue
        met = [agent.start, *agent.waypoints, agent.goal]
        assert [tuple(place) for place in curve[:, :2].tolist()] == met
        assert (curve[0, 2], curve[-1, 2]) == (agent.start_time, agent.max_time)
    again = problem.written.inside(lines)
    for before, after in zip(curves, again.curves(), strict=True):
        assert after == pytest.approx(before, abs=1e-11)


def test_what_misses_its_point_is_not_put_on_it() -> None:
    problem = prepare(
        parse_scene("stplan: 1\nhorizon: 9\nagents: [{id: a, start: [1, 1], goal: [5, 4]}]")
    )
    (agent,) = problem.scene.agents
    curve = np.array([[*agent.start, 0.0], [*agent.goal, agent.max_time]])
    off = WorldLines.from_curves(problem.agent_ids, [curve + np.array([1e-3, 0.0, 0.0])])
    found = problem.written.outside(off).curve(0)
    for end, place in zip(found[:, :2], ((1.0, 1.0), (5.0, 4.0)), strict=True):
        assert np.hypot(*(end - place)) == pytest.approx(1e-3 * problem.frame.length)


def test_reasons_are_told_in_the_units_of_the_scene() -> None:
    scene = written(Copy(length=1e3, time=60.0, shift=(1e5, 0.0)).of(DETAILED))
    frame = scene.frame
    figures = {"radius": 0.3, "latest": 2.0, "speed": 1.0, "acceleration": 1.0, "margin": 1.05}
    local = Reason("touching", ("a",), place=(0.0, 0.0), times=(0.0, 1.0), figures=figures)
    told = scene.outside_reason(local)
    assert told.place == frame.origin
    assert told.times == (frame.start, frame.start + frame.time)
    assert told.figures == pytest.approx(
        {
            "radius": 0.3 * frame.length,
            "latest": frame.start + 2.0 * frame.time,
            "speed": frame.speed,
            "acceleration": frame.acceleration,
            "margin": 1.05,
        }
    )
