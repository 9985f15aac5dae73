"""What walls hide, and how far whoever does not see through them may go until it stands.

Take two agents of which one does not see the other for a wall, and g, the length of the shortest way between
their centres. It bends at a corner v that the one at p sees: g is at least |p - v|, and what is left from v
to the other, who keeps its radius r from all walls and is behind that corner, out of sight from p. The least
of that over all corners, D(p), is known from the map alone. If each goes at most (D - R) / 2 until it stands,
they never come within a way of R of each other. Where they are nearer than that through the air a wall is
between them, from which both keep their radii, so they are more than R = r + r' apart all the same.

Where D(p) - R allows less later on the way than is left of a motion, that motion is not chosen. So whatever
comes into view, or goes out of it, both can stand by then.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.geometry.boundary_grid import BoundaryGrid
from stplan.geometry.visibility import clear_segments
from stplan.problem.shortest_ways import corner_faces
from stplan.scene.model import Scene
from stplan.world.free_space import FreeSpace

# Corners are looked at a little before them, as a share of the way, and from around them, in metres as shares
# of the smallest radius: what is seen of them by rounding alone counts as seen.
SHORT = 1e-6
AROUND = (1e-3, 0.5)
# Lines of sight pass walls at more than this share of the smallest radius.
THIN = 1e-9
# What is kept to spare, as a share.
ROOM = 1e-6
# Corners hide what is behind them from this angle on, rad: less is rounding.
GRAZING = 1e-9
# Where less than a stride is allowed, these shares of what is are tried, for it takes time to stand.
CAREFUL = np.array([0.8, 0.5, 0.25])
# Directions around a corner.
NORMALS = 3


@dataclass(frozen=True)
class Blinds:
    """Corners behind which somebody may be.

    Attributes:
        corners: (C, 6) as `corner_faces` has them.
        next_corner: (C,) how far it is to the nearest other end of a wall, m.
        around: (C, N, 2) points by which it is asked whether a corner is seen.
        walls: the boundary.
        thin: how near to a wall a line of sight may pass, m: no more than rounding.
    """

    corners: FloatArray
    next_corner: FloatArray
    around: FloatArray
    walls: BoundaryGrid
    thin: float

    @staticmethod
    def of(space: FreeSpace, least_radius: float) -> Blinds:
        """The blinds of a free space, for agents of a radius or more."""
        corners = corner_faces(space)
        ends = np.unique(space.boundary_vertices, axis=0)
        gaps = np.hypot(*np.moveaxis(corners[:, None, :2] - ends[None], -1, 0))
        gaps[gaps == 0.0] = np.inf
        share = np.linspace(0.0, 1.0, NORMALS)
        angles = corners[:, 2, None] + corners[:, 3, None] * share[None, :]
        normals = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        around = [corners[:, None, :2] + far * least_radius * normals for far in AROUND]
        return Blinds(
            corners,
            gaps.min(axis=1, initial=np.inf),
            np.concatenate(around, axis=1),
            BoundaryGrid.from_segments(space.boundary_segments),
            THIN * least_radius,
        )

    def clear(self, heads: FloatArray, tails: FloatArray) -> BoolArray:
        """(n,) whether no wall is between points (n, 2)."""
        return clear_segments(
            np.ascontiguousarray(heads), np.ascontiguousarray(tails), self.thin, self.walls
        )

    def ways_to_hidden(self, points: FloatArray, radius: float, reach: float) -> FloatArray:
        """(n,) the shortest way from points (n, 2) to anybody of a radius that walls may hide, m.

        Ways longer than `reach` are inf.
        """
        found = np.full(len(points), np.inf)
        if not len(self.corners):
            return found
        offset = points[:, None] - self.corners[None, :, :2]
        far = np.hypot(offset[..., 0], offset[..., 1])
        # Angles are counted from the first edge at the corner; free are those up to `span` and half a turn.
        angle = np.arctan2(offset[..., 1], offset[..., 0]) - (self.corners[:, 2] - 0.5 * np.pi)
        angle = np.mod(angle, 2.0 * np.pi)
        span = self.corners[:, 3]
        after, before = span - angle, angle - np.pi
        inside = angle <= span + np.pi
        ways = np.full(far.shape, np.inf)
        for hidden, edge in ((after, self.corners[:, 5]), (before, self.corners[:, 4])):
            least = np.minimum(np.hypot(edge, radius), self.next_corner + radius)
            with np.errstate(divide="ignore"):
                aside = radius / np.sin(np.clip(hidden, 0.0, 0.5 * np.pi))
            behind = np.where(hidden >= 0.5 * np.pi, radius, np.minimum(aside, least))
            ways = np.where(inside & (hidden > -GRAZING), np.minimum(ways, far + behind), ways)
        rows, columns = np.nonzero(ways <= reach)
        seen = self._seen(points[rows], columns)
        np.minimum.at(found, rows[seen], ways[rows[seen], columns[seen]])
        return found

    def _seen(self, points: FloatArray, corners: IntArray) -> BoolArray:
        """(n,) which points (n, 2) see a corner (n,), or a spot by it."""
        places = self.corners[corners, :2]
        seen = self.clear(points, places + SHORT * (points - places))
        for spot in range(self.around.shape[1]):
            left = np.flatnonzero(~seen)
            seen[left] = self.clear(points[left], self.around[corners[left], spot])
        return seen


class Hiding:
    """Whom walls hide from whom in a scene that is played, and what that asks of everybody.

    Args:
        apart: (A, A) what pairs keep, m, 0 where they need not.
    """

    def __init__(self, scene: Scene, space: FreeSpace, apart: FloatArray) -> None:
        blind = np.array([agent.line_of_sight for agent in scene.agents])
        self._blind, self._radii = blind, np.array([agent.radius for agent in scene.agents])
        self._blinds = Blinds.of(space, float(self._radii.min())) if blind.any() else None
        hidden = (blind[:, None] | blind[None, :]) & (apart > 0.0)
        # Of several who keep the same and are as large, one is enough.
        self._others = [
            sorted({(float(self._radii[b]), float(apart[a, b])) for b in np.flatnonzero(row)})
            for a, row in enumerate(hidden)
        ]

    def seen(self, places: FloatArray) -> BoolArray:
        """(A, A) whom at places (A, 2) no wall hides from whom, by row."""
        seen = np.ones((len(places), len(places)), dtype=bool)
        if self._blinds is None:
            return seen
        one, other = np.nonzero(np.triu(self._blind[:, None] | self._blind[None, :], 1))
        clear = self._blinds.clear(places[one], places[other])
        seen[one, other] = clear | ~self._blind[one]
        seen[other, one] = clear | ~self._blind[other]
        return seen

    def allows(self, a: int, ways: FloatArray) -> BoolArray:
        """(C,) which ways (C, L, 2) of an agent are short enough from every step on."""
        allowed = np.ones(len(ways), dtype=bool)
        if self._blinds is None or not self._others[a]:
            return allowed
        step = np.diff(ways, axis=1)
        lengths = np.hypot(step[..., 0], step[..., 1])
        left = np.cumsum(lengths[:, ::-1], axis=1)[:, ::-1]
        room = self._room(a, ways[:, :-1].reshape(-1, 2), float(left.max())).reshape(left.shape)
        return np.asarray(((left <= room) | (left == 0.0)).all(axis=1))

    def lost(self, a: int, places: FloatArray, stride: float) -> FloatArray:
        """(n,) how much of a stride (m) an agent would not be allowed at places (n, 2), m."""
        if self._blinds is None or not self._others[a]:
            return np.zeros(len(places))
        return np.maximum(stride - self._room(a, places, stride), 0.0)

    def short_shares(self, a: int, place: FloatArray, stride: float) -> FloatArray:
        """(n,) shares of a stride (m) that an agent is allowed at a place (2,), where it is not the whole."""
        lost = float(self.lost(a, place[None], stride)[0])
        return CAREFUL * (1.0 - lost / stride) if lost > 0.0 else np.empty(0)

    def _room(self, a: int, places: FloatArray, most: float) -> FloatArray:
        """(n,) how far an agent may go from places (n, 2) until it stands, m; inf beyond `most`."""
        room = np.full(len(places), np.inf)
        if self._blinds is None:
            return room
        for radius, apart in self._others[a]:
            ways = self._blinds.ways_to_hidden(places, radius, 2.0 * most + apart)
            room = np.minimum(room, (1.0 - ROOM) * 0.5 * (ways - apart))
        return room
