"""Movies of runs: MP4 through the ffmpeg that comes in a wheel, GIF and WebP through Pillow."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from stplan.arrays import FloatArray
from stplan.callbacks import Progress, unheard
from stplan.errors import UsageError
from stplan.viewing.movie_frames import Film, default_height
from stplan.viewing.run_view import RunView

FORMATS = ("mp4", "gif", "webp")
# Without a speed asked for, longer runs are shown faster, so that a movie takes so long (s).
LONGEST = 12.0
# The last frame stands for so long (s).
_HOLD = 1.0
_MOST_FRAMES = 50_000

Frames = Iterable[NDArray[np.uint8]]


def movie_bytes(
    views: Sequence[RunView],
    titles: Sequence[str],
    kind: str,
    *,
    fps: float = 25.0,
    speed: float | None = None,
    size: tuple[int, int | None] = (960, None),
    progress: Progress = unheard,
) -> bytes:
    """A movie of runs side by side as a file of `kind`, one of `FORMATS`.

    Args:
        titles: one a run.
        fps: frames a second.
        speed: seconds of the run in a second of the movie; None is 1, or more for long runs.
        size: width and height in pixels, the height None follows from the maps; both are made even.
        progress: told which frame is drawn.

    Raises:
        UsageError: it would have too many frames.
    """
    begin, end = min(view.begin for view in views), max(view.end for view in views)
    chosen = max(1.0, (end - begin) / LONGEST) if speed is None else speed
    if (end - begin) * fps / chosen > _MOST_FRAMES:
        raise UsageError(
            f"the movie would have more than {_MOST_FRAMES} frames; raise --speed or lower --fps"
        )
    times = frame_times(begin, end, fps, chosen)
    width, height = size[0], size[1] or default_height(views, size[0])
    even = (width + width % 2, height + height % 2)
    note = "real time" if chosen == 1 else f"{chosen:.3g} times as fast"
    film = Film(views, titles, even, note)
    frames = _reported(film.frames(times), len(times), progress)
    return _mp4(frames, even, fps) if kind == "mp4" else _pillow(frames, kind, fps)


def frame_times(begin: float, end: float, fps: float, speed: float) -> FloatArray:
    """The moments shown, s: evenly from `begin` to `end`, which stands still for a while."""
    count = int(np.ceil((end - begin) * fps / speed)) + 1
    moving = np.minimum(begin + np.arange(count) * speed / fps, end)
    return np.append(moving, np.full(round(_HOLD * fps), end))


def _reported(frames: Frames, count: int, progress: Progress) -> Iterator[NDArray[np.uint8]]:
    for number, frame in enumerate(frames, start=1):
        progress(f"frame {number} of {count}")
        yield frame


def _mp4(frames: Frames, size: tuple[int, int], fps: float) -> bytes:
    with tempfile.TemporaryDirectory(prefix="stplan-movie-") as folder:
        path = Path(folder) / "movie.mp4"
        writer = imageio_ffmpeg.write_frames(
            str(path), size, pix_fmt_in="rgba", pix_fmt_out="yuv420p", fps=fps, codec="libx264",
            quality=None, macro_block_size=2,
            output_params=["-crf", "20", "-preset", "medium", "-movflags", "+faststart"],
        )  # fmt: skip
        writer.send(None)
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
        writer.close()
        return path.read_bytes()


def _pillow(frames: Frames, kind: str, fps: float) -> bytes:
    images: Iterator[Image.Image] = (Image.fromarray(frame).convert("RGB") for frame in frames)
    if kind == "gif":
        images = _with_one_palette(images)
        options: dict[str, Any] = {"optimize": False, "disposal": 1}
    else:
        options = {"quality": 72, "method": 4}
    first = next(images)
    stream = io.BytesIO()
    first.save(
        stream, format=kind.upper(), save_all=True, append_images=images,
        duration=max(round(1000 / fps), 20), loop=0, **options,
    )  # fmt: skip
    return stream.getvalue()


def _with_one_palette(images: Iterator[Image.Image]) -> Iterator[Image.Image]:
    """All in the colours of the first, where everyone is there: without flicker, and small."""
    first = next(images).quantize(colors=192, method=Image.Quantize.MEDIANCUT)
    yield first
    for image in images:
        yield image.quantize(palette=first, dither=Image.Dither.NONE)
