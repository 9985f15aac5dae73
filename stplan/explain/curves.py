"""What there is to say of curves: what is tight, who waits, who is late, who goes further than alone."""

from __future__ import annotations

from collections.abc import Sequence

from stplan.amounts import distinct
from stplan.analysis.crowd import Crowd
from stplan.analysis.detours import LONGER, Detour, detours
from stplan.analysis.lateness import Late, late_agents, timed
from stplan.analysis.tightness import TIGHT, TightSpot, certified_spots, tightest
from stplan.analysis.waiting import Wait, waits
from stplan.arrays import FloatArray
from stplan.certify.certificate import Certificate
from stplan.certify.meetings import MeetingSpot
from stplan.certify.motion import Peak
from stplan.explain.explanation import Fact, Section
from stplan.wording import at, count, metres


def curve_sections(
    crowd: Crowd, certificate: Certificate, alone: Sequence[FloatArray | None]
) -> list[Section]:
    """Everything that is worth saying of the crowd's curves, which have sound ends.

    Args:
        certificate: of these curves.
        alone: the way of every agent without the others.
    """
    found = waits(crowd)
    pairs, walls = certified_spots(crowd, certificate)
    return [
        pair_section(pairs, certificate.num_pairs),
        wall_section(walls),
        *limit_sections(certificate),
        waiting_section(found, crowd.num_agents),
        lateness_section(crowd, found),
        detour_section(crowd, alone),
    ]


def pair_section(spots: Sequence[TightSpot], num_pairs: int) -> Section:
    """Pairs that come close to the distance they keep, the tightest first, of `num_pairs` in all."""
    what = count(num_pairs, "pair") + " that may not touch"
    return _tight("pairs", "Between agents", spots, what, "No two agents have to keep apart.")


def wall_section(spots: Sequence[TightSpot]) -> Section:
    """Agents that come close to a wall, the tightest first."""
    what = count(len(spots), "agent") + " that may not touch walls"
    return _tight("walls", "To the walls", spots, what, "No agent has walls to mind.")


def _tight(key: str, title: str, spots: Sequence[TightSpot], what: str, nothing: str) -> Section:
    if not spots:
        return Section(key, title, nothing)
    tight = tightest(spots)
    if not tight:
        least = min(spots, key=lambda spot: spot.share)
        lead = f"Nothing is tight among {what}; the least room is:"
        return Section(key, title, lead, [_spot(least)])
    closer = (
        f"{'leave' if len(tight) > 1 else 'leaves'} less than {TIGHT:.0%} of the distance to keep"
    )
    return Section(key, title, f"{len(tight)} of {what} {closer}:", [*map(_spot, tight)])


def _spot(spot: TightSpot) -> Fact:
    names = " and ".join(spot.who)
    where = f"at t = {spot.time:.2f} s near {at(spot.place)}"
    keep = metres(spot.needed)
    if spot.clearance <= 0:
        over = metres(-spot.clearance)
        return Fact(f"{names}: {over} too near {where}, where {keep} have to be kept", spot)
    beyond = f"its radius of {keep}" if len(spot.who) == 1 else f"their {keep}"
    room = f"{metres(spot.clearance)} to spare beyond {beyond}"
    return Fact(f"{names}: {room}, {where}", spot)


def limit_sections(certificate: Certificate) -> list[Section]:
    """Limits of motion that are used up, and meetings; no section for a scene without."""
    sections = []
    if certificate.limits:
        near = [peak for peak in certificate.limits if peak.reached > (1 - TIGHT) * peak.allowed]
        near.sort(key=lambda peak: -peak.reached / peak.allowed)
        lead = f"{len(near)} of {count(len(certificate.limits), 'limit')} of motion are used up"
        lead += f" to within {TIGHT:.0%}{':' if near else '.'}"
        sections.append(Section("limits", "Limits", lead, [*map(_peak, near)]))
    if certificate.meetings:
        met = [meeting for meeting in certificate.meetings if meeting.holds]
        verb = "takes" if len(met) == 1 else "take"
        lead = f"{len(met)} of {count(len(certificate.meetings), 'meeting')} {verb} place"
        lead += ":" if met else "."
        sections.append(Section("meetings", "Meetings", lead, [*map(_meeting, met)]))
    return sections


def _peak(peak: Peak) -> Fact:
    unit = "m/s" if peak.limit == "speed" else "m/s2"
    reached, allowed = distinct(peak.reached, peak.allowed, digits=3)
    return Fact(
        f"{peak.agent}: {peak.limit} {reached} of {allowed} {unit}, at t = {peak.time:.2f} s",
        peak,
    )


def _meeting(meeting: MeetingSpot) -> Fact:
    return Fact(
        f"{' and '.join(meeting.who)} meet at t = {meeting.time:.2f} s near {at(meeting.place)}, "
        f"{metres(meeting.distance)} apart of at most {metres(meeting.within)}",
        meeting,
    )


def waiting_section(found: Sequence[Wait], num_agents: int) -> Section:
    """The waits, and who is waited for most."""
    if not found:
        return Section("waits", "Waiting", "Nobody waits or holds back for anybody.")
    lost: dict[str, list[float]] = {}
    for wait in found:
        if wait.meeting is not None:
            lost.setdefault(wait.meeting.agent, []).append(wait.lost)
    slow = len({wait.agent for wait in found})
    verb = "wait or hold back" if slow > 1 else "waits or holds back"
    lead = f"{slow} of {count(num_agents, 'agent')} {verb}"
    if lost:
        most = max(lost, key=lambda name: sum(lost[name]))
        lead += f"; {most} is waited for most, {sum(lost[most]):.1f} s in all"
    return Section("waits", "Waiting", f"{lead}:", [*map(_wait, found)])


def _wait(wait: Wait) -> Fact:
    still = wait.speed < 0.02 * wait.pace
    how = "stands still" if still else f"goes at {wait.speed:.2g} m/s"
    when = f"from t = {wait.begin:.2f} to {wait.end:.2f} s near {at(wait.place)}"
    cost = f"which costs it {wait.lost:.2f} s at its mean pace of {wait.pace:.2g} m/s"
    met = wait.meeting
    if met is None:
        nobody = "nobody is in its way then, it has time"
        return Fact(f"{wait.agent} {how} {when}, {cost}; {nobody}", wait)
    verb = "waits" if wait.is_wait else "holds back"
    return Fact(
        f"{wait.agent} {verb} for {met.agent}: it {how} {when}, {cost}; going on, it would have been "
        f"{metres(met.overlap)} too near at t = {met.time:.2f} s, {at(met.place)}",
        wait,
    )


def lateness_section(crowd: Crowd, found: Sequence[Wait]) -> Section:
    """Late agents, the latest first."""
    title, total = "Arrivals", len(timed(crowd))
    if not total:
        return Section("late", title, "No agent has a preferred time.")
    late = late_agents(crowd, found)
    if not late:
        return Section("late", title, f"All {total} agents with a preferred time keep it.")
    lead = f"{len(late)} of {total} agents with a preferred time are late:"
    return Section("late", title, lead, [*map(_late, late)])


def _late(late: Late) -> Fact:
    waited = f"; waiting cost it {late.waited:.2f} s" if late.waited > 0 else ""
    return Fact(
        f"{late.agent} arrives at t = {late.arrival:.2f} s, {late.arrival - late.preferred:.2f} s "
        f"later than the {late.preferred:g} s it prefers{waited}",
        late,
    )


def detour_section(crowd: Crowd, alone: Sequence[FloatArray | None]) -> Section:
    """Detours of agents that find their own way, the longest first."""
    title, found = "Detours", detours(crowd, alone)
    if not found:
        return Section("detours", title, f"Nobody goes more than {LONGER:.0%} further than alone.")
    total = sum(detour.length - detour.alone for detour in found)
    able = int((~crowd.prescribed).sum())
    lead = f"{len(found)} of {able} agents go further than alone, {total:.2f} m in all:"
    return Section("detours", title, lead, [*map(_detour, found)])


def _detour(detour: Detour) -> Fact:
    more = detour.length - detour.alone
    share = f" ({more / detour.alone:.0%})" if detour.alone > 0 else ""
    return Fact(
        f"{detour.agent} goes {detour.length:.2f} m, {more:.2f} m{share} more than its shortest way "
        "alone",
        detour,
    )
