"""Parts are optimised alike by a cluster, whatever becomes of its workers."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from distributed import Client, LocalCluster

from stplan.bench import families_open as wide
from stplan.errors import StplanError
from stplan.optimize.cluster_workers import on_cluster
from stplan.optimize.parts import DividedProblem, Part
from stplan.optimize.workers import THIS_PROCESS, WorkersFor
from stplan.planner import find_initial_curves, plan, prepare
from stplan.scene.model import Scene

PARTS = [Part(np.arange(3 * k, 3 * k + 3), begin=2) for k in range(4)]


def flows(blocks: int | None) -> Scene:
    scene = wide.crossing_flows(12, 1.0, 3)
    return replace(scene, solver=replace(scene.solver, effort="quick", starts=1, blocks=blocks))


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=60
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


@pytest.fixture
def divided() -> DividedProblem:
    problem = prepare(flows(None))
    (initial,) = find_initial_curves(problem)
    return DividedProblem(problem, initial.seed.world_lines, lambda: False)


def curves(divided: DividedProblem, workers: WorkersFor) -> list[np.ndarray]:
    told: list[int] = []
    with workers(divided) as crew:
        results = crew.optimise(PARTS, told.append)
    assert told == [1, 2, 3, 4]
    return [np.vstack(result.curves) for result in results if result is not None]


def test_a_cluster_gives_what_this_process_gives(divided: DividedProblem, client: Client) -> None:
    here, there = (curves(divided, workers) for workers in (THIS_PROCESS, on_cluster(client)))
    assert len(here) == len(there) == len(PARTS)
    assert all(map(np.array_equal, here, there))


def test_workers_may_die_at_their_work(divided: DividedProblem, client: Client) -> None:
    expected = curves(divided, THIS_PROCESS)
    victims = list(client.run(os.getpid).values())

    def kill() -> None:
        time.sleep(0.1)
        for victim in victims:
            with suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    found = curves(divided, on_cluster(client))
    killer.join()
    assert all(map(np.array_equal, expected, found))
    client.wait_for_workers(2, timeout=30)
    assert not set(victims) & set(client.run(os.getpid).values())


def test_what_is_asked_to_stop_gives_what_it_has(divided: DividedProblem, client: Client) -> None:
    divided.stop = lambda: True
    with on_cluster(client)(divided) as crew:
        assert crew.optimise(PARTS, lambda done: None) == [None] * len(PARTS)


def test_workers_of_another_version_are_refused(
    divided: DividedProblem, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stplan.optimize.cluster_workers.version", lambda name: "9.9")
    with (
        on_cluster(client)(divided) as crew,
        pytest.raises(StplanError, match=r"a worker of the cluster has stplan .*, this is 9\.9"),
    ):
        crew.optimise(PARTS, lambda done: None)


def test_a_whole_plan(client: Client) -> None:
    here, there = plan(flows(6)), plan(flows(6), cluster=client)
    assert here.trajectories is not None
    assert there.trajectories is not None
    assert there.certificate.holds
    assert np.array_equal(here.trajectories.knots, there.trajectories.knots)


def test_what_travels_has_no_square_of_all_pairs_and_is_the_same_there(
    divided: DividedProblem,
) -> None:
    there: DividedProblem = pickle.loads(pickle.dumps(divided))
    assert np.array_equal(there.knots, divided.knots)
    assert there.problem.interactions.equals(divided.problem.interactions)
    assert np.array_equal(
        there.formulation.scales.pair_reach, divided.formulation.scales.pair_reach
    )
    problem = prepare(wide.wide_field(300))
    assert len(pickle.dumps(problem)) < problem.distance.nbytes


def test_distances_that_the_scene_does_not_say_travel_too(divided: DividedProblem) -> None:
    own = replace(divided.problem.interactions, distance=1.5 * divided.problem.distance)
    problem = replace(divided.problem, interactions=own)
    there = pickle.loads(pickle.dumps(problem))
    assert there.interactions.equals(own)
    assert not there.interactions.equals(divided.problem.interactions)
