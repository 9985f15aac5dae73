"""What is drawn of a run, whatever has become of its scene."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.errors import UsageError
from stplan.viewing.run_view import open_run
from tests.viewing.runs import CURVES, HALL, hall_run


@pytest.fixture
def run(tmp_path):
    return hall_run(tmp_path)


def test_a_whole_run(run):
    view = open_run(run)
    assert (view.name, view.title, view.notes) == ("hall", "hall", ())
    assert view.lines.agent_ids == ("ann", "ben", "cat")
    assert view.seed is not None
    assert view.radii.tolist() == [0.3, 0.4, 0.3]
    np.testing.assert_equal(view.crowd.preferred, [7.0, np.nan, np.nan])
    assert view.waypoints == ((), ((0.0, -1.0),), ())
    assert (view.begin, view.end) == (0.0, 9.0)
    # Who stays is seen until nothing moves any more.
    assert view.leaves.tolist() == [9.0, 9.0, 9.0]
    assert view.bounds == (-5.0, -3.0, 5.0, 3.0)
    assert view.free_space is not None
    assert view.crowd.distance[0, 1] == pytest.approx(0.7)


def test_files_of_a_run(run):
    assert open_run(run / "trajectories.csv").radii.tolist() == [0.3, 0.4, 0.3]
    seed = open_run(run / "seed.npz")
    assert seed.title == "hall, initial curves"
    assert seed.seed is None
    assert seed.lines.knots[0, 1] == 0.05


def test_curves_on_which_time_goes_back_cannot_be_shown(run):
    file = run / "trajectories.csv"
    lines = file.read_text().splitlines()
    first, second = lines[1].split(","), lines[2].split(",")
    first[-1], second[-1] = second[-1], first[-1]
    file.write_text("\n".join([lines[0], ",".join(first), ",".join(second), *lines[3:]]) + "\n")
    with pytest.raises(UsageError, match="the time of agent 'ann' goes back; see stplan check"):
        open_run(file)


def test_a_folder_with_initial_curves_only(run):
    for name in ("trajectories.npz", "trajectories.csv"):
        (run / name).unlink()
    view = open_run(run)
    assert view.title == "hall, initial curves"
    assert "holds initial curves only" in view.notes[0]


def test_an_empty_folder(tmp_path):
    with pytest.raises(UsageError, match=r"holds no trajectories\.npz"):
        open_run(tmp_path)


def test_the_scene_is_gone(run, tmp_path):
    (tmp_path / "scene.yaml").unlink()
    view = open_run(run)
    (note,) = view.notes
    assert "scene.yaml is missing" in note
    assert view.free_space is None
    assert view.radii.tolist() == [0.3, 0.4, 0.3]
    assert view.bounds == pytest.approx((-4.3, -2.9, 4.3, 1.9))


def test_the_scene_is_gone_and_so_are_the_radii(run, tmp_path):
    (tmp_path / "scene.yaml").unlink()
    (run / "trajectories.npz").unlink()
    with pytest.raises(UsageError, match="name the scene: --scene FILE"):
        open_run(run)
    other = tmp_path / "moved.yaml"
    other.write_text(HALL)
    assert open_run(run, other).radii.tolist() == [0.3, 0.4, 0.3]


def test_the_report_is_gone(run):
    (run / "report.json").unlink()
    view = open_run(run)
    assert "holds no report.json" in view.notes[0]
    assert view.name == "hall"


def test_the_scene_has_changed(run, tmp_path):
    (tmp_path / "scene.yaml").write_text(HALL.replace("[-5.0, -3.0", "[-6.0, -3.0"))
    view = open_run(run)
    assert "is not as it was" in view.notes[0]
    assert view.bounds[0] == -6.0


def test_the_scene_cannot_be_read_any_more(run, tmp_path):
    (tmp_path / "scene.yaml").write_text(HALL.replace("horizon: 12.0", "horizon: soon"))
    assert "drawn without the scene" in open_run(run).notes[0]


def test_the_scene_has_other_agents(run, tmp_path):
    changed = HALL.replace("id: cat", "id: dan")
    (tmp_path / "scene.yaml").write_text(changed)
    view = open_run(run)
    assert view.notes[-1].endswith("has other agents by now; drawn without it")
    assert view.lines.agent_ids[2] == "cat"
    other = tmp_path / "other.yaml"
    other.write_text(changed)
    with pytest.raises(UsageError, match="has other agents than"):
        open_run(run, other)


def test_the_map_is_gone(run, tmp_path):
    base = "rectangle: [-5.0, -3.0, 5.0, 3.0]\n  obstacles: [{rectangle: [-1.0, 2.0, 1.0, 3.0]}]"
    assert base in HALL
    (tmp_path / "hall.obj").write_text("v -5 -3 0\nv 5 -3 0\nv 5 3 0\nv -5 3 0\nf 1 2 3 4\n")
    (tmp_path / "scene.yaml").write_text(HALL.replace(base, "mesh: hall.obj"))
    assert open_run(run).free_space is not None
    (tmp_path / "hall.obj").unlink()
    view = open_run(run)
    assert view.free_space is None
    assert any("hall.obj" in note for note in view.notes)


def test_agents_in_another_order_than_in_the_scene(run, tmp_path):
    lines = HALL.splitlines()
    (tmp_path / "scene.yaml").write_text("\n".join([*lines[:9], lines[11], lines[9], lines[10]]))
    view = open_run(run)
    assert view.lines.agent_ids == ("ann", "ben", "cat")
    assert view.crowd.stays.tolist() == [True, True, False]
    assert view.crowd.preferred[0] == 7.0
    assert view.lines.curve(2).tolist() == CURVES[2].tolist()
