"""What every format's own library reads of an exported run is the run, and the same bytes come out twice."""

from __future__ import annotations

import csv
import io
import json
import sqlite3

import h5py
import numpy as np
import pedpy
import pyarrow.parquet
import pytest
import shapely
import trimesh
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from pxr import Usd, UsdGeom, UsdValidation

from stplan.analysis.paths import positions
from stplan.errors import UsageError
from stplan.exports.frames import frames_of
from stplan.exports.registry import EXPORTS
from stplan.exports.settings import ExportSettings
from stplan.viewing.run_view import open_run
from stplan.world import build_free_space
from tests.viewing.runs import hall_run
from tests.world.scenes import scene

HALF = ExportSettings(0.5, 0.5)
NAMES = ("ann", "ben", "cat")


@pytest.fixture
def view(tmp_path):
    return open_run(hall_run(tmp_path))


def written(view, form: str, settings: ExportSettings = HALF) -> bytes:
    return EXPORTS[form].write(view, settings)


def expected(view, times: np.ndarray) -> np.ndarray:
    return positions(view.lines, view.leaves, times)


@pytest.mark.parametrize("form", EXPORTS)
def test_the_same_run_gives_the_same_bytes(form: str, view) -> None:
    assert written(view, form) == written(view, form)


def test_headings_follow_motion_and_stay_when_it_ends(view) -> None:
    frames = frames_of(view, 0.25, 0.5)
    ann, ben, _ = frames.headings
    np.testing.assert_allclose(ann, 0.0, atol=1e-12)
    np.testing.assert_allclose(ben, np.pi / 2, atol=1e-12)
    # A turn takes no longer than the smoothing.
    bent = frames.headings[2]
    early, late = np.arctan2(-0.4, -5), np.arctan2(-0.1, -3)
    times = frames.times
    turned = np.remainder(bent - np.where(times < 6, early, late) + np.pi, 2 * np.pi) - np.pi
    assert np.abs(turned[np.abs(times - 6) > 0.25]).max() < 1e-9


def test_too_many_samples_are_refused(view) -> None:
    with pytest.raises(UsageError, match="a longer step is expected"):
        frames_of(view, 1e-7, 0.5)


def test_csv(view) -> None:
    rows = [*csv.DictReader(io.StringIO(written(view, "csv").decode()))]
    for a, name in enumerate(NAMES):
        mine = [row for row in rows if row["agent"] == name]
        times = np.array([float(row["t"]) for row in mine])
        np.testing.assert_allclose(np.diff(times), 0.5)
        places = np.array([[float(row["x"]), float(row["y"])] for row in mine])
        np.testing.assert_allclose(places, expected(view, times)[a], atol=1e-8)
    cat = [float(row["t"]) for row in rows if row["agent"] == "cat"]
    assert (cat[0], cat[-1]) == (1.0, 9.0)


def test_blender_csv_is_in_frames(view) -> None:
    rows = [*csv.DictReader(io.StringIO(written(view, "blender").decode()))]
    assert [row["agent"] for row in rows[:2]] == ["ann", "ben"]
    assert {row["frame"] for row in rows} == {str(k) for k in range(1, 20)}
    assert rows[1]["radius"] == "0.4"


def test_jupedsim_sqlite_is_read_by_pedpy(view, tmp_path) -> None:
    path = tmp_path / "run.sqlite"
    path.write_bytes(written(view, "jupedsim-sqlite"))
    data = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=path)
    assert data.frame_rate == 2.0
    ben = data.data[data.data["id"] == 2]
    np.testing.assert_allclose(
        ben[["x", "y"]], expected(view, ben["frame"].to_numpy() / 2.0)[1], atol=1e-9
    )
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=path)
    assert area.polygon.equals(view.free_space.polygon)
    with sqlite3.connect(path) as connection:
        names = connection.execute("SELECT name FROM agent_names ORDER BY id").fetchall()
    connection.close()
    assert [name for (name,) in names] == [*NAMES]


def test_an_exported_run_is_a_map_again(view, tmp_path) -> None:
    (tmp_path / "run.geojson").write_bytes(written(view, "geojson"))
    (tmp_path / "run.sqlite").write_bytes(written(view, "jupedsim-sqlite"))
    for tree in ("{file: run.geojson, scale: 1.0}", "{file: run.sqlite}"):
        area = build_free_space(scene(tree, folder=tmp_path)).area
        assert area.equals(view.free_space.area)


def test_geojson_has_knots_with_times(view) -> None:
    tree = json.loads(written(view, "geojson"))
    floor, *agents = tree["features"]
    assert shapely.geometry.shape(floor["geometry"]).equals(view.free_space.area)
    for a, agent in enumerate(agents):
        knots = np.column_stack([agent["geometry"]["coordinates"], agent["properties"]["times"]])
        np.testing.assert_array_equal(knots, view.lines.curve(a))


def test_paths_have_all_knots(view) -> None:
    lines = written(view, "paths").decode().splitlines()
    assert lines[0] == "ann: (-4,0,0)->(4,0,8)"
    assert len(lines) == 3


def test_orders_and_requests_hold_places_with_times(view) -> None:
    orders = json.loads(written(view, "vda5050"))["orders"]
    assert [order["serialNumber"] for order in orders] == [*NAMES]
    for a, order in enumerate(orders):
        numbers = [node["sequenceId"] for node in order["nodes"]]
        assert numbers == [2 * k for k in range(len(numbers))]
        assert [edge["sequenceId"] for edge in order["edges"]] == [k + 1 for k in numbers[:-1]]
        assert all(-np.pi <= node["nodePosition"]["theta"] <= np.pi for node in order["nodes"])
        places = [[node["nodePosition"][key] for key in "xy"] for node in order["nodes"]]
        times = np.array([node["plannedTime"] for node in order["nodes"]])
        np.testing.assert_allclose(places, expected(view, times)[a], atol=1e-9)
    robots = json.loads(written(view, "openrmf"))["robots"]
    times = [stop["t"]["sec"] + stop["t"]["nanosec"] / 1e9 for stop in robots[2]["path"]]
    assert (times[0], times[-1]) == (1.0, 9.0)


def test_hdf5_and_parquet(view) -> None:
    with h5py.File(io.BytesIO(written(view, "hdf5"))) as file:
        assert [name.decode() for name in file["agents"]] == [*NAMES]
        np.testing.assert_allclose(file["places"], expected(view, file["times"][:]), atol=1e-12)
        np.testing.assert_array_equal(file["knots"], view.lines.knots)
        assert file.attrs["heading_smoothing"] == 0.5
    table = pyarrow.parquet.read_table(io.BytesIO(written(view, "parquet"))).to_pydict()
    cat = [k for k, name in enumerate(table["agent"]) if name == "cat"]
    places = np.column_stack([np.array(table[key])[cat] for key in "xy"])
    np.testing.assert_allclose(places, expected(view, np.array(table["t"])[cat])[2], atol=1e-12)


def test_mcap_is_read_as_messages_of_ros(view) -> None:
    reader = make_reader(io.BytesIO(written(view, "mcap")), decoder_factories=[DecoderFactory()])
    messages = [*reader.iter_decoded_messages()]
    paths = [one for one in messages if one.channel.topic.endswith("/path")]
    topics = [f"/agents/{name}_{k}/path" for k, name in enumerate(NAMES, 1)]
    assert sorted(one.channel.topic for one in paths) == topics
    assert paths[0].schema.name == "nav_msgs/msg/Path"
    first = next(one for one in paths if "ann" in one.channel.topic).decoded_message
    assert (first.poses[2].header.stamp.sec, first.poses[2].pose.position.x) == (1, -3.0)
    markers = [one.decoded_message.markers for one in messages if one.channel.topic == "/agents"]
    assert len(markers) == 19
    # cat appears after a second.
    assert [marker.action for marker in markers[0]] == [0, 0, 2]
    assert [marker.action for marker in markers[2]] == [0, 0, 0]
    assert markers[2][1].scale.x == pytest.approx(0.8)


def test_usd_opens_and_moves(view, tmp_path) -> None:
    path = tmp_path / "run.usda"
    path.write_bytes(written(view, "usd"))
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert UsdValidation.ValidationContext(validators).Validate(stage) == []
    assert stage.GetTimeCodesPerSecond() == 2.0
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    ann = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Agent_1_ann"))
    place = ann.ComputeLocalToWorldTransform(Usd.TimeCode(8)).ExtractTranslation()
    np.testing.assert_allclose(list(place), [0.0, 0.0, 0.15])
    cat = UsdGeom.Imageable(stage.GetPrimAtPath("/World/Agent_3_cat"))
    assert cat.ComputeVisibility(Usd.TimeCode(0)) == "invisible"
    assert cat.ComputeVisibility(Usd.TimeCode(4)) == "inherited"


def test_the_animated_glb_is_sound(view) -> None:
    content = written(view, "animated-glb")
    scene_read = trimesh.load(io.BytesIO(content), file_type="glb")
    assert {*NAMES, "map floor"} <= set(scene_read.graph.nodes)
    length = int.from_bytes(content[12:16], "little")
    tree = json.loads(content[20 : 20 + length])
    data = content[20 + length + 8 :]
    (animation,) = tree["animations"]

    def array(index: int) -> np.ndarray:
        accessor = tree["accessors"][index]
        part = tree["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        values = np.frombuffer(data, "<f4", accessor["count"] * width, part["byteOffset"])
        assert values.reshape(-1, width).min(axis=0).tolist() == accessor["min"]
        return values.reshape(-1, width)

    by_target = {
        (channel["target"]["node"], channel["target"]["path"]): animation["samplers"][
            channel["sampler"]
        ]
        for channel in animation["channels"]
    }
    times = array(by_target[0, "translation"]["input"])[:, 0]
    moves = array(by_target[1, "translation"]["output"])
    true = expected(view, times.astype(float))[1]
    np.testing.assert_allclose(moves[:, [0, 2]] * [1, -1], true, atol=1e-6)
    turns = array(by_target[1, "rotation"]["output"])
    np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1.0, atol=1e-6)
    sizes = array(by_target[2, "scale"]["output"])[:, 0]
    assert (sizes[0], sizes[4]) == (0.0, pytest.approx(0.3))
