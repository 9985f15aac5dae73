"""Results as arrays, tables and data sets."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pytest

from stplan.api.building import AgentSpec, build_scene
from stplan.api.results import diff, sample, to_pandas, to_xarray
from stplan.files.csv_file import csv_bytes
from stplan.planner import Plan, plan, seed

SCENE = build_scene(
    [
        AgentSpec("sam", (0, 0), (4, 0), after_arrival="vanish", max_time=5),
        AgentSpec("ann", (4, 0.1), (0, 0.1), start_time=1),
    ],
    horizon=8,
)


@pytest.fixture(scope="module")
def planned() -> Plan:
    return plan(SCENE)


def test_a_table_is_what_the_file_holds(planned):
    table = to_pandas(planned)
    assert planned.trajectories is not None
    file = pd.read_csv(io.BytesIO(csv_bytes(planned.trajectories)))
    assert list(table.columns) == list(file.columns)
    assert (table[["x", "y", "t"]].to_numpy() == file[["x", "y", "t"]].to_numpy()).all()
    assert table.groupby("agent").t.max()["sam"] <= 5


def test_whoever_vanishes_is_nowhere(planned):
    times = np.array([0.0, 3.0, 7.9])
    places = sample(planned, times)
    assert places.shape == (2, 3, 2)
    assert np.isnan(places[0, 2]).all()
    assert np.isnan(places[1, 0]).all()
    assert places[1, 2] == pytest.approx([0, 0.1], abs=0.3)
    dataset = to_xarray(planned, times)
    assert dataset.x.sel(agent="sam", time=3.0).item() == places[0, 1, 0]
    assert dataset.time.attrs["units"] == "s"


def test_a_seed_is_shown_where_there_is_no_more():
    seeded = seed(SCENE)
    assert len(to_pandas(seeded)) == len(seeded.seed.knots)


def test_plans_are_compared(planned):
    assert diff(planned, planned).equal
    found = diff(planned.seed, planned, atol=1e-9)
    assert {agent.agent for agent in found.agents} == {"sam", "ann"}
