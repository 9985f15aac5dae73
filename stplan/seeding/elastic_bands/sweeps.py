"""Compiled sweeps over elastic bands in space-time: tension, contacts, walls, one solve an agent.

An agent's band is a chain of knots in z = (x, y, c t). A sweep takes the agents in turn (Gauss-
Seidel) and minimises, with everybody else held still,

    1/2 w sum |z_{i+1} - z_i|^2 + 1/2 sum kappa (target - d)^2 + 1/2 |z - z_before|^2

over the contacts closer than their target, linearised at the closest points. The Hessian is
block tridiagonal with 3x3 blocks (see `block_tridiagonal`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.axes import TIME
from stplan.compiled import inlined, kernel
from stplan.geometry.allocation import new_numbers
from stplan.geometry.crossings import segments_cross
from stplan.geometry.segments import Point, closest_of_segments, plane_point, space_time_point
from stplan.seeding.elastic_bands.band_neighbours import Neighbours
from stplan.seeding.elastic_bands.bands import Bands
from stplan.seeding.elastic_bands.block_tridiagonal import (
    Chain,
    clear,
    hold_knots,
    make_chain,
    solve,
)

# Stiffness of a contact spring, with the proximal weight as 1; walls are stiffer, because they do
# not give way.
CONTACT_STIFFNESS = 50.0
WALL_STIFFNESS = 1000.0
# Longest step of a knot in radii of its agent: more would jump over others.
LONGEST_STEP = 0.5
# A step may shrink a duration to this part of the mean one; further only if it was already so.
LEAST_DURATION = 0.2
TOUCHING = 1e-9
# What an agent answers for of a spring at least, however heavy.
LEAST_SHARE = 0.1


class Contacts(NamedTuple):
    """Springs between bands.

    Attributes:
        rows, members: segments near every segment (see `Neighbours`).
        target: (A, A) distance that springs aim at, m.
        masses: (A,) the heavier answer for less of a spring; where the other segment does not move
            everybody answers for all of it.
        reference: (P, 3) positions where the neighbours were listed, m.
    """

    rows: IntArray
    members: IntArray
    target: FloatArray
    masses: FloatArray
    reference: FloatArray


class WallContacts(NamedTuple):
    """Springs between bands and walls.

    Attributes:
        rows, members: boundary edges near every segment (see `Neighbours`).
        edges: (E, 4) as x0, y0, x1, y1, m.
        target: (A,) distance aimed at, m; 0 where an agent ignores walls.
        guarded: (A,) refuse steps through walls.
    """

    rows: IntArray
    members: IntArray
    edges: FloatArray
    target: FloatArray
    guarded: BoolArray


@kernel
def sweep_bands(
    order: IntArray,
    bands: Bands,
    contacts: Contacts,
    walls: WallContacts | None,
    tension: FloatArray,
    grown: float,
    skip_idle: bool,
) -> float:
    """One sweep over the agents of `order`, in place; returns the largest move since listing, m.

    Args:
        walls: None in the open plane.
        tension: (A,) w of every band.
        grown: part of the targets between bands that is aimed at.
        skip_idle: leave agents alone that touch nobody.
    """
    most = 0
    for a in order:
        most = max(most, bands.num_knots[a])
    chain = make_chain(most)
    moved = 0.0
    for a in order:
        begin = bands.first_knot[a]
        count = bands.num_knots[a]
        own = bands.positions[begin : begin + count]
        clear(chain, count)
        touching = _press_contacts(own, a, bands, contacts, grown, chain)
        touching += _press_walls(own, a, bands, walls, chain)
        if skip_idle and touching == 0:
            continue
        _pull_band(own, tension[a], bands.rest_rises[a], chain)
        hold_knots(bands.hold[begin : begin + count], chain)
        solve(chain, count)
        _step(own, chain, a, bands, walls)
        for i in range(count):
            gap = 0.0
            for x in range(own.shape[1]):
                gap += (own[i, x] - contacts.reference[begin + i, x]) ** 2
            moved = max(moved, gap)
    return np.sqrt(moved)


@inlined
def _pull_band(own: FloatArray, tension: float, rest_rise: float, chain: Chain) -> None:
    """Add tension and the proximal term (weight 1) of one band."""
    diagonal, upper, force = chain.diagonal, chain.upper, chain.force
    last = own.shape[1] - 1
    for i in range(len(own)):
        for x in range(last + 1):
            diagonal[i, x, x] += 1.0
    for i in range(len(own) - 1):
        for x in range(last + 1):
            pull = tension * (own[i + 1, x] - own[i, x] - (rest_rise if x == last else 0.0))
            force[i, x] += pull
            force[i + 1, x] -= pull
            diagonal[i, x, x] += tension
            diagonal[i + 1, x, x] += tension
            upper[i, x, x] -= tension


@inlined
def _press_contacts(
    own: FloatArray, agent: int, bands: Bands, contacts: Contacts, grown: float, chain: Chain
) -> int:
    """Add the springs of every contact closer than its target; returns how many there are."""
    diagonal, upper, force = chain.diagonal, chain.upper, chain.force
    rows, members = contacts.rows, contacts.members
    head = bands.first_segment[agent]
    touching = 0
    normal = new_numbers(3)
    for i in range(len(own) - 1):
        for k in range(rows[head + i], rows[head + i + 1]):
            j = members[k]
            other = bands.agents[j]
            target = grown * contacts.target[agent, other]
            s, t, squared = closest_of_segments(bands.positions, bands.segments, head + i, j)
            if squared >= target * target:
                continue
            touching += 1
            gap = np.sqrt(squared)
            u = bands.segments[j, 0]
            v = bands.segments[j, 1]
            if gap > TOUCHING:
                for x in range(3):
                    near = own[i, x] + s * (own[i + 1, x] - own[i, x])
                    far = t * (bands.positions[v, x] - bands.positions[u, x])
                    normal[x] = (near - bands.positions[u, x] - far) / gap
            else:
                p, q = space_time_point(own, i), space_time_point(own, i + 1)
                far_p, far_q = (
                    space_time_point(bands.positions, u),
                    space_time_point(bands.positions, v),
                )
                _normal_of_crossing(p, q, far_p, far_q, head < j, normal)
            push = CONTACT_STIFFNESS * (target - gap)
            if j < bands.num_moving:
                own_mass, others_mass = contacts.masses[agent], contacts.masses[other]
                push *= min(max(2.0 * others_mass / (own_mass + others_mass), LEAST_SHARE), 1.0)
            for x in range(3):
                force[i, x] += push * (1.0 - s) * normal[x]
                force[i + 1, x] += push * s * normal[x]
                for y in range(3):
                    stiff = CONTACT_STIFFNESS * normal[x] * normal[y]
                    diagonal[i, x, y] += stiff * (1.0 - s) * (1.0 - s)
                    diagonal[i + 1, x, y] += stiff * s * s
                    upper[i, x, y] += stiff * s * (1.0 - s)
    return touching


@inlined
def _normal_of_crossing(
    p: Point, q: Point, u: Point, v: Point, first: bool, normal: FloatArray
) -> None:
    """A direction that parts two segments that meet, opposite for the two of them."""
    for x in range(3):
        y = (x + 1) % 3
        z = (x + 2) % 3
        normal[x] = (q[y] - p[y]) * (v[z] - u[z]) - (q[z] - p[z]) * (v[y] - u[y])
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if length <= TOUCHING:
        # Parallel: sideways of the one that comes first, which both sides agree upon.
        sign = 1.0 if first else -1.0
        normal[0] = sign * (p[1] - q[1] if first else u[1] - v[1])
        normal[1] = sign * (q[0] - p[0] if first else v[0] - u[0])
        normal[2] = 0.0
        length = np.sqrt(normal[0] ** 2 + normal[1] ** 2)
        if length <= TOUCHING:
            normal[0] = sign
            normal[1] = 0.0
            length = 1.0
    for x in range(3):
        normal[x] /= length


@inlined
def _press_walls(
    own: FloatArray, agent: int, bands: Bands, walls: WallContacts | None, chain: Chain
) -> int:
    """Add springs of knots near edges and of edge ends near segments; returns how many."""
    if walls is None:
        return 0
    target = walls.target[agent]
    if target == 0.0:
        return 0
    rows, members = walls.rows, walls.members
    edges = walls.edges
    head = bands.first_segment[agent]
    touching = 0
    for i in range(len(own) - 1):
        ax, ay = own[i, 0], own[i, 1]
        ux, uy = own[i + 1, 0] - ax, own[i + 1, 1] - ay
        length = ux * ux + uy * uy
        for k in range(rows[head + i], rows[head + i + 1]):
            e = members[k]
            px, py = edges[e, 0], edges[e, 1]
            vx, vy = edges[e, 2] - px, edges[e, 3] - py
            # A knot against the edge: every knot but the first ends a segment. The edge's own
            # first point against the segment: boundaries are closed, so each vertex is one once.
            for kind in range(2):
                if kind == 0:
                    s = 1.0
                    x, y = ax + ux, ay + uy
                    t = ((x - px) * vx + (y - py) * vy) / max(vx * vx + vy * vy, 1e-300)
                    t = min(max(t, 0.0), 1.0)
                    x -= px + t * vx
                    y -= py + t * vy
                else:
                    if length < TOUCHING * TOUCHING:
                        continue
                    s = ((px - ax) * ux + (py - ay) * uy) / length
                    if s <= 0.0 or s >= 1.0:
                        continue
                    x = ax + s * ux - px
                    y = ay + s * uy - py
                gap = np.sqrt(x * x + y * y)
                if gap >= target or gap < TOUCHING:
                    continue
                touching += 1
                _add_wall_spring(chain, i, s, x / gap, y / gap, target - gap)
    return touching


@inlined
def _add_wall_spring(chain: Chain, i: int, s: float, x: float, y: float, depth: float) -> None:
    """Add a spring with plane normal (x, y) at `s` of segment i, `depth` (m) within its target."""
    for end in range(2):
        weight = 1.0 - s if end == 0 else s
        push = WALL_STIFFNESS * depth * weight
        chain.force[i + end, 0] += push * x
        chain.force[i + end, 1] += push * y
        _add_outer(chain.diagonal, i + end, WALL_STIFFNESS * weight * weight, x, y)
    _add_outer(chain.upper, i, WALL_STIFFNESS * s * (1.0 - s), x, y)


@inlined
def _add_outer(blocks: FloatArray, i: int, stiff: float, x: float, y: float) -> None:
    """Add `stiff` times the outer product of (x, y) to the plane part of block i."""
    blocks[i, 0, 0] += stiff * x * x
    blocks[i, 0, 1] += stiff * x * y
    blocks[i, 1, 0] += stiff * x * y
    blocks[i, 1, 1] += stiff * y * y


@inlined
def _step(
    own: FloatArray, chain: Chain, agent: int, bands: Bands, walls: WallContacts | None
) -> None:
    """Move a band by the chain's solution, shortened; time on its own where it would run back."""
    step = chain.force
    count = len(own)
    before = np.empty_like(own)
    furthest = 0.0
    for i in range(count):
        for x in range(own.shape[1]):
            before[i, x] = own[i, x]
        furthest = max(furthest, step[i, 0] ** 2 + step[i, 1] ** 2 + step[i, 2] ** 2)
    part = min(1.0, LONGEST_STEP * bands.radii[agent] / np.sqrt(max(furthest, 1e-300)))
    latest = bands.ceilings[agent] - before[count - 1, TIME]
    step[count - 1, TIME] = min(step[count - 1, TIME] * part, latest) / part
    least = LEAST_DURATION * (before[count - 1, TIME] - before[0, TIME]) / (count - 1)
    time_part = part
    for attempt in range(3):
        rising = True
        for i in range(count - 1):
            old = before[i + 1, TIME] - before[i, TIME]
            new = old + time_part * (step[i + 1, TIME] - step[i, TIME])
            if new < min(least, old):
                rising = False
                break
        if rising:
            break
        time_part = 0.25 * part if attempt == 0 else 0.0
    for i in range(count):
        own[i, TIME] = before[i, TIME] + time_part * step[i, TIME]
    for _ in range(6):
        for i in range(count):
            for x in range(own.shape[1] - 1):
                own[i, x] = before[i, x] + part * step[i, x]
        if not _is_barred(own, agent, bands, walls):
            return
        part *= 0.5
    for i in range(count):
        for x in range(own.shape[1]):
            own[i, x] = before[i, x]


@inlined
def _is_barred(own: FloatArray, agent: int, bands: Bands, walls: WallContacts | None) -> bool:
    """Whether a band lies across a wall that its agent must not step through."""
    if walls is None:
        return False
    if not walls.guarded[agent]:
        return False
    return _crosses(own, bands.first_segment[agent], walls.rows, walls.members, walls.edges)


@kernel
def band_crosses(knots: FloatArray, near: Neighbours, edges: FloatArray) -> bool:
    """Whether a band of `knots` (n, 3) touches or crosses an edge listed for its segments."""
    return _crosses(knots, 0, near.rows, near.members, edges)


@inlined
def _crosses(
    own: FloatArray, head: int, rows: IntArray, members: IntArray, edges: FloatArray
) -> bool:
    """Whether a band touches or crosses an edge listed for its segments, which begin at `head`."""
    for i in range(len(own) - 1):
        for k in range(rows[head + i], rows[head + i + 1]):
            e = members[k]
            if segments_cross(
                plane_point(own, i), plane_point(own, i + 1),
                (edges[e, 0], edges[e, 1]), (edges[e, 2], edges[e, 3]),
            ):  # fmt: skip
                return True
    return False
