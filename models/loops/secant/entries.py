r"""Entries of a secant matrix: expressions whose ranges contain the entries.

Let f be continuous and piecewise C^1 on a box Y_1 x ... x Y_N that holds y and y*.  The path
from y* to y changes one coordinate at a time, in the order 1, 2, ..., N:

    f(y) - f(y*) = \sum_k [f(y_1..y_k, y*_k+1..y*_N) - f(y_1..y_k-1, y*_k..y*_N)]

"slope" writes bracket k as s_k (y_k - y*_k).  The difference quotient s_k is enclosed over
Y_1 x ... x Y_k with the later coordinates at y*.  "derivative" encloses the same s_k by the range
of df/dy_k there, because s_k is the mean of df/dy_k over the segment.  Both need every corner of
the path from y* to y in the domain.  A box contains these corners; a general convex set does not.

"jacobian" uses the straight segment: f(y) - f(y*) = (\int_0^1 J(y* + s (y - y*)) ds) (y - y*).  The
entries lie in the ranges of df_i/dy_k over the whole box.  It holds on every convex set
inside the box.

Entries from different orders of the coordinates must not be intersected, because each order has its
own matrix.  Entries c + d phi with the same phi share one number theta.  They may share it because
the mean is taken over the same segment: for all rows of one column in "slope" and "derivative",
and for the whole matrix in "jacobian".

Source: Krawczyk and Neumaier (1985), "Interval slopes for rational functions and associated
centered forms", SIAM J. Numer. Anal. 22(3); Hansen (1968), coordinate by coordinate.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Literal, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.expression_range import expression_range

if TYPE_CHECKING:
    import sympy as sp

Form: TypeAlias = Literal["slope", "derivative", "jacobian"]


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """An expression whose range over the box contains the secant matrix's entry."""

    row: int
    column: int
    expression: sp.Expr
    box: Mapping[sp.Symbol, Interval]
    how: str


def entries_of(
    rows: Sequence[sp.Expr],
    columns: Sequence[sp.Symbol],
    reference: Mapping[sp.Symbol, sp.Expr],
    box: Mapping[sp.Symbol, Interval],
    form: Form,
) -> Iterator[Entry]:
    """Yield the entries that are not identically zero, column by column."""
    for column, symbol in enumerate(columns):
        for row, whole in enumerate(rows):
            if form == "jacobian":
                entry = Entry(row, column, whole.diff(symbol), box, "derivative")
            else:
                fixed = at_point(
                    whole, {later: reference[later] for later in columns[column + 1 :]}
                )
                entry = _one(row, column, fixed, symbol, reference[symbol], box, form)
            if entry.expression != 0:
                yield entry


def at_point(expression: sp.Expr, point: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Return the value of the expression at the point, or its limit if the value is 0/0.

    Raises
    ------
    ModelError : the expression has no finite value at the point.
    """
    import sympy as sp

    for symbol, value in point.items():
        if not expression.has(symbol):
            continue
        found = expression.subs(symbol, value)
        if found.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
            found = sp.limit(expression, symbol, value)
        if found.has(sp.nan, sp.zoo, sp.oo, -sp.oo, sp.AccumBounds, sp.Limit):
            raise ModelError(
                f"{expression} has no finite value at {symbol} = {value}; choose another reference "
                "point, or write the equation without the singularity"
            )
        expression = found
    return expression


def split(expression: sp.Expr) -> tuple[Fraction, Fraction, sp.Expr]:
    """Return (c, d, phi) with expression = c + d phi, c and d rational; phi = 0 for a number."""
    import sympy as sp

    constant, rest = expression.as_coeff_Add(rational=True)
    if rest == 0:
        return _fraction(constant), Fraction(0), sp.S.Zero
    content, core = rest.primitive()
    if core.could_extract_minus_sign():
        content, core = -content, -core
    return _fraction(constant), _fraction(content), core


def _one(
    row: int,
    column: int,
    whole: sp.Expr,
    symbol: sp.Symbol,
    rest: sp.Expr,
    box: Mapping[sp.Symbol, Interval],
    form: Form,
) -> Entry:
    derivative = Entry(row, column, whole.diff(symbol), box, "derivative")
    # The slope form needs a rational, constant reference.  A derivative without symbols is constant
    # and therefore equals the slope.
    if form == "derivative" or not rest.is_Rational or not derivative.expression.free_symbols:
        return derivative
    import sympy as sp

    shift = symbol if rest == 0 else sp.Symbol(f"delta_{symbol.name}", real=True)
    shifted = dict(box)
    shifted[shift] = box[symbol] - _fraction(rest)
    slope = _slope(whole, symbol, rest, shift)
    try:
        # The coarse tolerance is enough: any finite range shows that ball arithmetic can evaluate
        # the quotient at 0/0.  The bounds themselves are computed later.
        expression_range(slope, shifted, tolerance=Fraction(10**6))
    except ModelError:
        return derivative
    return Entry(row, column, slope, shifted, "slope")


def _slope(whole: sp.Expr, symbol: sp.Symbol, rest: sp.Expr, shift: sp.Symbol) -> sp.Expr:
    """Return (f(rest + shift) - f(rest)) / shift, with polynomial terms divided exactly."""
    import sympy as sp

    total = sp.S.Zero
    for term in sp.Add.make_args(whole):
        factor, moving = term.as_independent(symbol, as_Add=False)
        if not moving.has(symbol):
            continue
        if moving.is_polynomial(symbol):
            powers = sp.Poly(moving.subs(symbol, rest + shift), shift).all_coeffs()[:-1]
            quotient = sum(
                (c * shift**power for power, c in enumerate(reversed(powers))), sp.S.Zero
            )
        else:
            at_rest = at_point(moving, {symbol: rest})
            quotient = (moving.subs(symbol, rest + shift) - at_rest) / shift
        total += factor * quotient
    return total


def _fraction(number: sp.Rational) -> Fraction:
    return Fraction(int(number.p), int(number.q))
