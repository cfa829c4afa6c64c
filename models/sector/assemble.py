"""From entries in premise symbols to a TSModel: exactness check, vertices, derivation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from takagi.models.derivation import Derivation, Step
from takagi.models.enclosure.interval import Number
from takagi.models.errors import ModelError
from takagi.models.premise import Premise
from takagi.models.ts_model import TSModel

if TYPE_CHECKING:
    import sympy as sp

__all__ = ["Factored", "Equations", "assemble"]

LETTERS = ("A", "B", "C", "D", "E")


@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """xdot = f(x, u, w), y = outputs(x, u), in symbols; ``units`` by symbol."""

    f: tuple[sp.Expr, ...]
    states: tuple[sp.Symbol, ...]
    inputs: tuple[sp.Symbol, ...]
    disturbances: tuple[sp.Symbol, ...]
    outputs: tuple[sp.Expr, ...]
    units: Mapping[sp.Symbol, str]

    def named(self, symbols: Sequence[sp.Symbol]) -> tuple[str, ...]:
        """Return ``"x1 [rad]"``, ... for the symbols."""
        return tuple(f"{symbol} [{self.units.get(symbol, '-')}]" for symbol in symbols)


@dataclass(frozen=True, slots=True, eq=False)
class Factored:
    """A, B, C, D, E with entries in premise symbols, and what each premise stands for.

    ``constants`` gives the value of symbols that may stand in the entries besides.
    """

    matrices: Mapping[str, sp.Matrix]
    premises: Mapping[sp.Symbol, sp.Expr]
    constants: Mapping[sp.Symbol, Fraction] = field(default_factory=dict)

    def check_exact(self, plant: Equations) -> None:
        """Raise ModelError unless f - (A x + B u + E w) and y - (C x + D u) simplify to zero."""
        import sympy as sp

        x, u, w = (sp.Matrix(part) for part in (plant.states, plant.inputs, plant.disturbances))
        m = self.matrices
        rebuilt = m["A"] * x + _times(m["B"], u) + _times(m["E"], w)
        seen = m["C"] * x + _times(m["D"], u)
        pairs = [*zip(plant.f, rebuilt, strict=True), *zip(plant.outputs, seen, strict=True)]
        for row, (wanted, written) in enumerate(pairs, start=1):
            rest = sp.simplify(wanted - written.subs(self.premises))
            if rest != 0:
                what = f"row {row}" if row <= len(plant.f) else f"output {row - len(plant.f)}"
                raise ModelError(
                    f"{what}: the factored form misses the plant by {rest}, which does not "
                    "simplify to 0; correct the entries of that row"
                )

    def check_multilinear(self) -> None:
        """Raise ModelError unless every entry is of degree <= 1 in each premise, and no more.

        The products of weights blend such entries exactly, and no others.
        """
        import sympy as sp

        for letter, matrix in self.matrices.items():
            for index, entry in enumerate(matrix):
                where = f"{letter}[{index // matrix.cols}, {index % matrix.cols}] = {entry}"
                strange = entry.free_symbols - set(self.premises) - set(self.constants)
                if strange:
                    names = ", ".join(sorted(map(str, strange)))
                    raise ModelError(
                        f"{where} still contains {names}; replace it by a premise, or give its "
                        "value as a parameter"
                    )
                for symbol in self.premises:
                    if sp.simplify(entry.diff(symbol, 2)) != 0:
                        raise ModelError(
                            f"{where} is not linear in the premise {symbol}; make the whole "
                            "entry a premise"
                        )


def assemble(
    plant: Equations,
    factored: Factored,
    premises: Sequence[Premise],
    *,
    steps: Sequence[Step] = (),
    names: Mapping[str, Sequence[str]] | None = None,
    box: Mapping[str, tuple[Number, Number]],
    name: str,
    source: str,
) -> TSModel:
    """Return the TSModel with the entries' values at every corner of the premises.

    Parameters
    ----------
    premises : one per symbol of ``factored.premises``, in that order.
    steps : put between the plant and its factored form in the derivation.
    names : states, inputs, outputs, disturbances; None names them by symbol and unit.

    Raises
    ------
    ModelError : the factored form is not exact, or an entry is not multilinear in the premises.
    """
    import sympy as sp

    factored.check_exact(plant)
    factored.check_multilinear()
    rules = list(product(*(range(len(premise.corners)) for premise in premises)))
    fixed = {s: sp.Rational(*v.as_integer_ratio()) for s, v in factored.constants.items()}
    arrays: dict[str, list[NDArray[np.float64]]] = {letter: [] for letter in LETTERS}
    for rule in rules:
        corner = {
            symbol: sp.Rational(*premise.corners[k].as_integer_ratio())
            for symbol, premise, k in zip(factored.premises, premises, rule, strict=True)
        }
        for letter, matrix in factored.matrices.items():
            values = [float(entry.subs(fixed | corner)) for entry in matrix]
            arrays[letter].append(np.array(values).reshape(matrix.shape))
    labels = names or {
        "states": plant.named(plant.states),
        "inputs": plant.named(plant.inputs),
        "outputs": tuple(f"y{k} [-]" for k in range(1, len(plant.outputs) + 1)),
        "disturbances": plant.named(plant.disturbances),
    }
    stacks = {letter: np.array(stack) for letter, stack in arrays.items()}
    given = {letter: stack if stack.size else None for letter, stack in stacks.items()}
    return TSModel(
        stacks["A"],
        given["B"],
        C=given["C"],
        D=given["D"],
        E=given["E"],
        states=labels["states"],
        inputs=labels["inputs"],
        outputs=labels["outputs"],
        disturbances=labels["disturbances"],
        premises=premises,
        rules=rules,
        box=box,
        name=name,
        source=source,
        derivation=_derivation(plant, factored, premises, steps),
    )


def _times(matrix: sp.Matrix, vector: sp.Matrix) -> sp.Matrix:
    """Return matrix * vector, zero when there is nothing to multiply with."""
    import sympy as sp

    return matrix * vector if len(vector) else sp.zeros(matrix.rows, 1)


def _derivation(
    plant: Equations, factored: Factored, premises: Sequence[Premise], between: Sequence[Step]
) -> Derivation:
    import sympy as sp

    symbols = {s: sp.Symbol(p.latex) for s, p in zip(factored.premises, premises, strict=True)}
    left = _matrix(sp.Matrix([sp.Symbol(rf"\dot{{{sp.latex(s)}}}") for s in plant.states]))
    terms = [
        _matrix(factored.matrices[letter].subs(symbols)) + _matrix(sp.Matrix(vector))
        for letter, vector in (("A", plant.states), ("B", plant.inputs), ("E", plant.disturbances))
        if vector
    ]
    steps = [
        Step("Plant.", left + " = " + _matrix(sp.Matrix(plant.f))),
        *between,
        Step("Factored form, equal to the plant.", left + " = " + " + ".join(terms)),
    ]
    if factored.constants:
        values = [rf"{sp.latex(s)} = {_decimal(v)}" for s, v in factored.constants.items()]
        steps.append(Step("Constants, in SI units.", r",\quad ".join(values)))
    expressions = factored.premises.values()
    steps += [_premise_step(p, e) for p, e in zip(premises, expressions, strict=True)]
    return Derivation(tuple(steps))


def _premise_step(premise: Premise, expression: sp.Expr) -> Step:
    import sympy as sp

    unit = "" if premise.unit == "-" else rf"\ \mathrm{{[{premise.unit}]}}"
    bounds = rf"{_decimal(premise.lower)} \le {premise.latex} \le {_decimal(premise.upper)}"
    return Step(
        f"Premise {premise.name}; bounds: {premise.evidence}.",
        rf"{premise.latex} = {sp.latex(expression)}, \qquad {bounds}{unit}",
    )


def _matrix(matrix: sp.Matrix) -> str:
    import sympy as sp

    return str(sp.latex(matrix, mat_delim="", mat_str="pmatrix"))


def _decimal(value: Number) -> str:
    text = f"{float(value):.12g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    return text
