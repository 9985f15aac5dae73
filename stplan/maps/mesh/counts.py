"""What mesh files announce about themselves, looked at before a reader spends memory on it."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable

from stplan.errors import SceneError

# Floors are far smaller; what is larger would take minutes and gigabytes.
MOST_VERTICES = 1_000_000
MOST_FACES = 2_000_000
# Of a text file, comments and all else counted.
MOST_LINES = 5_000_000
# A header is looked for within so many bytes.
LONGEST_HEADER = 65_536
_STL_HEAD, _STL_FACE = 84, 50


def announced_faces(content: bytes, kind: str) -> int:
    """How many faces a PLY or OFF file announces, 0 for files of another `kind`.

    Raises:
        SceneError: the file announces more than is read; the message goes after its name.
        ValueError: it has no readable header.
    """
    if content.count(b"\n") > MOST_LINES and kind in {"obj", "ply", "off"}:
        raise SceneError(f"has more than {MOST_LINES} lines")
    vertices, faces = _COUNTS.get(kind, _none)(content)
    check_counts(vertices, faces)
    return faces if kind in {"ply", "off"} else 0


def check_counts(vertices: int, faces: int) -> None:
    """Raise SceneError where there are more than are read."""
    for count, most, what in ((vertices, MOST_VERTICES, "vertices"), (faces, MOST_FACES, "faces")):
        if count > most:
            raise SceneError(f"has {count} {what}, at most {most} are read")


def _none(content: bytes) -> tuple[int, int]:
    del content
    return 0, 0


def _ply(content: bytes) -> tuple[int, int]:
    head, end, _ = content[:LONGEST_HEADER].partition(b"end_header")
    if not end:
        raise ValueError("no end of the header")
    counts = {name: int(count) for name, count in re.findall(rb"element\s+(\w+)\s+(-?\d+)", head)}
    if min(counts.values(), default=0) < 0:
        raise ValueError("negative counts")
    # Elements of other names take as much to read.
    faces = counts.pop(b"face", 0)
    return sum(counts.values()), faces


def _off(content: bytes) -> tuple[int, int]:
    words = re.sub(rb"#.*", b"", content[:LONGEST_HEADER]).split()[:3]
    if words[0] != b"OFF":
        return 0, 0
    vertices, faces = int(words[1]), int(words[2])
    if vertices < 0 or faces < 0:
        raise ValueError("negative counts")
    return vertices, faces


def _stl(content: bytes) -> tuple[int, int]:
    text = content.lstrip()[:5].lower() == b"solid"
    vertices = content.count(b"vertex") if text else 0
    if not vertices:
        vertices = 3 * max(0, (len(content) - _STL_HEAD) // _STL_FACE)
    return vertices, vertices // 3


def _glb(content: bytes) -> tuple[int, int]:
    """Every accessor is as good as vertices; a mesh is read as often as nodes refer to it."""
    (length,) = struct.unpack_from("<I", content, 12)
    tree = json.loads(content[20 : 20 + length])
    sizes = [int(accessor["count"]) for accessor in tree.get("accessors", ())]
    if min(sizes, default=0) < 0:
        raise ValueError("negative counts")
    in_mesh = [_mesh_size(mesh, sizes) for mesh in tree.get("meshes", ())]
    children = [node.get("children", ()) for node in tree.get("nodes", ())]
    own = [in_mesh[node["mesh"]] if "mesh" in node else 0 for node in tree.get("nodes", ())]
    roots = [node for scene in tree.get("scenes", ()) for node in scene.get("nodes", ())]
    return max(sum(sizes), _tree_size(roots, children, own)), 0


def _mesh_size(mesh: dict[str, list[dict[str, dict[str, int]]]], sizes: list[int]) -> int:
    return sum(
        sizes[index] for part in mesh["primitives"] for index in part.get("attributes", {}).values()
    )


def _tree_size(roots: list[int], children: list[list[int]], own: list[int]) -> int:
    """Nodes and vertices below `roots`; counting ends where it is too many, as in a cycle."""
    size = 0
    stack = list(roots)
    while stack and size <= MOST_VERTICES:
        node = stack.pop()
        size += 1 + own[node]
        stack += children[node]
    return size


_COUNTS: dict[str, Callable[[bytes], tuple[int, int]]] = {
    "ply": _ply,
    "off": _off,
    "stl": _stl,
    "glb": _glb,
}
