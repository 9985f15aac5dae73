"""The foreign formats. A new one is a file here and an entry of `FORMATS`."""

from __future__ import annotations

from pathlib import Path

from stplan.maps.files import FileContent
from stplan.maps.formats import (
    ccbs,
    dxf,
    geojson,
    ifc,
    jupedsim,
    lif,
    mappit,
    menge,
    movingai,
    openrmf,
    pictures,
    svg,
    vadere,
    wkt,
)
from stplan.maps.formats.drawing import ForeignFormat, FormatError

FORMATS: tuple[ForeignFormat, ...] = (
    movingai.MAP,
    movingai.SCENARIO,
    openrmf.BUILDING,
    pictures.OCCUPANCY,
    pictures.PICTURE,
    wkt.WKT,
    mappit.MAPPIT,
    vadere.VADERE,
    lif.LIF,
    jupedsim.SCENARIO,
    geojson.GEOJSON,
    jupedsim.DATABASE,
    menge.MENGE,
    ccbs.CCBS,
    dxf.DXF,
    svg.SVG,
    ifc.IFC,
)
SUFFIXES = tuple(dict.fromkeys(suffix for form in FORMATS for suffix in form.suffixes))


def format_of(file: FileContent) -> ForeignFormat:
    """The format of a file, by its ending and, where several share it, by what it holds.

    Raises:
        FormatError: it is of none that is known.
    """
    suffix = Path(file.path).suffix.lower()
    candidates = [form for form in FORMATS if suffix in form.suffixes]
    for form in candidates:
        if form.claims is None or form.claims(file.content):
            return form
    names = ", ".join(form.name for form in candidates)
    raise FormatError(
        f"is none of what ends in {suffix}: {names}"
        if candidates
        else f"ends in {suffix!r}, of no known format"
    )
