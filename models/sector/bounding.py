"""Premises with proved ranges, and the number of rules that they make."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.enclosure.interval import Interval, Number
from takagi.models.errors import ModelError
from takagi.models.premise import Premise, round_outward
from takagi.models.sector.problem import Problem

if TYPE_CHECKING:
    import sympy as sp

__all__ = ["bounded_premise", "check_rule_count"]


def bounded_premise(
    symbol: sp.Symbol,
    expression: sp.Expr,
    problem: Problem,
    given: tuple[Number, Number] | None,
    tolerance: Fraction,
) -> Premise:
    """Return the premise with proved bounds, or the given ones.

    Raises
    ------
    ModelError : it cannot be bounded, or an attained value contradicts the given bounds.
    """
    import sympy as sp

    from takagi.models.sector.ball import expression_range, expression_value

    names = {s.name: s for s in expression.free_symbols}

    def evaluate(**point: float) -> float:
        return expression_value(expression, {s: point[n] for n, s in names.items() if n in point})

    found = expression_range(expression, problem.box, tolerance=tolerance)
    if given is None:
        bounds = round_outward(found.outer)
        how = "ball arithmetic" if found.evidence is None else found.evidence.words
        evidence = f"{how}, rounded outward"
    else:
        bounds = Interval.of(*given)
        if found.inner.lower < bounds.lower or bounds.upper < found.inner.upper:
            raise ModelError(
                f"premise {symbol} = {expression}: the given bounds {bounds} leave out values that "
                f"it attains, {found.inner}; widen them, or shrink the box"
            )
        proved = bounds.contains(found.outer)
        evidence = "given by the user" + (", confirmed by ball arithmetic" if proved else "")
    return Premise(
        symbol.name,
        bounds.lower,
        bounds.upper,
        unit=problem.equations.units.get(symbol, "-"),
        latex=sp.latex(symbol),
        evidence=evidence,
        evaluate=evaluate,
    )


def check_rule_count(premises: Sequence[Premise], most_rules: int) -> int:
    """Return the number of rules that the premises make.

    Raises
    ------
    ModelError : more than ``most_rules``; each premise that is not constant doubles them.
    """
    varying = [premise for premise in premises if len(premise.corners) > 1]
    count = 1 << len(varying)
    if count <= most_rules:
        return count

    def relative(premise: Premise) -> float:
        return float(premise.bounds.width / premise.bounds.magnitude)

    ranked = "; ".join(
        f"{p.name} in {p.bounds}, width {100 * relative(p):.3g} % of its size"
        for p in sorted(varying, key=relative)
    )
    raise ModelError(
        f"{len(varying)} premises make {count} rules, more than most_rules = {most_rules}; each "
        "premise doubles them, and a narrow one is the cheapest to do without (as an uncertainty, "
        f"or by a smaller box): {ranked}"
    )
