"""Two rooms with a doorway, twelve metres by eight, in every format."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import shapely
from ezdxf import units
from PIL import Image

# The wall between the rooms stands at x = 6 to 7, the doorway is at y = 2 to 5.
FLOOR = shapely.box(0, 0, 12, 8)
BLOCKS = (shapely.box(6, 0, 7, 2), shapely.box(6, 5, 7, 8))
ROOMS = FLOOR.difference(shapely.union_all(BLOCKS))


@dataclass(frozen=True)
class Sample:
    """A file, and how it is read.

    Attributes:
        write: writes it into a folder, and files beside it; gives its name.
        options: of the map that bring it to `ROOMS`.
        loss: area that its shapes may lack, m2.
    """

    write: Callable[[Path], str]
    options: dict[str, Any] = field(default_factory=dict)
    loss: float = 1e-6


def ring(shape: Any, scale: float = 1.0) -> list[list[float]]:
    """The corners of a polygon, counterclockwise, once each."""
    return [
        [x * scale, y * scale]
        for x, y in shapely.get_coordinates(shapely.orient_polygons(shape))[:-1]
    ]


def cells(size: float) -> np.ndarray:
    """Whether the middle of every cell is free, row 0 on top."""
    rows, columns = int(8 / size), int(12 / size)
    x, y = np.meshgrid((np.arange(columns) + 0.5) * size, 8 - (np.arange(rows) + 0.5) * size)
    return shapely.contains_xy(ROOMS, x, y)


def movingai(folder: Path) -> str:
    rows = ["".join(".@"[not free] for free in row) for row in cells(1.0)]
    (folder / "rooms.map").write_text(
        "\n".join(["type octile", "height 8", "width 12", "map", *rows]) + "\n"
    )
    return "rooms.map"


def picture(folder: Path) -> str:
    Image.fromarray(np.where(cells(0.25), 250, 20).astype(np.uint8)).save(folder / "plan.png")
    return "plan.png"


def occupancy(folder: Path) -> str:
    values = np.where(cells(0.25), 254, 0).astype(np.uint8)
    head = f"P5\n# made by hand\n{values.shape[1]} {values.shape[0]}\n255\n".encode()
    (folder / "occupancy.pgm").write_bytes(head + values.tobytes())
    (folder / "occupancy.yaml").write_text(
        "image: occupancy.pgm\nmode: trinary\nresolution: 0.25\norigin: [-3.0, -4.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    return "occupancy.yaml"


def wkt(folder: Path) -> str:
    left, door, right = shapely.box(0, 0, 6, 8), shapely.box(5, 2, 8, 5), shapely.box(7, 0, 12, 8)
    (folder / "rooms.wkt").write_text(
        shapely.to_wkt(shapely.GeometryCollection([left, door, right])) + "\n"
    )
    return "rooms.wkt"


def _features(place: Callable[[float, float], list[float]]) -> dict[str, Any]:
    def feature(shape: Any, kind: str) -> dict[str, Any]:
        corners = [place(x, y) for x, y in shapely.get_coordinates(shape)]
        return {
            "type": "Feature",
            "properties": {"kind": kind},
            "geometry": {"type": "Polygon", "coordinates": [corners]},
        }

    return {
        "type": "FeatureCollection",
        "features": [feature(FLOOR, "room"), *(feature(block, "obstacle") for block in BLOCKS)],
    }


def geojson(folder: Path) -> str:
    (folder / "rooms.geojson").write_text(json.dumps(_features(lambda x, y: [x, y])))
    return "rooms.geojson"


def degrees(folder: Path) -> str:
    def place(x: float, y: float) -> list[float]:
        # On the ellipsoid at 50 degrees north, around the middle of the floor.
        latitude = math.radians(50.0)
        e2, a = 0.00669437999014, 6378137.0
        root = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
        north, east = a * (1 - e2) / root**3, a / root * math.cos(latitude)
        return [7.0 + math.degrees((x - 6) / east), 50.0 + math.degrees((y - 4) / north)]

    (folder / "degrees.geojson").write_text(json.dumps(_features(place)))
    return "degrees.geojson"


def dxf(folder: Path) -> str:
    document = ezdxf.new()
    document.units = units.MM
    space = document.modelspace()
    corners = ring(FLOOR, 1000.0)
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        space.add_line(a, b, dxfattribs={"layer": "WALLS"})
    block = document.blocks.new("pier")
    block.add_solid([(0, 0), (1000, 0), (0, 1000), (1000, 1000)])
    for y in (0, 1, 5, 6, 7):
        space.add_blockref("pier", (6000, y * 1000), dxfattribs={"layer": "WALLS"})
    space.add_text("Room", dxfattribs={"layer": "TEXT"})
    space.add_circle((3000, 3000), 400, dxfattribs={"layer": "FURNITURE"})
    document.saveas(folder / "rooms.dxf")
    return "rooms.dxf"


def svg(folder: Path) -> str:
    (folder / "rooms.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        'viewBox="0 0 120 80"><style>.wall { fill: #333 }</style>'
        '<rect width="120" height="80" fill="white"/><defs><path id="pier" d="M0 0h10v10h-10z"/></defs>'
        '<g transform="translate(60 0)"><rect class="wall" width="10" height="30"/>'
        '<use xlink:href="#pier" y="60"/><use xlink:href="#pier" y="70"/></g><text>door</text></svg>'
    )
    return "rooms.svg"


def building(folder: Path) -> str:
    places = [c for shape in (FLOOR, *BLOCKS) for c in ring(shape, 20.0)] + [
        [40.0, 80.0],
        [200.0, 80.0],
        [140.0, 60.0],
    ]
    names = ["" for _ in places]
    names[-3:] = ["dock", "shelf", "kiosk"]
    vertices = "\n".join(
        f'      - [{x}, {160.0 - y}, 0, "{name}"]'
        for (x, y), name in zip(places, names, strict=True)
    )
    vertices = vertices.replace(', "dock"]', ", dock, {spawn_robot_name: [1, cart]}]")
    walls = "\n".join(
        f"      - [{k + j}, {k + (j + 1) % 4}, {{}}]" for k in (4, 8) for j in range(4)
    )
    (folder / "rooms.building.yaml").write_text(
        f"name: rooms\nlevels:\n  L1:\n    vertices:\n{vertices}\n    walls:\n{walls}\n"
        "    measurements:\n      - [0, 1, {distance: [3, 8.0]}]\n"
        "    floors:\n      - vertices: [0, 1, 2, 3]\n"
        "    holes:\n      - vertices: [4, 5, 6, 7]\n      - vertices: [8, 9, 10, 11]\n"
        "    doors:\n      - [5, 8, {name: [1, d], type: [1, hinged]}]\n"
        "    lanes:\n      - [12, 13, {}]\n"
        "  L2:\n    vertices: []\n"
    )
    return "rooms.building.yaml"


def vadere(folder: Path) -> str:
    def rectangle(shape: Any) -> dict[str, Any]:
        x0, y0, x1, y1 = shape.bounds
        return {
            "type": "RECTANGLE",
            "x": x0 + 0.5,
            "y": y0 + 0.5,
            "width": x1 - x0,
            "height": y1 - y0,
        }

    polygon = {
        "type": "POLYGON",
        "points": [{"x": x + 0.5, "y": y + 0.5} for x, y in ring(BLOCKS[1])],
    }
    topography = {
        "attributes": {"bounds": {"x": 0.0, "y": 0.0, "width": 13.0, "height": 9.0}, "boundingBoxWidth": 0.5,
                       "bounded": True},
        "obstacles": [{"id": 1, "shape": rectangle(BLOCKS[0])}, {"id": 2, "shape": polygon}],
        "targets": [{"id": 7, "shape": rectangle(shapely.box(10, 1, 12, 7))}],
        "sources": [{"id": 3, "shape": rectangle(shapely.box(1, 1, 5, 7)), "targetIds": [7],
                     "spawner": {"eventElementCount": 10}}],
        "dynamicElements": [], "attributesPedestrian": {"radius": 0.2, "maximumSpeed": 2.2},
    }  # fmt: skip
    (folder / "rooms.scenario").write_text(
        json.dumps({"name": "rooms", "scenario": {"topography": topography}})
    )
    return "rooms.scenario"


def jupedsim(folder: Path) -> str:
    content = {
        "walkable_area_wkt": shapely.to_wkt(FLOOR),
        "obstacles": {str(k): {"coordinates": ring(block)} for k, block in enumerate(BLOCKS)},
        "distributions": {"crowd": {"coordinates": ring(shapely.box(1, 1, 5, 7)),
                                    "parameters": {"number": 10, "radius": 0.2}}},
        "exits": {"door": {"coordinates": ring(shapely.box(10, 1, 12, 7))}},
    }  # fmt: skip
    (folder / "rooms.json").write_text(json.dumps(content))
    return "rooms.json"


def database(folder: Path) -> str:
    with sqlite3.connect(folder / "rooms.sqlite") as connection:
        connection.execute("CREATE TABLE geometry (hash INTEGER, wkt TEXT)")
        connection.execute("INSERT INTO geometry VALUES (1, ?)", (shapely.to_wkt(ROOMS),))
    connection.close()
    return "rooms.sqlite"


def menge(folder: Path) -> str:
    def obstacle(corners: list[list[float]]) -> str:
        vertices = "".join(f'<Vertex p_x="{x}" p_y="{y}"/>' for x, y in corners)
        return f'<Obstacle closed="1">{vertices}</Obstacle>'

    agents = "".join(f'<Agent p_x="{1 + k}" p_y="{y}"/>' for k in range(5) for y in (1.5, 6.5))
    outlines = "".join([obstacle(ring(FLOOR)[::-1]), *(obstacle(ring(block)) for block in BLOCKS)])
    (folder / "roomsS.xml").write_text(
        '<?xml version="1.0"?>\n<Experiment version="2.0"><AgentProfile name="p"><Common r="0.2"/>'
        "</AgentProfile>"
        '<AgentGroup><ProfileSelector type="const" name="p"/><Generator type="explicit">'
        f'{agents}</Generator></AgentGroup><ObstacleSet type="explicit">{outlines}</ObstacleSet></Experiment>'
    )
    (folder / "roomsB.xml").write_text(
        '<BFSM><GoalSet id="0"><Goal type="AABB" id="0" xmin="8" xmax="11.5" ymin="0.5" ymax="7.5"/>'
        "</GoalSet></BFSM>"
    )
    return "roomsS.xml"


def ccbs(folder: Path) -> str:
    rows = "".join(f"<row>{' '.join('01'[not free] for free in row)}</row>" for row in cells(1.0))
    (folder / "grid.xml").write_text(
        f"<root><map><width>12</width><height>8</height><grid>{rows}</grid></map></root>"
    )
    agents = "".join(
        f'<agent id="{k}" start_i="{k}" start_j="1" goal_i="{7 - k}" goal_j="10"/>'
        for k in range(8)
    )
    agents += '<agent id="8" start_i="1" start_j="3" goal_i="1" goal_j="8"/>'
    agents += '<agent id="9" start_i="6" start_j="3" goal_i="6" goal_j="8"/>'
    (folder / "agents.xml").write_text(f'<?xml version="1.0" ?>\n<root>{agents}</root>')
    return "grid.xml"


def mappit(folder: Path) -> str:
    quads = [shapely.box(0, 0, 6, 8), shapely.box(6, 2, 7, 5), shapely.box(7, 0, 12, 8)]
    lines = [f"v {x} {y} 0" for quad in quads for x, y in ring(quad)]
    lines += [f"f {4 * k + 1} {4 * k + 2} {4 * k + 3} {4 * k + 4}" for k in range(3)]
    (folder / "terrain.obj").write_text("\n".join(lines) + "\n")
    agents = {
        f"agent{k}": {
            "id": k, "xse": [[1.5, 0.75 * k + 0.5, 0], [10.5, 7.5 - 0.75 * k, 30]], "radius": 0.25, "mass": 1,
            "friends": [2] if k == 1 else [],
            "energy_coefficients": {"K_agent": 1, "K_map": 1, "K_ke": 1, "K_rg": 10},
        }
        for k in range(1, 11)
        if 0.75 * k + 0.5 < 7.7
    }  # fmt: skip
    setup = {"name": "rooms", "agents": agents, "obstacles": {}, "terrain": {"mesh": "terrain.obj"}}
    (folder / "setup.json").write_text(json.dumps(setup))
    return "setup.json"


def ifc(folder: Path) -> str:
    from ifcopenshell.api import context as contexts
    from ifcopenshell.api import project as projects
    from ifcopenshell.api import root, spatial, unit

    model = projects.create_file()
    root.create_entity(model, ifc_class="IfcProject", name="rooms")
    unit.assign_unit(model, length={"is_metric": True, "raw": "METERS"})
    context = contexts.add_context(model, context_type="Model")
    body = contexts.add_context(
        model,
        context_type="Model",
        context_identifier="Body",
        target_view="MODEL_VIEW",
        parent=context,
    )
    storey = root.create_entity(model, ifc_class="IfcBuildingStorey", name="ground")
    storey.Elevation = 0.0

    def solid(kind: str, shape: Any, bottom: float, height: float) -> None:
        points = [
            model.createIfcCartesianPoint((float(x), float(y)))
            for x, y in shapely.get_coordinates(shape)
        ]
        profile = model.createIfcArbitraryClosedProfileDef(
            "AREA", None, model.createIfcPolyline(points)
        )
        place = model.createIfcAxis2Placement3D(model.createIfcCartesianPoint((0.0, 0.0, bottom)))
        up = model.createIfcDirection((0.0, 0.0, 1.0))
        extruded = model.createIfcExtrudedAreaSolid(profile, place, up, height)
        element = root.create_entity(model, ifc_class=kind, name=kind)
        shape_of = model.createIfcShapeRepresentation(body, "Body", "SweptSolid", [extruded])
        element.Representation = model.createIfcProductDefinitionShape(None, None, [shape_of])
        spatial.assign_container(model, products=[element], relating_structure=storey)

    solid("IfcSlab", FLOOR, -0.2, 0.2)
    for block in BLOCKS:
        solid("IfcWall", block, 0.0, 2.5)
    # The lintel of the doorway is above everybody's head.
    solid("IfcWall", shapely.box(6, 2, 7, 5), 2.1, 0.4)
    model.write(str(folder / "rooms.ifc"))
    return "rooms.ifc"


def lif(folder: Path) -> str:
    places = {"a": (2, 4), "b": (6, 4), "c": (10, 4), "d": (6, 7)}
    content = {
        "metaInformation": {"projectIdentification": "rooms"},
        "layouts": [{
            "layoutId": "ground",
            "nodes": [{"nodeId": name, "nodePosition": {"x": x, "y": y}} for name, (x, y) in places.items()],
            "edges": [
                {"edgeId": f"e{k}", "startNodeId": a, "endNodeId": b,
                 "vehicleTypeEdgeProperties": [{"maxSpeed": 1.0}]}
                for k, (a, b) in enumerate(("ab", "bc", "bd"))
            ],
            "stations": [{"stationId": name, "interactionNodeIds": [node]} for name, node in ("Sa", "Tc")],
        }],
    }  # fmt: skip
    (folder / "layout.lif").write_text(json.dumps(content))
    return "layout.lif"


SAMPLES = {
    "movingai": Sample(movingai),
    "picture": Sample(picture, {"scale": 0.25}),
    "occupancy": Sample(occupancy, {"origin": [3.0, 4.0]}),
    "wkt": Sample(wkt),
    "geojson": Sample(geojson, {"scale": 1.0}),
    "degrees": Sample(degrees, {"origin": [6.0, 4.0]}, 1e-3),
    "dxf": Sample(dxf, {"layers": ["WALLS"]}),
    "svg": Sample(svg, {"scale": 0.1}),
    "building": Sample(building, {"origin": [0.0, 8.0]}),
    "vadere": Sample(vadere, {"origin": [-0.5, -0.5]}),
    "jupedsim": Sample(jupedsim),
    "database": Sample(database),
    "menge": Sample(menge),
    "ccbs": Sample(ccbs),
    "mappit": Sample(mappit),
    "ifc": Sample(ifc, {}, 1e-3),
}
