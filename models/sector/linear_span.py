"""Exact linear algebra on sums of atoms: which sums are combinations of others."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.sector.terms import Sum

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
