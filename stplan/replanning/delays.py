"""Plans in which any one agent may be late: nobody is in the way of prescribed motion just before it comes.

Where all keep the order of passing, whoever comes later waits. Only prescribed motion cannot. So a plan
survives a delay just where everybody is off a spot for so long before a prescribed motion gets there
(`longest_delay`). To plan for that, a prescribed motion is preceded by copies of itself, earlier by up to the
delay, which keep their distance like itself: their rods fill the part of space-time that has to be free.
Each stands for the moments until half a step s before and after its own: at a speed v, whatever is within R
of a place of these is within R + v s / 2 of the copy. Copies are among what the costs were weighed with.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from stplan.amounts import amount
from stplan.analysis.precedence import Precedence, longest_delay, precedence
from stplan.analysis.robustness import robustness
from stplan.arrays import FloatArray
from stplan.callbacks import Progress, Stop
from stplan.errors import SeedingError, StoppedError
from stplan.planned import Plan
from stplan.replanning.stand_ins import StandIns, as_planned, first_lines, with_stand_ins
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Robust, Scene
from stplan.status import Status

# Plans that are tried at most, beside the one that does not know of the delay.
TRIALS = 4
# Each may search for initial curves for this share of the time limit.
SEARCH = 0.25
# Where a plan survives less than was left free, so many times what is missing is added, and this share.
MORE, SPARE = 1.5, 0.01
# Copies are so far apart at most, as a share of the least distance that is kept from them.
SPACING = 0.2


def forgiving(scene: Scene, plan: Callable[[Scene], Plan], progress: Progress, stop: Stop) -> Plan:
    """The plan of `scene`, which has no changes, that survives its `robust` delay, or else the longest.

    Raises like `plan`, a maker of plans.
    """
    best, asked = plan(scene), scene.robust.delay
    if not asked:
        return judged(best)
    order = precedence(best.scene, best.trajectories or best.seed)
    survived, too_much = longest_delay(order), np.inf
    ahead, late = asked, _unwaiting(order, asked)
    for _ in range(TRIALS):
        if survived >= asked or not late or stop():
            break
        progress(
            f"a stop of {amount(survived)} s of {amount(asked)} s is survived; "
            f"planning with {amount(ahead)} s free ahead of {', '.join(sorted(late))}"
        )
        try:
            found = _among_copies(scene, late, ahead, plan)
        except StoppedError:
            break
        except SeedingError:
            too_much = ahead
            ahead = 0.5 * (min(survived, ahead) + too_much)
            continue
        order = precedence(found.scene, found.trajectories or found.seed)
        proven, known = longest_delay(order), len(late)
        late |= _unwaiting(order, asked)
        if proven > survived:
            best, survived = found, proven
        if len(late) == known:
            more = MORE * (asked - proven) + SPARE * asked
            ahead = min(ahead + more, 0.5 * (ahead + too_much))
    return judged(best)


def judged(plan: Plan) -> Plan:
    """`plan` with what it forgives in its report, where its scene asks for that."""
    asked = plan.scene.robust
    if plan.trajectories is None or asked == Robust():
        return plan
    found = robustness(plan.scene, plan.trajectories)
    content = replace(plan.report, robustness=found)
    if not found.holds and not plan.status.exit_status:
        content = replace(content, status=Status.FRAGILE)
    return replace(plan, report=content)


def with_copies_ahead(scene: Scene, late: Collection[str], ahead: float) -> Scene:
    """`scene` in which each of the prescribed agents `late` has copies of itself up to `ahead` s before it.

    They come after all others, keep as far from those who find their way as it does, and cost nothing.
    """
    settings, everyone = PairSettings(scene), np.arange(len(scene.agents))
    free = np.array([agent.path is None for agent in scene.agents])
    groups = []
    for a, agent in enumerate(scene.agents):
        if agent.id not in late or agent.path is None:
            continue
        pairs = settings.between(np.array([a]), everyone)
        least = float(pairs.distance[0][pairs.collides[0] & free].min())
        path = np.array(agent.path)
        reach = ahead * _fastest(path)
        number = max(int(np.ceil(reach / (SPACING * least))), 1)
        earlier = ahead * (np.arange(number) + 0.5) / number
        paths = [path - [0.0, 0.0, shift] for shift in earlier.tolist()]
        groups.append(StandIns(a, paths, free, 0.5 * reach / number))
    return with_stand_ins(scene, groups)


def _fastest(path: FloatArray) -> float:
    """The greatest speed of a curve (n, 3), m/s."""
    step = np.diff(path, axis=0)
    return float((np.hypot(step[:, 0], step[:, 1]) / step[:, 2]).max())


def _among_copies(
    scene: Scene, late: Collection[str], ahead: float, plan: Callable[[Scene], Plan]
) -> Plan:
    """A plan of `scene` found with copies ahead of those who may be `late`. Raises like `plan`."""
    seeding = replace(scene.seeding, time_limit=SEARCH * scene.seeding.time_limit)
    given = with_copies_ahead(replace(scene, seeding=seeding), late, ahead)
    found = plan(given)
    count = len(scene.agents)
    lines = None if found.trajectories is None else first_lines(found.trajectories, count)
    return as_planned(scene, found, first_lines(found.seed, count), lines)


def _unwaiting(order: Precedence, delay: float) -> frozenset[str]:
    """Prescribed agents that would have to wait where somebody stops for `delay` s."""
    return frozenset(
        one.second
        for one in order.passings
        if one.second in order.fixed and one.first not in order.fixed and one.slack < delay
    )
