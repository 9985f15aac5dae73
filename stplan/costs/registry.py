"""The terms there are: every module of `stplan.costs.terms` registers its own, and nobody else knows them."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
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


_Registered = TypeVar("_Registered", bound=type[BuiltTerm])
_ranks: dict[type[BuiltTerm], int] = {}


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


def build_terms(setup: TermSetup, wanted: Capability | None = None) -> tuple[BuiltTerm, ...]:
    """The terms that the scene has a use for, of those with all that is `wanted`."""
    built = (
        term.build(setup)
        for term in registered_terms()
        if wanted is None or wanted in term.capabilities
    )
    return tuple(term for term in built if term is not None)
