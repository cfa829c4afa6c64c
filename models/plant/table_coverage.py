"""The arguments of every table must stay inside it on the whole box."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant

TOLERANCE = Fraction(1, 10**6)


def check_coverage(plant: Plant) -> None:
    """Raise ModelError unless each argument of each table provably stays inside it on the box.

    The range of an argument is enclosed rigorously; one that only touches the edge of its table
    may be refused, because its enclosure is wider by a millionth of its width.  In f(g(x)) the
    argument of g is examined first, because a range of g(x) is defined only inside g.
    """
    import sympy as sp

    from takagi.models.splines.table_function import TableFunction, table_ranges

    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    checked_calls: set[Any] = set()
    for owner, expression in plant.expressions:
        calls = expression.atoms(TableFunction)
        for call in sorted(calls, key=lambda c: (len(c.atoms(TableFunction)), str(c))):
            if call in checked_calls:
                continue
            checked_calls.add(call)
            pairs = zip(call.args, table_ranges(call.table), strict=True)
            for number, (argument, covered) in enumerate(pairs, start=1):
                _check(plant, f"{owner}: argument {number} of {call}", argument, covered, values)


def _check(
    plant: Plant,
    owner: str,
    argument: sp.Expr,
    covered: Interval,
    values: Mapping[sp.Symbol, sp.Rational],
) -> None:
    attained = _range(plant, owner, argument.subs(values))
    if covered.contains(attained):
        return
    named = sorted(str(symbol) for symbol in argument.free_symbols)
    sides = ", ".join(
        f"{variable.name} in {variable.range}"
        for variable in plant.variables
        if variable.name in named and variable.range is not None
    )
    raise ModelError(
        f"{owner}, {argument}, takes values in {attained} on the box "
        f"({sides or 'a number'}), but the "
        f"table covers {covered}; shrink the ranges or extend the table"
    )


def _range(plant: Plant, owner: str, argument: sp.Expr) -> Interval:
    from takagi.models.ranges.expression_range import expression_range

    ranges = {variable.symbol: variable.range for variable in plant.variables}
    missing = sorted(str(s) for s in argument.free_symbols if ranges[s] is None)
    if missing:
        raise ModelError(
            f"{owner}, {argument}, depends on {', '.join(missing)}, which has no range; give one"
        )
    if argument.is_Symbol:
        return plant.box[argument]
    try:
        return expression_range(argument, plant.box, tolerance=TOLERANCE).outer
    except ModelError as error:
        raise ModelError(f"{owner}: its range cannot be enclosed: {error}") from error
