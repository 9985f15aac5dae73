"""What collision, wall and grouping share: contacts, weighed by a potential, scattered into blocks.

A term is a pure function of the knots. Its contact set makes asking cheap where it is complete; elsewhere
the answer is the same from a fresh set, so nothing depends on what was asked before. `renewed` gives the
same term with a set that is complete around other knots, for whoever walks there.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from stplan.arrays import BoolArray, FloatArray, IntArray
from stplan.costs.contacts.blocks import MISSING, ContactBlocks, DenseCoupling
from stplan.costs.contacts.contact_set import ContactList, ContactSet
from stplan.costs.contacts.potential import Coefficients, Potential
from stplan.geometry.contacts import Measured, add_gradient, add_hessian, measure
from stplan.nlp.term import Capability, Structure, Term

# A contact as soft as this, against the stiffest one, may miss the Hessian for a while: it hardly
# slows the descent, and its value and gradient are exact all the same.
NOTICEABLE = 1e-2


@dataclass(frozen=True)
class ContactModel:
    """What stays the same about a term over contacts.

    Attributes:
        potential: how distances become a cost.
        make_blocks: called for `blocks`, when second derivatives are asked for at last.
        coupling: room for the dense part of the exact Hessian of smooth minima, None without them.
    """

    potential: Potential
    make_blocks: Callable[[], ContactBlocks]
    coupling: DenseCoupling | None = None

    @cached_property
    def blocks(self) -> ContactBlocks:
        """Room for second derivatives."""
        return self.make_blocks()


@dataclass(frozen=True)
class _Evaluated:
    """Contacts at one iterate."""

    knots: FloatArray
    positions: FloatArray
    measured: Measured
    coefficients: Coefficients


class ContactTerm(Term):
    """A term over contacts.

    Args:
        contacts: who is near whom, and around which knots.
        model: everything else.
    """

    def __init__(self, contacts: ContactSet, model: ContactModel) -> None:
        self._contacts = contacts
        self._model = model
        self._latest: _Evaluated | None = None

    @property
    def contacts(self) -> ContactList:
        """The present list, complete around the knots it was made for."""
        return self._contacts.contacts

    def renewed(self, knots: FloatArray) -> Self:
        """The same term with contacts that are complete at `knots`."""
        contacts = self._contacts.renewed(knots)
        if contacts is self._contacts:
            return self
        other = copy(self)
        other._contacts = contacts
        other._latest = None
        other.__dict__.pop("_places", None)
        return other

    def touches(self, knots: FloatArray) -> bool:
        """Whether contacts of the present list touch at `knots`: then no others need be looked for."""
        if Capability.CLEARANCE not in self.capabilities or not self._contacts.moved(knots).any():
            return False
        positions = self._contacts.candidates.positions(knots)
        distance = measure(positions, self.contacts.points).distance
        return self._model.potential.coefficients(distance, self.contacts).least <= 0.0

    def _at(self, knots: FloatArray) -> tuple[Self, _Evaluated]:
        """Contacts that are complete at `knots` and their geometry; the latest are kept."""
        latest = self._latest
        if latest is not None and np.array_equal(latest.knots, knots):
            return self, latest
        term = self.renewed(knots)
        candidates, contacts = term._contacts.candidates, term.contacts
        positions = candidates.positions(knots)
        measured = measure(positions, contacts.points)
        coefficients = self._model.potential.coefficients(measured.distance, contacts)
        term._latest = _Evaluated(knots.copy(), positions, measured, coefficients)
        return term, term._latest

    def measured(self, knots: FloatArray) -> tuple[ContactList, Coefficients]:
        """The contacts that are complete at `knots`, and what they contribute there."""
        term, at = self._at(knots)
        return term.contacts, at.coefficients

    @property
    def _axis_scale(self) -> FloatArray:
        return self._contacts.candidates.axis_scale

    def value(self, knots: FloatArray) -> float:
        """The cost, inf where something touches."""
        return self._at(knots)[1].coefficients.value

    def least_clearance(self, knots: FloatArray) -> float:
        """Smallest clearance that is felt, m; inf where none is."""
        return self._at(knots)[1].coefficients.least

    def unbounded_weight(self, knots: FloatArray) -> float:
        """Summed weight of logarithms without a range."""
        return self._at(knots)[1].coefficients.unbounded

    def gradient(self, knots: FloatArray) -> FloatArray:
        """(M, 3)."""
        term, at = self._at(knots)
        result = np.zeros_like(knots)
        add_gradient(
            term.contacts.points, at.measured, at.coefficients.slope, self._axis_scale, result
        )
        return result

    def hessian_structure(self) -> Structure:
        """Blocks of near knots, then the dense blocks of smooth minima."""
        rows, columns = self._model.blocks.structure()
        if self._model.coupling is None:
            return rows, columns
        more_rows, more_columns = self._model.coupling.structure()
        return np.append(rows, more_rows), np.append(columns, more_columns)

    def hessian(self, knots: FloatArray) -> FloatArray:
        """Exact, except for contacts that miss the structure (see `is_stale`)."""
        term, at = self._at(knots)
        values = term._blocks_values(at, at.coefficients.curvature, exact=True)
        if self._model.coupling is None:
            return values
        dense = self._model.coupling.values(
            term.contacts, at.measured, at.coefficients, self._axis_scale
        )
        return np.concatenate([values, dense])

    def gauss_newton_structure(self) -> Structure:
        """Blocks of near knots."""
        return self._model.blocks.structure()

    def gauss_newton_hessian(self, knots: FloatArray) -> FloatArray:
        """Rank-one terms only: positive semidefinite, and as sparse as the contacts.

        Barriers fall with distance, and distances bend upwards: what is left out is negative, so that
        this is a majorizer.
        """
        term, at = self._at(knots)
        return term._blocks_values(at, at.coefficients.majorizer, exact=False)

    def is_stale(self, knots: FloatArray) -> bool:
        """Whether a contact misses the structure although its curvature matters."""
        term, at = self._at(knots)
        missing: BoolArray = (term._places == MISSING).any(axis=1)
        curvature = at.coefficients.majorizer
        return bool((missing & (curvature > NOTICEABLE * curvature.max(initial=0.0))).any())

    @cached_property
    def _places(self) -> IntArray:
        return self._model.blocks.places(self.contacts)

    def _blocks_values(self, at: _Evaluated, curvature: FloatArray, exact: bool) -> FloatArray:
        values = np.zeros(self._model.blocks.num_values)
        add_hessian(
            at.positions, self.contacts.points, at.measured, at.coefficients.slope, curvature,
            self._axis_scale, exact, self._places, self._model.blocks.dimension, values,
        )  # fmt: skip
        return values
