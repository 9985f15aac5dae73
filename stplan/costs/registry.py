"""The terms there are: every module of `stplan.costs.terms` registers its own, and nobody else knows them.

Users add some of their own for as long as they like (`added_costs`).
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from typing import Protocol, Self, TypeVar

from stplan.costs.formulation import TermSetup
from stplan.nlp.term import Capability, Term


class BuiltTerm(Term, Protocol):
    """A term that builds itself."""

    @classmethod
    def build(cls, setup: TermSetup) -> Self | None:
        """The term of a program, None where the scene has no use for it."""
        ...


class TermSource(Protocol):
    """What builds a term: a class that builds itself, or an object that knows how."""

    @property
    def name(self) -> str:
        """Of the terms it builds."""
        ...

    @property
    def capabilities(self) -> Capability:
        """What they are to others."""
        ...

    def build(self, setup: TermSetup) -> Term | None:
        """The term of a program, None where the scene has no use for it."""
        ...


_Registered = TypeVar("_Registered", bound=type[BuiltTerm])
_ranks: dict[type[BuiltTerm], int] = {}
_added: ContextVar[tuple[TermSource, ...]] = ContextVar("added", default=())


def register(rank: int) -> Callable[[_Registered], _Registered]:
    """Add a term to those a program is built of, summed in the order of their ranks."""

    def add(term: _Registered) -> _Registered:
        _ranks[term] = rank
        return term

    return add


@cache
def registered_terms() -> tuple[type[BuiltTerm], ...]:
    """All terms in their fixed order."""
    package = importlib.import_module("stplan.costs.terms")
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{package.__name__}.{module.name}")
    return tuple(sorted(_ranks, key=lambda term: (_ranks[term], term.name)))


@contextmanager
def added_costs(*costs: TermSource) -> Iterator[None]:
    """Within, programs sum `costs` too, after those of the scene.

    What is optimised and how the improvement of plans compares heeds them. The choice among initial curves,
    the bound on costs, and the processes of `stplan batch` do not know them.

    Raises:
        ValueError: a name is taken.
    """
    names = [term.name for term in registered_terms()] + [one.name for one in _added.get()]
    for cost in costs:
        if cost.name in names:
            raise ValueError(f"{cost.name!r} is the name of another cost")
        names.append(cost.name)
    token = _added.set((*_added.get(), *costs))
    try:
        yield
    finally:
        _added.reset(token)


def build_terms(setup: TermSetup, wanted: Capability | None = None) -> tuple[Term, ...]:
    """The terms that the scene has a use for, of those with all that is `wanted`."""
    sources: tuple[TermSource, ...] = (*registered_terms(), *_added.get())
    built = (
        source.build(setup) for source in sources if wanted is None or wanted in source.capabilities
    )
    return tuple(term for term in built if term is not None)
