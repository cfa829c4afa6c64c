"""A factored form whose premises are a common denominator and the factors of the numerators.

The inverse of a mass matrix is adj(M)/det(M).  If each of its entries were a premise, the rules
would combine extreme values of entries that do not occur together.  The input matrix of some rules
could then have a determinant of the opposite sign, and no gains would stabilise all rules.  Here
1/det(M) is one premise, and the varying part of adj(M) another.  The entries are products of both,
so that every rule has the inverse of a mass matrix M(z), up to a positive factor.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp

from takagi.models.sector.factored_form import (
    EntryIndex,
    FactoredForm,
    LinearSpan,
    Polynomial,
    scaled_to_first,
)
from takagi.models.sector.terms import Sum, terms_of

INPUTS = ("B", "E")


def denominator_forms(entries: Mapping[EntryIndex, Sum]) -> Iterator[FactoredForm]:
    """Yield the form with denominators and numerator factors as premises, if there is one.

    Every entry is R + N/D with at most one sum D.  The premises are

    1. 1/D for each D;
    2. sums (the varying part of adj(M)), as few as possible, in which the N and R of the input
       matrices are affine;
    3. for the other entries, the factors of N and R that remain after division by the sums of 2:
       one product for each, or single atoms if N has no factors.

    Nothing is yielded if no entry has such a D, or if a term has two of them or a power of one.
    """
    by_place = {position: _parts(value) for position, value in entries.items()}
    if any(numerators is None for numerators in by_place.values()):
        return
    numerators = {
        position: fractions_there
        for position, fractions_there in by_place.items()
        if fractions_there is not None
    }
    if not any(
        base is not None for fractions_there in numerators.values() for base in fractions_there
    ):
        return
    premises = _Premises()
    ordered = sorted(numerators, key=lambda position: position[0] not in INPUTS)
    polynomials: dict[EntryIndex, Polynomial] = {}
    for position in ordered:
        if position[0] in INPUTS:
            for value in numerators[position].values():
                premises.add_moving(value)
    for position in ordered:
        polynomial: Polynomial = {}
        for base, value in numerators[position].items():
            inverse = () if base is None else (premises.inverse(base),)
            for members, c in premises.written(value, moving_only=position[0] in INPUTS).items():
                key = (*inverse, *members)
                polynomial[key] = polynomial.get(key, 0) + c
        polynomials[position] = {members: c for members, c in polynomial.items() if c != 0}
    premises_used = {
        p for polynomial in polynomials.values() for members in polynomial for p in members
    }
    in_order = {position: polynomials[position] for position in entries}
    yield FactoredForm(tuple(p for p in premises.order if p in premises_used), in_order)


def _parts(value: Sum) -> dict[sp.Expr | None, Sum] | None:
    """Return D -> N with value = sum of N/D; the key None has the terms without a sum as divisor.

    None if a term is divided by two sums, or by a power of one: then N is not a polynomial.
    """
    numerators: dict[sp.Expr | None, Sum] = {}
    for atom, c in value.items():
        poles = [p for p in atom.as_ordered_factors() if p.is_Pow and p.base.is_Add and p.exp < 0]
        if len(poles) > 1 or any(power.exp != -1 for power in poles):
            return None
        bases = [power.base for power in poles]
        base = bases[0] if bases else None
        remaining_atom = atom * base if base is not None else atom
        numerator = numerators.setdefault(base, {})
        numerator[remaining_atom] = numerator.get(remaining_atom, 0) + c
    return numerators


@dataclass(slots=True)
class _Premises:
    """The premises chosen up to now, in their order."""

    order: list[sp.Expr] = field(default_factory=list)
    span: LinearSpan = field(default_factory=LinearSpan)
    moving: list[sp.Expr] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.span.add((), {sp.S.One: sp.S.One})

    def _known(self, premise: sp.Expr) -> sp.Expr:
        if premise not in self.order:
            self.order.append(premise)
        return premise

    def inverse(self, base: sp.Expr) -> sp.Expr:
        return self._known(1 / base)

    def add_moving(self, value: Sum) -> None:
        """Add the sum's varying part as a premise, unless it is affine in the present ones."""
        varying = {atom: c for atom, c in value.items() if not atom.is_Rational}
        if varying and self.span.combination(varying) is None:
            scaled = scaled_to_first(varying)
            premise = self._known(sp.Add(*(c * atom for atom, c in scaled.items())))
            self.span.add((premise,), scaled)
            self.moving.append(premise)

    def written(self, value: Sum, *, moving_only: bool) -> Polynomial:
        """Return the sum as a polynomial in premises; missing premises are added."""
        combination = self.span.combination(value)
        if combination is not None:
            return dict(combination)  # type: ignore[arg-type]
        assert not moving_only, "the inputs' sums were added before"
        product = self._in_factors(value)
        return self._in_atoms(value) if product is None else product

    def _in_factors(self, value: Sum) -> Polynomial | None:
        """Return number * (affine in a moving premise) * (one product); None for a single sum."""
        number, factors = _factor_list(sp.Add(*(c * atom for atom, c in value.items())))
        affine: Polynomial = {(): sp.S.One}
        other_factors: list[sp.Expr] = []
        for factor in factors:
            combination = self.span.combination(terms_of(factor))
            if combination is not None and len(affine) == 1:
                affine = dict(combination)  # type: ignore[arg-type]
            else:
                other_factors.append(factor)
        if len(other_factors) == 1 and other_factors[0].is_Add and len(factors) == 1:
            return None
        if not other_factors:
            return {members: number * c for members, c in affine.items()}
        product_premise = self._known(sp.Mul(*other_factors))
        return {(*members, product_premise): number * c for members, c in affine.items()}

    def _in_atoms(self, value: Sum) -> Polynomial:
        """Return the sum with each atom as a premise; no varying premise is used as a factor."""
        polynomial: Polynomial = {}
        for atom, c in value.items():
            if atom.is_Rational:
                members: tuple[sp.Expr, ...] = ()
                number = c * atom
            else:
                number = c
                factors = list(sp.Mul.make_args(atom))
                factor = next((m for m in self.moving if factors.count(m) == 1), None)
                remaining = atom if factor is None else atom / factor
                further_members = () if remaining == 1 else (self._known(remaining),)
                members = further_members if factor is None else (factor, *further_members)
            polynomial[members] = polynomial.get(members, 0) + number
        return polynomial


def _factor_list(expression: sp.Expr) -> tuple[sp.Rational, list[sp.Expr]]:
    """Return (number, factors) of the expression; sin(x)/x is one factor."""
    quotients: dict[sp.Expr, sp.Symbol] = {}

    def whole(term: sp.Expr) -> sp.Expr:
        term_factors = list(sp.Mul.make_args(term))
        for pole in [p for p in term_factors if p.is_Pow and p.base.is_Symbol and p.exp == -1]:
            partner = next(
                (p for p in term_factors if p != pole and p.subs(pole.base, 0) == 0), None
            )
            if partner is not None:
                term_factors.remove(pole)
                term_factors.remove(partner)
                term_factors.append(quotients.setdefault(partner * pole, sp.Dummy()))
        return sp.Mul(*term_factors)

    flat = sp.Add(*(whole(term) for term in sp.Add.make_args(expression)))
    back = {symbol: quotient for quotient, symbol in quotients.items()}
    number, powers = sp.factor_list(flat)
    factors = [base.xreplace(back) for base, exponent in powers for _ in range(int(exponent))]
    return number, factors


def sum_quotients(rows: Sequence[sp.Expr], states: Sequence[sp.Symbol]) -> dict[sp.Symbol, sp.Expr]:
    """Return f(s)/s for the functions f of sums s = a x + b y + ... with f(0) = 0 in the rows.

    sin(x + y) vanishes neither with x nor with y alone, so that it belongs to no state; as
    z (x + y) with z = sin(x + y)/(x + y) it goes to both.
    """
    quotients: dict[sp.Symbol, sp.Expr] = {}
    functions: set[sp.Expr] = set()
    for row in rows:
        for function in sorted(row.atoms(sp.Function), key=sp.default_sort_key):
            if function in functions or len(function.args) != 1:
                continue
            functions.add(function)
            argument = sp.expand(function.args[0])
            symbols = argument.free_symbols
            if (
                len(symbols) < 2
                or not symbols <= set(states)
                or not argument.is_polynomial(*symbols)
            ):
                continue
            polynomial = sp.Poly(argument, *sorted(symbols, key=str))
            if not polynomial.is_homogeneous or polynomial.total_degree() != 1:
                continue
            if function.subs(dict.fromkeys(symbols, 0)) == 0:
                quotients[sp.Dummy(real=True)] = function / argument
    return quotients
