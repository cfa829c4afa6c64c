"""Equations of motion in symbols, the same as matrices whose entries are premises, and steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy as sp


@dataclass(frozen=True, slots=True)
class Step:
    r"""One line of reasoning: ``title`` in plain words, ``latex`` in display mathematics.

    ``latex`` has neither dollar signs nor an environment around it; it fits inside ``\[ ... \]``.
    """

    title: str
    latex: str


@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """xdot = f(x, u, w), y = outputs(x, u), in symbols; ``units`` by symbol.

    With ``sample_time`` T in s, x(t + T) replaces xdot.  ``scheduling`` are the
    disturbances that appear in coefficients alone: no term goes to their columns of E.
    """

    f: tuple[sp.Expr, ...]
    states: tuple[sp.Symbol, ...]
    inputs: tuple[sp.Symbol, ...]
    disturbances: tuple[sp.Symbol, ...]
    outputs: tuple[sp.Expr, ...]
    units: Mapping[sp.Symbol, str]
    sample_time: float | None = None
    scheduling: tuple[sp.Symbol, ...] = ()

    def named(self, symbols: Sequence[sp.Symbol]) -> tuple[str, ...]:
        """Return ``"x1 [rad]"``, ... for the symbols."""
        return tuple(f"{symbol} [{self.units.get(symbol, '-')}]" for symbol in symbols)


@dataclass(frozen=True, slots=True, eq=False)
class BoundedNumber:
    """A number that is no fraction, such as pi or a rest that was solved for, with its bounds."""

    expression: sp.Expr
    lower: Fraction
    upper: Fraction

    @property
    def middle(self) -> Fraction:
        return (self.lower + self.upper) / 2


@dataclass(frozen=True, slots=True, eq=False)
class Factored:
    """A, B, C, D, E with entries in premise symbols, and what each premise stands for.

    ``constants`` gives the values of other symbols that may appear in the entries; of ``numbers``,
    which are no fractions, the middle of their bounds.
    """

    matrices: Mapping[str, sp.Matrix]
    premises: Mapping[sp.Symbol, sp.Expr]
    constants: Mapping[sp.Symbol, Fraction] = field(default_factory=dict)
    numbers: Mapping[sp.Symbol, BoundedNumber] = field(default_factory=dict)

    def pairs(self, plant: Equations) -> list[tuple[str, sp.Expr, sp.Expr]]:
        """Return (place, plant's expression, the same rebuilt from the entries), row by row."""
        import sympy as sp

        x, u, w = (
            sp.Matrix(symbols) for symbols in (plant.states, plant.inputs, plant.disturbances)
        )
        m = self.matrices
        rebuilt = m["A"] * x + _times(m["B"], u) + _times(m["E"], w)
        outputs = m["C"] * x + _times(m["D"], u)
        values = {**self.premises, **{s: number.expression for s, number in self.numbers.items()}}
        rows = [*zip(plant.f, rebuilt, strict=True), *zip(plant.outputs, outputs, strict=True)]
        return [
            (
                f"row {row}" if row <= len(plant.f) else f"output {row - len(plant.f)}",
                expected,
                written.xreplace(values),
            )
            for row, (expected, written) in enumerate(rows, start=1)
        ]


def _times(matrix: sp.Matrix, vector: sp.Matrix) -> sp.Matrix:
    """Return matrix * vector, zero when there is nothing to multiply with."""
    import sympy as sp

    return matrix * vector if len(vector) else sp.zeros(matrix.rows, 1)
