"""Maps that are damaged, that lie about themselves, or that are far too large."""

from __future__ import annotations

import json
import math
import random
import struct
from collections.abc import Callable, Iterator
from typing import Any

from tests.refusals.case import Case, Content

MANY = 10_000_000
SQUARE = "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\n"


def _ply(
    vertices: int, faces: int, body: bytes = b"", kind: str = "ascii", index: str = "int"
) -> bytes:
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {faces}\nproperty list uchar {index} vertex_indices\n"
        "end_header\n"
    )
    return head.encode() + body


BINARY = "binary_little_endian"
_TRIANGLE = b"0 0 0\n9 0 0\n0 9 0\n"
_PACKED = struct.pack("<9f", 0, 0, 0, 9, 0, 0, 0, 9, 0)


def _glb(tree: Any, binary: bytes = b"") -> bytes:
    text = tree if isinstance(tree, bytes) else json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _gltf(**changes: Any) -> bytes:
    """A triangle, changed."""
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 48}],
    }  # fmt: skip
    return _glb(tree | changes, _PACKED + struct.pack("<3I", 0, 1, 2))


def _accessors(count: int, **more: Any) -> list[dict[str, Any]]:
    return [
        {"componentType": 5126, "count": count, "type": "VEC3", **more},
        {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
    ]


def _circle(count: int, radius: float = 1.0) -> str:
    angles = (2 * math.pi * k / count for k in range(count))
    return "".join(f"v {radius * math.cos(a):.9f} {radius * math.sin(a):.9f} 0\n" for a in angles)


def _soup(count: int) -> bytes:
    rng = random.Random(1)
    corners = "".join(f"v {rng.random()} {rng.random()} 0\n" for _ in range(count))
    faces = "".join(
        f"f {' '.join(str(rng.randint(1, count)) for _ in range(3))}\n" for _ in range(2 * count)
    )
    return (corners + faces).encode()


def _crowded() -> bytes:
    """A fan whose slender triangles end in as many corners in almost one place."""
    rng, count = random.Random(2), 3000
    middle = "".join(f"v {1e-9 * rng.random()} {1e-9 * rng.random()} 0\n" for _ in range(count))
    faces = "".join(
        f"f {k + 1} {count + k + 1} {count + (k + 1) % count + 1}\n" for k in range(count)
    )
    return (middle + _circle(count) + faces).encode()


OBJ: dict[str, Content] = {
    "empty": b"",
    "no faces": SQUARE.encode(),
    "lines": f"{SQUARE}l 1 2\n".encode(),
    "two corners": f"{SQUARE}f 1 2\n".encode(),
    "no such vertex": f"{SQUARE}f 1 2 99\n".encode(),
    "vertex zero": f"{SQUARE}f 0 1 2\n".encode(),
    "far below": f"{SQUARE}f -99 -98 -97\n".encode(),
    "huge reference": f"{SQUARE}f 1 2 {10**30}\n".encode(),
    "long reference": f"{SQUARE}f 1 2 {'9' * 6000}\n".encode(),
    "no reference": f"{SQUARE}f a b c\n".encode(),
    "nan": f"{SQUARE}v nan 0 0\nf 1 2 5\n".encode(),
    "inf": f"{SQUARE}v inf 0 0\nf 1 2 5\n".encode(),
    "1e300": f"{SQUARE}v 1e300 0 0\nf 1 2 5\n".encode(),
    "two numbers": b"v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n",
    "words": b"v x y z\nf 1 1 1\n",
    "one line": b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
    "one point": b"v 1 1 0\nf 1 1 1\n",
    "upright": b"v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n",
    "bow tie": b"v 0 0 0\nv 9 9 0\nv 9 0 0\nv 0 5 0\nf 1 2 3 4\n",
    "noise": random.Random(3).randbytes(5000),
    "nul": bytes(5_000_000),
    "binary ply": _ply(3, 1, _PACKED, BINARY),
    "circle of 2001 corners": (
        _circle(2001) + "f " + " ".join(str(k) for k in range(1, 2002)) + "\n"
    ).encode(),
    "long line": b"v 0 0 0\nf" + b" 1" * 60_000 + b"\n",
    "soup": _soup(3000),
    "crowded": _crowded,
    "10^7 vertices": lambda: b"v 1 2 0\n" * MANY + b"f 1 2 3\n",
    "10^7 faces": lambda: SQUARE.encode() + b"f 1 2 3\n" * MANY,
    "10^7 lines": lambda: b"\n" * MANY,
    "10^7 continuations": lambda: b"\\\n" * MANY,
    "1000001 vertices": lambda: b"v 1 2 0\n" * 1_000_001 + b"f 1 2 3\n",
    "above 100 MiB": lambda: bytes(100 * 2**20 + 1),
}
PLY: dict[str, Content] = {
    "empty": b"",
    "head only": b"ply\nformat ascii 1.0\n",
    "endless head": b"ply\n" + b"comment x\n" * 20_000,
    "no end": b"ply\nformat ascii 1.0\nelement vertex 3\n",
    "10^7 announced": _ply(MANY, MANY),
    "10^12 announced": _ply(10**12, 10**12, _TRIANGLE),
    "10^12 announced, binary": _ply(10**12, 1, _PACKED, BINARY),
    "faces missing": _ply(3, 2, _TRIANGLE + b"3 0 1 2\n"),
    "vertices missing": _ply(4, 1, _TRIANGLE),
    "faces missing, binary": _ply(3, 100, _PACKED + struct.pack("<B3i", 3, 0, 1, 2), BINARY),
    "vertices missing, binary": _ply(100, 1, _PACKED, BINARY),
    "corners missing, binary": _ply(3, 1, _PACKED + struct.pack("<B3i", 255, 0, 1, 2), BINARY),
    "negative": _ply(-3, -1, _TRIANGLE),
    "negative, binary": _ply(-3, -1, _PACKED, BINARY),
    "no such vertex": _ply(3, 1, _TRIANGLE + b"3 0 1 99\n"),
    "negative index": _ply(3, 1, _TRIANGLE + b"3 0 1 -9\n"),
    "nan": _ply(3, 1, b"nan 0 0\n9 0 0\n0 9 0\n3 0 1 2\n"),
    "inf, binary": _ply(
        3, 1, struct.pack("<9fB3i", math.inf, 0, 0, 9, 0, 0, 0, 9, 0, 3, 0, 1, 2), BINARY
    ),
    "no numbers": _ply(3, 1, b"a b c\n" * 3 + b"3 0 1 2\n"),
    "wrong byte order": _ply(
        3, 1, _PACKED + struct.pack("<B3i", 3, 0, 1, 2), "binary_big_endian"
    ),
    "unknown format": _ply(3, 1, _TRIANGLE + b"3 0 1 2\n", "morse"),
    "unknown type": _ply(3, 1, _TRIANGLE + b"3 0 1 2\n", index="quaternion"),
    "one line": _ply(3, 1, b"0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n"),
    "20000 elements": b"ply\nformat ascii 1.0\n"
    + b"".join(b"element e%d 1\nproperty float x\n" % k for k in range(20_000)) + b"end_header\n",
    "noise": b"ply\n" + random.Random(4).randbytes(5000),
    "10^7 vertices": lambda: _ply(MANY, 1, b"0 0 0\n" * MANY + b"3 0 1 2\n"),
    "10^7 vertices, binary": lambda: _ply(
        8 * 10**6, 1, bytes(12 * 8 * 10**6) + struct.pack("<B3i", 3, 0, 1, 2), BINARY
    ),
}  # fmt: skip
OFF: dict[str, Content] = {
    "empty": b"",
    "no counts": b"OFF\n",
    "10^7 announced": b"OFF\n%d %d 0\n" % (MANY, MANY),
    "faces missing": b"OFF\n3 2 0\n" + _TRIANGLE + b"3 0 1 2\n",
    "negative": b"OFF\n-3 -1 0\n" + _TRIANGLE,
    "no such vertex": b"OFF\n3 1 0\n" + _TRIANGLE + b"3 0 1 9\n",
    "infinitely high": b"OFF\n3 1 0\n0 0 inf\n9 0 0\n0 9 0\n3 0 1 2\n",
    "very high": b"OFF\n3 1 0\n0 0 1e300\n9 0 -1e300\n0 9 0\n3 0 1 2\n",
    "words": b"OFF\nthree one zero\n" + _TRIANGLE,
    "noise": b"OFF\n" + random.Random(5).randbytes(2000),
}
STL: dict[str, Content] = {
    "empty": b"",
    "2^32 announced": bytes(80) + struct.pack("<I", 2**32 - 1),
    "10^7 announced": bytes(80) + struct.pack("<I", MANY) + bytes(50),
    "solid nothing": b"solid x\nendsolid x\n",
    "no numbers": b"solid x\nfacet normal 0 0 1\nouter loop\nvertex a b c\nendloop\nendfacet\n",
    "no area": bytes(80) + struct.pack("<I", 1) + bytes(50),
    "400000 facets": lambda: bytes(80) + struct.pack("<I", 400_000) + bytes(50 * 400_000),
    "400000 facets, text": lambda: b"solid x\n" + b"vertex 0 0 0\n" * 1_200_000 + b"endsolid x\n",
}
GLB: dict[str, Content] = {
    "empty": b"",
    "head only": b"glTF",
    "length lies": struct.pack("<4sIII4s", b"glTF", 2, 2**32 - 1, 2**32 - 1, b"JSON") + b"{}",
    "deep": _glb(b"[" * 1_000_000),
    "no tree": _glb([1, 2]),
    "no meshes": _glb({"asset": {"version": "2.0"}}),
    "10^9 zeros": _gltf(accessors=_accessors(10**9)),
    "10^12 zeros": _gltf(accessors=_accessors(10**12)),
    "negative": _gltf(accessors=_accessors(-3, bufferView=0)),
    "beyond the buffer": _gltf(accessors=_accessors(1000, bufferView=0)),
    "no such view": _gltf(accessors=_accessors(3, bufferView=99)),
    "circle of nodes": _gltf(nodes=[{"mesh": 0, "children": [0]}]),
    "2^40 nodes": _gltf(
        nodes=[{"children": [k + 1, k + 1]} for k in range(40)] + [{"mesh": 0}]
    ),
    "other file": _gltf(buffers=[{"byteLength": 48, "uri": "/etc/passwd"}]),
    "other scheme": _gltf(buffers=[{"byteLength": 48, "uri": "http://localhost:1/x"}]),
}  # fmt: skip


def cases() -> Iterator[Case]:
    """Every hostile map, as that of a scene which is sound otherwise."""
    kinds = {"obj": OBJ, "ply": PLY, "off": OFF, "stl": STL, "glb": GLB}
    for kind, meshes in kinds.items():
        for name, content in meshes.items():
            text = (
                f"stplan: 1\nhorizon: 20\nmap: {{mesh: map.{kind}}}\n"
                "agents: [{id: sam, start: [1, 1], goal: [3, 1]}]\n"
            )
            yield Case(f"{kind}: {name}", text.encode(), {f"map.{kind}": content}, "map.mesh")


def content_of(content: Content) -> bytes:
    """The bytes, made now where they are many."""
    return content() if isinstance(content, Callable) else content
