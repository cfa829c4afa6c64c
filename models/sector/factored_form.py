"""A factored form: premises, and each entry as a multi-affine polynomial in them."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, product
from math import prod
from typing import TypeAlias

import sympy as sp

from takagi.models.sector.terms import Sum, product_of, terms_of

Combination: TypeAlias = "dict[Hashable, sp.Rational]"


class LinearSpan:
    """The rational span of sums, each with a key; grows by ``add``.

    ``combination(v)`` gives coefficients by key with v = sum_k c_k v_k, or None.
    """

    def __init__(self, sums: Sequence[tuple[Hashable, Sum]] = ()) -> None:
        # Rows in echelon form: pivot atom, row with pivot 1, and what it is made of.
        self.rows: list[tuple[sp.Expr, Sum, Combination]] = []
        for key, value in sums:
            self.add(key, value)

    def _reduced(self, value: Sum) -> tuple[Sum, Combination]:
        """Return (rest, c) with value = rest + sum_k c_k v_k and rest free of the pivots."""
        remainder = dict(value)
        combination: Combination = {}
        for pivot, row, row_combination in self.rows:
            share = remainder.get(pivot)
            if share:
                subtract(remainder, share, row)
                for key, c in row_combination.items():
                    combination[key] = combination.get(key, 0) + share * c
        return remainder, {key: c for key, c in combination.items() if c != 0}

    def combination(self, value: Sum) -> Combination | None:
        """Return the coefficients by key, or None when the value lies outside."""
        remainder, combination = self._reduced(value)
        return None if remainder else combination

    def add(self, key: Hashable, value: Sum) -> bool:
        """Add a sum; False when it lies in the span already, and nothing changes then."""
        remainder, combination = self._reduced(value)
        if not remainder:
            return False
        pivot = next(iter(remainder))
        scale = 1 / remainder[pivot]
        row = {atom: c * scale for atom, c in remainder.items()}
        row_combination = {key: scale, **{k: -c * scale for k, c in combination.items()}}
        self.rows.append((pivot, row, row_combination))
        return True


def subtract(target: Sum, share: sp.Rational, row: Sum) -> None:
    """Take a share of a row from a sum; what is then zero is left out."""
    for atom, c in row.items():
        difference = target.get(atom, 0) - share * c
        if difference == 0:
            target.pop(atom, None)
        else:
            target[atom] = difference


EntryIndex: TypeAlias = tuple[str, int, int]
"""Matrix letter, row and column of an entry."""
Polynomial: TypeAlias = "dict[tuple[sp.Expr, ...], sp.Expr]"
"""Premises that are multiplied -> coefficient; () is the constant term."""

MOST_TOGETHER = 3  # premises whose products are looked for in entries


@dataclass(frozen=True, slots=True, eq=False)
class FactoredForm:
    """``entries`` in terms of ``premises``, which are expressions; those of the user come first."""

    premises: tuple[sp.Expr, ...]
    entries: Mapping[EntryIndex, Polynomial]


def forms_of(entries: Mapping[EntryIndex, Sum], asked: Sequence[sp.Expr]) -> Iterator[FactoredForm]:
    """Yield the ways to choose premises for the entries.

    1. As few as make all entries affine combinations of premises and of products of the wanted
       ones (a basis of their span), made of single atoms where that takes no more.
    2. The same without atoms that are products of others.
    3. Atoms taken apart into their factors.

    Each is exact; the wanted premises are kept in all of them.
    """
    constant, varying = _parted(entries)
    asked_span = _products({premise: terms_of(premise) for premise in asked})
    atoms = _needed_atoms(varying.values(), asked_span)
    basis = _basis(varying, asked_span)
    singles: list[Sum] = [{atom: _one()} for atom in atoms]
    new = singles if len(singles) <= len(basis) else basis
    forms = [_written(constant, varying, asked, new, products=False)]
    fewer: list[Sum] = [{atom: _one()} for atom in _without_products(atoms)]
    if len(fewer) < len(singles):
        forms.append(_written(constant, varying, asked, fewer, products=True))
    if any(len(_factors(atom)[1]) > 1 for atom in atoms):
        forms.append(_in_factors(constant, varying, asked))
    yield from (form for form in forms if form is not None)


def _one() -> sp.Rational:
    return sp.S.One


def _parted(
    entries: Mapping[EntryIndex, Sum],
) -> tuple[dict[EntryIndex, sp.Expr], dict[EntryIndex, Sum]]:
    """Return the constant part of each entry, a fraction, and the rest of it.

    A number such as pi is in the rest: vertices are fractions, so it needs a premise.
    """
    constant = {
        position: sp.Add(*(c * atom for atom, c in value.items() if atom.is_Rational))
        for position, value in entries.items()
    }
    varying = {
        position: {atom: c for atom, c in value.items() if not atom.is_Rational}
        for position, value in entries.items()
    }
    return constant, varying


def _products(premises: Mapping[sp.Expr, Sum]) -> LinearSpan:
    """Return the span of 1 and the products of up to three of the premises."""
    span = LinearSpan([((), {sp.S.One: sp.S.One})])
    for size in range(1, MOST_TOGETHER + 1):
        for members in combinations(premises, size):
            value = product_of([premises[member] for member in members])
            if value:
                span.add(members, value)
    return span


def _needed_atoms(values: Iterable[Sum], known_span: LinearSpan) -> list[sp.Expr]:
    """Return the atoms of the values that lie outside what is known, without known atoms."""
    atoms: dict[sp.Expr, None] = {}
    for value in values:
        if known_span.combination(value) is None:
            for atom in value:
                if known_span.combination({atom: _one()}) is None:
                    atoms[atom] = None
    return list(atoms)


def _basis(varying: Mapping[EntryIndex, Sum], known_span: LinearSpan) -> list[Sum]:
    """Return entries that span the others together with what is known; the shortest first."""
    span = LinearSpan()
    span.rows = list(known_span.rows)
    entries: list[Sum] = []
    for value in sorted(varying.values(), key=len):
        if value and span.add(("new", len(entries)), value):
            entries.append(scaled_to_first(value))
    return entries


def scaled_to_first(value: Sum) -> Sum:
    """Return the sum over its content, so that a single atom stands without coefficient."""
    first = next(iter(value.values()))
    return {atom: c / first for atom, c in value.items()}


def _without_products(atoms: Sequence[sp.Expr]) -> list[sp.Expr]:
    """Return the atoms without those that are products of two or three of the remaining ones."""
    independent = list(atoms)
    for atom in atoms:
        other_atoms = [candidate for candidate in independent if candidate != atom]
        products = chain.from_iterable(combinations(other_atoms, k) for k in (2, 3))
        if len(other_atoms) <= 12 and any(sp.Mul(*some) == atom for some in products):
            independent.remove(atom)
    return independent


def _written(
    constant: Mapping[EntryIndex, sp.Expr],
    varying: Mapping[EntryIndex, Sum],
    asked: Sequence[sp.Expr],
    new: Sequence[Sum],
    *,
    products: bool,
) -> FactoredForm | None:
    """Return the form in the wanted and new premises; None when these do not make the entries.

    ``products`` looks for products of the new premises too.
    """
    new_premises = {sp.Add(*(c * atom for atom, c in value.items())): value for value in new}
    premises = list(new_premises)
    asked_sums = {premise: terms_of(premise) for premise in asked}
    span = _products(asked_sums | new_premises if products else asked_sums)
    for premise, value in new_premises.items():
        span.add((premise,), value)
    entries: dict[EntryIndex, Polynomial] = {}
    for position, value in varying.items():
        combination = span.combination(value)
        if combination is None:
            return None
        polynomial: Polynomial = dict(combination)  # type: ignore[arg-type]
        polynomial[()] = polynomial.get((), sp.S.Zero) + constant[position]
        entries[position] = {members: c for members, c in polynomial.items() if c != 0}
    return _used(asked, premises, entries)


def _in_factors(
    constant: Mapping[EntryIndex, sp.Expr],
    varying: Mapping[EntryIndex, Sum],
    asked: Sequence[sp.Expr],
) -> FactoredForm:
    asked_span = _products({premise: terms_of(premise) for premise in asked})
    entries: dict[EntryIndex, Polynomial] = {}
    new: dict[sp.Expr, None] = {}
    for position, value in varying.items():
        combination = asked_span.combination(value)
        polynomial: Polynomial = dict(combination) if combination is not None else {}  # type: ignore[arg-type]
        polynomial[()] = polynomial.get((), sp.S.Zero) + constant[position]
        for atom, c in {} if combination is not None else value.items():
            number, members = _factors(atom)
            new.update(dict.fromkeys(members))
            polynomial[members] = polynomial.get(members, sp.S.Zero) + c * number
        entries[position] = {members: c for members, c in polynomial.items() if c != 0}
    return _used(asked, [f for f in new if f not in asked], entries)


def _used(
    asked: Sequence[sp.Expr], new: Sequence[sp.Expr], entries: Mapping[EntryIndex, Polynomial]
) -> FactoredForm:
    """Return the form with the premises that appear in some entry."""
    present = {p for polynomial in entries.values() for members in polynomial for p in members}
    order = [p for p in (*asked, *new) if p in present]
    return FactoredForm(tuple(order), entries)


def _factors(atom: sp.Expr) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """Return (number, factors) whose product is the atom; 1/x stays with what vanishes at x = 0."""
    factors = list(sp.Mul.make_args(atom))
    number = sp.Mul(*(factor for factor in factors if factor.is_Rational))
    poles = [p for p in factors if p.is_Pow and p.base.is_Symbol and p.exp.is_negative]
    moving = [p for p in factors if not p.is_Rational and p not in poles]
    for pole in poles:
        partner = next((p for p in moving if p.subs(pole.base, 0) == 0), None)
        if partner is None:
            moving.append(pole)
        else:
            moving[moving.index(partner)] = partner * pole
    return number, tuple(moving)


def with_numbers_apart(
    form: FactoredForm, variables: Collection[sp.Symbol], asked: Collection[sp.Expr]
) -> FactoredForm:
    """Return the form without premises that are numbers, or a + b z for another premise z.

    The numbers a and b, as pi or a rest that was solved for, become factors of coefficients.  A
    premise is left as it is where the user wants it, or where z would be squared.
    """
    replaced: dict[sp.Expr, Polynomial] = {}
    shapes: dict[object, tuple[sp.Expr, sp.Expr, sp.Expr]] = {}
    for premise in form.premises:
        offset, size, shape = _affine_shape(premise, variables)
        first, of_first, first_size = shapes.setdefault(shape, (premise, offset, size))
        if premise in asked or (shape and first == premise):
            continue
        if not shape:
            replaced[premise] = {(): offset}
        elif not _multiplied(form, first, premise):
            share = size / first_size
            replaced[premise] = {(first,): share, (): offset - share * of_first}
    if not replaced:
        return form
    entries: dict[EntryIndex, Polynomial] = {}
    for position, polynomial in form.entries.items():
        entries[position] = {}
        for members, c in polynomial.items():
            factor_sums = [replaced.get(member, {(member,): _one()}) for member in members]
            for chosen in product(*(factor_sum.items() for factor_sum in factor_sums)):
                key = tuple(chain.from_iterable(symbols for symbols, _ in chosen))
                total = entries[position].get(key, 0) + c * prod(number for _, number in chosen)
                entries[position][key] = total
        entries[position] = {key: total for key, total in entries[position].items() if total != 0}
    return FactoredForm(tuple(p for p in form.premises if p not in replaced), entries)


def _affine_shape(
    premise: sp.Expr, variables: Collection[sp.Symbol]
) -> tuple[sp.Expr, sp.Expr, object]:
    """Return numbers a, b and f with premise = a + b f; f is the same for affine images of it."""
    offset, moving = sp.expand_mul(premise).as_independent(*variables, as_Add=True)
    terms = [
        term.as_independent(*variables, as_Add=False)
        for term in sp.Add.make_args(moving)
        if term != 0
    ]
    if not terms:
        return offset, sp.S.Zero, None
    size = min(terms, key=lambda term: sp.default_sort_key(term[1]))[0]
    return offset, size, frozenset((core, number / size) for number, core in terms)


def _multiplied(form: FactoredForm, first: sp.Expr, second: sp.Expr) -> bool:
    return any(
        first in members and second in members
        for polynomial in form.entries.values()
        for members in polynomial
    )
