"""How many rules a model would have, before anything of it is built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from takagi.models.ts.premise import Premise

ROUGH = Fraction(1, 50)  # allowed excess of bounds that are only used to rank premises
MOST_TOLD = 8  # the most premises that a message names


@dataclass(frozen=True, slots=True, eq=False)
class RuleCount:
    """The rules that premises make: 2^k for the k that are not constant.

    Attributes
    ----------
    rules : number of vertices.
    premises : those that vary, sorted by width over size: the one with the least effect comes
        first.
    constant : those that cost no rule.
    """

    rules: int
    premises: tuple[Premise, ...]
    constant: tuple[Premise, ...]

    @property
    def words(self) -> str:
        """The first premises in that order: range, and width as a share of its size."""
        told = [
            f"{_named(p)} in {p.bounds}, width {100 * _relative(p):.3g} % of its size"
            for p in self.premises[:MOST_TOLD]
        ]
        left = len(self.premises) - len(told)
        return "; ".join(told) + (f"; and {left} more" if left else "")


def counted(premises: Sequence[Premise]) -> RuleCount:
    """Return the count of premises that are bounded already."""
    varying = [premise for premise in premises if len(premise.corners) > 1]
    constant = tuple(premise for premise in premises if len(premise.corners) == 1)
    return RuleCount(1 << len(varying), tuple(sorted(varying, key=_relative)), constant)


def _relative(premise: Premise) -> float:
    return float(premise.bounds.width / premise.bounds.magnitude)


def _named(premise: Premise) -> str:
    """Return e.g. ``z1 = sin(x)/x``: a number alone says nothing before there is a model."""
    return premise.name if premise.proof is None else f"{premise.name} = {premise.proof.expression}"
