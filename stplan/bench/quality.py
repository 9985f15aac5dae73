"""How near plans are to the best ones known: by default, and after so many moves of improvement."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from stplan.bench.ledger import Entry
from stplan.bench.solves import plan_cost, warm_up
from stplan.callbacks import Progress
from stplan.improvement.budget import ImprovementBudget
from stplan.planner import improve, plan
from stplan.scene.reading.load import load_scene

# Scenes below the folder of all scenes that leave agents several ways around each other; small ones first.
SMALL_SCENES = ("tight/plus-crossing", "tight/pocket-swap", "tight/cabin", "tight/parking-lot")
FULL_SCENES = (
    *SMALL_SCENES,
    "tight/door",
    "tight/warehouse",
    "aircraft/first-class",
    "subway/platform",
    "subway/platform-tight",
    "comparison/gap",
    "comparison/lane",
    "tunnel/tunnel",
    "bottleneck/bottleneck",
    "mazes/rings",
    "mazes/corn",
    "pond/strangers",
    "pond/meeting",
    "pond/messenger",
    "pond/friends",
)
SMALL_MOVES, FULL_MOVES = 20, 200


@dataclass(frozen=True)
class Quality:
    """A scene planned by default and improved.

    Attributes:
        planned, improved: cost of all agents by themselves, `own_costs`, before and after.
        planned_seconds, improve_seconds: processor time of either.
        accepted: moves that led to a cheaper plan.
        certified: whether both plans hold their certificates.
    """

    scene: str
    agents: int
    planned: float
    planned_seconds: float
    improved: float
    improve_seconds: float
    moves: int
    accepted: int
    certified: bool
    file: Path

    def entries(self) -> list[Entry]:
        """What a ledger may take: the cheaper plan, where it is certified."""
        if not self.certified:
            return []
        solve = f"stplan solve {self.file.as_posix()}"
        command = solve if self.accepted == 0 else f"{solve} --improve {self.moves}"
        return [Entry(self.scene, self.improved, command)]


def measure(files: dict[str, Path], moves: int, *, progress: Progress) -> list[Quality]:
    """Every scene planned by default, and improved by so many moves."""
    warm_up()
    found = []
    for name, file in files.items():
        found.append(_measured(name, file, moves))
        one = found[-1]
        progress(
            f"{name}: {one.planned:.6g} in {one.planned_seconds:.1f} s, "
            f"{one.improved:.6g} after {moves} moves in {one.improve_seconds:.1f} s"
        )
    return found


def _measured(name: str, file: Path, moves: int) -> Quality:
    scene = load_scene(file)
    began = time.process_time()
    planned = plan(scene)
    between = time.process_time()
    improved = improve(planned, ImprovementBudget(moves=moves))
    ended = time.process_time()
    before, after = (plan_cost(scene, one) for one in (planned, improved))
    record = improved.report.improvement
    return Quality(
        scene=name,
        agents=len(scene.agents),
        planned=before,
        planned_seconds=between - began,
        improved=after,
        improve_seconds=ended - between,
        moves=moves,
        accepted=0 if record is None else record.accepted,
        certified=planned.certificate.holds and improved.certificate.holds,
        file=file,
    )
