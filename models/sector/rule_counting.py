"""How many rules a model would have, before anything of it is built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.models.ts.premise import Premise

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.plant import Plant

__all__ = ["RuleCount", "counted", "rule_count"]

ROUGH = Fraction(1, 50)  # excess of bounds that only rank premises
MOST_TOLD = 8  # premises that are told, of how many there may be


@dataclass(frozen=True, slots=True, eq=False)
class RuleCount:
    """The rules that premises make: 2^k for the k that are not constant.

    Attributes
    ----------
    rules : number of vertices.
    premises : those that vary, the cheapest to do without first: by width over size.
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


def rule_count(
    f: Plant | Sequence[sp.Expr],
    states: Sequence[sp.Symbol] = (),
    inputs: Sequence[sp.Symbol] = (),
    **options: Any,
) -> RuleCount:
    """Return how many rules ``sector_model`` would make of the same arguments, and why.

    No vertex is computed; bounds are proved, but looser than the model's: each end exceeds the
    premise's range by up to a fiftieth of its width.

    Parameters
    ----------
    options : any of ``sector_model`` but ``most_rules``.

    Raises
    ------
    ModelError : as ``sector_model``, but not for too many rules.
    """
    from takagi.models.intervals.interval import exact
    from takagi.models.sector.arguments import posed
    from takagi.models.sector.premise_bounds import Asked, bounded_premises

    given, sampled = options.pop("bounds", None), options.pop("sampled_bounds", ())
    tolerance = options.pop("tolerance", None)
    problem, factored = posed(f, states, inputs, **options)
    share = ROUGH if tolerance is None else exact(tolerance)
    return counted(
        bounded_premises(problem, factored, Asked(given or {}, frozenset(sampled), share))
    )


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
