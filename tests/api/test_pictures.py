"""Plans drawn into axes of one's own."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from stplan.api.building import AgentSpec, build_scene
from stplan.api.pictures import plot
from stplan.errors import UsageError
from stplan.planner import plan

PLAN = plan(
    build_scene([AgentSpec("sam", (0, 0), (4, 0)), AgentSpec("ann", (4, 1), (0, 1))], horizon=8)
)


def test_a_map_is_drawn_beside_other_things():
    left, right = Figure().subplots(1, 2)
    right.plot([0, 1], [0, 1])
    assert plot(PLAN, left, seed=True) is left
    names = {text.get_text() for text in left.texts}
    assert {"sam", "ann"} <= names
    assert len(right.lines) == 1


@pytest.mark.parametrize("part", ["map", "clearance", "speed", "arrivals", "rods"])
def test_every_part_has_axes_of_its_own(part):
    axes = plot(PLAN, part=part)
    assert axes.has_data()


def test_an_unknown_part_is_refused():
    with pytest.raises(UsageError, match="none of map"):
        plot(PLAN, part="maps")
