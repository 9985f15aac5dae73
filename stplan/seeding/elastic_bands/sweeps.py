"""Compiled sweeps over elastic space-time strings: tension, contacts, walls, one solve an agent.

An agent's string is a chain of knots in z = (x, y, c t). A sweep takes the agents in turn (Gauss-
Seidel) and minimises, with everybody else held still,

    1/2 w sum |z_{i+1} - z_i|^2 + 1/2 sum kappa (target - d)^2 + 1/2 |z - z_before|^2

over the contacts closer than their target, linearised at the closest points. The Hessian is
block tridiagonal with 3x3 blocks: `diagonal` (K, 3, 3) and `upper` (K, 3, 3), where upper[i]
couples knots i and i + 1.
"""

from __future__ import annotations

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.segments import closest_parameters
from stplan.seeding.elastic_bands.block_tridiagonal import hold_knots, solve

# Stiffness of a contact spring, with the proximal weight as 1; walls are stiffer, because they do
# not give way.
CONTACT_STIFFNESS = 50.0
WALL_STIFFNESS = 1000.0
# Longest step of a knot in radii of its agent: more would jump over others.
LONGEST_STEP = 0.5
# A step may shrink a duration to this part of the mean one; further only if it was already so.
LEAST_DURATION = 0.2
TOUCHING = 1e-9


@kernel
def sweep_strings(
    order: IntArray,
    first_knot: IntArray,
    num_knots: IntArray,
    positions: FloatArray,
    reference: FloatArray,
    hold: IntArray,
    ceilings: FloatArray,
    rest_rises: FloatArray,
    tension: FloatArray,
    radii: FloatArray,
    skip_idle: bool,
    segments: IntArray,
    agents: IntArray,
    first_segment: IntArray,
    num_moving: int,
    rows: IntArray,
    members: IntArray,
    target: FloatArray,
    share: FloatArray,
    wall_rows: IntArray,
    wall_members: IntArray,
    edges: FloatArray,
    wall_target: FloatArray,
    guarded: BoolArray,
) -> float:
    """One sweep over the agents of `order`, in place; returns the largest move since `reference`.

    Args:
        first_knot, num_knots: (A,) where an agent's knots are in `positions`.
        positions: (P, 3) in (x, y, c t), m.
        reference: (P, 3) where the neighbour rows were made.
        hold: (P,) FREE, PINNED or FIXED.
        ceilings: (A,) latest c t of a string's end, m.
        rest_rises: (A,) rise in c t that tension leaves a segment where the end may slide, m.
        tension: (A,) w of every agent.
        skip_idle: leave agents alone that touch nobody.
        segments, agents: (S, 2) indices of knots and (S,) owners; the first `num_moving` move, and
            an agent's own start at `first_segment` (A,).
        rows, members: segments near every segment.
        target: (A, A) distance that contact springs aim at, m.
        share: (A, A) how much of a spring the first agent answers for; all of it where the other
            segment does not move.
        wall_rows, wall_members, edges: boundary edges near every segment; (E, 4).
        wall_target: (A,) distance to walls aimed at, m.
        guarded: (A,) refuse steps through walls.
    """
    moved = 0.0
    for a in order:
        begin = first_knot[a]
        count = num_knots[a]
        own = positions[begin : begin + count]
        diagonal = np.zeros((count, 3, 3))
        upper = np.zeros((count, 3, 3))
        force = np.zeros((count, 3))
        head = first_segment[a]
        touching = _press_contacts(
            own, head, positions, segments, agents, num_moving, rows, members, target[a], share[a],
            diagonal, upper, force,
        )  # fmt: skip
        if wall_target[a] > 0.0:
            touching += _press_walls(
                own, head, wall_rows, wall_members, edges, wall_target[a], diagonal, upper, force
            )
        if skip_idle and touching == 0:
            continue
        _pull_string(own, tension[a], rest_rises[a], diagonal, upper, force)
        hold_knots(hold[begin : begin + count], diagonal, upper, force)
        solve(diagonal, upper, force)
        _step(
            own, force, LONGEST_STEP * radii[a], ceilings[a], head, guarded[a],
            wall_rows, wall_members, edges,
        )  # fmt: skip
        for i in range(count):
            gap = 0.0
            for x in range(3):
                gap += (own[i, x] - reference[begin + i, x]) ** 2
            moved = max(moved, gap)
    return float(np.sqrt(moved))


@kernel
def _pull_string(
    own: FloatArray,
    tension: float,
    rest_rise: float,
    diagonal: FloatArray,
    upper: FloatArray,
    force: FloatArray,
) -> None:
    """Add tension and the proximal term (weight 1) of one string."""
    for i in range(len(own)):
        for x in range(3):
            diagonal[i, x, x] += 1.0
    for i in range(len(own) - 1):
        for x in range(3):
            pull = tension * (own[i + 1, x] - own[i, x] - (rest_rise if x == 2 else 0.0))
            force[i, x] += pull
            force[i + 1, x] -= pull
            diagonal[i, x, x] += tension
            diagonal[i + 1, x, x] += tension
            upper[i, x, x] -= tension


@kernel
def _press_contacts(
    own: FloatArray,
    head: int,
    positions: FloatArray,
    segments: IntArray,
    agents: IntArray,
    num_moving: int,
    rows: IntArray,
    members: IntArray,
    target: FloatArray,
    share: FloatArray,
    diagonal: FloatArray,
    upper: FloatArray,
    force: FloatArray,
) -> int:
    """Add the springs of every contact closer than its target; returns how many there are."""
    touching = 0
    normal = np.empty(3)
    for i in range(len(own) - 1):
        for k in range(rows[head + i], rows[head + i + 1]):
            j = members[k]
            other = agents[j]
            u = positions[segments[j, 0]]
            v = positions[segments[j, 1]]
            s, t, squared = closest_parameters(
                own[i, 0], own[i, 1], own[i, 2], own[i + 1, 0], own[i + 1, 1], own[i + 1, 2],
                u[0], u[1], u[2], v[0], v[1], v[2],
            )  # fmt: skip
            if squared >= target[other] * target[other]:
                continue
            touching += 1
            gap = np.sqrt(squared)
            if gap > TOUCHING:
                for x in range(3):
                    near = own[i, x] + s * (own[i + 1, x] - own[i, x])
                    normal[x] = (near - u[x] - t * (v[x] - u[x])) / gap
            else:
                _normal_of_crossing(own[i], own[i + 1], u, v, head < j, normal)
            push = CONTACT_STIFFNESS * (target[other] - gap)
            if j < num_moving:
                push *= share[other]
            for x in range(3):
                force[i, x] += push * (1.0 - s) * normal[x]
                force[i + 1, x] += push * s * normal[x]
                for y in range(3):
                    stiff = CONTACT_STIFFNESS * normal[x] * normal[y]
                    diagonal[i, x, y] += stiff * (1.0 - s) * (1.0 - s)
                    diagonal[i + 1, x, y] += stiff * s * s
                    upper[i, x, y] += stiff * s * (1.0 - s)
    return touching


@kernel
def _normal_of_crossing(
    p: FloatArray, q: FloatArray, u: FloatArray, v: FloatArray, first: bool, normal: FloatArray
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
            normal[0], normal[1], length = sign, 0.0, 1.0
    for x in range(3):
        normal[x] /= length


@kernel
def _press_walls(
    own: FloatArray,
    head: int,
    wall_rows: IntArray,
    wall_members: IntArray,
    edges: FloatArray,
    target: float,
    diagonal: FloatArray,
    upper: FloatArray,
    force: FloatArray,
) -> int:
    """Add springs of knots near edges and of edge ends near segments; returns how many."""
    touching = 0
    for i in range(len(own) - 1):
        ax, ay = own[i, 0], own[i, 1]
        ux, uy = own[i + 1, 0] - ax, own[i + 1, 1] - ay
        length = ux * ux + uy * uy
        for k in range(wall_rows[head + i], wall_rows[head + i + 1]):
            e = wall_members[k]
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
                x /= gap
                y /= gap
                push = WALL_STIFFNESS * (target - gap)
                _add_plane_spring(diagonal[i], force[i], x, y, 1.0 - s, push)
                _add_plane_spring(diagonal[i + 1], force[i + 1], x, y, s, push)
                stiff = WALL_STIFFNESS * s * (1.0 - s)
                upper[i, 0, 0] += stiff * x * x
                upper[i, 0, 1] += stiff * x * y
                upper[i, 1, 0] += stiff * x * y
                upper[i, 1, 1] += stiff * y * y
    return touching


@kernel
def _add_plane_spring(
    block: FloatArray, force: FloatArray, x: float, y: float, weight: float, push: float
) -> None:
    """Add one end of a wall spring with plane normal (x, y)."""
    force[0] += push * weight * x
    force[1] += push * weight * y
    stiff = WALL_STIFFNESS * weight * weight
    block[0, 0] += stiff * x * x
    block[0, 1] += stiff * x * y
    block[1, 0] += stiff * x * y
    block[1, 1] += stiff * y * y


@kernel
def _step(
    own: FloatArray,
    step: FloatArray,
    longest: float,
    ceiling: float,
    head: int,
    guarded: bool,
    wall_rows: IntArray,
    wall_members: IntArray,
    edges: FloatArray,
) -> None:
    """Move a string by `step`, shortened; time on its own where it would run back."""
    count = len(own)
    before = own.copy()
    furthest = 0.0
    for i in range(count):
        furthest = max(furthest, step[i, 0] ** 2 + step[i, 1] ** 2 + step[i, 2] ** 2)
    part = min(1.0, longest / np.sqrt(max(furthest, 1e-300)))
    step[count - 1, 2] = min(step[count - 1, 2] * part, ceiling - before[count - 1, 2]) / part
    least = LEAST_DURATION * (before[count - 1, 2] - before[0, 2]) / (count - 1)
    time_part = part
    for attempt in range(3):
        rising = True
        for i in range(count - 1):
            old = before[i + 1, 2] - before[i, 2]
            new = old + time_part * (step[i + 1, 2] - step[i, 2])
            if new < min(least, old):
                rising = False
                break
        if rising:
            break
        time_part = 0.25 * part if attempt == 0 else 0.0
    for i in range(count):
        own[i, 2] = before[i, 2] + time_part * step[i, 2]
    for _ in range(6):
        for i in range(count):
            own[i, 0] = before[i, 0] + part * step[i, 0]
            own[i, 1] = before[i, 1] + part * step[i, 1]
        if not guarded or not string_crosses(own, head, wall_rows, wall_members, edges):
            return
        part *= 0.5
    own[:] = before


@kernel
def string_crosses(
    own: FloatArray, head: int, wall_rows: IntArray, wall_members: IntArray, edges: FloatArray
) -> bool:
    """Whether a string touches or crosses one of the edges listed for its segments."""
    for i in range(len(own) - 1):
        ax, ay, bx, by = own[i, 0], own[i, 1], own[i + 1, 0], own[i + 1, 1]
        for k in range(wall_rows[head + i], wall_rows[head + i + 1]):
            e = wall_members[k]
            px, py, qx, qy = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
            if max(ax, bx) < min(px, qx) or min(ax, bx) > max(px, qx):
                continue
            if max(ay, by) < min(py, qy) or min(ay, by) > max(py, qy):
                continue
            side_p = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
            side_q = (bx - ax) * (qy - ay) - (by - ay) * (qx - ax)
            side_a = (qx - px) * (ay - py) - (qy - py) * (ax - px)
            side_b = (qx - px) * (by - py) - (qy - py) * (bx - px)
            if side_p * side_q <= 0.0 and side_a * side_b <= 0.0:
                return True
    return False
