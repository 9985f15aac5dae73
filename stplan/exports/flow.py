"""Flow figures of a run, as those who study crowds take them: with PedPy, at lines and in areas.

Agents are points here. Headings and the ellipses of bodies are not modelled, so they are in no figure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from stplan.arrays import FloatArray
from stplan.errors import UsageError
from stplan.exports.frames import Frames, frames_of
from stplan.exports.probes import Probe
from stplan.optional import require
from stplan.viewing.run_view import RunView

PACKAGE, EXTRA = "pedpy", "measure"
# Speeds are taken over so many seconds, half of them on either side; flows over so many.
SPEED_SPAN, FLOW_SPAN = 0.4, 2.0
# Whoever vanishes is seen so many steps later at least: nobody stands on a line.
OFF_THE_LINE = 0.01
# Floor around the curves in the open plane, m.
ROOM = 1.0


@dataclass(frozen=True)
class LineFigures:
    """What passes a line.

    Attributes:
        crossings: (N, 2) time (s), and how many have crossed by then.
        flows: (W, 2) agents a second in one `FLOW_SPAN` after another, and their mean speed, m/s.
        mean_flow: agents a second between the first and the last crossing; None below two.
    """

    probe: Probe
    crossings: FloatArray
    flows: FloatArray
    mean_flow: float | None


@dataclass(frozen=True)
class AreaFigures:
    """What is in an area, frame by frame: a row of the fundamental diagram each.

    Attributes:
        rows: (T, 5) time (s), classic density (1/m^2), Voronoi density (1/m^2), Voronoi speed (m/s), and
            specific flow, their product (1/(m s)).
    """

    probe: Probe
    rows: FloatArray


@dataclass(frozen=True)
class FlowFigures:
    """Of a whole run.

    Attributes:
        evacuation: (T, 3) time (s), how many are on their way, how many have arrived.
    """

    evacuation: FloatArray
    lines: tuple[LineFigures, ...]
    areas: tuple[AreaFigures, ...]


def flow_figures(view: RunView, probes: tuple[Probe, ...], step: float) -> FlowFigures:
    """What PedPy measures of a run at `probes`, every `step` s.

    Raises:
        UsageError: PedPy is not installed, or a probe is no line or area of the floor.
    """
    pedpy = require(PACKAGE, "stplan measure", extra=EXTRA)
    frames = frames_of(view, step, SPEED_SPAN)
    arrivals = np.array([curve[-1, 2] for curve in view.lines.curves()])
    starts = np.array([curve[0, 2] for curve in view.lines.curves()])
    arrived = (arrivals[None, :] <= frames.times[:, None]).sum(axis=1)
    begun = (starts[None, :] <= frames.times[:, None]).sum(axis=1)
    try:
        return FlowFigures(
            np.column_stack([frames.times, begun - arrived, arrived]),
            tuple(_at_line(pedpy, view, frames, one) for one in probes if not one.area),
            _in_areas(pedpy, view, frames, [one for one in probes if one.area]),
        )
    except pedpy.errors.PedPyError as error:
        raise UsageError(f"PedPy: {error}") from error


def _at_line(pedpy: Any, view: RunView, frames: Frames, probe: Probe) -> LineFigures:
    """Who vanishes goes on for two steps as it moved, so that it crosses a line on which it vanishes."""
    data = _trajectories(pedpy, view, frames, beyond=True)
    line = pedpy.MeasurementLine([tuple(point) for point in probe.points])
    counted, crossings = pedpy.compute_n_t(traj_data=data, measurement_line=line)
    curve = counted[["frame", "cumulative_pedestrians"]].to_numpy(dtype=np.float64)
    curve[:, 0] = view.begin + frames.step * curve[:, 0]
    times = np.sort(crossings["frame"].to_numpy(dtype=np.float64)) * frames.step
    if len(times) < 2 or times[-1] == times[0]:
        return LineFigures(probe, curve, np.empty((0, 2)), None)
    flow = pedpy.compute_flow(
        nt=counted, crossing_frames=crossings, individual_speed=_speeds(pedpy, data, frames),
        delta_frame=max(1, round(FLOW_SPAN / frames.step)), frame_rate=1.0 / frames.step,
    )  # fmt: skip
    mean = (len(times) - 1) / float(times[-1] - times[0])
    flows = flow[["flow", "mean_speed"]].to_numpy(dtype=np.float64)
    return LineFigures(probe, curve, flows, mean)


def _in_areas(
    pedpy: Any, view: RunView, frames: Frames, probes: list[Probe]
) -> tuple[AreaFigures, ...]:
    if not probes:
        return ()
    data = _trajectories(pedpy, view, frames, beyond=False)
    speeds = _speeds(pedpy, data, frames)
    cells = pedpy.compute_individual_voronoi_polygons(
        traj_data=data, walkable_area=pedpy.WalkableArea(_floor(view))
    )
    found = []
    for probe in probes:
        area = pedpy.MeasurementArea([tuple(point) for point in probe.points])
        classic = pedpy.compute_classic_density(traj_data=data, measurement_area=area)
        density, parts = pedpy.compute_voronoi_density(
            individual_voronoi_data=cells, measurement_area=area
        )
        speed = pedpy.compute_voronoi_speed(
            traj_data=data, individual_speed=speeds, individual_voronoi_intersection=parts,
            measurement_area=area,
        )  # fmt: skip
        table = classic.merge(density, on="frame", suffixes=("", "_voronoi")).merge(
            speed, on="frame"
        )
        rows = table[["frame", "density", "density_voronoi", "speed"]].to_numpy(dtype=np.float64)
        rows[:, 0] = view.begin + frames.step * rows[:, 0]
        found.append(AreaFigures(probe, np.column_stack([rows, rows[:, 2] * rows[:, 3]])))
    return tuple(found)


def _trajectories(pedpy: Any, view: RunView, frames: Frames, *, beyond: bool) -> Any:
    """The frames as PedPy reads them; `beyond` with two steps more of those who vanish."""
    pandas = require("pandas", "stplan measure", extra=EXTRA)
    tables = []
    for a, curve in enumerate(view.lines.curves()):
        seen = np.array(frames.rows(a))
        if len(seen) < 2:
            continue
        places = frames.places[a, seen]
        if beyond and view.leaves[a] <= curve[-1, 2]:
            seen = seen[frames.times[seen] < curve[-1, 2]]
            places, step = frames.places[a, seen], curve[-1] - curve[-2]
            over = view.begin + (seen[-1] + 1) * frames.step - curve[-1, 2]
            over = max(over, OFF_THE_LINE * frames.step)
            # PedPy looks a frame back, so that crossings of the last step need another one.
            ahead = np.array([[over], [over + frames.step]]) / step[2]
            onward = curve[-1, :2] + ahead * step[:2]
            seen, places = np.append(seen, seen[-1] + [1, 2]), np.vstack([places, onward])
        tables.append(
            pandas.DataFrame({"id": a + 1, "frame": seen, "x": places[:, 0], "y": places[:, 1]})
        )
    if not tables:
        raise UsageError("nobody is there for two frames; a shorter --dt is expected")
    return pedpy.TrajectoryData(
        pandas.concat(tables, ignore_index=True), frame_rate=1.0 / frames.step
    )


def _speeds(pedpy: Any, data: Any, frames: Frames) -> Any:
    return pedpy.compute_individual_speed(
        traj_data=data,
        frame_step=max(1, round(0.5 * SPEED_SPAN / frames.step)),
        speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
    )


def _floor(view: RunView) -> shapely.Geometry:
    """Where agents may be; without a map, what surrounds their curves."""
    if view.free_space is not None:
        return view.free_space.polygon
    west, south, east, north = view.bounds
    return shapely.box(west - ROOM, south - ROOM, east + ROOM, north + ROOM)
