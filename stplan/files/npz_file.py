"""World lines as numpy arrays in a zip: for programs, exact, the same bytes for the same curves."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy_format

from stplan.amounts import LARGEST
from stplan.arrays import FloatArray, IntArray
from stplan.errors import UsageError
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Scene

FORMAT = 1
_REQUIRED = ("agent_ids", "offsets", "knots")
# What a damaged, encrypted, foreign or unreadable file raises, one way or another.
_BROKEN = (OSError, EOFError, ValueError, RuntimeError, zipfile.BadZipFile, zlib.error)
# Zip knows no dates before this one.
_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class NpzContent:
    """What a file holds; files of other programs may leave out all but the world lines.

    Attributes:
        world_lines: the curves.
        radii: (A,) m, or None.
        masses: (A,) kg, or None.
        time_scale: m/s, or None.
    """

    world_lines: WorldLines
    radii: FloatArray | None
    masses: FloatArray | None
    time_scale: float | None


def npz_bytes(lines: WorldLines, scene: Scene) -> bytes:
    """`lines`, with what `scene` says of their agents, as an uncompressed .npz."""
    agents = {agent.id: agent for agent in scene.agents}
    arrays: dict[str, np.ndarray[Any, Any]] = {
        "agent_ids": np.array(lines.agent_ids, dtype=np.str_),
        "offsets": lines.offsets.astype("<i8"),
        "knots": lines.knots.astype("<f8"),
        "radii": np.array([agents[name].radius for name in lines.agent_ids], dtype="<f8"),
        "masses": np.array([agents[name].mass for name in lines.agent_ids], dtype="<f8"),
        "time_scale": np.array(scene.time_scale, dtype="<f8"),
        "format": np.array(FORMAT, dtype="<i8"),
    }
    return arrays_bytes(arrays)


def arrays_bytes(arrays: Mapping[str, np.ndarray[Any, Any]]) -> bytes:
    """`arrays` by name as an uncompressed .npz, the same bytes for the same arrays.

    `numpy.savez` stamps every member with the time of writing, hence the zip by hand.
    """
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            npy_format.write_array(member, np.asarray(array, order="C"), allow_pickle=False)
            entry = zipfile.ZipInfo(f"{name}.npy", _DATE)
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, member.getvalue())
    return whole.getvalue()


def read_npz(path: Path) -> NpzContent:
    """Read and check a file; nothing in it is ever executed.

    Raises:
        UsageError: headed by the file and the key.
    """
    return _Checked(Path(path), read_arrays(path)).content()


def read_arrays(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """All arrays of a file by name. Raises UsageError where it cannot be read."""
    path = Path(path)
    try:
        # By hand too: numpy.load leaves the file open where the zip in it is broken.
        with path.open("rb") as stream, zipfile.ZipFile(stream) as archive:
            return {
                name.removesuffix(".npy"): npy_format.read_array(
                    io.BytesIO(archive.read(name)), allow_pickle=False
                )
                for name in archive.namelist()
            }
    except FileNotFoundError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from error
    except _BROKEN as error:
        raise UsageError(f"{path}: not a readable .npz file: {error}") from error


class _Checked:
    """The arrays of a file, each checked as it is asked for."""

    def __init__(self, path: Path, arrays: Mapping[str, np.ndarray[Any, Any]]) -> None:
        self.path = path
        self.arrays = arrays

    def content(self) -> NpzContent:
        missing = [name for name in _REQUIRED if name not in self.arrays]
        if missing:
            raise UsageError(f"{self.path}: lacks {', '.join(missing)}")
        if "format" in self.arrays and self.arrays["format"].tolist() != FORMAT:
            raise self._error(
                "format", f"is {self.arrays['format'].tolist()}; this version reads {FORMAT}"
            )
        ids = self._agent_ids()
        knots = self._floats("knots", (None, 3))
        if np.abs(knots).max(initial=0.0) > LARGEST:
            place = tuple(np.argwhere(np.abs(knots) > LARGEST)[0].tolist())
            raise self._error("knots", f"the number at {place} is beyond {LARGEST:g}")
        lines = WorldLines(ids, self._offsets(len(ids), len(knots)), knots)
        scale = self._optional("time_scale", ())
        return NpzContent(
            lines,
            self._optional("radii", (len(ids),)),
            self._optional("masses", (len(ids),)),
            None if scale is None else float(scale),
        )

    def _agent_ids(self) -> tuple[str, ...]:
        ids = self.arrays["agent_ids"]
        if ids.ndim != 1 or ids.dtype.kind != "U" or not ids.size:
            raise self._error("agent_ids", "expected a list of at least one text")
        names = tuple(str(name) for name in ids.tolist())
        if len(set(names)) != len(names):
            raise self._error("agent_ids", "an id stands there twice")
        return names

    def _offsets(self, num_agents: int, num_knots: int) -> IntArray:
        offsets = self.arrays["offsets"]
        if offsets.dtype.kind not in "iu" or offsets.shape != (num_agents + 1,):
            raise self._error("offsets", f"expected {num_agents + 1} whole numbers")
        result = np.ascontiguousarray(offsets, dtype=np.int64)
        if result[0] != 0 or result[-1] != num_knots:
            raise self._error("offsets", f"expected to run from 0 to the {num_knots} knots")
        if (np.diff(result) < 2).any():
            raise self._error("offsets", "every agent needs at least 2 knots")
        return result

    def _floats(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        array = self.arrays[name]
        fits = len(array.shape) == len(shape) and all(
            wanted in (None, found) for wanted, found in zip(shape, array.shape, strict=True)
        )
        if not fits or array.dtype.kind not in "fiu":
            wanted = tuple("M" if size is None else size for size in shape)
            raise self._error(name, f"expected numbers of shape {wanted}, found {array.shape}")
        result = np.array(array, dtype=np.float64, order="C")
        if not np.isfinite(result).all():
            place = tuple(np.argwhere(~np.isfinite(result))[0].tolist())
            raise self._error(name, f"the number at {place} is not finite")
        return result

    def _optional(self, name: str, shape: tuple[int | None, ...]) -> FloatArray | None:
        return self._floats(name, shape) if name in self.arrays else None

    def _error(self, name: str, message: str) -> UsageError:
        return UsageError(f"{self.path}: {name}: {message}")
