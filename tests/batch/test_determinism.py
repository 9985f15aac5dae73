"""The same bytes, whoever plans: in this process, in one worker or two, under any hash seed."""

from __future__ import annotations

from tests.batch.conftest import lasting, stplan


def test_neither_jobs_nor_hash_seeds_nor_repetition_change_a_byte(golden, place):
    for jobs, hash_seed in ((1, "0"), (2, "4242")):
        ended = stplan(
            "batch", "scenes", "-o", "results", "--force", "--jobs", jobs,
            cwd=place, PYTHONHASHSEED=hash_seed,
        )  # fmt: skip
        assert ended.status == 0, ended.err
        assert lasting(place / "results") == golden.contents


def test_planning_twice_in_one_process_changes_nothing(golden, place, monkeypatch):
    from stplan.planner import plan, plan_files
    from stplan.scene import load_scene

    monkeypatch.chdir(place)
    for _ in range(2):
        for name in ("room", "one"):
            planned = plan(load_scene(f"scenes/{name}.yaml"))
            files = plan_files(planned)
            for file in ("trajectories.csv", "trajectories.npz", "seed.npz", "report.json"):
                assert files[file] == golden.contents[f"{name}/{file}"]
