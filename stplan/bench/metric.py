"""What the metric's c does to whole plans: cost, success, iterations and time of several `time_scale`s."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stplan.bench import families_open as wide
from stplan.bench import families_tight as tight
from stplan.bench.named_scenes import named
from stplan.bench.solves import priced, warm_up
from stplan.scene.model import Scene
from stplan.scene.reading.load import load_scene

AUTO = "auto"
# m/s, or left to the program.
TIME_SCALES: tuple[float | str, ...] = (1.0, 2.0, 3.0, AUTO)
SMALL_SCENES = ("comparison/gap", "tight/cabin", "tight/plus-crossing", "three-agents/symmetric")
FULL_SCENES = (
    *SMALL_SCENES,
    "tight/pocket-swap",
    "tight/parking-lot",
    "tight/door",
    "tight/warehouse",
    "aircraft/first-class",
    "subway/platform",
    "bottleneck/bottleneck",
    "circle/circle-20",
    "meadow/meadow",
    "mazes/rings",
)
# Random numbers of the generated scenes.
RNG_SEED = 7


@dataclass(frozen=True)
class MetricTrial:
    """A scene planned in one metric.

    Attributes:
        time_scale: c in m/s, or `auto`.
        cost: of all agents by themselves, in the scene as it is; nan where there is no plan.
        seconds: of processor time.
    """

    scene: str
    agents: int
    time_scale: float | str
    cost: float
    iterations: int
    seconds: float

    @property
    def found(self) -> bool:
        """Whether there is a plan that holds its certificate."""
        return not np.isnan(self.cost)


def chosen(folder: Path, names: Sequence[str], *, full: bool) -> dict[str, Scene]:
    """Scenes by name, all of which leave c to the program: shipped ones below `folder`, generated ones.

    Args:
        names: what the names of scenes contain; where there is none, all scenes of a size.
        full: whether the larger ones are taken too where none is named.

    Raises:
        UsageError: no scene has such a name.
    """
    every = full or bool(names)
    generated = _generated(every)
    shipped = FULL_SCENES if every else SMALL_SCENES
    return {
        scene: in_metric(
            generated[scene] if scene in generated else load_scene(folder / f"{scene}.yaml"), AUTO
        )
        for scene in named((*shipped, *generated), names)
    }


def _generated(every: bool) -> dict[str, Scene]:
    rng = np.random.default_rng(RNG_SEED)
    scenes = {
        "door, 5 a side": tight.door(rng, per_side=5),
        "cabin of 6": tight.cabin(rng, depth=1, passengers=6),
        "crossing flows of 16": wide.crossing_flows(16, 1.0, RNG_SEED),
    }
    if every:
        scenes |= {
            "door, 10 a side": tight.door(rng, per_side=10),
            "cabin of 10": tight.cabin(rng, depth=1, passengers=10),
            "warehouse of 16": tight.warehouse(rng, robots=16),
            "pillars, 16 agents": tight.pillars(rng, agents=16),
            "crossing flows of 64": wide.crossing_flows(64, 1.0, RNG_SEED),
        }
    return scenes


def measure(
    scenes: Mapping[str, Scene],
    *,
    time_scales: Sequence[float | str] = TIME_SCALES,
    progress: Callable[[str], None],
) -> list[MetricTrial]:
    """Every scene planned in every metric; `scenes` by name."""
    warm_up()
    found = []
    for name, scene in scenes.items():
        for time_scale in time_scales:
            found.append(_tried(name, scene, time_scale))
            one = found[-1]
            progress(
                f"{name}, time_scale {time_scale}: cost {one.cost:.6g}, {one.iterations} iterations, "
                f"{one.seconds:.1f} s"
            )
    return found


def _tried(name: str, scene: Scene, time_scale: float | str) -> MetricTrial:
    one = priced(in_metric(scene, time_scale), costs=scene)
    return MetricTrial(
        name, len(scene.agents), time_scale, one.cost, one.figures.iterations, one.seconds
    )


def in_metric(scene: Scene, time_scale: float | str) -> Scene:
    """`scene` with c stated in m/s or, where it says `auto`, left to the program."""
    if isinstance(time_scale, str):
        return replace(scene, metric="auto")
    return replace(scene, time_scale=time_scale, metric="stated")
