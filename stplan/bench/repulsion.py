"""Repulsive curves beside our plans: how long and how far apart either gets.

The same agents, the same ends and, for each, the time that our plan takes. Repulsive curves are given some
length; ours are given none, they take what costs least.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from stplan.arrays import FloatArray
from stplan.bench.comparison import smallest_distances
from stplan.bench.csv_table import csv_table
from stplan.bench.markdown import number, table
from stplan.bench.result_files import result_files
from stplan.bench.rivals.repulsive import repel
from stplan.callbacks import Progress
from stplan.planner import plan
from stplan.scene.model import Scene
from stplan.scene.reading.load import load_scene

OURS = "stplan"
SMALL_SCENES = ("three-agents/symmetric",)
FULL_SCENES = ("three-agents/symmetric", "circle/circle-5")
BUDGETS = (1.02, 1.05, 1.1, 1.2)


@dataclass(frozen=True)
class Spread:
    """Curves of a scene.

    Attributes:
        length: paths on the ground over straight ones, of all together.
        energy: kinetic over that of straight ways in the same time.
        nearest: least distance of two agents over the distance that they have to keep.
        mean: mean over pairs of the least distance, over what they have to keep.
    """

    scene: str
    planner: str
    length: float
    energy: float
    nearest: float
    mean: float


def measure(
    files: Mapping[str, Path], budgets: Sequence[float] = BUDGETS, *, progress: Progress
) -> list[Spread]:
    """Our plan of every scene, and its repulsive curves of all lengths."""
    found = []
    for name, file in files.items():
        scene = load_scene(file)
        planned = plan(scene)
        ours = list((planned.trajectories or planned.seed).curves())
        found.append(_spread(scene, name, OURS, ours))
        starts = np.array([curve[0, :2] for curve in ours])
        goals = np.array([curve[-1, :2] for curve in ours])
        durations = np.array([curve[-1, 2] - curve[0, 2] for curve in ours])
        for budget in budgets:
            curves = repel(starts, goals, durations, scene.time_scale, budget)
            for curve, own in zip(curves, ours, strict=True):
                curve[:, 2] += own[0, 2]
            planner = f"repulsive curves, rods {100 * (budget - 1):.0f} % longer"
            found.append(_spread(scene, name, planner, curves))
            progress(f"{name}: {planner}: paths {found[-1].length:.3f} times straight")
    return found


def _spread(scene: Scene, name: str, planner: str, curves: list[FloatArray]) -> Spread:
    steps = [np.diff(curve, axis=0) for curve in curves]
    straight = [np.linalg.norm(curve[-1, :2] - curve[0, :2]) for curve in curves]
    lengths = [np.linalg.norm(step[:, :2], axis=1).sum() for step in steps]
    energy = sum(((step[:, :2] ** 2).sum(axis=1) / step[:, 2]).sum() for step in steps)
    least = sum(s**2 / (c[-1, 2] - c[0, 2]) for s, c in zip(straight, curves, strict=True))
    pairs, distance = smallest_distances(scene, curves)
    radii = np.array([agent.radius for agent in scene.agents])
    kept = distance / radii[pairs].sum(axis=1)
    return Spread(
        name, planner, float(sum(lengths) / sum(straight)), float(energy / least),
        float(kept.min()), float(kept.mean()),
    )  # fmt: skip


def files(spreads: Sequence[Spread]) -> dict[str, bytes]:
    """Names and contents of the files of the measurement."""
    head = (
        "scene", "curves", "paths over straight", "kinetic over straight", "nearest over needed",
        "mean of pairs over needed",
    )  # fmt: skip
    rows = [
        (
            one.scene, one.planner, number(one.length, ".4f"), number(one.energy, ".4f"),
            number(one.nearest, ".2f"), number(one.mean, ".2f"),
        )
        for one in spreads
    ]  # fmt: skip
    text = table(head, rows, words=(0, 1))
    return result_files("repulsion", csv_table([asdict(one) for one in spreads]), text)
