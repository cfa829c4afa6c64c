"""The derivation that a model came from, step by step, as LaTeX."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from takagi.models.equations.step import Step

if TYPE_CHECKING:
    from takagi.models.equations.symbolic_form import SymbolicForm

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
