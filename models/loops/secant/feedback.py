"""A feedback law u = v(x, w) in symbols, with amplitude limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact, rational

if TYPE_CHECKING:
    import sympy as sp


@dataclass(frozen=True, slots=True, eq=False)
class Feedback:
    """u_j = v_j(x, w), or the nearest value in [lower_j, upper_j] where u_j is limited.

    Attributes
    ----------
    commands : input -> v_j, an expression in states, disturbances and parameters of the plant.
    limits : input -> (lower, upper) for each input that saturates.

    Raises
    ------
    ModelError : limits are given for an input without command, or in the wrong order.
    """

    commands: Mapping[sp.Symbol, sp.Expr]
    limits: Mapping[sp.Symbol, Interval] = field(default_factory=dict)

    def __post_init__(self) -> None:
        unknown = [str(symbol) for symbol in self.limits if symbol not in self.commands]
        if unknown:
            raise ModelError(
                f"limits of {', '.join(unknown)} were given, but the law commands "
                f"{', '.join(map(str, self.commands)) or 'nothing'}; limit a commanded input"
            )
        limits = {
            symbol: side if isinstance(side, Interval) else Interval.of(*side)
            for symbol, side in self.limits.items()
        }
        object.__setattr__(self, "commands", MappingProxyType(dict(self.commands)))
        object.__setattr__(self, "limits", MappingProxyType(limits))


def product_memberships(premises: Sequence[tuple[sp.Expr, Number, Number]]) -> tuple[sp.Expr, ...]:
    """Return h_i = prod_k w_k,c_ik, w_k0 = (upper - z)/(upper - lower), w_k1 = 1 - w_k0.

    Parameters
    ----------
    premises : (z_k, lower, upper) with z_k in symbols.  The rules are ordered as in a ``TSModel``:
        the index of the last premise changes fastest.  A premise with lower == upper makes no rule
        there and must be left out here.

    Raises
    ------
    ModelError : lower >= upper.
    """
    import sympy as sp

    found: list[sp.Expr] = [sp.S.One]
    for expression, lower, upper in premises:
        first, last = exact(lower), exact(upper)
        if first >= last:
            raise ModelError(
                f"premise {expression}: lower bound {float(first):.9g} is not below upper bound "
                f"{float(last):.9g}; give the smaller one first, leave out a constant premise"
            )
        low, high = rational(first), rational(last)
        weights = ((high - expression) / (high - low), (expression - low) / (high - low))
        found = [share * weight for share in found for weight in weights]
    return tuple(found)


def blended_feedback(
    states: Sequence[sp.Symbol],
    inputs: Sequence[sp.Symbol],
    memberships: Sequence[sp.Expr],
    gains: Sequence[Sequence[Sequence[Number]]],
    *,
    limits: Mapping[sp.Symbol, Interval] | None = None,
) -> Feedback:
    """Return u = -sum_j h_j(x) K_j x, the parallel distributed compensation.

    Parameters
    ----------
    memberships : h_j in symbols, e.g. from ``product_memberships``.  They are not normalised, even
        if they do not sum to 1.
    gains : K_j, (m, n) each; a float is read as the decimal number that it prints as.

    Raises
    ------
    ModelError : a gain has the wrong shape, or the numbers of gains and memberships differ.

    Source: Wang, Tanaka, Griffin (1996), IEEE Trans. Fuzzy Systems 4(1).
    """
    import sympy as sp

    if len(gains) != len(memberships):
        raise ModelError(
            f"{len(gains)} gains for {len(memberships)} memberships; give one K_j for each h_j"
        )
    total = sp.zeros(len(inputs), 1)
    for number, (share, gain) in enumerate(zip(memberships, gains, strict=True), start=1):
        rows = [[rational(entry) for entry in row] for row in gain]
        if len(rows) != len(inputs) or any(len(row) != len(states) for row in rows):
            raise ModelError(
                f"gain {number} of {len(gains)} has rows of lengths {[len(row) for row in rows]}; "
                f"{len(inputs)} x {len(states)} is needed"
            )
        total -= share * (sp.Matrix(rows) * sp.Matrix(list(states)))
    return Feedback(dict(zip(inputs, total, strict=True)), limits or {})
