"""Contacts: pairs of segments (or points) close enough to feel each other, and what is summed over them.

A contact joins four points p0 p1 | q0 q1, given as indices into an array of positions; a point against
a segment repeats its index. The first `num_knots` positions move, later ones are fixed (ends of tails,
corners of walls). With closest parameters (s, t) from `segments`, the distance D has the gradient
w_i n, where n is the unit vector from q to p and w = (1-s, s, -(1-t), -t). As (s, t) minimise, the
envelope theorem gives the second derivative of D^2 / 2,

    w_i w_j I - F_i^T A^-1 F_j,   A = [[|u|^2, -u.v], [-u.v, |v|^2]] over the parameters not clamped,
    F_i = (a_i r + w_i u, b_i r - w_i v),   a = (-1, 1, 0, 0),   b = (0, 0, 1, -1),   r = D n,

and that of D follows by the chain rule.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stplan.arrays import FloatArray, IntArray
from stplan.compiled import kernel
from stplan.geometry.allocation import new_number_rows, new_numbers
from stplan.geometry.segments import PARALLEL, POINT, closest_parameters, space_time_point

# The ten pairs (i, j), j <= i, of a contact's four points, in the order of `block_positions`.
POINT_PAIRS = tuple((i, j) for i in range(4) for j in range(i + 1))


class Measured(NamedTuple):
    """Geometry of C contacts at one iterate.

    Attributes:
        distance: (C,) m.
        parameters: (C, 2) closest parameters s and t.
        normal: (C, 3) unit vector from the second to the first segment.
        free: (C,) bit 1 where s, bit 2 where t is not clamped to an end.
    """

    distance: FloatArray
    parameters: FloatArray
    normal: FloatArray
    free: IntArray

    def at(self, contacts: slice) -> Measured:
        """The geometry of some contacts only."""
        return Measured(
            self.distance[contacts],
            self.parameters[contacts],
            self.normal[contacts],
            self.free[contacts],
        )


def measure(positions: FloatArray, points: IntArray) -> Measured:
    """Distances of contacts `points` (C, 4) among `positions` (P, 3) in m."""
    count = len(points)
    result = Measured(
        np.empty(count), np.empty((count, 2)), np.empty((count, 3)), np.empty(count, dtype=np.int64)
    )
    _measure(positions, points, result)
    return result


@kernel
def _measure(positions: FloatArray, points: IntArray, result: Measured) -> None:
    distance, parameters, normal, free = result
    for k in range(len(points)):
        p0 = space_time_point(positions, points[k, 0])
        p1 = space_time_point(positions, points[k, 1])
        q0 = space_time_point(positions, points[k, 2])
        q1 = space_time_point(positions, points[k, 3])
        s, t, squared = closest_parameters(p0, p1, q0, q1)
        root = np.sqrt(squared)
        distance[k] = root
        parameters[k, 0] = s
        parameters[k, 1] = t
        a = 0.0
        e = 0.0
        b = 0.0
        for x in range(len(p0)):
            u = p1[x] - p0[x]
            v = q1[x] - q0[x]
            a += u * u
            e += v * v
            b += u * v
            gap = (p0[x] + s * u) - (q0[x] + t * v)
            normal[k, x] = gap / root if root > 0.0 else 0.0
        bits = 0
        if 0.0 < t < 1.0 and e > POINT:
            bits = 2
        if 0.0 < s < 1.0 and a > POINT and (bits == 0 or a * e - b * b > PARALLEL * a * e):
            # Parallel segments keep one free parameter: along the other the distance is flat.
            bits += 1
        free[k] = bits


@kernel
def add_gradient(
    points: IntArray,
    measured: Measured,
    slope: FloatArray,
    axis_scale: FloatArray,
    gradient: FloatArray,
) -> None:
    """Add sum_k slope_k grad D_k to `gradient` (M, 3), whose axes are scaled by `axis_scale` (3,)."""
    parameters, normal = measured.parameters, measured.normal
    num_knots = len(gradient)
    for k in range(len(points)):
        if slope[k] == 0.0:
            continue
        s = parameters[k, 0]
        t = parameters[k, 1]
        for i in range(4):
            point = points[k, i]
            if point >= num_knots:
                continue
            weight = 1.0 - s if i == 0 else (s if i == 1 else (t - 1.0 if i == 2 else -t))
            if weight == 0.0:
                continue
            for x in range(3):
                gradient[point, x] += slope[k] * weight * normal[k, x] * axis_scale[x]


@kernel
def add_hessian(
    positions: FloatArray,
    points: IntArray,
    measured: Measured,
    slope: FloatArray,
    curvature: FloatArray,
    axis_scale: FloatArray,
    exact: bool,
    block_positions: IntArray,
    dimension: int,
    values: FloatArray,
) -> None:
    """Add sum_k curvature_k grad D_k grad D_k^T, plus slope_k hess D_k where `exact`, to `values`.

    `block_positions` (C, 10) says where the lower block of each of `POINT_PAIRS` starts in `values`
    (row by row, `dimension` axes; a diagonal block holds its lower triangle only), -1 where the
    structure has no room for it. Pairs of a repeated point have weight 0 and need no place.
    """
    distance, parameters, normal, free = measured
    weight = new_numbers(4)
    force = new_number_rows(4, 3)
    lever = new_number_rows(4, 3)
    for k in range(len(points)):
        if slope[k] == 0.0 and curvature[k] == 0.0:
            continue
        s = parameters[k, 0]
        t = parameters[k, 1]
        weight[0] = 1.0 - s
        weight[1] = s
        weight[2] = t - 1.0
        weight[3] = -t
        i00 = 0.0
        i01 = 0.0
        i11 = 0.0
        bits = free[k]
        if exact and bits > 0:
            a = 0.0
            e = 0.0
            b = 0.0
            for x in range(3):
                u = positions[points[k, 1], x] - positions[points[k, 0], x]
                v = positions[points[k, 3], x] - positions[points[k, 2], x]
                a += u * u
                e += v * v
                b += u * v
                r = normal[k, x] * distance[k]
                for i in range(4):
                    along_u = -1.0 if i == 0 else (1.0 if i == 1 else 0.0)
                    along_v = 1.0 if i == 2 else (-1.0 if i == 3 else 0.0)
                    force[i, x] = along_u * r + weight[i] * u
                    lever[i, x] = along_v * r - weight[i] * v
            if bits == 1:
                i00 = 1.0 / a
            elif bits == 2:
                i11 = 1.0 / e
            else:
                determinant = a * e - b * b
                i00 = e / determinant
                i11 = a / determinant
                i01 = b / determinant
        bend = slope[k] / distance[k]
        pair = -1
        for i in range(4):
            for j in range(i + 1):
                pair += 1
                at = block_positions[k, pair]
                if at < 0:
                    continue
                row = i
                column = j
                if points[k, j] > points[k, i]:
                    row = j
                    column = i
                ww = weight[i] * weight[j]
                for x in range(dimension):
                    for y in range(dimension):
                        if i == j and y > x:
                            break
                        value = curvature[k] * ww * normal[k, x] * normal[k, y]
                        if exact:
                            same = 1.0 if x == y else 0.0
                            hessian = ww * (same - normal[k, x] * normal[k, y])
                            if bits > 0:
                                hessian -= force[row, x] * (
                                    i00 * force[column, y] + i01 * lever[column, y]
                                ) + lever[row, x] * (
                                    i01 * force[column, y] + i11 * lever[column, y]
                                )
                            value += bend * hessian
                        values[at] += value * axis_scale[x] * axis_scale[y]
                        at += 1
