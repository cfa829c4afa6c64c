"""The rows of f as sums of terms, each with the columns (states, inputs) to which it may belong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    from takagi.models.equations.equations import Equations

Sum: TypeAlias = "dict[sp.Expr, sp.Rational]"
"""Atom -> rational coefficient; atoms are products without rational factor, 1 is the constant."""


LARGE_NUMERATOR = 10**6


class Option(NamedTuple):
    """``variable`` times ``coefficient`` is the term."""

    variable: sp.Symbol
    coefficient: Sum


@dataclass(frozen=True, slots=True)
class RowTerm:
    """A part of one row, with the ways to write it; the usual way is the first."""

    row: int
    options: tuple[tuple[Option, ...], ...]


def terms_of(expression: sp.Expr) -> Sum:
    """Return the expanded expression as atom -> coefficient; terms that cancel are left out."""
    coefficients: Sum = {}
    for term in sp.Add.make_args(_expanded(expression)):
        coefficient, atom = _canonical(term)
        if coefficient != 0:
            coefficients[atom] = coefficients.get(atom, sp.S.Zero) + coefficient
    return {atom: c for atom, c in coefficients.items() if c != 0}


def product_of(sums: Sequence[Sum]) -> Sum:
    """Return the product of sums; their atoms are multiplied and not expanded again."""
    total: Sum = {sp.S.One: sp.S.One}
    for factor in sums:
        coefficients: Sum = {}
        for (a, c), (b, d) in product(total.items(), factor.items()):
            share, atom = _canonical(a * b)
            coefficients[atom] = coefficients.get(atom, sp.S.Zero) + c * d * share
        total = {atom: c for atom, c in coefficients.items() if c != 0}
    return total


def row_terms(
    rows: Sequence[sp.Expr], plant: Equations, box: Mapping[sp.Symbol, Interval]
) -> list[RowTerm]:
    """Return the terms of all rows with their options.

    A term with an input belongs to the input.  A term that is linear in a disturbance belongs to
    the disturbance, unless this is a scheduling signal.  Any other term belongs to a state that is
    a factor of it, or with which it vanishes (a removable singularity).
    If only the sum of several terms of a row vanishes, such as cos(x) - 1, the sum is telescoped,
    R(x, y) = [R(x, y) - R(x, 0)] + [R(x, 0) - R(0, 0)], one difference for each variable.

    Raises
    ------
    ModelError : an input that enters nonlinearly, or terms that do not vanish at the origin.
    """
    terms = []
    for row, expression in enumerate(rows):
        together: list[sp.Expr] = []
        for atom, coefficient in terms_of(expression).items():
            options = _options(atom, coefficient, plant, box, row)
            if options:
                terms.append(RowTerm(row, tuple((option,) for option in options)))
            else:
                together.append(coefficient * atom)
        if together:
            orders = _telescoped(sp.Add(*together), plant, row)
            terms.append(RowTerm(row, orders))
    return terms


def _expanded(expression: sp.Expr) -> sp.Expr:
    """Return the expression expanded, each sum in a denominator kept as one factor."""
    placeholders: dict[sp.Expr, sp.Symbol] = {}
    exchanged = {}
    for power in expression.atoms(sp.Pow):
        if power.base.is_Add and power.exp.is_Integer and power.exp < 0:
            # sympy would multiply the denominators out: 1/(x (a + b)) to 1/(a x + b x).
            content, base = sp.expand(power.base).primitive()
            symbol = placeholders.setdefault(base, sp.Dummy())
            exchanged[power] = content**power.exp * symbol**power.exp
    back = {symbol: base for base, symbol in placeholders.items()}
    return sp.expand(expression.xreplace(exchanged)).xreplace(back)


def _canonical(term: sp.Expr) -> tuple[sp.Rational, sp.Expr]:
    """Return (coefficient, atom) with the rational content of sums in it taken out."""
    coefficient, body = term.as_coeff_Mul()
    factors = []
    for factor in sp.Mul.make_args(body):
        base, power = factor.as_base_exp()
        if base.is_Add and power.is_Integer:
            content, base = base.primitive()
            coefficient *= content**power
            factors.append(base**power)
        else:
            factors.append(factor)
    return coefficient, sp.Mul(*factors)


def _signed(term: sp.Expr) -> tuple[sp.Rational, sp.Expr]:
    """Return (coefficient, atom), the same atom for a term and its negative.

    (1 - exp(x))/x in one row and (exp(x) - 1)/x in another are then one premise.
    """
    coefficient, body = term.as_coeff_Mul()
    factors = []
    for factor in sp.Mul.make_args(body):
        if factor.is_Add:
            # The decimals of a table would give huge whole numbers, which make the premise
            # unreadable.
            sizes = factor.as_coefficients_dict()
            first = min(
                (summand for summand in sizes if summand is not sp.S.One), key=sp.default_sort_key
            )
            has_large = any(abs(size.p) > LARGE_NUMERATOR for size in sizes.values())
            share = sizes[first] if has_large else sp.S.One
            factor = sp.Add(*(summand / share for summand in factor.args))
            if factor.could_extract_minus_sign():
                share, factor = -share, sp.Add(*(-summand for summand in factor.args))
            coefficient *= share
        factors.append(factor)
    return coefficient, sp.Mul(*factors)


def _options(
    atom: sp.Expr,
    coefficient: sp.Rational,
    plant: Equations,
    box: Mapping[sp.Symbol, Interval],
    row: int,
) -> list[Option]:
    def divided(variable: sp.Symbol) -> Option:
        share, quotient = _canonical(atom / variable)
        return Option(variable, {quotient: coefficient * share})

    acting = [symbol for symbol in plant.inputs if atom.has(symbol)]
    if acting:
        own_input = _own_input(atom, coefficient, acting, box, row)
        return [] if own_input is None else [divided(own_input)]
    disturbing = [s for s in plant.disturbances if s not in plant.scheduling]
    for symbol in disturbing:
        if atom.has(symbol) and not (atom / symbol).has(symbol):
            return [divided(symbol)]
    powers = atom.as_powers_dict()
    factors = [s for s in reversed(plant.states) if _whole(powers.get(s, 0))]
    vanishing = [s for s in plant.states if s not in factors and _vanishes(atom, s, box)]
    squares = [s for s in disturbing if _whole(powers.get(s, 0))]
    return [divided(symbol) for symbol in [*factors, *vanishing] or squares]


def _own_input(
    atom: sp.Expr,
    coefficient: sp.Rational,
    acting: Sequence[sp.Symbol],
    box: Mapping[sp.Symbol, Interval],
    row: int,
) -> sp.Symbol | None:
    """Return the input to which the term belongs; None if it vanishes with no single input.

    u^3 becomes u^2 times u: the coefficient may depend on inputs that have a range.
    """
    linear = next((s for s in acting if not (atom / s).has(*acting)), None)
    if linear is not None:
        return linear
    without = [s.name for s in acting if s not in box]
    if without:
        raise ModelError(
            f"row {row + 1}: {', '.join(without)} enters nonlinearly (in the term "
            f"{coefficient * atom}); give it a range, so that its coefficient can be bounded, or "
            "make it a state with an input of its own"
        )
    vanishing = [s for s in acting if _whole(atom.as_powers_dict().get(s, 0))]
    return next(
        (s for s in (*vanishing, *acting) if s in vanishing or _vanishes(atom, s, box)), None
    )


def _whole(power: object) -> bool:
    return bool(sp.sympify(power).is_Integer and power >= 1)  # type: ignore[operator]


def _vanishes(atom: sp.Expr, state: sp.Symbol, box: Mapping[sp.Symbol, Interval]) -> bool:
    """Return whether atom / state has a removable singularity at state = 0."""
    if state not in atom.free_symbols or state not in box or atom.has(sp.Abs, sp.sign):
        return False
    if atom.subs(state, 0) != 0:
        return False
    slope = atom.diff(state).subs(state, 0)
    return not slope.has(sp.zoo, sp.nan, sp.oo, -sp.oo)


def _telescoped(term: sp.Expr, plant: Equations, row: int) -> tuple[tuple[Option, ...], ...]:
    """Return the rest as differences along one variable each, in both orders of the variables."""
    signals = (s for s in plant.disturbances if s not in plant.scheduling)
    variables = [s for s in (*plant.states, *signals, *plant.inputs) if s in term.free_symbols]
    origin = term.subs(dict.fromkeys(variables, 0))
    if not variables or (origin != 0 and sp.simplify(origin) != 0):
        bent = origin.has(sp.zoo, sp.nan, sp.oo, -sp.oo)
        there = "without a value, since it divides by 0," if bent else str(origin)
        raise ModelError(
            f"row {row + 1}: {term} does not vanish with any state: it is "
            f"{there} at the origin, so it cannot be written as coefficients times states; give "
            "rest values at which it is 0"
        )
    orders = []
    for order in (variables, variables[::-1]):
        options = []
        current = term
        for variable in order:
            following = current.subs(variable, 0)
            difference = current - following
            if difference != 0:
                share, atom = _signed(_quotient(difference, variable))
                options.append(Option(variable, {atom: share}))
            current = following
        orders.append(tuple(options))
    return tuple(orders) if len(variables) > 1 else (orders[0],)


def _quotient(difference: sp.Expr, variable: sp.Symbol) -> sp.Expr:
    """Return the difference, which vanishes with the variable, over it.

    The variable is divided out of a rational function, so that nothing of the form 0/0 is left:
    1/(1 + x) - 1 over x is -1/(1 + x).
    """
    if difference.is_rational_function() and sp.denom(sp.together(difference)).has(variable):
        return sp.factor(difference / variable)
    return sp.factor_terms(difference) / variable
