"""Maps of other programs that are damaged, lie about themselves, or would burst a careless reader."""

from __future__ import annotations

import io
import json
import sqlite3
import struct
import zlib
from collections.abc import Callable, Iterator
from typing import Any

from PIL import Image

from tests.refusals.case import Case, Content

MANY = 2_000_000


def _png(width: int, height: int, body: bytes | None = None) -> bytes:
    """A grey picture that announces a size, with other pixels than these where `body` says so."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    pixels = zlib.compress(bytes(height * (width + 1)), 9) if body is None else body
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    )


def _gif(width: int, height: int) -> bytes:
    buffer = io.BytesIO()
    Image.new("L", (1, 1)).save(buffer, "gif")
    content = bytearray(buffer.getvalue())
    content[6:10] = struct.pack("<HH", width, height)
    return bytes(content)


def _occupancy(**changes: Any) -> bytes:
    tree = {
        "image": "m.pgm",
        "resolution": 0.05,
        "origin": [0, 0, 0],
        "negate": 0,
        "free_thresh": 0.25,
    }
    return json.dumps(
        {key: value for key, value in (tree | changes).items() if value is not None}
    ).encode()


_PGM = b"P5 4 4 255\n" + b"\xfe" * 16
_HEAD = "type octile\nheight 4\nwidth 4\nmap\n"
_ENTITIES = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 12))
_LAUGHS = f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY e0 "lol">{_ENTITIES}]>'
_EXTERNAL = '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>'
_SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10">%s</svg>'
# Every group uses the one before ten times.
_TEN = ["".join(f"<use href='#u{k - 1}'/>" for _ in range(10)) for k in range(1, 10)]
_GROUPS = [f"<g id='u{k}'>{uses}</g>" for k, uses in enumerate(_TEN, 1)]
_USES = f"<defs><rect id='u0' width='1' height='1'/>{''.join(_GROUPS)}</defs><use href='#u9'/>"


def _menge(body: str) -> bytes:
    return f"<Experiment>{body}</Experiment>".encode()


_BOUNDS = {"x": 0, "y": 0, "width": 9, "height": 9}


def _vadere(**changes: Any) -> bytes:
    topography = {
        "attributes": {"bounds": {"x": 0, "y": 0, "width": 9, "height": 9}, "boundingBoxWidth": 0.5}
    }
    return json.dumps({"scenario": {"topography": topography | changes}}).encode()


def _building(**changes: Any) -> bytes:
    level = {
        "vertices": [[0, 0, 0, ""], [9, 0, 0, ""], [9, 9, 0, ""]],
        "walls": [],
        "floors": [{"vertices": [0, 1, 2]}],
    }
    return json.dumps({"levels": {"L1": level | changes}}).encode()


def _feature(geometry: Any) -> bytes:
    tree = {
        "type": "FeatureCollection",
        "features": [{"type": "Feature", "properties": {}, "geometry": geometry}],
    }
    return json.dumps(tree).encode()


def _dxf(blocks: str = "", entities: str = "") -> bytes:
    text = f"0|SECTION|2|BLOCKS|{blocks}0|ENDSEC|0|SECTION|2|ENTITIES|{entities}0|ENDSEC|0|EOF|"
    return text.replace("|", "\n").encode()


def _insert(name: str) -> str:
    return f"0|INSERT|8|0|2|{name}|10|0|20|0|"


def _nested_blocks() -> bytes:
    blocks = "0|BLOCK|8|0|2|b0|10|0|20|0|0|LINE|8|0|10|0|20|0|11|1|21|1|0|ENDBLK|"
    for k in range(1, 9):
        blocks += f"0|BLOCK|8|0|2|b{k}|10|0|20|0|{_insert(f'b{k - 1}') * 10}0|ENDBLK|"
    return _dxf(blocks, _insert("b8"))


def _own_block() -> bytes:
    return _dxf(f"0|BLOCK|8|0|2|b|10|0|20|0|{_insert('b')}0|ENDBLK|", _insert("b"))


def _database(statement: str, *values: object) -> bytes:
    connection = sqlite3.connect(":memory:")
    connection.execute("CREATE TABLE geometry (hash INTEGER, wkt TEXT)")
    connection.execute(statement, values)
    connection.commit()
    content = connection.serialize()
    connection.close()
    return content


def _endless_view() -> bytes:
    connection = sqlite3.connect(":memory:")
    connection.execute(
        "CREATE VIEW geometry AS WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) "
        "SELECT count(*) AS wkt FROM n"
    )
    connection.commit()
    content = connection.serialize()
    connection.close()
    return content


def _wkt(text: str) -> bytes:
    return text.encode()


def _lif(**changes: Any) -> bytes:
    node = {"nodeId": "a", "nodePosition": {"x": 0, "y": 0}}
    layout = {"layoutId": "g", "nodes": [node], "edges": [{"startNodeId": "a", "endNodeId": "a"}]}
    return json.dumps({"layouts": [layout | changes]}).encode()


def _setup(mesh: Any, agents: Any = None) -> bytes:
    agent = {"a": {"id": 1, "xse": [[0, 0, 0], [1, 1, 9]]}}
    return json.dumps(
        {"agents": agent if agents is None else agents, "terrain": {"mesh": mesh}}
    ).encode()


# A line that crosses itself a million times.
_SCRIBBLE = [(k * 7919 % 1000 / 100, k * 104729 % 997 / 100) for k in range(3000)]
_SCRIBBLE_TEXT = ", ".join(f"{x} {y}" for x, y in [*_SCRIBBLE, _SCRIBBLE[0]])
_SQUARE = "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))"
_Files = dict[str, Content]

GRIDS: dict[str, Content] = {
    "no head": b"@@@@\n....\n",
    "no width": b"type octile\nheight 4\nmap\n....\n",
    "empty": b"",
    "huge": b"type octile\nheight 99999999\nwidth 99999999\nmap\n",
    "gigantic number": b"type octile\nheight 4\nwidth " + b"9" * 5000 + b"\nmap\n",
    "negative": b"type octile\nheight -4\nwidth 4\nmap\n....\n",
    "zero": b"type octile\nheight 0\nwidth 0\nmap\n",
    "short rows": f"{_HEAD}....\n...\n....\n....\n".encode(),
    "few rows": f"{_HEAD}....\n".encode(),
    "no floor": (_HEAD + "@@@@\n" * 4).encode(),
    "binary": bytes(range(256)) * 40,
    "chessboard": lambda: (
        b"height 4000\nwidth 4000\nmap\n" + (b".@" * 2000 + b"\n" + b"@." * 2000 + b"\n") * 2000
    ),
}
OCCUPANCY: dict[str, Content] = {
    "no image": _occupancy(image=None),
    "image that is no name": _occupancy(image=[1]),
    "path upwards": _occupancy(image="../../../etc/passwd.png"),
    "path upwards inside": _occupancy(image="a/../../m.pgm"),
    "absolute path": _occupancy(image="/etc/passwd.png"),
    "drive": _occupancy(image="C:\\windows\\win.png"),
    "network": _occupancy(image="\\\\server\\share\\m.png"),
    "device": _occupancy(image="/dev/zero"),
    "missing": _occupancy(image="none.pgm"),
    "nul": _occupancy(image="m\0.pgm"),
    "another kind": _occupancy(image="m.exe"),
    "itself": _occupancy(image="map.yaml"),
    "resolution 0": _occupancy(resolution=0),
    "resolution negative": _occupancy(resolution=-0.05),
    "resolution text": _occupancy(resolution="fine"),
    "resolution huge": _occupancy(resolution=1e11),
    "origin": _occupancy(origin="here"),
    "origin of lists": _occupancy(origin=[[0], 0, 0]),
    "mode": _occupancy(mode="octal"),
    "negate": _occupancy(negate="maybe"),
    "all blocked": _occupancy(negate=1),
    "list": b"- image\n- resolution\n",
    "bomb": b"image: m.pgm\nresolution: 1\na: &a [x, x, x, x, x, x, x, x, x]\n"
    + b"".join(
        b"%c: &%c [%s]\n" % (98 + k, 98 + k, b", ".join([b"*%c" % (97 + k)] * 9)) for k in range(9)
    ),
    "deep": b"image: m.pgm\nresolution: " + b"[" * 5000,
}
PICTURES: dict[str, Content] = {
    "empty": b"",
    "text": b"not a picture at all, whatever its name says",
    "announces 10^10 pixels": _png(100_000, 100_000, zlib.compress(b"")),
    "zip bomb": lambda: _png(60_000, 60_000, zlib.compress(bytes(30_000_000), 9)),
    "cut": _png(64, 64)[:60],
    "black": _png(64, 64),
    "zero wide": _png(0, 64, zlib.compress(b"")),
    "pixels missing": _png(64, 64, zlib.compress(bytes(10))),
}
WKT: dict[str, Content] = {
    "empty": b"",
    "text": b"hello",
    "deep": b"GEOMETRYCOLLECTION (" * 200_000,
    "brackets": b"(" * 1_000_000,
    "open ring": _wkt("POLYGON ((0 0, 9 0, 9 9))"),
    "nan": _wkt("POLYGON ((0 0, nan 0, 9 9, 0 0))"),
    "infinite": _wkt("POLYGON ((0 0, inf 0, 9 9, 0 0))"),
    "far": _wkt("POLYGON ((0 0, 1e200 0, 1e200 1e200, 0 0))"),
    "words": _wkt("POLYGON ((zero zero, one one))"),
    "points only": _wkt("MULTIPOINT ((0 0), (1 1))"),
    "no area": _wkt("POLYGON ((0 0, 9 0, 0 0, 0 0))"),
    "many corners": lambda: b"LINESTRING (" + b"0 0, " * 3_000_000 + b"1 1)",
    "closing first": b")" * 1000,
    "scribbled polygon": _wkt(f"POLYGON (({_SCRIBBLE_TEXT}))"),
    "scribbled line": _wkt(f"LINESTRING ({_SCRIBBLE_TEXT})"),
}
GEOJSON: dict[str, Content] = {
    "cut": b'{"type": "FeatureCollection", "features": [',
    "list": b'[{"type": "Feature"}]',
    "no coordinates": _feature({"type": "Polygon"}),
    "flat": _feature({"type": "Polygon", "coordinates": [0, 1, 2]}),
    "words": _feature({"type": "Polygon", "coordinates": [[["a", "b"]] * 4]}),
    "unknown type": _feature({"type": "Sphere", "coordinates": []}),
    "nan": b'{"type": "Feature", "geometry": {"type": "Point", "coordinates": [NaN, 0]}}',
    "far from any degree": _feature(
        {"type": "Polygon", "coordinates": [[[0, 0], [900, 0], [900, 900], [0, 0]]]}
    ),
    "deep": b'{"type": "Feature", "geometry": ' + b"[" * 100_000,
    "collections": _feature(
        {"type": "GeometryCollection", "geometries": [{"type": "GeometryCollection"}]}
    ),
    "many values": lambda: b'{"type": "Feature", "x": [' + b"0," * 5_000_000 + b"0]}",
    "long number": b'{"type": "Feature", "geometry": {"type": "Point", "coordinates": ['
    + b"9" * 10_000
    + b", 0]}}",
    "bytes": b'{"type": "Feature", "name": "\xff"}',
    "scribble": _feature({"type": "Polygon", "coordinates": [[*_SCRIBBLE, _SCRIBBLE[0]]]}),
    "no features": b'{"type": "FeatureCollection", "features": []}',
}
SVG: dict[str, Content] = {
    "billion laughs": f"{_LAUGHS}<svg>&e11;</svg>".encode(),
    "external entity": f"{_EXTERNAL}<svg>&e;</svg>".encode(),
    "uses of uses": (_SVG % _USES).encode(),
    "uses itself": (_SVG % "<g id='a'><use href='#a'/></g>").encode(),
    "uses nothing": (_SVG % "<use href='#b'/>").encode(),
    "cut": b"<svg><rect",
    "other root": b"<html><body/></html>",
    "deep": b"<svg>" + b"<g>" * 100_000,
    "wide": lambda: b"<svg>" + b"<g/>" * 1_000_000 + b"</svg>",
    "path of letters": (_SVG % "<path d='M 1 2 L x y Z 3'/>").encode(),
    "path that ends early": (_SVG % "<path d='M 1 2 C 1 2 3'/>").encode(),
    "infinite": (_SVG % "<rect width='1e999' height='1'/>").encode(),
    "transform": (_SVG % "<g transform='warp(1)'><rect/></g>").encode(),
    "all dark": (_SVG % "<rect width='10' height='10'/>").encode(),
    "empty": b"",
    "nothing drawn": (_SVG % "").encode(),
    "curves far away": (_SVG % f"<path d='M0 0{'C1e8 1e8 -1e8 1e8 1 1' * 2000}'/>").encode(),
    "corners that are drawn": (_SVG % ("<circle r='1'/>" * 8000)).encode(),
    "comments in comments": (_SVG % f"<style>{'/*' * 200_000}</style>").encode(),
    "scribbled stroke": (
        _SVG % f"<polyline fill='none' stroke='black' points='{_SCRIBBLE_TEXT}'/>"
    ).encode(),
    "drawings in drawings": b"<svg><svg viewBox='0 0 1e-300 1' width='1e9' height='1'><g/></svg></svg>",
    "light over dark over light": (
        _SVG % ("<rect width='9' height='9'/><rect width='8' height='8' fill='white'/>" * 1100)
    ).encode(),
}
MENGE: dict[str, Content] = {
    "billion laughs": f"{_LAUGHS}<Experiment>&e11;</Experiment>".encode(),
    "corner without place": _menge("<Obstacle closed='1'><Vertex p_x='1'/></Obstacle>"),
    "corner in words": _menge("<Obstacle closed='1'><Vertex p_x='a' p_y='b'/></Obstacle>"),
    "single corner": _menge("<Obstacle closed='1'><Vertex p_x='1' p_y='1'/></Obstacle>"),
    "gigantic grid": _menge(
        "<AgentGroup><Generator type='rect_grid' count_x='99999' count_y='99999' anchor_x='0' anchor_y='0' "
        "offset_x='1' offset_y='1'/></AgentGroup>"
    ),
    "unknown generator": _menge("<AgentGroup><Generator type='magic'/></AgentGroup>"),
    "encoding": b"<?xml version='1.0' encoding='nonsense'?><Experiment/>",
    "ccbs without cells": b"<root><map><grid></grid></map></root>",
    "ccbs uneven": b"<root><map><grid><row>0 0</row><row>0</row></grid></map></root>",
    "ccbs agent without place": b"<root><agent id='0'/></root>",
    "neither": b"<root></root>",
}
VADERE: dict[str, Content] = {
    "no topography": b'{"scenario": {"topography": 3}}',
    "no bounds": _vadere(attributes={}),
    "bounds in words": _vadere(attributes={"bounds": {"x": "a", "y": 0, "width": 1, "height": 1}}),
    "frame wider than the floor": _vadere(attributes={"bounds": {"x": 0, "y": 0, "width": 1, "height": 1},
                                                      "boundingBoxWidth": 9}),
    "obstacle without shape": _vadere(obstacles=[{"id": 1}]),
    "obstacle of another shape": _vadere(obstacles=[{"shape": {"type": "STAR"}}]),
    "obstacles that are text": _vadere(obstacles="many"),
    "everything blocked": _vadere(obstacles=[{"shape": {"type": "RECTANGLE", **_BOUNDS}}]),
    "infinite": b'{"scenario": {"topography": {"attributes": {"bounds": {"x": 1e999}}}}}',
}  # fmt: skip
BUILDINGS: dict[str, Content] = {
    "no levels": b'{"levels": 3}',
    "level of nothing": b'{"levels": {"L1": 3}}',
    "unknown vertex": _building(walls=[[0, 99, {}]]),
    "negative vertex": _building(walls=[[0, -1, {}]]),
    "vertex in words": _building(vertices=[["a", "b", 0, ""]]),
    "true vertex": _building(walls=[[True, 0, {}]]),
    "no distance": _building(measurements=[[0, 1, {}]]),
    "unknown system": b'{"coordinate_system": "mars", "levels": {"L1": {}}}',
}
DATABASES: dict[str, Content] = {
    "text": b"not a database",
    "cut": _database("INSERT INTO geometry VALUES (1, ?)", _SQUARE)[:700],
    "empty table": _database("DELETE FROM geometry"),
    "number": _database("INSERT INTO geometry VALUES (1, x'00')"),
    "deep geometry": _database(
        "INSERT INTO geometry VALUES (1, ?)", "GEOMETRYCOLLECTION (" * 10_000
    ),
    "endless view": _endless_view,
    "other tables": _database("ALTER TABLE geometry RENAME TO other"),
}
DRAWINGS: dict[str, Content] = {
    "empty": b"",
    "text": b"hello world",
    "no entities": _dxf(),
    "blocks of blocks": _nested_blocks,
    "block of itself": _own_block,
    "cut": _dxf("", "0|LINE|8|0|10|"),
    "words": _dxf("", "0|LINE|8|0|10|a|20|b|11|1|21|1|"),
    "far": _dxf("", "0|LINE|8|0|10|0|20|0|11|1e300|21|1e300|"),
    "circle around the world": _dxf("", "0|CIRCLE|8|0|10|0|20|0|40|1e11|"),
    "binary": b"AutoCAD Binary DXF\r\n\x1a\x00" + bytes(300),
}
LAYOUTS: dict[str, Content] = {
    "no layout": b'{"layouts": []}',
    "unknown node": _lif(edges=[{"startNodeId": "a", "endNodeId": "z"}]),
    "no edges": _lif(edges=[]),
    "place in words": _lif(nodes=[{"nodeId": "a", "nodePosition": {"x": "b", "y": 0}}]),
    "no place": _lif(nodes=[{"nodeId": "a"}]),
    "mesh upwards": _setup("../terrain.obj"),
    "mesh anywhere": _setup("/etc/terrain.obj"),
    "mesh of another kind": _setup("terrain.sh"),
    "mesh missing": _setup("none.obj"),
    "mesh that is none": _setup("map.obj"),
    "agents without ends": _setup("floor.obj", {"a": {"xse": [1]}}),
    "scenario without area": b'{"exits": {}, "distributions": {}}',
    "none of all": b'{"hello": "world"}',
}
MODELS: dict[str, Content] = {
    "text": b"hello",
    "cut": b"ISO-10303-21;\nHEADER;\n",
    "no storey": b"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\nENDSEC;\n",
}
# By ending; `.json` where several formats share it.
KINDS: dict[str, tuple[str, dict[str, Content]]] = {
    "grid": ("map.map", GRIDS),
    "occupancy": ("map.yaml", OCCUPANCY),
    "picture": ("map.png", PICTURES),
    "wkt": ("map.wkt", WKT),
    "geojson": ("map.geojson", GEOJSON),
    "svg": ("map.svg", SVG),
    "xml": ("map.xml", MENGE),
    "vadere": ("map.scenario", VADERE),
    "building": ("map.building.yaml", BUILDINGS),
    "database": ("map.sqlite", DATABASES),
    "drawing": ("map.dxf", DRAWINGS),
    "json": ("map.json", LAYOUTS),
    "model": ("map.ifc", MODELS),
}
_FLOOR = b"v 0 0 0\nv 9 0 0\nv 9 9 0\nf 1 2 3\n"


def cases() -> Iterator[Case]:
    """Every hostile file, as the map of a scene which is sound otherwise."""
    for kind, (file, contents) in KINDS.items():
        for name, content in contents.items():
            text = (
                f"stplan: 1\nhorizon: 20\nmap: {{file: {file}}}\n"
                "agents: [{id: sam, start: [1, 1], goal: [3, 1]}]\n"
            )
            files: dict[str, bytes | Callable[[], bytes]] = {file: content, "m.pgm": _PGM}
            files |= {"floor.obj": _FLOOR, "map.obj": b"no mesh\n"}
            yield Case(f"{kind}: {name}", text.encode(), files, "map.file")
    gif = _gif(60_000, 60_000)
    text = b"stplan: 1\nhorizon: 20\nmap: {file: map.gif}\nagents: [{id: sam, start: [1, 1], goal: [3, 1]}]\n"
    yield Case("picture: gif of 3.6 10^9 pixels", text, {"map.gif": gif}, "map.file")
