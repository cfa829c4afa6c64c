"""A step of a derivation: of equations, and of the model made from them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Step:
    r"""One line of reasoning: ``title`` in plain words, ``latex`` in display mathematics.

    ``latex`` has neither dollar signs nor an environment around it; it fits inside ``\[ ... \]``.
    """

    title: str
    latex: str
