"""Generated tight scenes: as many agents as were asked for, where they fit."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.bench import families_tight as tight
from stplan.planner import prepare
from stplan.seeding.portfolio import find_seed


@pytest.mark.parametrize(
    ("passengers", "depth", "rows"), [(6, 1, 6), (16, 1, 9), (20, 1, 11), (10, 2, 6)]
)
def test_cabins_have_a_seat_for_everybody(passengers, depth, rows):
    rng = np.random.default_rng(4)
    scene = tight.cabin(rng, depth=depth, passengers=passengers, rows=rows)
    starts = {agent.start for agent in scene.agents}
    goals = {agent.goal for agent in scene.agents}
    assert len(starts) == len(scene.agents) == passengers
    assert goals == starts
    # Seat backs on both sides, before and after every row.
    assert len(scene.map.obstacles) == 2 * (rows + 1)


def test_a_cabin_of_sixteen_changes_seats():
    scene = tight.cabin(np.random.default_rng(1004), depth=1, passengers=16, rows=9)
    seed = find_seed(prepare(scene), progress=lambda line: None)
    assert len(seed.world_lines.agent_ids) == 16


@pytest.mark.parametrize("agents", [16, 24, 100])
def test_pillars_leave_room_for_all_who_start_beside_each_other(agents):
    scene = tight.pillars(np.random.default_rng(0), agents=agents)
    assert len(scene.agents) == agents
    for ends in ("start", "goal"):
        places = np.array([getattr(agent, ends) for agent in scene.agents])
        apart = np.hypot(*np.moveaxis(places[:, None] - places[None], 2, 0))
        np.fill_diagonal(apart, np.inf)
        assert apart.min() > 2.0 * tight.RADIUS
    assert scene.horizon / np.sqrt(len(scene.map.obstacles)) == pytest.approx(12.0)
