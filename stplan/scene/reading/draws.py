"""Free spots of places for agents that start anywhere in them, drawn with the scene's seed. Lengths in m."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stplan.amounts import amount
from stplan.arrays import FloatArray
from stplan.maps.reader import Floor
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Scene
from stplan.scene.places import Place
from stplan.scene.reading.regions import OFF_WALLS, floor_of, region_of
from stplan.schema.mapping import Fault

if TYPE_CHECKING:
    import shapely

# Spots lie so many times as far apart as they have to: nobody starts wedged in.
ROOMY = 1.1
# Of points this many times as many as agents are drawn one is taken after another where it is free; where
# they run out, spots of a lattice are, at ever smaller distances down to what is needed.
DRAWS = 200
LATTICES = (1.08, 1.05, 1.02, 1.005)


def with_drawn_starts(scene: Scene, drawn: Mapping[int, Place], faults: list[Fault]) -> Scene:
    """`scene` with starts of the agents `drawn`; with new faults it must not be used.

    Spots keep clear of the walls, of other starts and of each other, those of other times by the distance in
    (x, y, c t).
    """
    if not drawn:
        return scene
    draw = _Draw(scene, drawn, faults)
    return draw.scene()


class _Draw:
    def __init__(self, scene: Scene, drawn: Mapping[int, Place], faults: list[Fault]) -> None:
        self._scene, self._drawn, self._faults = scene, drawn, faults
        self._rng = np.random.default_rng(scene.seeding.rng_seed)
        self._halves = PairSettings(scene).half_distances()
        self._floor: Floor | None = None
        fixed = [a for a in range(len(scene.agents)) if a not in drawn]
        self._spots = np.array([self._point(a, scene.agents[a].start) for a in fixed]).reshape(
            -1, 3
        )
        self._around = self._halves[fixed]
        self._starts = {a: scene.agents[a].start for a in fixed}

    def scene(self) -> Scene:
        """The scene with all starts."""
        known = len(self._faults)
        self._floor = floor_of(self._scene, self._faults)
        if len(self._faults) > known:
            return self._scene
        groups: dict[tuple[Place, float], list[int]] = {}
        for a, place in self._drawn.items():
            agent = self._scene.agents[a]
            room = OFF_WALLS * agent.radius if agent.weights.wall > 0 else 0.0
            groups.setdefault((place, room), []).append(a)
        for (place, room), members in groups.items():
            self._fill(place, room, members)
        agents = tuple(
            replace(agent, start=self._starts.get(a, agent.start))
            for a, agent in enumerate(self._scene.agents)
        )
        return replace(self._scene, agents=agents)

    def _fill(self, place: Place, room: float, members: list[int]) -> None:
        region = region_of(place, self._floor, room)
        path = self._scene.entry_path(members[0])
        radius = amount(self._scene.agents[members[0]].radius)
        if region.is_empty:
            text = f"starts in {place}, which has no point that a disc of {radius} m can stand on"
            self._faults.append((path, text))
            return
        before = self._spots, self._around
        for spacing in (None, *LATTICES):
            self._spots, self._around = before
            left = self._placed(region, spacing, members)
            if not left:
                return
        text = (
            f"{place} has no room for {len(members)} agents of {radius} m to start; "
            f"the last {left} found no free spot"
        )
        self._faults.append((path, text))

    def _placed(self, region: shapely.Geometry, spacing: float | None, members: list[int]) -> int:
        """Place `members` one after another; how many found no spot."""
        apart = ROOMY if spacing is None else 1.0
        widest = 2.0 * float(self._halves[members].max())
        if spacing is None:
            points = scattered(region, DRAWS * len(members), self._rng)
        else:
            points = self._rng.permutation(_lattice(region, spacing * widest))
        k = 0
        for number, a in enumerate(members):
            while k < len(points) and not self._is_free(a, points[k], apart):
                k += 1
            if k == len(points):
                return len(members) - number
            spot = (float(points[k, 0]), float(points[k, 1]))
            self._starts[a] = spot
            self._spots = np.vstack([self._spots, self._point(a, spot)])
            self._around = np.append(self._around, self._halves[a])
            # Streams come back to the same spots at later times.
            k = 0 if spacing is not None else k + 1
        return 0

    def _is_free(self, agent: int, point: FloatArray, apart: float) -> bool:
        if not len(self._spots):
            return True
        step = self._spots - self._point(agent, (float(point[0]), float(point[1])))
        needed = apart * (self._around + self._halves[agent])
        return bool(((step**2).sum(axis=1) > needed**2).all())

    def _point(self, agent: int, start: tuple[float, float]) -> FloatArray:
        """A start in (x, y, c t), m."""
        time = self._scene.agents[agent].start_time
        return np.array([start[0], start[1], self._scene.time_scale * time])


def scattered(region: shapely.Geometry, count: int, rng: np.random.Generator) -> FloatArray:
    """About `count` points (n, 2) of `region`, evenly drawn."""
    import shapely

    if shapely.area(region) == 0.0:
        parts = [part for part in shapely.get_parts(region) if shapely.length(part) > 0]
        if not parts:
            return np.asarray(shapely.get_coordinates(region), dtype=np.float64)
        lengths = np.array([shapely.length(part) for part in parts])
        chosen = rng.choice(len(parts), size=count, p=lengths / lengths.sum())
        at = rng.random(count) * lengths[chosen]
        return np.asarray(
            shapely.get_coordinates(shapely.line_interpolate_point(np.array(parts)[chosen], at))
        )
    low_x, low_y, high_x, high_y = shapely.bounds(region)
    share = shapely.area(region) / ((high_x - low_x) * (high_y - low_y))
    points = rng.random((int(count / share) + 1, 2))
    points = np.array([low_x, low_y]) + points * [high_x - low_x, high_y - low_y]
    shapely.prepare(region)
    kept: FloatArray = points[shapely.contains_xy(region, points[:, 0], points[:, 1])]
    return kept


def _lattice(region: shapely.Geometry, spacing: float) -> FloatArray:
    """Points (n, 2) of a hexagonal lattice in an area; evenly spaced ones along lines."""
    import shapely

    if shapely.area(region) == 0.0:
        found = [
            shapely.get_coordinates(
                shapely.line_interpolate_point(part, np.arange(0.0, shapely.length(part), spacing))
            )
            for part in shapely.get_parts(region)
        ]
        return np.vstack([np.empty((0, 2)), *found])
    low_x, low_y, high_x, high_y = shapely.bounds(region)
    rise = spacing * np.sqrt(0.75)
    rows, columns = (
        np.arange(int((high_y - low_y) / rise) + 1),
        np.arange(int((high_x - low_x) / spacing) + 2),
    )
    x = low_x + (columns[None, :] + 0.5 * (rows[:, None] % 2)) * spacing
    y = np.broadcast_to(low_y + rows[:, None] * rise, x.shape)
    points = np.column_stack([x.ravel(), y.ravel()])
    kept: FloatArray = points[shapely.intersects_xy(region, points[:, 0], points[:, 1])]
    return kept
