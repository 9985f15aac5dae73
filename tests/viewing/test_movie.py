"""Movies, read back: size, number and pace of frames, and that discs are where agents are."""

from __future__ import annotations

import io
import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from stplan.viewing.movie import LONGEST, frame_times, movie_bytes
from stplan.viewing.movie_frames import Film
from stplan.viewing.palette import agent_colours
from stplan.viewing.run_view import open_run
from tests.viewing.runs import hall_run


@pytest.fixture
def view(tmp_path):
    return open_run(hall_run(tmp_path))


def _places_of(picture: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """(N, 2) columns and rows of pixels of this hue: discs are drawn pale over the floor."""
    pale = 0.78 * 255 * colour + 0.22 * 255
    rows, columns = np.nonzero(np.abs(picture[..., :3].astype(int) - pale).max(axis=2) <= 6)
    return np.column_stack([columns, rows])


def test_discs_are_where_agents_are_at_true_size(view):
    film = Film([view], ["hall"], (1000, 660), "")
    ann, _, cat = agent_colours(3)
    early, late = film.frame(2.0), film.frame(6.0)
    assert early.shape == (660, 1000, 4)
    places = [_places_of(picture, ann) for picture in (early, late)]
    # The map is 6 m high, with margins of 0.25 m on both sides; title and time take 78 of 660 pixels.
    scale = 582 / 6.5
    for found in places:
        assert len(found) == pytest.approx(np.pi * (0.3 * scale) ** 2, rel=0.15)
    moved = np.median(places[1], axis=0) - np.median(places[0], axis=0)
    assert moved[0] / scale == pytest.approx(4.0, abs=0.1)
    assert abs(moved[1]) <= 1
    # cat is not there before its start.
    assert len(_places_of(film.frame(0.5), cat)) < 0.1 * len(_places_of(early, cat))


def _decoded(path: Path, width: int) -> np.ndarray:
    """(N, height, width, 3) frames of a movie."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-i", str(path)]
    raw = subprocess.run(
        [*command, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], capture_output=True, check=True
    ).stdout
    return np.frombuffer(raw, np.uint8).reshape(21, -1, width, 3).astype(int)


def test_mp4(view, tmp_path):
    said = []
    content = movie_bytes(
        [view], ["hall"], "mp4", fps=5, speed=3.0, size=(321, None), progress=said.append
    )
    path = tmp_path / "movie.mp4"
    path.write_bytes(content)
    assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (21, pytest.approx(4.2, abs=0.05))
    frames = _decoded(path, 322)
    # 9 s at three times their speed, and a second of standing still.
    assert len(frames) == 16 + 5
    assert said[-1] == "frame 21 of 21"
    assert np.abs(frames[0] - frames[8]).max() > 100
    assert np.abs(frames[-1] - frames[-2]).max() < 40


@pytest.mark.parametrize("kind", ["gif", "webp"])
def test_gif_and_webp(view, kind):
    content = movie_bytes([view, view], ["a", "b"], kind, fps=10, speed=9.0, size=(400, 200))
    with Image.open(io.BytesIO(content)) as movie:
        assert movie.format == kind.upper()
        assert movie.size == (400, 200)
        assert movie.n_frames >= 11
        first = np.asarray(movie.convert("RGB")).astype(int)
        movie.seek(5)
        later = np.asarray(movie.convert("RGB")).astype(int)
        assert movie.info["duration"] == 100
    changed = np.abs(first - later).max(axis=2) > 60
    # Both halves move, and alike: it is the same run twice.
    left, right = changed[40:150, :200].sum(), changed[40:150, 200:].sum()
    assert left > 100
    assert left == pytest.approx(right, rel=0.1)


def test_long_runs_are_shown_faster():
    times = frame_times(0.0, 90.0, 10.0, 90.0 / LONGEST)
    assert len(times) == 10 * LONGEST + 1 + 10
    assert times[-1] == times[-11] == 90.0
    assert frame_times(2.0, 5.0, 2.0, 1.0)[:3].tolist() == [2.0, 2.5, 3.0]
