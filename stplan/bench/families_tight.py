"""Families of tight scenes with random parameters: each can be solved, none by going straight.

Each function draws one scene from a seeded generator. Agents stay on their goals unless `stay` is
False. `FAMILIES` names them.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from stplan.arrays import Point
from stplan.maps.obstacles import PolygonObstacle
from stplan.maps.polygon import PolygonBase
from stplan.maps.spec import MapSpec
from stplan.scene.model import (
    Agent,
    Scene,
    SeedingSettings,
    SolverSettings,
    Weights,
)

RADIUS = 0.3


def rectangle(left: float, bottom: float, right: float, top: float) -> tuple[Point, ...]:
    """Four corners, anticlockwise."""
    return ((left, bottom), (right, bottom), (right, top), (left, top))


def make_scene(
    name: str,
    outer: tuple[Point, ...] | None,
    obstacles: list[tuple[Point, ...]],
    journeys: list[tuple[Point, Point]],
    *,
    radii: list[float] | float = RADIUS,
    horizon: float = 60.0,
    time_scale: float = 1.0,
    stay: bool = True,
    rng_seed: int = 0,
) -> Scene:
    """A scene of plain agents with the given (start, goal) pairs."""
    sizes = [radii] * len(journeys) if isinstance(radii, float) else radii
    agents = tuple(
        Agent(
            id=f"a{index}",
            start=(float(start[0]), float(start[1])),
            goal=(float(goal[0]), float(goal[1])),
            start_time=0.0,
            max_time=horizon,
            preferred_time=None,
            radius=size,
            mass=1.0,
            after_arrival="stay" if stay else "vanish",
            waypoints=(),
            weights=Weights(),
        )
        for index, ((start, goal), size) in enumerate(zip(journeys, sizes, strict=True))
    )
    return Scene(
        name=name,
        description="",
        source=None,
        content_hash="",
        map=None
        if outer is None
        else MapSpec(PolygonBase(outer), tuple(PolygonObstacle(ring) for ring in obstacles)),
        horizon=horizon,
        time_scale=time_scale,
        agents=agents,
        pairs=(),
        seeding=SeedingSettings(rng_seed=rng_seed),
        solver=SolverSettings(),
    )


def corridor_with_pocket(rng: np.random.Generator, *, half_width: float = 0.0) -> Scene:
    """Two agents swap ends of a corridor; one has to dodge into a pocket.

    `half_width` in radii, 1.05 to 3; 0 draws it.
    """
    half = RADIUS * (half_width or float(np.exp(rng.uniform(np.log(1.05), np.log(3.0)))))
    length = RADIUS * float(rng.uniform(18, 30))
    middle = length * float(rng.uniform(0.35, 0.65))
    width = RADIUS * float(rng.uniform(2.3, 3.0))
    depth = RADIUS * float(rng.uniform(2.4, 3.0))
    outer = (
        (0.0, -half),
        (length, -half),
        (length, half),
        (middle + width / 2, half),
        (middle + width / 2, half + depth),
        (middle - width / 2, half + depth),
        (middle - width / 2, half),
        (0.0, half),
    )
    room = half - 1.03 * RADIUS
    shift = rng.uniform(-room, room, 2)
    end = 1.2 * RADIUS
    left, right = (end, float(shift[0])), (length - end, float(shift[1]))
    return make_scene("corridor", outer, [], [(left, right), (right, left)], horizon=60.0)


def plus_crossing(rng: np.random.Generator, *, turn: int | None = None) -> Scene:
    """Four agents at the ends of a crossing's arms go straight (2), left (3) or right (1)."""
    turn = int(rng.integers(1, 4)) if turn is None else turn
    half = RADIUS * float(rng.uniform(1.15, 1.6))
    arm = RADIUS * float(rng.uniform(10, 16))
    outer = (
        (-half, -arm), (half, -arm), (half, -half), (arm, -half), (arm, half), (half, half),
        (half, arm), (-half, arm), (-half, half), (-arm, half), (-arm, -half), (-half, -half),
    )  # fmt: skip
    end = arm - 1.2 * RADIUS
    ends = [(0.0, -end), (end, 0.0), (0.0, end), (-end, 0.0)]
    journeys = [(ends[index], ends[(index + turn) % 4]) for index in range(4)]
    return make_scene("plus", outer, [], journeys, horizon=80.0)


def scattered(
    rng: np.random.Generator,
    count: int,
    box: tuple[float, float, float, float],
    apart: float,
    taken: list[Point] | None = None,
) -> list[Point]:
    """`count` random points of a box, `apart` from one another and from `taken`."""
    points: list[Point] = []
    others = list(taken or [])
    for _ in range(100000):
        if len(points) == count:
            return points
        point = (float(rng.uniform(box[0], box[2])), float(rng.uniform(box[1], box[3])))
        if all(np.hypot(point[0] - x, point[1] - y) > apart for x, y in points + others):
            points.append(point)
    raise ValueError("the box is too small")


def door(rng: np.random.Generator, *, per_side: int = 0) -> Scene:
    """Two rooms of 3 to 20 agents each change places through a door of 1.1 diameters."""
    per_side = per_side or int(rng.integers(3, 21))
    side = max(RADIUS * 2 * np.sqrt(per_side / 0.22), RADIUS * 8)
    gap = 1.1 * RADIUS
    wall = 0.5 * RADIUS
    outer = rectangle(-side - wall, 0.0, side + wall, side)
    sill = float(rng.uniform(0.3, 0.7)) * side
    obstacles = [
        rectangle(-wall, -1.0, wall, sill - gap),
        rectangle(-wall, sill + gap, wall, side + 1.0),
    ]
    inset = 1.1 * RADIUS
    left = (-side - wall + inset, inset, -wall - 2 * RADIUS, side - inset)
    right = (wall + 2 * RADIUS, inset, side + wall - inset, side - inset)
    apart = 2.2 * RADIUS
    from_left, from_right = (scattered(rng, per_side, box, apart) for box in (left, right))
    to_left, to_right = (scattered(rng, per_side, box, apart) for box in (left, right))
    journeys = [*zip(from_left, to_right, strict=True), *zip(from_right, to_left, strict=True)]
    horizon = 30.0 + 6.0 * per_side
    return make_scene("door", outer, obstacles, journeys, horizon=horizon)


def warehouse(
    rng: np.random.Generator, *, robots: int = 0, columns: int = 5, rows: int = 4
) -> Scene:
    """10 to 30 robots move between random spots of single-lane aisles around blocks of shelves.

    In a hall of more than 17 columns there is time in proportion to them.
    """
    robots = robots or int(rng.integers(10, 31))
    lane = RADIUS * float(rng.uniform(2.3, 2.8))
    width, height = 5.0 * RADIUS, 3.0 * RADIUS
    outer = rectangle(0.0, 0.0, columns * (width + lane) + lane, rows * (height + lane) + lane)
    obstacles = []
    spots: list[Point] = []
    for row in range(rows + 1):
        for column in range(columns + 1):
            x, y = column * (width + lane), row * (height + lane)
            if row < rows and column < columns:
                obstacles.append(rectangle(x + lane, y + lane, x + lane + width, y + lane + height))
            spots.append((x + lane / 2, y + lane / 2))
            if column < columns:
                spots.append((x + lane + width / 2, y + lane / 2))
    starts = [spots[index] for index in rng.permutation(len(spots))[:robots]]
    goals = [spots[index] for index in rng.permutation(len(spots))[:robots]]
    journeys = list(zip(starts, goals, strict=True))
    return make_scene("warehouse", outer, obstacles, journeys, horizon=90 * max(columns / 17, 1.0))


def cabin(rng: np.random.Generator, *, depth: int = 0, passengers: int = 0, rows: int = 6) -> Scene:
    """6 to 10 passengers of an aircraft cabin sit in each other's seats, one or two deep."""
    depth = depth or int(rng.integers(1, 3))
    passengers = passengers or int(rng.integers(6, 11))
    pitch, seat = 3.0 * RADIUS, 2.3 * RADIUS
    aisle = 1.2 * RADIUS
    reach = aisle + depth * seat
    outer = rectangle(-2 * pitch, -reach, (rows + 1) * pitch, reach)
    obstacles = []
    seats: list[Point] = []
    for row in range(rows + 1):
        # Seat backs between rows, on both sides of the aisle.
        x = row * pitch
        back = 0.2 * RADIUS
        obstacles.append(rectangle(x - back, aisle, x + back, reach + 1.0))
        obstacles.append(rectangle(x - back, -reach - 1.0, x + back, -aisle))
        if row < rows:
            for place in range(depth):
                y = aisle + (place + 0.5) * seat
                seats += [(x + pitch / 2, y), (x + pitch / 2, -y)]
    chosen = rng.permutation(len(seats))[:passengers]
    shift = int(rng.integers(1, passengers))
    goals = np.roll(chosen, shift)
    journeys = [(seats[a], seats[b]) for a, b in zip(chosen, goals, strict=True)]
    return make_scene("cabin", outer, obstacles, journeys, horizon=120.0)


def pillars(rng: np.random.Generator, *, agents: int = 0) -> Scene:
    """16 or 24 agents cross a hall of square pillars with single-lane gaps, from all four sides.

    The hall is as wide as it takes for them to stand along its sides, and there is time in proportion.
    """
    agents = agents or int(rng.choice([16, 24]))
    gap = RADIUS * float(rng.uniform(2.2, 2.7))
    block = RADIUS * float(rng.uniform(2.0, 4.0))
    per_side = agents // 4
    row = (per_side - 1) * 2.4 * RADIUS
    count = max(5, math.ceil((row + gap) / (block + gap)))
    margin = 6.0 * RADIUS
    hall = count * block + (count - 1) * gap
    outer = rectangle(-margin, -margin, hall + margin, hall + margin)
    obstacles = [
        rectangle(x, y, x + block, y + block)
        for x in np.arange(count) * (block + gap)
        for y in np.arange(count) * (block + gap)
    ]
    near, far = -margin + 1.5 * RADIUS, hall + margin - 1.5 * RADIUS
    places = np.linspace(0.0, hall, per_side)
    journeys: list[tuple[Point, Point]] = []
    for side in range(4):
        order = rng.permutation(per_side)
        for place, other in zip(places, places[order], strict=True):
            head, tail = [
                ((near, place), (far, other)),
                ((far, place), (near, other)),
                ((place, near), (other, far)),
                ((place, far), (other, near)),
            ][side]
            journeys.append((head, tail))
    # Opposite sides share their places, so goals are moved by more than a diameter inwards.
    inwards = 2.2 * RADIUS
    moved = []
    for (sx, sy), (gx, gy) in journeys:
        goal = tuple(
            value + inwards * (1 if value == near else -1 if value == far else 0)
            for value in (gx, gy)
        )
        moved.append(((sx, sy), (goal[0], goal[1])))
    return make_scene("pillars", outer, obstacles, moved, horizon=12.0 * count)


FAMILIES: dict[str, Callable[[np.random.Generator], Scene]] = {
    "corridor": corridor_with_pocket,
    "corridor 1.05": lambda rng: corridor_with_pocket(rng, half_width=1.05),
    "plus right": lambda rng: plus_crossing(rng, turn=1),
    "plus straight": lambda rng: plus_crossing(rng, turn=2),
    "plus left": lambda rng: plus_crossing(rng, turn=3),
    "door": door,
    "warehouse": warehouse,
    "cabin one deep": lambda rng: cabin(rng, depth=1),
    "cabin two deep": lambda rng: cabin(rng, depth=2),
    "pillars 16": lambda rng: pillars(rng, agents=16),
    "pillars 24": lambda rng: pillars(rng, agents=24),
}
