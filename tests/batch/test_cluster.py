"""A Dask cluster gives what plain processes give, whatever becomes of its workers."""

from __future__ import annotations

import os
import signal
import sys

import pytest
from distributed import Client, LocalCluster

from stplan.batch.campaign import Settings, run_batch
from stplan.batch.runs import list_runs
from tests.batch.conftest import lasting


class _Killer:
    """Looks on, and kills a worker of the cluster as soon as the runs are handed out."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self.killed: list[int] = []

    def begin(self, total):
        pass

    def started(self, run):
        if not self.killed:
            victim = next(iter(self._client.run(os.getpid).values()))
            os.kill(victim, signal.SIGKILL)
            self.killed.append(victim)

    def progress(self, run, line):
        pass

    def finished(self, result):
        pass


def test_a_cluster_whose_worker_is_killed_gives_the_same_bytes(golden, place, monkeypatch):
    monkeypatch.chdir(place)
    runs = list_runs(["scenes"], output=place / "results")
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=60
        ) as cluster,
        Client(cluster) as client,
    ):
        killer = _Killer(client)
        settings = Settings(place / "results", jobs=2, dask=cluster.scheduler_address)
        batch = run_batch(runs, settings, killer)
        assert killer.killed[0] not in client.run(os.getpid).values()
    assert batch.exit_statuses == [0, 0, 0, 0]
    assert lasting(place / "results") == golden.contents


def test_a_cluster_of_its_own_on_this_machine(golden, place, run, monkeypatch):
    monkeypatch.chdir(place)
    (place / "scenes/three.yaml").write_text("stplan: 1\n")
    result = run(
        "batch", "scenes", "-o", "results", "--dask", "local", "--jobs", 1, "--filter", "*o*"
    )
    assert result.status == 0, result.err
    assert result.out.startswith("3 runs: 3 certified\n")
    kept = lasting(place / "results")
    for name in ("one", "room", "two"):
        path = f"{name}/trajectories.npz"
        assert kept[path] == golden.contents[path]


def test_without_dask_the_message_says_how_to_get_it(place, run, monkeypatch):
    monkeypatch.chdir(place)
    monkeypatch.setitem(sys.modules, "distributed", None)
    result = run("batch", "scenes", "-o", "results", "--dask", "local")
    assert result.status == 2
    assert result.err == "--dask needs Dask: pip install 'stplan[dask]'\n"


@pytest.mark.parametrize("command", [("batch", "scenes"), ("solve", "scenes/one.yaml")])
@pytest.mark.parametrize("address", ["nonsense://x", "tcp://127.0.0.1:1"])
def test_no_scheduler_at_the_address(place, run, monkeypatch, command, address):
    monkeypatch.chdir(place)
    monkeypatch.setattr("stplan.clusters.PATIENCE", "1s")
    result = run(*command, "-o", "results", "--dask", address)
    assert result.status == 2
    assert f"--dask {address}: no Dask scheduler answers there\n" in result.err


def test_one_scene_on_a_cluster_of_its_own(place, run, monkeypatch):
    monkeypatch.chdir(place)
    (place / "many.yaml").write_text(
        "stplan: 1\nhorizon: 9.0\nsolver: {blocks: 2, effort: quick}\nagents:\n"
        + "".join(
            f"  - {{id: a{k}, start: [0.0, {k}], goal: [5.0, {k}], radius: 0.3}}\n"
            for k in range(4)
        )
    )
    for folder, options in (("here", []), ("there", ["--dask", "local", "--workers", 1])):
        assert run("solve", "many.yaml", "-o", folder, *options).status == 0
    assert lasting(place / "there") == lasting(place / "here")
