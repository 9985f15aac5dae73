"""A room that empties: what is measured of our plan and of a simulation."""

from __future__ import annotations

import numpy as np

from stplan.bench import evacuation
from stplan.bench.comparison import OURS
from stplan.bench.comparison_table import markdown_text
from stplan.bench.rivals import jupedsim_model
from stplan.bench.rivals.task import Motion
from stplan.world import build_free_space


def test_a_small_room_is_left_by_all_and_ours_touches_nobody():
    ours, rival = evacuation.outcomes(6, progress=lambda line: None)
    assert (ours.planner, rival.planner) == (OURS, jupedsim_model.NAME)
    assert ours.arrived == rival.arrived == 6
    assert ours.clearance > 0.0
    assert ours.note.startswith("0 pairs touch, 0 agents touch a wall; certified; no plan before ")
    least = float(ours.note.split()[-2])
    assert least <= ours.makespan < 1.3 * least
    assert ours.makespan < rival.makespan
    page = markdown_text([ours, rival])
    assert "A room of 60 on a grid" in page
    assert "pairs touch" in page


def test_pairs_that_overlap_are_counted():
    scene = evacuation.fastest_room(3)
    along = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 4.0]])
    curves = [along + np.array([0.0, y, 0.0]) for y in (0.0, 0.39, 0.8)]
    assert evacuation.touching_pairs(scene, Motion(curves, np.ones(3, dtype=bool))) == 1


def test_nobody_is_simulated_beyond_the_time_that_is_allowed():
    scene = evacuation.fastest_room(6)
    motion = jupedsim_model.leave(scene, build_free_space(scene), 1.3, 0.5)
    assert not motion.arrived.any()
    assert max(curve[-1, 2] for curve in motion.curves) < 0.6
