"""What a model was derived from, in symbols: plant, equations about rest, entries, premises."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from takagi.models.equations.equations import Factored
    from takagi.models.equations.problem import Problem
    from takagi.models.plant.plant import Plant


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicForm:
    """The symbols behind a model of ``sector_model``.

    Attributes
    ----------
    plant : as it was given; None where expressions were given instead.
    problem : equations in deviations from the equilibrium, box and domain.
    factored : A, B, C, D, E with entries in premise symbols, and what each premise stands for.
    kind : "sector" where f = A(z) x + ..., "secant" where A(z), ... are the slopes of f.
    """

    plant: Plant | None
    problem: Problem
    factored: Factored
    kind: Literal["sector", "secant"] = "sector"
