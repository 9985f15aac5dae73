"""A world that changes while its plan is executed: everybody goes on from where it is, the plan is mended.

Nothing that happened before is touched, and what was executed is certified as a whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stplan import planner
from stplan.analysis.metrics import metrics
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.certify.certificate import Certificate
from stplan.certify.history import certify_history
from stplan.clock import Clock
from stplan.errors import BrokenSeedError, StoppedError
from stplan.planned import Plan
from stplan.problem.continuation import curves_of, joined_history
from stplan.problem.world_lines import WorldLines
from stplan.problem.worlds import space_of, spaces_of, whole_scene
from stplan.replanning.delays import forgiving, judged
from stplan.replanning.easing import with_eased_starts
from stplan.report import OptimisationReport
from stplan.scene.model import Scene, WorldChange
from stplan.scene.moving_goals import is_play
from stplan.status import Status

if TYPE_CHECKING:
    from distributed import Client

    from stplan.optimize.continuation import LiveLine


def plan(
    scene: Scene,
    *,
    progress: Progress | None = None,
    live: LiveLine | None = None,
    stop: Stop | None = None,
    num_workers: int = 1,
    cluster: Client | None = None,
) -> Plan:
    """Plan `scene`, and mend the plan at each of its changes, of which it knew nothing before.

    A scene whose goals move is played instead, round by round. Raises like `planner.plan`; a SeedingError
    says at which change nothing was found, or who did not get to its goal.
    """
    if is_play(scene):
        from stplan.replanning.playing import play_out

        return play_out(scene, progress=progress or unheard, stop=stop or never)

    def planned(given: Scene) -> Plan:
        return with_eased_starts(
            given,
            lambda one: planner.plan(
                one, progress=progress, live=live, stop=stop,
                num_workers=num_workers, cluster=cluster,
            ),
        )  # fmt: skip

    first = forgiving(replace(scene, changes=()), planned, progress or unheard, stop or never)
    if not scene.changes:
        return first
    return go_on(scene, first, scene.changes, progress=progress, stop=stop)


def seed(scene: Scene, *, progress: Progress | None = None, stop: Stop | None = None) -> Plan:
    """Only the initial curves of `scene`, certified. Raises like `plan`."""
    return with_eased_starts(scene, lambda one: planner.seed(one, progress=progress, stop=stop))


def go_on(
    scene: Scene,
    before: Plan,
    changes: Sequence[WorldChange],
    *,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Plan:
    """The plan of `scene`, given that `before` its last `changes`: certified as a whole.

    Raises:
        SeedingError: there is no way to go on after one of them.
        StoppedError: `stop` said so before the last of them was planned.
    """
    from stplan.replanning.mending import mend

    progress, stop = progress or unheard, stop or never
    clock = Clock()
    known = len(scene.changes) - len(changes)
    earlier = scene.changes[known - 1].scene if known else scene
    lines = before.trajectories or before.seed
    history, seeds = curves_of(lines), curves_of(before.seed)
    made: OptimisationReport | None = before.report.optimisation
    spaces = spaces_of(scene)
    with clock.stage("replan"):
        for number, change in enumerate(changes, start=known):
            if stop():
                raise StoppedError
            progress(f"{change.at:g} s: {', '.join(change.causes)}")
            found = mend(before.scene, earlier, history, change, progress=progress, stop=stop)
            history = joined_history(history, found.curves, change.at)
            seeds = joined_history(seeds, found.seed, change.at)
            made = OptimisationReport.of(found.scene, found.optimisation)
            partial = replace(scene, changes=scene.changes[: number + 1])
            certificate = certify_history(partial, spaces[: number + 2], _lines(history))
            if not certificate.holds:
                raise BrokenSeedError(certificate.violations)
            earlier = change.scene
            progress(f"planned anew: {', '.join(found.replanned) or 'nobody'}")
    whole = whole_scene(scene, history)
    lines = _lines(history)
    status = Status.INTERRUPTED if stop() else found.optimisation.status
    figures = metrics(whole, lines)
    report = replace(
        before.report, scene=whole, status=status, certificate=certificate, metrics=figures,
        optimisation=made, bound=None, arrivals=None, improvement=None, rivals=(),
    )  # fmt: skip
    whole_plan = Plan(_lines(seeds), lines, report, before.run.and_then(clock))
    return judged(whole_plan)


def check(scene: Scene, lines: WorldLines, *, progress: Progress | None = None) -> Certificate:
    """The certificate of any trajectories against `scene`, changes included. Raises like `planner.check`."""
    if is_play(scene):
        from stplan.certify.play import certify_play

        return certify_play(scene, space_of(scene), lines)
    if not scene.changes:
        return planner.check(scene, lines, progress=progress)
    return certify_history(scene, spaces_of(scene), lines)


def _lines(curves: Mapping[str, FloatArray]) -> WorldLines:
    return WorldLines.from_curves(list(curves), list(curves.values()))
