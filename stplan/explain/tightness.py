"""What is tight: the pairs and the walls that leave least room, from the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stplan.certify.certificate import Certificate, Tightest
from stplan.explain.explanation import Section, at, count, metres
from stplan.scene.interactions import scene_interactions
from stplan.scene.model import Scene

# A clearance is tight below this share of the distance that is kept.
TIGHT = 0.1


@dataclass(frozen=True)
class TightSpot:
    """A least clearance (m) of two agents, or of one and the walls (m, s).

    Attributes:
        needed: the distance of centres, or to the wall, that has to be kept.
    """

    who: tuple[str, ...]
    clearance: float
    needed: float
    time: float
    place: tuple[float, float]

    @property
    def share(self) -> float:
        """The clearance as a share of what is needed."""
        return self.clearance / self.needed

    def sentence(self) -> str:
        """In words."""
        names = " and ".join(self.who)
        where = f"at t = {self.time:.2f} s near {at(self.place)}"
        keep = metres(self.needed)
        if self.clearance <= 0:
            over = metres(-self.clearance)
            return f"{names}: {over} too near {where}, where {keep} have to be kept"
        beyond = f"its radius of {keep}" if len(self.who) == 1 else f"their {keep}"
        room = f"{metres(self.clearance)} to spare beyond {beyond}"
        return f"{names}: {room}, {where}"


def tight_pairs(scene: Scene, certificate: Certificate) -> Section:
    """Pairs that come close to their comfort distance, the tightest first."""
    place = {agent.id: a for a, agent in enumerate(scene.agents)}
    distance = scene_interactions(scene).distance
    spots = [
        _spot(spot, float(distance[place[spot.who[0]], place[spot.who[1]]]))
        for spot in certificate.pairs
    ]
    what = count(len(spots), "pair") + " that may not touch"
    return _section("pairs", "Between agents", spots, what, "no two agents have to keep apart")


def tight_walls(scene: Scene, certificate: Certificate) -> Section:
    """Agents that come close to a wall, the tightest first."""
    radius = {agent.id: agent.radius for agent in scene.agents}
    spots = [_spot(spot, radius[spot.who[0]]) for spot in certificate.walls]
    what = count(len(spots), "agent") + " that may not touch walls"
    return _section("walls", "To the walls", spots, what, "no agent has walls to mind")


@dataclass(frozen=True)
class NearLimit:
    """How near an agent comes to a limit of its motion, and when (s)."""

    agent: str
    limit: str
    allowed: float
    reached: float
    time: float

    def sentence(self) -> str:
        """In words."""
        unit = "m/s" if self.limit == "speed" else "m/s2"
        return (
            f"{self.agent}: {self.limit} {self.reached:.3g} of {self.allowed:.3g} {unit}, "
            f"at t = {self.time:.2f} s"
        )


@dataclass(frozen=True)
class NearMeeting:
    """How near two agents that have to meet come, m, s."""

    who: tuple[str, str]
    within: float
    distance: float
    time: float
    place: tuple[float, float]

    def sentence(self) -> str:
        """In words."""
        return (
            f"{' and '.join(self.who)} meet at t = {self.time:.2f} s near {at(self.place)}, "
            f"{metres(self.distance)} apart of at most {metres(self.within)}"
        )


def limits_and_meetings(certificate: Certificate) -> list[Section]:
    """Limits of motion that are used up, and meetings; no section for a scene without."""
    sections = []
    if certificate.limits:
        facts = [NearLimit(p.agent, p.limit, p.allowed, p.reached, p.time)
                 for p in certificate.limits if p.reached > (1 - TIGHT) * p.allowed]  # fmt: skip
        facts.sort(key=lambda fact: -fact.reached / fact.allowed)
        lead = f"{len(facts)} of {count(len(certificate.limits), 'limit')} of motion are used up"
        sections.append(
            Section(
                "limits", "Limits", f"{lead} to within {TIGHT:.0%}{':' if facts else '.'}", facts
            )
        )
    if certificate.meetings:
        met = [NearMeeting(m.who, m.within, m.distance, m.time, m.place)
               for m in certificate.meetings if m.holds]  # fmt: skip
        verb = "takes" if len(met) == 1 else "take"
        lead = f"{len(met)} of {count(len(certificate.meetings), 'meeting')} {verb} place"
        sections.append(Section("meetings", "Meetings", lead + (":" if met else "."), met))
    return sections


def _spot(spot: Tightest, needed: float) -> TightSpot:
    return TightSpot(spot.who, spot.clearance, needed, spot.time, spot.place)


def _section(key: str, title: str, spots: Sequence[TightSpot], what: str, nothing: str) -> Section:
    if not spots:
        return Section(key, title, nothing.capitalize() + ".")
    spots = sorted(spots, key=lambda spot: spot.share)
    tight = [spot for spot in spots if spot.share < TIGHT]
    if not tight:
        return Section(key, title, f"Nothing is tight among {what}; the least room is:", spots[:1])
    closer = (
        f"{'leave' if len(tight) > 1 else 'leaves'} less than {TIGHT:.0%} of the distance to keep"
    )
    return Section(key, title, f"{len(tight)} of {what} {closer}:", tight)
