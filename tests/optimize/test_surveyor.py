"""What is around some agents: found as by looking at all pairs, fixed, shared with who moves meanwhile."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.bench import families_open as wide
from stplan.costs.contacts.rod_candidates import brute_force
from stplan.costs.formulation import TermSetup
from stplan.costs.terms.collision import Collision
from stplan.optimize.assembly import formulate
from stplan.optimize.parts import DividedProblem
from stplan.planner import find_initial_curves, prepare
from stplan.problem.restriction import restricted
from stplan.problem.world_lines import WorldLines
from stplan.scene import parse_scene

BLOCK = np.arange(0, 12, 2)


@pytest.fixture(scope="module")
def divided() -> DividedProblem:
    problem = prepare(wide.crossing_flows(12, 1.0, 3))
    initial = find_initial_curves(problem)[0]
    return DividedProblem(problem, initial.seed.world_lines, lambda: False)


@pytest.mark.parametrize("view", [0.0, 1.0, 3.0, 12.0])
def test_near_segments_are_those_of_all_pairs(divided: DividedProblem, view: float) -> None:
    rods, problem = divided.formulation.rods, divided.problem
    reach = problem.distance + view * divided.formulation.scales.pair_reach
    inside = np.isin(np.arange(12), BLOCK)
    pairs = brute_force(
        rods.positions(divided.knots), rods.segments, rods.agents,
        problem.collides & (inside[:, None] ^ inside[None, :]), reach,
    )  # fmt: skip
    found = divided.surveyor.near(divided.knots, BLOCK, view)
    assert inside[rods.agents[found.own]].all()
    assert not inside[rods.agents[found.other]].any()
    codes = np.sort(found.own * len(rods.agents) + found.other)
    own = inside[rods.agents[pairs[:, 0]]]
    first, second = np.where(own, pairs.T, pairs.T[::-1])
    assert np.array_equal(codes, np.sort(first * len(rods.agents) + second))
    assert (len(codes) > 0) == (view > 0.0)


def test_fixed_rods_push_as_moving_ones_do_and_feel_nothing(divided: DividedProblem) -> None:
    whole = Collision.build(TermSetup(divided.formulation, divided.knots, 1.0))
    problem = restricted(divided.problem, BLOCK)
    lines = WorldLines.from_curves(problem.agent_ids, [divided.curve(a) for a in BLOCK.tolist()])
    around = divided.surveyor.around(divided.knots, BLOCK, 3.0)
    formulation = formulate(problem, lines, surroundings=around)
    part = Collision.build(TermSetup(formulation, lines.knots, 1.0))
    alone = Collision.build(TermSetup(formulate(problem, lines), lines.knots, 1.0))
    assert whole is not None
    assert part is not None
    assert alone is not None
    gradient = part.gradient(lines.knots)
    assert gradient.shape == lines.knots.shape
    own = np.isin(divided.formulation.layout.agent_of_knot, BLOCK)
    pushed = whole.gradient(divided.knots)[own]
    # Fixed rods weigh with the scale of one alone, moving ones with the mean of both.
    assert np.linalg.norm(gradient - pushed) < 0.1 * np.linalg.norm(pushed)
    assert np.linalg.norm(alone.gradient(lines.knots) - pushed) > 0.1 * np.linalg.norm(pushed)
    assert max(part.gauss_newton_structure()[0]) < 3 * len(lines.knots)


def test_half_the_room_is_left_to_who_moves_meanwhile(divided: DividedProblem) -> None:
    others = np.setdiff1d(np.arange(12), BLOCK)
    plain = divided.surveyor.around(divided.knots, BLOCK, 3.0)
    shared = divided.surveyor.around(divided.knots, BLOCK, 3.0, others)
    assert plain is not None
    assert shared is not None
    more = shared.interactions.distance - plain.interactions.distance
    reach = 3.0 * divided.formulation.scales.pair_reach.max()
    assert (more >= 0.0).all()
    assert 0.0 < more.max() <= 0.5 * reach
    assert not more[: len(BLOCK), : len(BLOCK)].any()


def test_prescribed_partners_are_part_of_a_part() -> None:
    agents = "\n".join(
        f"  - {{id: a{k}, start: [{3 * k}, 0], goal: [{3 * k}, 9]}}" for k in range(4)
    )
    buses = "  - {id: bus, path: [[-9, 0, 0], [-9, 9, 19]]}\n  - {id: tram, path: [[-6, 0, 0], [-6, 9, 19]]}"
    pairs = "[{between: [a1, bus], meet: {within: 20}}, {between: [a2, tram], grouping: 1}]"
    problem = prepare(
        parse_scene(f"stplan: 1\nhorizon: 20\npairs: {pairs}\nagents:\n{agents}\n{buses}\n")
    )
    initial = find_initial_curves(problem)[0]
    surveyor = DividedProblem(problem, initial.seed.world_lines, lambda: False).surveyor
    assert surveyor.with_partners(np.array([0])).tolist() == [0]
    assert surveyor.with_partners(np.array([0, 1])).tolist() == [0, 1, 4]
    assert surveyor.with_partners(np.array([1, 2])).tolist() == [1, 2, 4, 5]
