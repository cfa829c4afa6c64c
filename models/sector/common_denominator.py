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
from typing import TYPE_CHECKING

from takagi.models.sector.factored_form import FactoredForm, LinearSpan, Place, Polynomial
from takagi.models.sector.terms import Sum, terms_of

if TYPE_CHECKING:
    import sympy as sp

INPUTS = ("B", "E")


def denominator_forms(entries: Mapping[Place, Sum]) -> Iterator[FactoredForm]:
    """Yield the form with denominators and numerator factors as premises, if there is one.

    Every entry is R + N/D with at most one sum D.  The premises are

    1. 1/D for each D;
    2. sums (the varying part of adj(M)), as few as possible, in which the N and R of the input
       matrices are affine;
    3. for the other entries, the factors of N and R that remain after division by the sums of 2:
       one product for each, or single atoms if N has no factors.

    Nothing is yielded if no entry has such a D, or if a term has two of them or a power of one.
    """
    by_place = {place: _parts(value) for place, value in entries.items()}
    if any(parts is None for parts in by_place.values()):
        return
    parts = {place: found for place, found in by_place.items() if found is not None}
    if not any(base is not None for found in parts.values() for base in found):
        return
    premises = _Premises()
    ordered = sorted(parts, key=lambda place: place[0] not in INPUTS)
    polynomials: dict[Place, Polynomial] = {}
    for place in ordered:
        if place[0] in INPUTS:
            for value in parts[place].values():
                premises.add_moving(value)
    for place in ordered:
        polynomial: Polynomial = {}
        for base, value in parts[place].items():
            inverse = () if base is None else (premises.inverse(base),)
            for members, c in premises.written(value, moving_only=place[0] in INPUTS).items():
                key = (*inverse, *members)
                polynomial[key] = polynomial.get(key, 0) + c
        polynomials[place] = {members: c for members, c in polynomial.items() if c != 0}
    used = {p for polynomial in polynomials.values() for members in polynomial for p in members}
    kept = {place: polynomials[place] for place in entries}
    yield FactoredForm(tuple(p for p in premises.order if p in used), kept)


def _parts(value: Sum) -> dict[sp.Expr | None, Sum] | None:
    """Return D -> N with value = sum of N/D; the key None has the terms without a sum as divisor.

    None if a term is divided by two sums, or by a power of one: then N is not a polynomial.
    """
    found: dict[sp.Expr | None, Sum] = {}
    for atom, c in value.items():
        poles = [p for p in atom.as_ordered_factors() if p.is_Pow and p.base.is_Add and p.exp < 0]
        if len(poles) > 1 or any(power.exp != -1 for power in poles):
            return None
        bases = [power.base for power in poles]
        base = bases[0] if bases else None
        rest = atom * base if base is not None else atom
        numerator = found.setdefault(base, {})
        numerator[rest] = numerator.get(rest, 0) + c
    return found


@dataclass(slots=True)
class _Premises:
    """The premises chosen up to now, in their order."""

    order: list[sp.Expr] = field(default_factory=list)
    span: LinearSpan = field(default_factory=LinearSpan)
    moving: list[sp.Expr] = field(default_factory=list)

    def __post_init__(self) -> None:
        import sympy as sp

        self.span.add((), {sp.S.One: sp.S.One})

    def _known(self, premise: sp.Expr) -> sp.Expr:
        if premise not in self.order:
            self.order.append(premise)
        return premise

    def inverse(self, base: sp.Expr) -> sp.Expr:
        return self._known(1 / base)

    def add_moving(self, value: Sum) -> None:
        """Add the sum's varying part as a premise, unless it is affine in the present ones."""
        import sympy as sp

        varying = {atom: c for atom, c in value.items() if not atom.is_Rational}
        if varying and self.span.combination(varying) is None:
            first = next(iter(varying.values()))
            scaled = {atom: c / first for atom, c in varying.items()}
            premise = self._known(sp.Add(*(c * atom for atom, c in scaled.items())))
            self.span.add((premise,), scaled)
            self.moving.append(premise)

    def written(self, value: Sum, *, moving_only: bool) -> Polynomial:
        """Return the sum as a polynomial in premises; missing premises are added."""
        found = self.span.combination(value)
        if found is not None:
            return dict(found)  # type: ignore[arg-type]
        assert not moving_only, "the inputs' sums were added before"
        product = self._in_factors(value)
        return self._in_atoms(value) if product is None else product

    def _in_factors(self, value: Sum) -> Polynomial | None:
        """Return number * (affine in a moving premise) * (one product); None for a single sum."""
        import sympy as sp

        number, factors = _factor_list(sp.Add(*(c * atom for atom, c in value.items())))
        affine: Polynomial = {(): sp.S.One}
        others: list[sp.Expr] = []
        for factor in factors:
            found = self.span.combination(terms_of(factor))
            if found is not None and len(affine) == 1:
                affine = dict(found)  # type: ignore[arg-type]
            else:
                others.append(factor)
        if len(others) == 1 and others[0].is_Add and len(factors) == 1:
            return None
        if not others:
            return {members: number * c for members, c in affine.items()}
        rest = self._known(sp.Mul(*others))
        return {(*members, rest): number * c for members, c in affine.items()}

    def _in_atoms(self, value: Sum) -> Polynomial:
        """Return the sum with each atom as a premise; no varying premise is used as a factor."""
        found: Polynomial = {}
        for atom, c in value.items():
            if atom.is_Rational:
                members: tuple[sp.Expr, ...] = ()
                number = c * atom
            else:
                number = c
                factor = next((m for m in self.moving if _divides(m, atom)), None)
                rest = atom if factor is None else atom / factor
                left = () if rest == 1 else (self._known(rest),)
                members = left if factor is None else (factor, *left)
            found[members] = found.get(members, 0) + number
        return found


def _divides(factor: sp.Expr, atom: sp.Expr) -> bool:
    """Return whether the atom has the factor once."""
    import sympy as sp

    return [part == factor for part in sp.Mul.make_args(atom)].count(True) == 1


def _factor_list(expression: sp.Expr) -> tuple[sp.Rational, list[sp.Expr]]:
    """Return (number, factors) of the expression; sin(x)/x is one factor."""
    import sympy as sp

    quotients: dict[sp.Expr, sp.Symbol] = {}

    def whole(term: sp.Expr) -> sp.Expr:
        parts = list(sp.Mul.make_args(term))
        for pole in [p for p in parts if p.is_Pow and p.base.is_Symbol and p.exp == -1]:
            partner = next((p for p in parts if p != pole and p.subs(pole.base, 0) == 0), None)
            if partner is not None:
                parts.remove(pole)
                parts.remove(partner)
                parts.append(quotients.setdefault(partner * pole, sp.Dummy()))
        return sp.Mul(*parts)

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
    import sympy as sp

    found: dict[sp.Symbol, sp.Expr] = {}
    seen: set[sp.Expr] = set()
    for row in rows:
        for function in sorted(row.atoms(sp.Function), key=sp.default_sort_key):
            if function in seen or len(function.args) != 1:
                continue
            seen.add(function)
            argument = sp.expand(function.args[0])
            used = argument.free_symbols
            if len(used) < 2 or not used <= set(states) or not argument.is_polynomial(*used):
                continue
            polynomial = sp.Poly(argument, *sorted(used, key=str))
            if not polynomial.is_homogeneous or polynomial.total_degree() != 1:
                continue
            if function.subs(dict.fromkeys(used, 0)) == 0:
                found[sp.Dummy(real=True)] = function / argument
    return found
