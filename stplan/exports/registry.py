"""The formats that a run is written in. A new one is a function and an entry of `EXPORTS`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stplan.exports import animated_glb, documents, jupedsim, mcap, splines, tables, usd
from stplan.exports.settings import ExportSettings
from stplan.viewing.glb_file import glb_bytes
from stplan.viewing.jupedsim_file import jupedsim_bytes
from stplan.viewing.run_view import RunView


@dataclass(frozen=True)
class Export:
    """A format.

    Attributes:
        file: what its file is called in the run's folder unless told.
        write: (run, settings) -> the file.
        sampled: whether it holds the run at fixed steps; else as planned.
    """

    file: str
    write: Callable[[RunView, ExportSettings], bytes]
    sampled: bool = True


def _rods(view: RunView, settings: ExportSettings) -> bytes:
    return glb_bytes(view, settings.pace)


def _text(view: RunView, settings: ExportSettings) -> bytes:
    return jupedsim_bytes(view, 1.0 / settings.step)


EXPORTS: dict[str, Export] = {
    "glb": Export("rods.glb", _rods, sampled=False),
    "animated-glb": Export("animated.glb", animated_glb.animated_glb_bytes),
    "csv": Export("samples.csv", tables.csv_frames),
    "blender": Export("blender.csv", tables.blender_csv),
    "jupedsim": Export("jupedsim.txt", _text),
    "jupedsim-sqlite": Export("jupedsim.sqlite", jupedsim.sqlite_bytes),
    "geojson": Export("run.geojson", documents.geojson_bytes, sampled=False),
    "paths": Export("paths.txt", documents.paths_bytes, sampled=False),
    "splines": Export("splines.json", splines.splines_bytes, sampled=False),
    "vda5050": Export("vda5050.json", documents.vda5050_bytes),
    "openrmf": Export("openrmf.json", documents.openrmf_bytes),
    "hdf5": Export("samples.h5", tables.hdf5_bytes),
    "parquet": Export("samples.parquet", tables.parquet_bytes),
    "mcap": Export("run.mcap", mcap.mcap_bytes),
    "usd": Export("run.usda", usd.usd_bytes),
}
