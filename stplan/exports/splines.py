"""Runs as cubic splines with continuous velocity and acceleration, clear of everything like the run itself.

A spline through an agent's knots swings beyond the straight segments that were certified, so it is certified
anew: its pieces are divided until the chords of their parts stray from it by less than a bound that is known
(h^2 / 8 times the greatest second derivative), and the chords have to clear everything by more than what
those concerned may stray. Splines that do not are led through points on the segments too, twice as many each
time, which halves their swing. Agents whose splines never clear everything, or break a limit or a waypoint,
keep their straight segments; the run with straight segments alone is clear, so this ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from stplan.arrays import FloatArray
from stplan.certify.certificate import Certificate, certify
from stplan.certify.ends import broken_ends
from stplan.errors import UsageError
from stplan.exports.settings import ExportSettings
from stplan.files.json_file import json_bytes
from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent
from stplan.viewing.run_view import RunView

# Chords stray from a spline by at most this share of the radius, unless a piece would fall into more parts.
STRAY_SHARE = 1e-4
MOST_PARTS = 256
# Speed is bounded on so many parts of a piece, each by the corners of its hull.
SPEED_PARTS = 8
# Segments are halved up to so many times before an agent keeps them straight.
MOST_HALVINGS = 6
ROUNDING = 1e-9


@dataclass(frozen=True)
class SplineCurve:
    """One agent's curve.

    Attributes:
        times: (n + 1,) s.
        coefficients: (n, degree + 1, 2), of powers of the time since the piece's begin, lowest first.
        chords: (m + 1, 3) points of it that hold all its knots; straight lines between them are near it.
        stray: how far from those lines it is at most, m.
    """

    times: FloatArray
    coefficients: FloatArray
    chords: FloatArray
    stray: float

    @property
    def is_spline(self) -> bool:
        """Whether it is more than its straight segments."""
        return self.coefficients.shape[1] > 2


def splines_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """Coefficients of every agent's pieces: x(t) = sum of c_k (t - t_i)^k from t_i on; m and s.

    Raises:
        UsageError: the scene that says what has to keep clear of what is lost, or the run is not certified.
    """
    del settings
    curves, certificate = clear_splines(view)
    agents = [
        {
            "agent": name, "curve": "spline" if curve.is_spline else "segments",
            "stray": curve.stray, "times": curve.times.tolist(),
            "x": curve.coefficients[:, :, 0].tolist(), "y": curve.coefficients[:, :, 1].tolist(),
        }
        for name, curve in zip(view.lines.agent_ids, curves, strict=True)
    ]  # fmt: skip
    proof: dict[str, Any] = {"holds": certificate.holds, "rounding": certificate.rounding}
    return json_bytes({"scene": view.name, "certificate": proof, "agents": agents})


def clear_splines(view: RunView) -> tuple[list[SplineCurve], Certificate]:
    """A curve an agent, splines where they are clear, and the certificate of their chords.

    Raises:
        UsageError: the scene is lost, or the run's own curves are not certified.
    """
    if view.scene is None:
        raise UsageError("splines are checked against the run's scene; name it: --scene FILE")
    lines, scene = view.lines, view.scene
    if not certify(scene, view.free_space, lines).holds:
        raise UsageError("the run's own curves do not hold their certificate; see stplan check")
    agents = {agent.id: agent for agent in scene.agents}
    planned = [(agents[name], lines.curve(a)) for a, name in enumerate(lines.agent_ids)]
    curves = [_spline(agent, curve, 0) for agent, curve in planned]
    halvings = [0] * len(curves)
    while True:
        chords = WorldLines.from_curves(lines.agent_ids, [curve.chords for curve in curves])
        certificate = certify(scene, view.free_space, chords)
        strays = {name: curve.stray for name, curve in zip(lines.agent_ids, curves, strict=True)}
        near = _too_near(certificate, strays)
        smooth = [a for a, curve in enumerate(curves) if curve.is_spline]
        rows = [a for a in smooth if lines.agent_ids[a] in near]
        if not rows and (certificate.holds or not smooth):
            return curves, certificate
        # What is broken without anybody being near is a meeting.
        for a in rows or smooth:
            halvings[a] += 1
            curves[a] = _spline(*planned[a], halvings[a])


def _too_near(certificate: Certificate, strays: dict[str, float]) -> set[str]:
    """The agents of which some spot is not clear by more than they may stray."""
    near = {
        name
        for spot in (*certificate.pairs, *certificate.walls)
        if spot.clearance <= certificate.rounding + sum(strays[who] for who in spot.who)
        for name in spot.who
    }
    others, furthest = certificate.unlisted, 2.0 * max(strays.values())
    if not near and others is not None and others.clearance <= certificate.rounding + furthest:
        return set(strays)
    return near


def _segments(curve: FloatArray) -> SplineCurve:
    """The curve as it was planned."""
    step = np.diff(curve, axis=0)
    coefficients = np.stack([curve[:-1, :2], step[:, :2] / step[:, 2:]], axis=1)
    return SplineCurve(curve[:, 2], coefficients, curve, 0.0)


def _spline(agent: Agent, curve: FloatArray, halvings: int) -> SplineCurve:
    """The spline through the knots and what halves the segments so many times.

    At rest at both ends (at the start with its velocity, where it has one) where accelerations are limited,
    without acceleration there elsewhere. The segments where that breaks what the agent alone is asked for, or
    `halvings` are too many.
    """
    if len(curve) < 3 or agent.path or halvings > MOST_HALVINGS:
        return _segments(curve)
    points = curve
    for _ in range(halvings):
        points = np.insert(points, range(1, len(points)), 0.5 * (points[1:] + points[:-1]), axis=0)
    ends: Any = "natural"
    if agent.max_acceleration is not None:
        ends = ((1, np.array(agent.start_velocity or (0.0, 0.0))), (1, np.zeros(2)))
    spline = CubicSpline(points[:, 2], points[:, :2], bc_type=ends)
    coefficients = np.ascontiguousarray(np.moveaxis(spline.c[::-1], 0, 1))
    found = _with_chords(points, coefficients, STRAY_SHARE * agent.radius)
    kept = _keeps_limits(agent, found) and not broken_ends(agent, found.chords, assigned=True)
    return found if kept else _segments(curve)


def _with_chords(curve: FloatArray, coefficients: FloatArray, stray: float) -> SplineCurve:
    span = np.diff(curve[:, 2])
    # The second derivative is linear on a piece: it is greatest at an end.
    second = _second_derivatives(coefficients, span).max(axis=1)
    bend = span**2 / 8.0 * second
    parts = np.clip(np.ceil(np.sqrt(bend / stray)), 1, MOST_PARTS).astype(int)
    rows = []
    for k, count in enumerate(parts.tolist()):
        since = span[k] * np.arange(count) / count
        powers = since[:, None] ** np.arange(coefficients.shape[1])
        rows.append(np.column_stack([powers @ coefficients[k], curve[k, 2] + since]))
        rows[-1][0] = curve[k]
    chords = np.vstack([*rows, curve[-1:]])
    return SplineCurve(curve[:, 2], coefficients, chords, float((bend / parts**2).max()))


def _second_derivatives(coefficients: FloatArray, span: FloatArray) -> FloatArray:
    """(n, 2) lengths of the second derivative at both ends of every piece, m/s2."""
    begin = 2.0 * coefficients[:, 2]
    ends = np.stack([begin, begin + 6.0 * coefficients[:, 3] * span[:, None]], axis=1)
    return np.asarray(np.hypot(ends[..., 0], ends[..., 1]))


def _keeps_limits(agent: Agent, curve: SplineCurve) -> bool:
    """Whether speed and acceleration of the spline itself are within the agent's limits."""
    span, c = np.diff(curve.times), curve.coefficients
    if agent.max_acceleration is not None:
        most = _second_derivatives(c, span).max()
        if most > agent.max_acceleration * (1.0 + ROUNDING):
            return False
    if agent.max_speed is None:
        return True
    part = span[:, None] / SPEED_PARTS
    since = (part * np.arange(SPEED_PARTS))[..., None]
    velocity = c[:, None, 1] + since * (2.0 * c[:, None, 2] + since * 3.0 * c[:, None, 3])
    change = 2.0 * c[:, None, 2] + 6.0 * c[:, None, 3] * since
    # Corners of the hull of velocities on a part: a parabola's begin, middle corner and end.
    middle = velocity + 0.5 * part[..., None] * change
    end = 2.0 * middle - velocity + 3.0 * c[:, None, 3] * part[..., None] ** 2
    corners = np.stack([velocity, middle, end])
    most = np.hypot(corners[..., 0], corners[..., 1]).max()
    return bool(most <= agent.max_speed * (1.0 + ROUNDING))
