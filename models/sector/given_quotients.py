"""Fixed premises N/D with a sum D, such as sin(s)/s with s = x + 2 y, put into the equations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from takagi.models.sector.factored_form import FactoredForm

if TYPE_CHECKING:
    import sympy as sp


def with_quotients(
    rows: Sequence[sp.Expr], wanted: Mapping[sp.Symbol, sp.Expr], states: Sequence[sp.Symbol]
) -> tuple[tuple[sp.Expr, ...], dict[sp.Symbol, sp.Expr]]:
    """Return the rows with N = z D for each wanted z = N/D, and the z that were used.

    sin(x + 2 y) becomes z x + 2 z y, whose terms go to x and y. A search term by term would not
    find this quotient, because sin(x + 2 y) does not vanish for x = 0 alone or y = 0 alone.  Done
    where D is a linear sum of two or more states and N appears in a row.
    """
    import sympy as sp

    found = {}
    written = tuple(rows)
    for symbol, premise in wanted.items():
        numerator, denominator = premise.as_numer_denom()
        number, core = numerator.as_coeff_Mul()
        divisor = sp.expand(denominator / number)
        if not (divisor.is_Add and divisor.is_polynomial(*states)) or core.is_polynomial(*states):
            continue
        polynomial = sp.Poly(divisor, *states)
        if not polynomial.is_homogeneous or polynomial.total_degree() != 1:
            continue
        replaced = tuple(row.subs(core, symbol * divisor) for row in written)
        if replaced != written:
            written, found[symbol] = replaced, premise
    return written, found


def without_quotients(form: FactoredForm, quotients: Mapping[sp.Symbol, sp.Expr]) -> FactoredForm:
    """Return the form with each z written as its expression again."""
    if not quotients:
        return form
    back = dict(quotients)
    return FactoredForm(
        tuple(premise.xreplace(back) for premise in form.premises),
        {
            place: {
                tuple(member.xreplace(back) for member in members): c
                for members, c in polynomial.items()
            }
            for place, polynomial in form.entries.items()
        },
    )
