"""Groups and pairs of a file -> rules over indices of agents, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from stplan.amounts import distinct
from stplan.scene.format.file import GroupFile, MeetFile, PairFile, PairSettingsFile
from stplan.scene.format.places import PlacedAgentsFile
from stplan.scene.interactions import PairSettings
from stplan.scene.model import Meet, PairRule, Scene
from stplan.scene.presence import present_until
from stplan.scene.reading.faults import Hints
from stplan.scene.reading.residents import Residents
from stplan.schema.mapping import Fault

_KEYS = "one of distance, grouping, collision, clearance, collide, meet"
# More meetings than this are a mistake: every one is a constraint of its own.
MOST_MEETINGS = 10_000

Names = Mapping[str, tuple[int, ...]]


class Placed(NamedTuple):
    """A rule and where it stands in the file."""

    path: str
    rule: PairRule


def group_rules(
    groups: Sequence[GroupFile | None],
    names: dict[str, tuple[int, ...]],
    all_known: bool,
    faults: list[Fault],
    hints: Hints,
) -> list[Placed]:
    """One rule a group with settings; names of groups are added to `names`.

    Args:
        names: indices of the agents that an id, a pattern's or a table's id stands for.
        all_known: whether every agent's id could be read.
    """
    rules = []
    for k, group in enumerate(groups):
        if group is None:
            continue
        path = f"groups[{k}]"
        members = _members(group.members, f"{path}.members", names, all_known, faults, hints)
        if len(members) < 2 and all(word in names for word in group.members):
            faults.append((f"{path}.members", "name fewer than two agents; two are expected"))
        if group.name is not None:
            if group.name == "all" or group.name in names:
                text = f"is '{group.name}', which means other agents already; another is expected"
                faults.append((f"{path}.name", text))
            else:
                names[group.name] = members
        elif not _changes(group):
            text = f"changes nothing; {_KEYS} or a name is expected"
            faults.append((path, text))
        if _changes(group):
            rules.append(Placed(path, _rule(members, members, group, f"{path}.meet", faults)))
    return rules


def pair_rules(
    pairs: Sequence[PairFile | None],
    names: Names,
    num_agents: int,
    all_known: bool,
    faults: list[Fault],
    hints: Hints,
    residents: Residents,
) -> list[Placed]:
    """One rule an entry of `pairs`; `residents` knows who starts and ends where."""
    everyone = tuple(range(num_agents))
    rules = []
    for k, entry in enumerate(pairs):
        if entry is None:
            continue
        path = f"pairs[{k}]"
        sides: list[tuple[int, ...]] = []
        for s, side in enumerate(entry.between):
            place = f"{path}.between[{s}]"
            if isinstance(side, PlacedAgentsFile):
                sides.append(residents.of(side, place, all_known, faults, hints))
                continue
            words = side if isinstance(side, list) else [side]
            known = [word for word in words if word != "all"]
            members = _members(known, place, names, all_known, faults, hints)
            sides.append(everyone if "all" in words else members)
        left, right = sides
        if len(left) == 1 and left == right:
            faults.append((f"{path}.between", "is an agent and itself; two agents are expected"))
        if not _changes(entry):
            faults.append(
                (
                    path,
                    f"changes nothing; {_KEYS} is expected",
                )
            )
        rules.append(Placed(path, _rule(left, right, entry, f"{path}.meet", faults)))
    return rules


def _members(
    words: Sequence[str],
    path: str,
    names: Names,
    all_known: bool,
    faults: list[Fault],
    hints: Hints,
) -> tuple[int, ...]:
    # Of an agent whose id could not be read nothing is known, perhaps it is the one that is meant.
    for word in words:
        if word not in names and all_known:
            faults.append((path, f"there is no agent '{word}'{hints(word, names)}"))
    return tuple(dict.fromkeys(index for word in words for index in names.get(word, ())))


def _changes(entry: PairSettingsFile) -> bool:
    return any(getattr(entry, key) is not None for key in PairSettingsFile.model_fields)


def _rule(
    left: tuple[int, ...],
    right: tuple[int, ...],
    entry: PairSettingsFile,
    path: str,
    faults: list[Fault],
) -> PairRule:
    meet = None if entry.meet is None else _meet(entry.meet, path, faults)
    if meet is not None and len(left) * len(right) > MOST_MEETINGS:
        text = f"is asked of {len(left) * len(right)} pairs; at most {MOST_MEETINGS} are expected"
        faults.append((path, text))
        meet = None
    return PairRule(
        left,
        right,
        entry.distance,
        entry.grouping,
        entry.collide,
        meet,
        entry.collision,
        entry.clearance,
    )


def _meet(entry: MeetFile, path: str, faults: list[Fault]) -> Meet:
    if entry.window is None:
        return Meet(entry.within)
    begin, end = entry.window
    if begin >= end:
        text = f"reaches from {begin:g} s to {end:g} s; a later end is expected"
        faults.append((f"{path}.window", text))
    return Meet(entry.within, (begin, end))


def meeting_faults(scene: Scene, paths: Sequence[str]) -> list[Fault]:
    """Meetings that cannot be: nearer than the pair may come, or never present together.

    `paths` say where the scene's rules stand.
    """
    if all(rule.meet is None for rule in scene.pairs):
        return []
    settings = PairSettings(scene)
    starts = np.array([agent.start_time for agent in scene.agents])
    stays = np.array([agent.after_arrival == "stay" for agent in scene.agents])
    latest = np.array([agent.max_time for agent in scene.agents])
    ends = present_until(stays, latest, scene.final_time)
    faults = []
    for path, rule in zip(paths, scene.pairs, strict=True):
        if rule.meet is None:
            continue
        rows, columns = np.array(rule.left, dtype=np.int64), np.array(rule.right, dtype=np.int64)
        pairs = settings.between(rows, columns)
        near = pairs.collides & (rule.meet.within <= pairs.distance)
        begin = np.maximum.outer(starts[rows], starts[columns])
        end = np.minimum.outer(ends[rows], ends[columns])
        if rule.meet.window is not None:
            begin = np.maximum(begin, rule.meet.window[0])
            end = np.minimum(end, rule.meet.window[1])
        wrong = np.argwhere((near | (begin > end)) & (rows[:, None] != columns[None, :]))
        if not len(wrong):
            continue
        row, column = wrong[0]
        first, second = scene.agents[rows[row]].id, scene.agents[columns[column]].id
        text = f"'{first}' and '{second}' are never both present in time for it"
        if near[row, column]:
            within, apart = distinct(rule.meet.within, float(pairs.distance[row, column]))
            text = (
                f"'{first}' and '{second}' meet within {within} m, but keep more than {apart} m apart; "
                "a larger `within` is expected"
            )
        faults.append((f"{path}.meet", text))
    return faults
