"""An explanation: titled sections of facts, each with a sentence for people and figures for programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

# So many facts of a section are said unless all are asked for.
FEW = 5


@dataclass(frozen=True)
class Fact:
    """Something worth saying.

    Attributes:
        sentence: in words.
        figures: a dataclass of the same in figures, None where the sentence is all there is.
    """

    sentence: str
    figures: Any = None

    def as_dict(self) -> dict[str, Any]:
        """For JSON: lengths in m, times in s."""
        return {"sentence": self.sentence, **({} if self.figures is None else asdict(self.figures))}


@dataclass(frozen=True)
class Section:
    """Facts of one kind, the most important first.

    Attributes:
        key: names the section in JSON.
        title: names it for people.
        lead: what all facts have in common, or that there are none; may be empty.
    """

    key: str
    title: str
    lead: str
    facts: Sequence[Fact] = ()

    def lines(self, few: int | None) -> list[str]:
        """The section as text; `few` facts of it, None for all."""
        lines = [self.title, *([f"  {self.lead}"] if self.lead else [])]
        said = self.facts[:few]
        lines += [f"  - {fact.sentence}" for fact in said]
        left = len(self.facts) - len(said)
        return [*lines, f"  and {left} more; --all lists them"] if left > 0 else lines

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"summary": self.lead, "facts": [fact.as_dict() for fact in self.facts]}


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
