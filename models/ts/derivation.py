"""The derivation that a model came from: its steps as LaTeX, and what was derived in symbols."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from takagi.models.equations.equations import Step

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


SPECIAL = {letter: f"\\{letter}" for letter in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
}


@dataclass(frozen=True, slots=True)
class Derivation:
    """The steps from the plant's equations to the vertex matrices, in order.

    ``exactness`` says how it was checked that the factored form is the plant; empty when nothing
    is said.  ``form`` has the plant, its factored form and its premises in symbols, where the model
    was derived from symbols.
    """

    steps: tuple[Step, ...]
    exactness: str = ""
    form: SymbolicForm | None = field(default=None, repr=False, compare=False)

    @property
    def latex(self) -> str:
        r"""The whole derivation as LaTeX paragraphs with ``\[ ... \]`` displays (amsmath)."""
        return "\n".join(f"{_escaped(step.title)}\n\\[\n{step.latex}\n\\]" for step in self.steps)


def _escaped(words: str) -> str:
    """Return plain words with the characters that LaTeX reads as commands written out."""
    return "".join(SPECIAL.get(letter, letter) for letter in words)
