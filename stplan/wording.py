"""Words: lengths, places and lists as one says them, and reasons why there are no initial curves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from stplan.amounts import amount, distinct
from stplan.amounts import place as in_full
from stplan.reasons import Kind, Reason

# Places nearer to the origin than this (m) are shown in full.
FINE = 0.1
# So many names of a list are said.
FEW_NAMES = 4

# Lengths that differ by less, as a share, are the same but for rounding.
SAME = 1e-12

_LIMITS = ("limits of time", "limit of acceleration")


def names(ids: Sequence[str]) -> str:
    """sam, ann and 3 more."""
    if len(ids) > FEW_NAMES + 1:
        return f"{', '.join(ids[:FEW_NAMES])} and {len(ids) - FEW_NAMES} more"
    return " and ".join(part for part in (", ".join(ids[:-1]), ids[-1]) if part)


def count(number: int, noun: str) -> str:
    """1 agent, 2 agents."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def metres(length: float) -> str:
    """A length (m) as one says it: small ones in millimetres."""
    return f"{amount(1000 * length, 3)} mm" if abs(length) < 0.1 else f"{amount(length, 3)} m"


def at(place: tuple[float, float]) -> str:
    """A place (m) as one says it: to the centimetre, but finer where all is near the origin."""
    x, y = place
    if max(abs(x), abs(y)) < FINE:
        return in_full(x, y)
    return in_full(round(x, 2), round(y, 2))


def in_words(reasons: Sequence[Reason]) -> str:
    """The headline, then a line a reason."""
    return f"{headline(reasons)}: " + "\n  ".join(sentences(reasons))


def headline(reasons: Sequence[Reason]) -> str:
    """What all `reasons` come to: that there are no curves, or only that none were found."""
    if all(reason.kind in _LIMITS for reason in reasons):
        return "no curves keep the limits of the scene"
    if all(reason.proven for reason in reasons):
        return "no collision-free curves exist"
    return "no collision-free initial curves"


def sentences(reasons: Sequence[Reason]) -> list[str]:
    """A sentence for each reason, those that say the same only once."""
    return list(dict.fromkeys(sentence(reason) for reason in reasons))


def sentence(reason: Reason) -> str:
    """One reason in words."""
    return _SENTENCES[reason.kind](reason)


def _names(reason: Reason) -> str:
    """The agents, as a list in words."""
    return " and ".join(reason.agents)


def _start(reason: Reason) -> str:
    text = f"{_names(reason)} start {_too_near(reason, ' in space-time')}"
    if reason.times is not None and reason.times[0] != reason.times[1]:
        text += ", at this time_scale; a larger one keeps their times further apart"
    return text


def _goal(reason: Reason) -> str:
    return f"{_names(reason)} stay on goals {_too_near(reason)}"


def _too_near(reason: Reason, where: str = "") -> str:
    """How far two ends are apart (`where`, if not in the plane), and how far they should be."""
    apart, required = reason.figures["distance"], reason.figures["required"]
    if abs(apart - required) <= SAME * required:
        return f"{amount(required)} m apart{where}, and more than that is needed"
    near, needed = distinct(apart, required)
    return f"{near} m apart{where}, not over {needed} m"


def _not_connected(reason: Reason) -> str:
    figures = reason.figures
    between = "its start, waypoints and goal" if figures["stops"] > 2 else "its start and goal"
    # How far it is across the cracks of a mesh, where nothing else is in the way.
    crack = figures.get("distance", 0.0)
    if crack > 0.0:
        weld = _rounded_up(2 * crack)
        return (
            f"{_names(reason)}: cracks in the mesh up to {amount(crack)} m wide part "
            f"{between}; map.weld: {weld} closes them"
        )
    if figures["widest"] == 0.0:
        return f"{_names(reason)}: {between} lie in separate parts of the map"
    widest, radius = distinct(figures["widest"], figures["radius"], digits=3)
    return (
        f"{_names(reason)}: no way connects {between} at its radius; the widest lets a radius of "
        f"{widest} m through, the agent's is {radius} m"
    )


def _rounded_up(value: float) -> str:
    """The least number of one digit that is not below `value`, above 0."""
    power = math.floor(math.log10(value))
    return amount(math.ceil(value / 10**power) * 10**power, 1)


def _limits_of_time(reason: Reason) -> str:
    figures = reason.figures
    what = "reach its goal"
    if "waypoint" in figures:
        what = f"have visited waypoint {figures['waypoint']:.0f}"
    text = (
        f"{_names(reason)} cannot {what} by {figures['latest']:g} s: "
        f"its way is at least {amount(figures['length'])} m long, and "
    )
    if "speed" in figures:
        text += f"at {figures['speed']:g} m/s "
    return text + f"that takes until {figures['earliest']:.4g} s"


def _limit_of_acceleration(reason: Reason) -> str:
    figures = reason.figures
    return (
        f"{_names(reason)} cannot reach its goal by {figures['latest']:g} s: its way is at least "
        f"{amount(figures['length'])} m long, too long from rest to rest at "
        f"{figures['acceleration']:g} m/s2"
    )


def _no_way(reason: Reason) -> str:
    return f"{_names(reason)}: no shortest way around the walls was found to relax"


def _roadmap(reason: Reason) -> str:
    return _unproven(
        f"{_names(reason)}: no way from start to goal was found that leaves its radius any room "
        "between the walls"
    )


def _mesh(reason: Reason) -> str:
    return _unproven(
        f"{_names(reason)}: no edges of the mesh lead from start to goal clear of the walls; "
        "lower map.resolution"
    )


def _layers(reason: Reason) -> str:
    return _unproven(
        f"{_names(reason)}: {reason.figures['layers']:g} time layers are too few for its way; "
        "raise seeding.layers"
    )


def _order(reason: Reason) -> str:
    return _unproven(
        f"{_names(reason)} found no way past the others in {reason.figures['orders']:g} orders"
    )


def _blocked(reason: Reason) -> str:
    return _unproven(
        f"{_names(reason)} cannot get past each other, whatever detours they take: all their joint "
        f"positions on a roadmap of {reason.figures['vertices']:.0f} points were searched"
    )


def _touching(reason: Reason) -> str:
    if "pairs" in reason.figures:
        return _unproven(
            f"{reason.figures['pairs']:.0f} pairs of {len(reason.agents)} agents touch in the "
            "best curves found"
        )
    text = f"{_names(reason)} still block each other"
    if reason.place is not None and reason.times is not None:
        first, last = reason.times
        text += f" near {at(reason.place)} at {first:.1f} to {last:.1f} s"
    return _unproven(text)


def _walls(reason: Reason) -> str:
    who = _names(reason) or "agents"
    return f"relaxation left {who} too near the walls"


def _not_clear(reason: Reason) -> str:
    return f"{_names(reason)}: initial curves were found but did not stay clear"


def _time_limit(reason: Reason) -> str:
    return f"not found within {reason.figures['limit']:g} s; raise seeding.time_limit to go on"


def _unprepared(reason: Reason) -> str:
    return (
        "clear curves were found, but not shortened and given their knots within "
        f"{reason.figures['limit']:g} s; raise seeding.time_limit to go on"
    )


def _time_scale(reason: Reason) -> str:
    return (
        f"agents go at about {amount(reason.figures['speed'], 2)} m/s, far more than time_scale: one near "
        "that speed lets them follow each other closely"
    )


def _method(reason: Reason) -> str:
    del reason
    return "seeding.method allows one way to look for curves only; auto tries all"


def _margin(reason: Reason) -> str:
    return f"seeding.margin asks for {reason.figures['margin']:g} times the distances; try a smaller one"


def _more_time(reason: Reason) -> str:
    del reason
    return "more time may let them wait for each other: a later horizon, or max_time"


def _unproven(text: str) -> str:
    return f"{text} (not found within the limit)"


_SENTENCES: dict[Kind, Callable[[Reason], str]] = {
    "start": _start,
    "goal": _goal,
    "not connected": _not_connected,
    "limits of time": _limits_of_time,
    "limit of acceleration": _limit_of_acceleration,
    "no way": _no_way,
    "roadmap": _roadmap,
    "mesh": _mesh,
    "layers": _layers,
    "order": _order,
    "blocked": _blocked,
    "touching": _touching,
    "walls": _walls,
    "not clear": _not_clear,
    "time limit": _time_limit,
    "unprepared": _unprepared,
    "time scale": _time_scale,
    "method": _method,
    "margin": _margin,
    "more time": _more_time,
}
