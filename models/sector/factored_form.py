"""A factored form: premises, and each entry as a multi-affine polynomial in them."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, product
from math import prod
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.sector.terms import Sum, product_of, terms_of

if TYPE_CHECKING:
    import sympy as sp

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
        rest = dict(value)
        made: Combination = {}
        for pivot, row, parts in self.rows:
            share = rest.get(pivot)
            if share:
                _subtract(rest, share, row)
                for key, c in parts.items():
                    made[key] = made.get(key, 0) + share * c
        return rest, {key: c for key, c in made.items() if c != 0}

    def combination(self, value: Sum) -> Combination | None:
        """Return the coefficients by key, or None when the value lies outside."""
        rest, made = self._reduced(value)
        return None if rest else made

    def add(self, key: Hashable, value: Sum) -> bool:
        """Add a sum; False when it lies in the span already, and nothing changes then."""
        rest, made = self._reduced(value)
        if not rest:
            return False
        pivot = next(iter(rest))
        scale = 1 / rest[pivot]
        row = {atom: c * scale for atom, c in rest.items()}
        parts = {key: scale, **{k: -c * scale for k, c in made.items()}}
        self.rows.append((pivot, row, parts))
        return True


def _subtract(target: Sum, share: sp.Rational, row: Sum) -> None:
    for atom, c in row.items():
        left = target.get(atom, 0) - share * c
        if left == 0:
            target.pop(atom, None)
        else:
            target[atom] = left


Place: TypeAlias = tuple[str, int, int]
"""Matrix letter, row and column of an entry."""
Polynomial: TypeAlias = "dict[tuple[sp.Expr, ...], sp.Expr]"
"""Premises that are multiplied -> coefficient; () is the constant term."""

MOST_TOGETHER = 3  # premises whose products are looked for in entries


@dataclass(frozen=True, slots=True, eq=False)
class FactoredForm:
    """``entries`` in terms of ``premises``, which are expressions; those of the user come first."""

    premises: tuple[sp.Expr, ...]
    entries: Mapping[Place, Polynomial]


def forms_of(entries: Mapping[Place, Sum], wanted: Sequence[sp.Expr]) -> Iterator[FactoredForm]:
    """Yield the ways to choose premises for the entries.

    1. As few as make all entries affine combinations of premises and of products of the wanted
       ones (a basis of their span), made of single atoms where that takes no more.
    2. The same without atoms that are products of others.
    3. Atoms taken apart into their factors.

    Each is exact; the wanted premises are kept in all of them.
    """
    constant, varying = _parted(entries)
    known = _products({premise: terms_of(premise) for premise in wanted})
    atoms = _needed_atoms(varying.values(), known)
    basis = _basis(varying, known)
    singles: list[Sum] = [{atom: _one()} for atom in atoms]
    new = singles if len(singles) <= len(basis) else basis
    ways = [_written(constant, varying, wanted, new, products=False)]
    fewer: list[Sum] = [{atom: _one()} for atom in _without_products(atoms)]
    if len(fewer) < len(singles):
        ways.append(_written(constant, varying, wanted, fewer, products=True))
    if any(len(_factors(atom)[1]) > 1 for atom in atoms):
        ways.append(_in_factors(constant, varying, wanted))
    yield from (form for form in ways if form is not None)


def _one() -> sp.Rational:
    import sympy as sp

    return sp.S.One


def _parted(entries: Mapping[Place, Sum]) -> tuple[dict[Place, sp.Expr], dict[Place, Sum]]:
    """Return the constant part of each entry, a fraction, and the rest of it.

    A number such as pi is in the rest: vertices are fractions, so it needs a premise.
    """
    import sympy as sp

    constant = {
        place: sp.Add(*(c * atom for atom, c in value.items() if atom.is_Rational))
        for place, value in entries.items()
    }
    varying = {
        place: {atom: c for atom, c in value.items() if not atom.is_Rational}
        for place, value in entries.items()
    }
    return constant, varying


def _products(premises: Mapping[sp.Expr, Sum]) -> LinearSpan:
    """Return the span of 1 and the products of up to three of the premises."""
    import sympy as sp

    span = LinearSpan([((), {sp.S.One: sp.S.One})])
    for size in range(1, MOST_TOGETHER + 1):
        for members in combinations(premises, size):
            value = product_of([premises[member] for member in members])
            if value:
                span.add(members, value)
    return span


def _needed_atoms(values: Iterable[Sum], known: LinearSpan) -> list[sp.Expr]:
    """Return the atoms of the values that lie outside what is known, without known atoms."""
    found: dict[sp.Expr, None] = {}
    for value in values:
        if known.combination(value) is None:
            for atom in value:
                if known.combination({atom: _one()}) is None:
                    found[atom] = None
    return list(found)


def _basis(varying: Mapping[Place, Sum], known: LinearSpan) -> list[Sum]:
    """Return entries that span the others together with what is known; the shortest first."""
    span = LinearSpan()
    span.rows = list(known.rows)
    found: list[Sum] = []
    for value in sorted(varying.values(), key=len):
        if value and span.add(("new", len(found)), value):
            found.append(_scaled(value))
    return found


def _scaled(value: Sum) -> Sum:
    """Return the sum over its content, so that a single atom stands without coefficient."""
    first = next(iter(value.values()))
    return {atom: c / first for atom, c in value.items()}


def _without_products(atoms: Sequence[sp.Expr]) -> list[sp.Expr]:
    """Return the atoms without those that are products of two or three of the remaining ones."""
    import sympy as sp

    kept = list(atoms)
    for atom in atoms:
        others = [other for other in kept if other != atom]
        products = chain.from_iterable(combinations(others, k) for k in (2, 3))
        if len(others) <= 12 and any(sp.Mul(*some) == atom for some in products):
            kept.remove(atom)
    return kept


def _written(
    constant: Mapping[Place, sp.Expr],
    varying: Mapping[Place, Sum],
    wanted: Sequence[sp.Expr],
    new: Sequence[Sum],
    *,
    products: bool,
) -> FactoredForm | None:
    """Return the form in the wanted and new premises; None when these do not make the entries.

    ``products`` looks for products of the new premises too.
    """
    import sympy as sp

    made = {sp.Add(*(c * atom for atom, c in value.items())): value for value in new}
    premises = list(made)
    given = {premise: terms_of(premise) for premise in wanted}
    span = _products(given | made if products else given)
    for premise, value in made.items():
        span.add((premise,), value)
    entries: dict[Place, Polynomial] = {}
    for place, value in varying.items():
        found = span.combination(value)
        if found is None:
            return None
        polynomial: Polynomial = dict(found)  # type: ignore[arg-type]
        polynomial[()] = polynomial.get((), sp.S.Zero) + constant[place]
        entries[place] = {members: c for members, c in polynomial.items() if c != 0}
    return _used(wanted, premises, entries)


def _in_factors(
    constant: Mapping[Place, sp.Expr], varying: Mapping[Place, Sum], wanted: Sequence[sp.Expr]
) -> FactoredForm:
    import sympy as sp

    known = _products({premise: terms_of(premise) for premise in wanted})
    entries: dict[Place, Polynomial] = {}
    new: dict[sp.Expr, None] = {}
    for place, value in varying.items():
        found = known.combination(value)
        polynomial: Polynomial = dict(found) if found is not None else {}  # type: ignore[arg-type]
        polynomial[()] = polynomial.get((), sp.S.Zero) + constant[place]
        for atom, c in {} if found is not None else value.items():
            number, members = _factors(atom)
            new.update(dict.fromkeys(members))
            polynomial[members] = polynomial.get(members, sp.S.Zero) + c * number
        entries[place] = {members: c for members, c in polynomial.items() if c != 0}
    return _used(wanted, [f for f in new if f not in wanted], entries)


def _used(
    wanted: Sequence[sp.Expr], new: Sequence[sp.Expr], entries: Mapping[Place, Polynomial]
) -> FactoredForm:
    """Return the form with the premises that appear in some entry."""
    present = {p for polynomial in entries.values() for members in polynomial for p in members}
    order = [p for p in (*wanted, *new) if p in present]
    return FactoredForm(tuple(order), entries)


def _factors(atom: sp.Expr) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """Return (number, factors) whose product is the atom; 1/x stays with what vanishes at x = 0."""
    import sympy as sp

    parts = list(sp.Mul.make_args(atom))
    number = sp.Mul(*(part for part in parts if part.is_Rational))
    poles = [p for p in parts if p.is_Pow and p.base.is_Symbol and p.exp.is_negative]
    rest = [p for p in parts if not p.is_Rational and p not in poles]
    for pole in poles:
        partner = next((p for p in rest if p.subs(pole.base, 0) == 0), None)
        if partner is None:
            rest.append(pole)
        else:
            rest[rest.index(partner)] = partner * pole
    return number, tuple(rest)


def with_numbers_apart(
    form: FactoredForm, variables: Collection[sp.Symbol], wanted: Collection[sp.Expr]
) -> FactoredForm:
    """Return the form without premises that are numbers, or a + b z for another premise z.

    The numbers a and b, as pi or a rest that was solved for, become factors of coefficients.  A
    premise is left as it is where the user wants it, or where z would be squared.
    """
    places: dict[sp.Expr, Polynomial] = {}
    shapes: dict[object, tuple[sp.Expr, sp.Expr, sp.Expr]] = {}
    for premise in form.premises:
        offset, size, shape = _affine_shape(premise, variables)
        first, of_first, other = shapes.setdefault(shape, (premise, offset, size))
        if premise in wanted or (shape and first == premise):
            continue
        if not shape:
            places[premise] = {(): offset}
        elif not _multiplied(form, first, premise):
            share = size / other
            places[premise] = {(first,): share, (): offset - share * of_first}
    if not places:
        return form
    entries: dict[Place, Polynomial] = {}
    for place, polynomial in form.entries.items():
        entries[place] = {}
        for members, c in polynomial.items():
            parts = [places.get(member, {(member,): _one()}) for member in members]
            for chosen in product(*(part.items() for part in parts)):
                key = tuple(chain.from_iterable(left for left, _ in chosen))
                total = entries[place].get(key, 0) + c * prod(number for _, number in chosen)
                entries[place][key] = total
        entries[place] = {key: total for key, total in entries[place].items() if total != 0}
    return FactoredForm(tuple(p for p in form.premises if p not in places), entries)


def _affine_shape(
    premise: sp.Expr, variables: Collection[sp.Symbol]
) -> tuple[sp.Expr, sp.Expr, object]:
    """Return numbers a, b and f with premise = a + b f; f is the same for affine images of it."""
    import sympy as sp

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
