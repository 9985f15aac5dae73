"""The plan of a scene whose goals move: what happened when it was played, certified as a whole."""

from __future__ import annotations

from stplan.analysis.chases import chases
from stplan.analysis.metrics import metrics
from stplan.callbacks import Progress, Stop
from stplan.certify.play import certify_play
from stplan.clock import Clock
from stplan.errors import BrokenSeedError, SeedingError, StoppedError, UsageError
from stplan.planned import Plan, notes_of
from stplan.problem.ends import ending_as
from stplan.problem.world_lines import WorldLines
from stplan.replanning.rounds import play
from stplan.report import Report, RunRecord, SeedReport
from stplan.scene.model import Scene
from stplan.status import Status
from stplan.world import fitted_free_space, warnings_of

# What report.json says the curves were found by.
FOUND_BY = "play"


def play_out(scene: Scene, *, progress: Progress, stop: Stop) -> Plan:
    """Play `scene` to its end; there are no curves but those that were executed.

    Raises:
        SceneError: the scene does not fit its map.
        SeedingError: somebody whose goal is a point does not get there.
        StoppedError: `stop` said so before the end.
    """
    clock = Clock()
    with clock.stage("world"):
        space = fitted_free_space(scene)
        if space is None:
            raise UsageError(f"{scene.name} is played, and has no map")
        for line in warnings_of(scene, space):
            progress(line)
    with clock.stage("play"):
        played = play(scene, space, stop)
    if played is None:
        raise StoppedError
    names = [agent.id for agent in scene.agents]
    lines = WorldLines.from_curves(names, list(played.curves))
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
    with clock.stage("certify"):
        certificate = certify_play(scene, space, lines)
    if not certificate.holds:
        raise BrokenSeedError(certificate.violations)
    shown = ending_as(scene, lines)
    found = chases(scene, lines)
    for one in found.captures:
        progress(one.sentence)
    figures = metrics(shown, lines)
    tightest = certificate.smallest
    seed = SeedReport(
        FOUND_BY,
        {"rounds": played.rounds},
        None if tightest is None else tightest.clearance,
        figures,
    )
    notes = notes_of(space)
    content = Report(shown, Status.PLAYED, certificate, figures, seed, notes=notes, chases=found)
    return Plan(lines, lines, content, RunRecord.of(clock))
