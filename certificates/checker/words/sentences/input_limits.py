"""What a proved claim of kind ``input-limits`` says, of sizes and of rates."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.kinds.invariant_set import InvariantSet
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.invariant_set import (
    letters,
    motion,
    rounded_level,
    where_valid,
)
from takagi.certificates.checker.words.loop_words import about, deviations
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(
    name: str,
    loop: PolytopicLoop,
    held: InvariantSet,
    limits: Sequence[Fraction],
    rates: Sequence[Fraction] | None,
    moving: Sequence[Fraction],
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    rates : the limits on |u_k'|, or on the steps of u_k; None where none is claimed.
    moving : the rates of memberships that they take for granted; () for none.
    """
    return name, (
        f"|u_k| <= {_most(limits)} for u = -Kx, from anywhere in {{x'Px <= {rounded_level(held)}}}"
        f"{_rate(loop, rates, moving)}, "
        f"along {about(loop)}; the set is invariant{where_valid(loop)}; "
        f"{motion(held, loop)}{deviations(loop, 'xu' + letters(held))}"
    )


def _rate(loop: PolytopicLoop, rates: Sequence[Fraction] | None, moving: Sequence[Fraction]) -> str:
    if rates is None:
        return ""
    move = "|u_k(x+) - u_k(x)|" if loop.is_discrete else "|u_k'|"
    shown = ", ".join(at_least(value, 6) for value in moving)
    assumed = f" for memberships with |h_j'| <= {shown}" if moving else ""
    return f" and {move} <= {_most(rates)}{assumed}"


def _most(limits: Sequence[Fraction]) -> str:
    return ", ".join(at_most(limit, 6) for limit in limits)
