"""Groups and pairs of a file -> rules over indices of agents, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

from stplan.scene.format.file import GroupFile, MeetFile, PairFile, PairSettingsFile
from stplan.scene.model import Agent, Meet, PairRule, Scene
from stplan.scene.reading.faults import Fault, Hints

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
            text = "changes nothing; distance, grouping, collide, meet or a name is expected"
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
) -> list[Placed]:
    """One rule an entry of `pairs`."""
    everyone = tuple(range(num_agents))
    rules = []
    for k, entry in enumerate(pairs):
        if entry is None:
            continue
        path = f"pairs[{k}]"
        sides: list[tuple[int, ...]] = []
        for s, side in enumerate(entry.between):
            words = side if isinstance(side, list) else [side]
            known = [word for word in words if word != "all"]
            place = f"{path}.between[{s}]"
            members = _members(known, place, names, all_known, faults, hints)
            sides.append(everyone if "all" in words else members)
        left, right = sides
        if len(left) == 1 and left == right:
            faults.append((f"{path}.between", "is an agent and itself; two agents are expected"))
        if not _changes(entry):
            faults.append((path, "changes nothing; distance, grouping or collide is expected"))
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
    return PairRule(left, right, entry.distance, entry.grouping, entry.collide, meet)


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
    faults = []
    sets = [(set(rule.left), set(rule.right)) for rule in scene.pairs]
    for path, rule in zip(paths, scene.pairs, strict=True):
        if rule.meet is None:
            continue
        for a, b in product(rule.left, rule.right):
            fault = "" if a == b else _meeting_fault(scene, sets, a, b, rule.meet)
            if fault:
                faults.append((f"{path}.meet", fault))
                break
    return faults


def _meeting_fault(
    scene: Scene, sets: Sequence[tuple[set[int], set[int]]], a: int, b: int, meet: Meet
) -> str:
    first, second = scene.agents[a], scene.agents[b]
    names = f"'{first.id}' and '{second.id}'"
    distance = first.radius + second.radius
    collide = first.weights.collision > 0 or second.weights.collision > 0
    for rule, (left, right) in zip(scene.pairs, sets, strict=True):
        if (a in left and b in right) or (b in left and a in right):
            distance = rule.distance if rule.distance is not None else distance
            collide = collide and rule.collide is not False
    if collide and meet.within <= distance:
        return (
            f"{names} meet within {meet.within:g} m, but keep {distance:g} m apart; "
            "a larger `within` is expected"
        )
    begin = max(first.start_time, second.start_time)
    end = min(_leaves(scene, first), _leaves(scene, second))
    if meet.window is not None:
        begin, end = max(begin, meet.window[0]), min(end, meet.window[1])
    return "" if begin <= end else f"{names} are never both present in time for it"


def _leaves(scene: Scene, agent: Agent) -> float:
    return scene.final_time if agent.after_arrival == "stay" else agent.max_time
