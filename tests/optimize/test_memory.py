"""Memory of Ipopt is given back."""

from __future__ import annotations

import gc

from stplan.bench.families_open import circle
from stplan.nlp.ipopt.c_interface import Problem
from stplan.planner import plan


def test_nothing_of_ipopt_is_left_once_a_scene_is_planned():
    gc.collect()
    gc.disable()
    try:
        plan(circle(3, 3.0, 10.0))
        left = [one for one in gc.get_objects() if isinstance(one, Problem)]
    finally:
        gc.enable()
    assert left == []
