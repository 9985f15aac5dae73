"""What other programs read from exported files is what was planned."""

from __future__ import annotations

import io

import numpy as np
import pedpy
import pytest
import shapely
import trimesh

from stplan.analysis.paths import positions, segment_speeds
from stplan.scene.reading.load import parse_scene
from stplan.viewing.glb_file import glb_bytes
from stplan.viewing.jupedsim_file import jupedsim_bytes
from stplan.viewing.palette import hex_colours
from stplan.viewing.run_view import open_run
from stplan.world import build_free_space
from tests.viewing.runs import hall_run, write_run

# Without symmetry of any kind.
HOUSE = [(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)]
YARD = [(1, 5), (3, 6), (2, 8)]


@pytest.fixture
def view(tmp_path):
    return open_run(hall_run(tmp_path))


def test_trimesh_reads_the_glb_back(view):
    scene = trimesh.load(io.BytesIO(glb_bytes(view, 2.0)), file_type="glb")
    assert set(scene.geometry) == {"ann", "ben", "cat", "map floor", "map walls"}
    ann = scene.geometry["ann"]
    # x stays, time (2 m a second) points upwards, y points away: y is -z.
    np.testing.assert_allclose(ann.bounds, [[-4.3, 0.0, -0.3], [4.3, 18.0, 0.3]], atol=1e-6)
    cat = scene.geometry["cat"]
    np.testing.assert_allclose(cat.bounds[:, 1], [2.0, 18.0])
    merged = ann.copy()
    merged.merge_vertices()
    assert merged.is_watertight
    assert merged.volume == pytest.approx(18.0 * np.pi * 0.3**2, rel=0.01)
    red, green, blue = ann.visual.material.baseColorFactor[:3].tolist()
    assert f"#{red:02x}{green:02x}{blue:02x}" == hex_colours(1)[0]
    np.testing.assert_allclose(scene.geometry["map walls"].bounds[:, [0, 2]], [[-5, -3], [5, 3]])


@pytest.mark.parametrize("shift", [(0.0, 0.0), (500_000.0, 4_649_776.0), (-8.0e6, 9.9e6)])
def test_an_exported_run_is_a_map_in_its_place(tmp_path, shift):
    floor = shapely.affinity.translate(shapely.Polygon(HOUSE, [YARD]), *shift)
    ring, hole = (np.array(part.coords[:-1]).tolist() for part in shapely.get_rings(floor))
    start, goal = np.add([[1.0, 1.0], [11.0, 1.0]], shift)
    text = (
        f"stplan: 1\nname: house\nmap: {{polygon: {ring}, holes: [{hole}]}}\nhorizon: 20.0\n"
        f"agents: [{{id: a, start: {start.tolist()}, goal: {goal.tolist()}}}]\n"
    )
    run = write_run(tmp_path, text, [np.array([[*start, 0.0], [*goal, 9.0]])])
    (tmp_path / "run.glb").write_bytes(glb_bytes(open_run(run)))
    read = build_free_space(parse_scene("""stplan: 1
map: {mesh: run.glb}
horizon: 20.0
agents: [{id: a, start: [0, 0], goal: [1, 1]}]
""", directory=tmp_path))  # fmt: skip
    apart = shapely.symmetric_difference(read.area, floor)
    assert apart.area < 1e-4
    assert shapely.hausdorff_distance(read.area, floor) < 1e-5


def test_the_default_height_of_a_second_is_the_time_scale(view):
    scene = trimesh.load(io.BytesIO(glb_bytes(view)), file_type="glb")
    assert scene.bounds[1, 1] == pytest.approx(9.0 * view.time_scale)


def test_pedpy_computes_our_speeds(view, tmp_path):
    path = tmp_path / "hall.txt"
    path.write_bytes(jupedsim_bytes(view, 20.0))
    trajectory = pedpy.load_trajectory(trajectory_file=path)
    assert trajectory.frame_rate == 20.0
    # ben and ann stay until the end, cat vanishes then.
    assert trajectory.data.groupby("id").frame.agg(["min", "max"]).to_numpy().tolist() == [
        [0, 180], [0, 180], [20, 180],
    ]  # fmt: skip
    places = positions(view.lines, view.leaves, np.arange(181) / 20.0)
    for number, rows in trajectory.data.groupby("id"):
        ours = places[number - 1][~np.isnan(places[number - 1, :, 0])]
        np.testing.assert_allclose(rows[["x", "y"]].to_numpy(), ours, atol=1e-8)
    speeds = pedpy.compute_individual_speed(
        traj_data=trajectory,
        frame_step=1,
        speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
    )
    compared = 0
    for a, curve in enumerate(view.lines.curves()):
        rows = speeds[speeds.id == a + 1]
        times = rows.frame.to_numpy() / 20.0
        for k, speed in enumerate(segment_speeds(curve)):
            # PedPy takes differences over the frames before and after.
            within = (times > curve[k, 2] + 0.051) & (times < curve[k + 1, 2] - 0.051)
            np.testing.assert_allclose(rows.speed.to_numpy()[within], speed, atol=1e-6)
            compared += int(within.sum())
    assert compared > 400


def test_names_and_map_stand_at_the_end(view):
    lines = jupedsim_bytes(view).decode().splitlines()
    assert lines[0] == "#framerate: 25"
    assert lines[-4:-1] == ["#id 1: ann", "#id 2: ben", "#id 3: cat"]
    area = pedpy.WalkableArea(lines[-1].removeprefix("#geometry: "))
    assert view.free_space is not None
    assert shapely.equals(area.polygon, view.free_space.polygon)
