"""An explanation: titled sections of facts, each with a sentence for people and figures for programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

# So many facts of a section are told unless all are asked for.
FEW = 5
# So many names of a group are told.
FEW_NAMES = 4


class Fact(Protocol):
    """Something worth saying; a dataclass, whose fields go into JSON."""

    def sentence(self) -> str:
        """In words."""


@dataclass(frozen=True)
class Remark:
    """A fact that is nothing but its sentence."""

    text: str

    def sentence(self) -> str:
        """In words."""
        return self.text


@dataclass(frozen=True)
class Section:
    """Facts of one kind, the most important first.

    Attributes:
        key: names the section in JSON.
        title: names it for people.
        lead: what all facts have in common, or that there are none.
    """

    key: str
    title: str
    lead: str
    facts: Sequence[Fact] = ()

    def lines(self, few: int | None) -> list[str]:
        """The section as text; `few` facts of it, None for all."""
        lines = [self.title, f"  {self.lead}"]
        told = self.facts[:few]
        lines += [f"  - {fact.sentence()}" for fact in told]
        left = len(self.facts) - len(told)
        return [*lines, f"  and {left} more; --all lists them"] if left > 0 else lines

    def as_dict(self) -> dict[str, Any]:
        """For JSON: lengths in m, times in s."""
        facts = [{"sentence": fact.sentence(), **_fields(fact)} for fact in self.facts]
        return {"summary": self.lead, "facts": facts}


@dataclass(frozen=True)
class Explanation:
    """What is to be said of a scene or a run; `headline` sums it up."""

    headline: str
    sections: tuple[Section, ...]

    def lines(self, *, everything: bool = False) -> list[str]:
        """As text, the few most important facts of every section unless `everything` is wanted."""
        lines = [self.headline]
        for section in self.sections:
            lines += ["", *section.lines(None if everything else FEW)]
        return lines

    def as_dict(self) -> dict[str, Any]:
        """For JSON, complete."""
        sections = {section.key: section.as_dict() for section in self.sections}
        return {"headline": self.headline, "sections": sections}


def _fields(fact: Any) -> dict[str, Any]:
    return {} if isinstance(fact, Remark) else asdict(fact)


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
    return f"{1000 * length:.3g} mm" if abs(length) < 0.1 else f"{length:.3g} m"


def at(place: tuple[float, float]) -> str:
    """A place (m) as one says it."""
    # Adding 0 makes a zero of a negative zero.
    return f"({round(place[0], 2) + 0:g}, {round(place[1], 2) + 0:g})"
