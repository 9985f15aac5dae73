"""Crowds of any size: agents that walk straight or wander, met by nobody who planned for it."""

from __future__ import annotations

import numpy as np

from stplan.problem.world_lines import WorldLines
from stplan.scene.model import Agent, PairRule, Scene, SeedingSettings, SolverSettings, Weights


def scene_of(
    lines: WorldLines,
    radii: np.ndarray,
    *,
    stays: bool = False,
    horizon: float | None = None,
    pairs: tuple[PairRule, ...] = (),
    weights: Weights | None = None,
) -> Scene:
    """A scene that asks for the ends of `lines`."""
    last = float(lines.knots[:, 2].max()) if horizon is None else horizon
    agents = [
        Agent(
            id=name,
            start=tuple(curve[0, :2].tolist()),
            goal=tuple(curve[-1, :2].tolist()),
            start_time=float(curve[0, 2]),
            max_time=last,
            preferred_time=None,
            radius=float(radius),
            mass=1.0,
            after_arrival="stay" if stays else "vanish",
            waypoints=(),
            weights=weights or Weights(),
        )
        for name, curve, radius in zip(lines.agent_ids, lines.curves(), radii, strict=True)
    ]
    return Scene(
        "crowd", "", None, "", None, last, 1.0, tuple(agents), pairs, SeedingSettings(), SolverSettings()
    )  # fmt: skip


def walkers(count: int, rng: np.random.Generator, density: float = 0.06) -> WorldLines:
    """Straight walks of up to 40 m within 60 s, anywhere on a square of so many agents a m2."""
    side = np.sqrt(count / density)
    start, angle = rng.uniform(0.0, side, (count, 2)), rng.uniform(0.0, 2.0 * np.pi, count)
    step = rng.uniform(10.0, 40.0, (count, 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    begin = rng.uniform(0.0, 20.0, count)
    end = begin + rng.uniform(20.0, 40.0, count)
    curves = np.concatenate(
        [np.column_stack([start, begin])[:, None], np.column_stack([start + step, end])[:, None]],
        axis=1,
    )
    return WorldLines.from_curves([f"w{a}" for a in range(count)], list(curves))


def wanderers(count: int, rng: np.random.Generator, extent: float = 30.0) -> WorldLines:
    """Curves of any number of knots, some fast, some standing, each there for a time of its own."""
    curves = []
    for _ in range(count):
        knots = int(rng.integers(2, 8))
        step = rng.normal(size=(knots, 2)) * rng.choice([0.01, 1.0, 5.0, 40.0])
        step[rng.random(knots) < 0.2] = 0.0
        step[0] = rng.uniform(-extent, extent, 2)
        times = rng.choice([0.0, 3.0, 50.0]) + np.cumsum(10.0 ** rng.uniform(-3, 1, knots))
        curves.append(np.column_stack([np.cumsum(step, axis=0), times]))
    return WorldLines.from_curves([f"w{a}" for a in range(count)], curves)
