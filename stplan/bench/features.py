"""What planners can do, measured: small scenes that need one feature each, and a figure that shows it.

What is judged is motion, whoever made it, by the code of the certificate. Where an agent does not arrive or
overlaps something by more than a hundredth of its radius, a feature is not there; overlaps of less count
only where the feature is that there are none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from stplan.arrays import FloatArray
from stplan.bench.comparison import (
    OURS,
    build_task,
    greatest_acceleration,
    smallest_clearance,
    smallest_distances,
)
from stplan.bench.rivals import casadi_grid, jupedsim_model, ompl_joint, repulsive, rvo2
from stplan.bench.rivals.task import Motion, Task
from stplan.callbacks import Progress
from stplan.planner import plan
from stplan.scene import parse_scene
from stplan.scene.model import Scene
from stplan.world import build_free_space

# Beside ours. Of two ways to start CasADi the one that needs nothing of ours.
RIVALS: Sequence[tuple[str, str, Callable[[Task], Motion]]] = (
    (rvo2.NAME, rvo2.PACKAGE, rvo2.drive),
    (jupedsim_model.NAME, jupedsim_model.PACKAGE, jupedsim_model.drive),
    (ompl_joint.NAME, ompl_joint.PACKAGE, ompl_joint.drive),
    (casadi_grid.NAME, casadi_grid.PACKAGE, casadi_grid.drive),
    (repulsive.NAME, repulsive.PACKAGE, repulsive.drive),
)
# Written for the open plane alone.
WITHOUT_WALLS = frozenset({repulsive.NAME})
# Overlaps (of a radius) that spoil no feature but that of touching nothing.
OVERLAP = 0.01

HEAD = """
stplan: 1
horizon: {horizon}
defaults: {{radius: {radius}, max_speed: 1.5, max_acceleration: 3, after_arrival: stay}}
"""


def _scene(radius: float, horizon: float, rest: str) -> Scene:
    return parse_scene(HEAD.format(radius=radius, horizon=horizon) + rest)


MASSES = """
agents:
  - {id: heavy, start: [-8, 0], goal: [8, 0], mass: 100}
  - {id: light, start: [8, 0.3], goal: [-8, 0.3]}
"""
SIZES = """
agents:
  - {id: large, start: [-8, 0], goal: [8, 0], radius: 2}
  - {id: small, start: [8, 0.3], goal: [-8, 0.3], radius: 0.3}
  - {id: other, start: [0, -8], goal: [0, 8], radius: 0.3}
"""
LANE = """
map: {rectangle: [0, 0, 10, 2.2], obstacles: [{rectangle: [0, 1, 4.4, 2.2]}, {rectangle: [5.6, 1, 10, 2.2]}]}
agents:
  - {id: east, start: [0.7, 0.5], goal: [9.3, 0.5]}
  - {id: west, start: [9.3, 0.5], goal: [0.7, 0.5]}
"""
GAP = """
map: {rectangle: [0, 0, 10, 6], obstacles: [{rectangle: [4.9, 0, 5.1, 2.4]}, {rectangle: [4.9, 3.6, 5.1, 6]}]}
agents:
  - {id: a, start: [1, 1.5], goal: [9, 1.5]}
  - {id: b, start: [1, 4.5], goal: [9, 4.5]}
  - {id: c, start: [8, 1.8], goal: [1, 3]}
"""
OPPOSED = """
agents:
  - {id: sam, start: [-8, 0], goal: [8, 0]}
  - {id: ann, start: [8, 1], goal: [-8, 1]}
  - {id: ben, start: [8, -1], goal: [-8, -1]}
"""
ARRIVALS = """
agents:
  - {id: early, start: [0, 0], goal: [9, 0], preferred_time: 8, weights: {arrival: 10}}
  - {id: late, start: [0, 5], goal: [9, 5], preferred_time: 16, weights: {arrival: 10}}
"""
MEETING = """
agents:
  - {id: mia, start: [0, 0], goal: [12, 0]}
  - {id: ben, start: [0, 7], goal: [12, 7]}
pairs: [{between: [mia, ben], meet: {within: 1.5}}]
"""


def _circle() -> str:
    angles = np.arange(8) * np.pi / 4
    ends = [(10 * np.cos(angle), 10 * np.sin(angle)) for angle in angles]
    rows = [
        f"  - {{id: a{n}, start: [{x:.6f}, {y:.6f}], goal: [{-x:.6f}, {-y:.6f}]}}"
        for n, (x, y) in enumerate(ends)
    ]
    return "agents:\n" + "\n".join(rows)


def _aside(curve: FloatArray) -> FloatArray:
    """(n,) distances from the straight line from start to goal, m."""
    along = (curve[-1, :2] - curve[0, :2]) / np.linalg.norm(curve[-1, :2] - curve[0, :2])
    away = curve[:, :2] - curve[0, :2]
    return np.abs(away[:, 0] * along[1] - away[:, 1] * along[0])


def _heavy_over_light(scene: Scene, motion: Motion) -> float:
    """How far the heavy one moves aside, over how far the light one does."""
    heavy, light = (float(_aside(curve).max()) for curve in motion.curves)
    return heavy / max(light, 1e-6)


def _clearance(scene: Scene, motion: Motion) -> float:
    return smallest_clearance(scene, build_free_space(scene), motion.curves)


def _acceleration(scene: Scene, motion: Motion) -> float:
    return max(greatest_acceleration(curve) for curve in motion.curves)


def _unpunctual(scene: Scene, motion: Motion) -> float:
    wanted = [agent.preferred_time or 0.0 for agent in scene.agents]
    return max(
        abs(float(curve[-1, 2]) - time) for curve, time in zip(motion.curves, wanted, strict=True)
    )


def _nearest(scene: Scene, motion: Motion) -> float:
    return float(smallest_distances(scene, motion.curves)[1].min())


def _lead(scene: Scene, motion: Motion) -> float:
    """How long before two are nearest the first of them has begun to give way, s; 0 where nobody does."""
    first, second = motion.curves[:2]
    times = np.linspace(0.0, min(first[-1, 2], second[-1, 2]), 1000)
    at = [
        np.column_stack([np.interp(times, own[:, 2], own[:, axis]) for axis in range(2)])
        for own in (first, second)
    ]
    closest = times[np.hypot(*(at[0] - at[1]).T).argmin()]
    begins = []
    for own in (first, second):
        aside = np.interp(times, own[:, 2], _aside(own))
        if aside.max() > 1e-3:
            begins.append(times[np.flatnonzero(aside >= 0.1 * aside.max())[0]])
    return float(closest - min(begins, default=closest))


@dataclass(frozen=True)
class Feature:
    """One thing that planners may be able to do.

    Attributes:
        measured: what the figure is, with its unit.
        figure: of a motion in the scene.
        least, most: bounds of the figure where the feature is there; None where there is none.
    """

    name: str
    measured: str
    scene: Callable[[], Scene]
    figure: Callable[[Scene, Motion], float]
    least: float | None = None
    most: float | None = None

    @property
    def asked(self) -> str:
        """The bounds in words."""
        bounds = [f"at least {self.least:g}"] if self.least is not None else []
        bounds += [f"at most {self.most:g}"] if self.most is not None else []
        return ", ".join(bounds)

    def holds(self, figure: float) -> bool:
        """Whether a figure is within its bounds."""
        above = self.least is None or figure >= self.least
        return above and (self.most is None or figure <= self.most)


FEATURES = (
    Feature(
        "unequal masses", "heavy one's deviation over the light one's",
        lambda: _scene(0.75, 13, MASSES), _heavy_over_light, most=0.2,
    ),
    Feature(
        "unequal sizes", "smallest clearance, m", lambda: _scene(0.5, 16, SIZES), _clearance, least=-0.003
    ),
    Feature(
        "a lane with one pocket", "smallest clearance, m", lambda: _scene(0.4, 40, LANE), _clearance,
        least=-0.004,
    ),
    Feature(
        "a gap from both sides", "smallest clearance, m", lambda: _scene(0.4, 40, GAP), _clearance,
        least=-0.004,
    ),
    Feature(
        "smooth", "greatest acceleration on the way, m/s²", lambda: _scene(0.75, 13, OPPOSED),
        _acceleration, most=3.1,
    ),
    Feature(
        "anticipation", "giving way before the closest moment, s", lambda: _scene(0.75, 13, OPPOSED),
        _lead, least=2.0,
    ),
    Feature(
        "arrival when asked for", "most that somebody is off its time, s",
        lambda: _scene(0.4, 30, ARRIVALS), _unpunctual, most=0.5,
    ),
    Feature(
        "meeting on the way", "nearest that the two come, m", lambda: _scene(0.4, 30, MEETING), _nearest,
        most=1.5,
    ),
    Feature(
        "eight agents on a circle", "smallest clearance, m", lambda: _scene(0.5, 20, _circle()),
        _clearance, least=-0.005,
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """A planner at a feature.

    Attributes:
        figure: nan where nobody moved.
        clearance: the smallest, m; nan where nobody moved.
        there: whether the feature is.
        arrived: whether everybody does.
        note: why not, where it is not for its figure.
    """

    feature: str
    planner: str
    figure: float
    clearance: float
    there: bool
    arrived: bool = False
    note: str = ""


def measure(features: Sequence[Feature] = FEATURES, *, progress: Progress) -> list[Finding]:
    """Ours and every rival that is installed at every feature."""
    found = []
    for feature in features:
        scene = feature.scene()
        found.append(judged(feature, scene, OURS, _our_motion(scene)))
        task = build_task(scene)
        for planner, package, drive in RIVALS:
            walled = task.free_space is not None and planner in WITHOUT_WALLS
            if find_spec(package) and not walled:
                found.append(judged(feature, scene, planner, drive(task)))
        listed = ", ".join(
            f"{one.planner} {one.figure:.3g} {one.note}".rstrip()
            for one in found
            if one.feature == feature.name
        )
        progress(f"{feature.name}: {listed}")
    return found


def _our_motion(scene: Scene) -> Motion:
    planned = plan(scene)
    arrived = np.full(len(scene.agents), planned.certificate.holds)
    return Motion(list((planned.trajectories or planned.seed).curves()), arrived, rests=True)


def judged(feature: Feature, scene: Scene, planner: str, motion: Motion) -> Finding:
    """What a motion shows of a feature."""
    if not motion.curves:
        return Finding(feature.name, planner, np.nan, np.nan, False, note=motion.note)
    clearance, figure = _clearance(scene, motion), feature.figure(scene, motion)
    arrived, agents = int(motion.arrived.sum()), len(scene.agents)
    note = ""
    if arrived < agents:
        note = f"{arrived} of {agents} arrive"
    elif clearance < -OVERLAP * max(agent.radius for agent in scene.agents):
        note = f"overlap of {1000 * -clearance:.0f} mm"
    there = not note and feature.holds(figure)
    return Finding(feature.name, planner, figure, clearance, there, arrived == agents, note)
