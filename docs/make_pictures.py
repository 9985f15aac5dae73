"""Draw the pictures of README from plans made now: `python docs/make_pictures.py` (needs matplotlib)."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path as Outline

from stplan import load_scene, plan
from stplan.pipeline import Plan
from stplan.world import build_free_space

ROOT = Path(__file__).parent.parent
DISCS = 9


def draw_map(axes: plt.Axes, result: Plan) -> None:
    """The walls as a filled outline, if the scene has a map."""
    free_space = build_free_space(result.scene)
    if free_space is None:
        return
    for part in getattr(free_space.polygon, "geoms", [free_space.polygon]):
        rings = [np.asarray(ring.coords) for ring in (part.exterior, *part.interiors)]
        codes = [
            code
            for ring in rings
            for code in [Outline.MOVETO, *[Outline.LINETO] * (len(ring) - 2), Outline.CLOSEPOLY]
        ]
        outline = Outline(np.vstack(rings), codes)
        axes.add_patch(PathPatch(outline, facecolor="#f4f4f0", edgecolor="#444444", lw=1.2))


def draw_plan(axes: plt.Axes, result: Plan) -> None:
    """Seed (thin), result (thick), and discs at equal times, paler when earlier."""
    draw_map(axes, result)
    colours = mpl.colormaps["tab10"].colors
    lines = result.trajectories
    if lines is None:
        raise ValueError("only planned scenes are drawn")
    latest = max(curve[-1, 2] for curve in lines.curves())
    for a, (agent, curve) in enumerate(zip(result.scene.agents, lines.curves(), strict=True)):
        colour = colours[a % len(colours)]
        seed = result.seed.curve(a)
        axes.plot(seed[:, 0], seed[:, 1], color=colour, lw=0.7, ls=":")
        axes.plot(curve[:, 0], curve[:, 1], color=colour, lw=1.8)
        for k, time in enumerate(np.linspace(0.0, latest, DISCS)):
            place = [np.interp(time, curve[:, 2], curve[:, x]) for x in range(2)]
            strength = 0.12 + 0.5 * k / (DISCS - 1)
            axes.add_patch(Circle(place, agent.radius, color=colour, alpha=strength, lw=0))
        axes.plot(*agent.goal, marker="x", color=colour, ms=6, mew=2)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.autoscale_view()
    axes.set_title(result.scene.description, fontsize=10)


def main() -> None:
    """Write docs/pictures/plans.png."""
    names = ["bottleneck/bottleneck", "roomba/roomba", "three-agents/size-and-mass"]
    figure, rows = plt.subplots(1, 3, figsize=(13, 4.2), width_ratios=[2, 1, 1.6])
    for axes, name in zip(rows, names, strict=True):
        draw_plan(axes, plan(load_scene(ROOT / "scenes" / f"{name}.yaml")))
    figure.tight_layout()
    target = ROOT / "docs" / "pictures" / "plans.png"
    target.parent.mkdir(exist_ok=True)
    figure.savefig(target, dpi=90, metadata={"Software": None})


if __name__ == "__main__":
    main()
