"""A world that changes while its plan is executed: everybody goes on from where it is, the plan is mended.

Nothing that happened before is touched, and what was executed is certified as a whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stplan import planner
from stplan.analysis.metrics import metrics
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop, never, unheard
from stplan.certify.certificate import Certificate
from stplan.certify.history import certify_history
from stplan.clock import Clock
from stplan.errors import BrokenSeedError, StoppedError, UsageError
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


def replan(
    before: Plan, scene: Scene, *, progress: Progress | None = None, stop: Stop | None = None
) -> Plan:
    """Go on with a plan to which something happens: its past to the byte, another future, one certificate.

    Args:
        scene: that of the plan with further `events`.

    Raises:
        UsageError: there are no further events, `before` is no certified plan of the rest of `scene`, or
            goals move.
        SeedingError: there is no way to go on after one of them.
        StoppedError: `stop` said so before the last of them was planned.

    >>> import stplan
    >>> agents = [stplan.AgentSpec("sam", (0, 0), (4, 0)), stplan.AgentSpec("ann", (4, 1), (0, 1))]
    >>> plan = stplan.plan(stplan.build_scene(agents, horizon=8))
    >>> late = [{"at": 3, "agent": "ann", "goal": [0, 2]}]
    >>> mended = stplan.replan(plan, stplan.build_scene(agents, horizon=8, events=late))
    >>> mended.certificate.holds, [agent.goal for agent in mended.scene.agents]
    (True, [(4.0, 0.0), (0.0, 2.0)])
    """
    if is_play(scene):
        raise UsageError(
            "goals that move are decided anew all the time; there is nothing to replan"
        )
    known = len(before.scene.changes)
    changes = scene.changes[known:]
    if not changes:
        raise UsageError(
            "nothing happens that the plan does not know; give the scene further events"
        )
    if changes[0].at < max((change.at for change in scene.changes[:known]), default=-np.inf):
        raise UsageError("an event lies before those that the plan knows")
    certificate = check(
        replace(scene, changes=scene.changes[:known]), before.trajectories or before.seed
    )
    if not certificate.holds:
        raise UsageError(f"this is no plan of the scene before its events: {certificate.summary}")
    return go_on(scene, before, changes, progress=progress, stop=stop)


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
