"""Parts of an expression that sympy removes, and whether they have a value on the whole box.

sympy turns 0 log(x) into 0 and sqrt(x)^2 into x as soon as it reads them, although they have no
value where x is negative.  The reader notes every part that is not defined everywhere.  If such a
part is missing from the result, it is proved here that the part is defined on the whole box;
otherwise the file is refused.

A quotient that cancels, such as x^2/x, has the value of its limit where its denominator vanishes,
if the denominator is a product of deviations from the equilibrium or of sums of multiples of them.
The checker, which reads the file too, does the same.  0/x and 0 (1/x) are not given such a value,
because they need not be written.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.expression_range import expression_range

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant

TOLERANCE = Fraction(1, 10**6)
# Function -> (least, greatest argument); an end that is None is open, and "open" excludes both.
PARTIAL: Mapping[str, tuple[int | None, int | None]] = {
    "log": (0, None),
    "asin": (-1, 1),
    "acos": (-1, 1),
    "acosh": (1, None),
    "atanh": (-1, 1),
    "tan": (None, None),
}
EXCLUDED = frozenset({"log", "atanh"})


@dataclass(frozen=True, slots=True)
class LostPart:
    """A part that has no value somewhere.

    Attributes
    ----------
    kind : "quotient", "root", or the name of the function or table.
    argument : the denominator, or what the root, function or table is of.
    result : what sympy made of it.
    column : where it appears in the text, from 0.
    covered : range of a table's argument.
    idle : it is multiplied by 0, or 0 is divided by it.
    """

    kind: str
    argument: sp.Expr
    result: sp.Expr
    column: int
    covered: Interval | None = None
    idle: bool = False


def lost_parts(parts: Iterable[LostPart], expression: sp.Expr) -> tuple[LostPart, ...]:
    """Return the parts whose domain the whole expression does not show any more."""
    return tuple(part for part in parts if part.idle or not _survives(part, expression))


def _survives(part: LostPart, expression: sp.Expr) -> bool:
    powers = expression.atoms(sp.Pow)
    if part.kind == "quotient":
        below = {power.base for power in powers if power.exp.is_negative}
        factors = [factor.as_base_exp()[0] for factor in sp.Mul.make_args(part.argument)]
        return all(f.is_number or f in below or -f in below for f in factors)
    if part.kind == "root":
        return any(p.base == part.argument and p.exp.is_integer is False for p in powers)
    return bool(part.result.is_Function and expression.has(part.result))


def check_lost(part: LostPart, plant: Plant) -> None:
    """Raise ModelError unless a part that was folded away has a value on the whole box."""
    argument = part.argument.subs(plant.rationals)
    if _is_defined(part, argument, plant):
        return
    named = {str(symbol) for symbol in argument.free_symbols}
    box = ", ".join(
        f"{v.name} in {v.range}" if v.range is not None else f"{v.name} without a range"
        for v in plant.variables
        if v.name in named
    )
    of = {"quotient": "the quotient by ", "root": "the root of "}.get(part.kind, f"{part.kind} of ")
    how = "is multiplied by 0" if part.idle else "cancels"
    raise ModelError(
        f"{of}{part.argument} {how}, but is not shown to have a value on the whole box "
        f"({box or 'a number'}), and where it has none the equation has none; leave it out, or "
        "give ranges on which it has"
    )


def _is_defined(part: LostPart, argument: sp.Expr, plant: Plant) -> bool:
    if part.kind == "quotient" and not part.idle:
        factors = [factor.as_base_exp()[0] for factor in sp.Mul.make_args(argument)]
        return all(_vanishes_at_rest(f, plant) or _excludes_zero(f, plant) for f in factors)
    if part.kind == "quotient":
        return _excludes_zero(argument, plant)
    if part.kind == "tan":
        return _excludes_zero(sp.cos(argument), plant)
    if part.kind == "root" and argument.is_nonnegative:
        return not part.result.as_base_exp()[1].is_negative or bool(argument.is_positive)
    if part.kind == "log" and argument.is_positive:
        return True
    argument_range = _range(argument, plant)
    if argument_range is None:
        return False
    if part.covered is not None:
        return part.covered.contains(argument_range)
    if part.kind == "root":
        return argument_range.lower >= 0
    low, high = PARTIAL[part.kind]
    inside = (low is None or argument_range.lower >= low) and (
        high is None or argument_range.upper <= high
    )
    if part.kind in EXCLUDED:
        return inside and argument_range.lower != low and argument_range.upper != high
    return inside


def _vanishes_at_rest(factor: sp.Expr, plant: Plant) -> bool:
    """Return whether this is a sum of multiples of deviations from the equilibrium."""
    symbols = sorted(factor.free_symbols, key=str)
    slopes = [factor.diff(s) for s in symbols]
    return (
        bool(symbols)
        and all(slope.is_number and slope != 0 for slope in slopes)
        and factor.subs(plant.at_rest) == 0
    )


def _excludes_zero(argument: sp.Expr, plant: Plant) -> bool:
    if argument.is_nonzero:
        return True
    argument_range = _range(argument, plant)
    return argument_range is not None and not argument_range.lower <= 0 <= argument_range.upper


def _range(argument: sp.Expr, plant: Plant) -> Interval | None:
    """Return an enclosure of what the argument takes on the box; None where none exists."""
    try:
        if argument.is_Symbol:
            return plant.box.get(argument)
        return expression_range(argument, plant.box, tolerance=TOLERANCE).outer
    except ModelError:
        return None
