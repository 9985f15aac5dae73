"""The plan of a scene whose goals move, or whose robots have tasks: what happened, certified as a whole."""

from __future__ import annotations

from collections.abc import Sequence

from stplan.analysis.chases import chases
from stplan.analysis.metrics import metrics
from stplan.analysis.throughput import throughput
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop
from stplan.certify.certificate import Certificate
from stplan.certify.play import certify_play
from stplan.clock import Clock
from stplan.errors import BrokenSeedError, SeedingError, StoppedError, UsageError
from stplan.planned import Plan, notes_of
from stplan.problem.ends import ending_as
from stplan.problem.world_lines import WorldLines
from stplan.replanning.rolling import roll
from stplan.replanning.rounds import play
from stplan.report import Report, RunRecord, SeedReport
from stplan.scene.model import Scene
from stplan.status import Status
from stplan.world import FreeSpace, fitted_free_space, warnings_of

# What report.json says the curves were found by.
FOUND_BY = "play"


def play_out(scene: Scene, *, progress: Progress, stop: Stop) -> Plan:
    """Play `scene` to its end; there are no curves but those that were executed.

    Raises:
        SceneError: the scene does not fit its map.
        SeedingError: somebody whose goal is a point does not get there, or to its task.
        StoppedError: `stop` said so before the end.
    """
    clock = Clock()
    with clock.stage("world"):
        space = fitted_free_space(scene)
        if space is None:
            raise UsageError(f"{scene.name} is played, and has no map")
        for line in warnings_of(scene, space):
            progress(line)
    if scene.tasks:
        return _worked_off(scene, space, clock, progress, stop)
    with clock.stage("play"):
        played = play(scene, space, stop)
    if played is None:
        raise StoppedError
    lines = _lines(scene, played.curves)
    gone = {one.prey for one in played.caught}
    late = [
        agent.id
        for a, agent in enumerate(scene.agents)
        if agent.moving_goal is None
        and played.curves[a][-1, :2].tolist() != list(agent.goal)
        and a not in gone
    ]
    if late:
        raise SeedingError(
            f"{', '.join(late)}: not at the goal by {scene.horizon:g} s; a longer horizon may help"
        )
    shown, certificate = _certified(scene, space, lines, clock)
    found = chases(scene, lines)
    for one in found.captures:
        progress(one.sentence)
    seed = _seed(shown, lines, certificate, played.rounds)
    content = Report(
        shown, Status.PLAYED, certificate, seed.metrics, seed, notes=notes_of(space), chases=found
    )
    return Plan(lines, lines, content, RunRecord.of(clock))


def _worked_off(
    scene: Scene, space: FreeSpace, clock: Clock, progress: Progress, stop: Stop
) -> Plan:
    """The plan of a scene whose robots have tasks, when all are done."""
    with clock.stage("roll"):
        rolled = roll(scene, space, stop, progress)
    if rolled is None:
        raise StoppedError
    if rolled.stuck:
        raise SeedingError("nobody can go on: " + "; ".join(rolled.stuck))
    lines = _lines(scene, rolled.curves)
    shown, certificate = _certified(scene, space, lines, clock)
    with clock.stage("throughput"):
        found = throughput(scene, space, lines)
    seed = _seed(shown, lines, certificate, rolled.rounds)
    content = Report(
        shown,
        Status.PLAYED,
        certificate,
        seed.metrics,
        seed,
        notes=notes_of(space),
        throughput=found,
    )
    return Plan(lines, lines, content, RunRecord.of(clock))


def _lines(scene: Scene, curves: Sequence[FloatArray]) -> WorldLines:
    return WorldLines.from_curves([agent.id for agent in scene.agents], list(curves))


def _certified(
    scene: Scene, space: FreeSpace, lines: WorldLines, clock: Clock
) -> tuple[Scene, Certificate]:
    """The scene that ends as `lines`, and their certificate. Raises BrokenSeedError where that is broken."""
    with clock.stage("certify"):
        certificate = certify_play(scene, space, lines)
    if not certificate.holds:
        raise BrokenSeedError(certificate.violations)
    return ending_as(scene, lines), certificate


def _seed(shown: Scene, lines: WorldLines, certificate: Certificate, rounds: int) -> SeedReport:
    tightest = certificate.smallest
    return SeedReport(
        FOUND_BY,
        {"rounds": rounds},
        None if tightest is None else tightest.clearance,
        metrics(shown, lines),
    )
