"""Equations in symbols, the units of their premises, and mass matrices.

From M(x) x' = f to x' = adj(M) f / det M, after a proof that det M has no zero on the box.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.equations.derivation_step import Step
from takagi.models.errors import ModelError
from takagi.models.files.units import PURE, Dimension, parse_unit
from takagi.models.intervals.interval import Interval
from takagi.models.plant.dimensions import NUMBERS, dimension_of
from takagi.models.plant.plant import Plant
from takagi.models.ranges.expression_range import Domain, expression_range

if TYPE_CHECKING:
    import sympy as sp


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


UNKNOWN = "SI"  # coherent SI units; which, is hidden in the numbers


def units_of(plant: Plant, premises: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, str]:
    """Return the unit of each premise that is written with the plant's own parameters."""
    unit_texts = {p.symbol: p.unit for p in plant.parameters}
    unit_texts |= {v.symbol: v.unit for v in plant.variables}
    premise_units = {}
    for symbol, expression in premises.items():
        try:
            units = {s: parse_unit(unit).dimension for s, unit in unit_texts.items()}
            name = f"premise {symbol}"
            premise_units[symbol] = _text(
                expression, unit_texts, dimension_of(expression, units, plant.values, owner=name)
            )
        except (ModelError, KeyError):
            premise_units[symbol] = UNKNOWN
    return premise_units


def unit_of(expression: sp.Expr, units: Mapping[sp.Symbol, str]) -> str:
    """Return the unit of an expression whose parameters are numbers; "SI" where they hide it.

    sin(x)/x is a pure number and x y has the unit of both; a term with a number other than 1 and
    -1 may have any unit, for the number may be a parameter's value.

    ``units`` : of the variables.
    """
    try:
        dimensions = {s: parse_unit(unit).dimension for s, unit in units.items()}
    except ModelError:
        return UNKNOWN
    return _text(expression, units, _dimension(expression, dimensions))


def _text(expression: sp.Expr, units: Mapping[sp.Symbol, str], dimension: Dimension | None) -> str:
    # A variable by itself keeps its own words: rad is a pure number too.
    if expression in units:
        return units[expression]
    integral = dimension is not None and all(e.denominator == 1 for e in dimension.exponents)
    return str(dimension) if integral else UNKNOWN  # half powers are not written in units


def _dimension(expression: sp.Expr, units: Mapping[sp.Symbol, Dimension]) -> Dimension | None:
    """Return the dimension; None where it cannot be told."""
    if expression.is_Symbol:
        return units.get(expression)
    if expression in (1, -1):
        return PURE
    if expression.is_Add:
        dimensions = {d for a in expression.args if (d := _dimension(a, units)) is not None}
        return dimensions.pop() if len(dimensions) == 1 else None
    if expression.is_Mul:
        total: Dimension | None = PURE
        for argument in expression.args:
            factor = _dimension(argument, units)
            total = None if total is None or factor is None else total.times(factor)
        return total
    if expression.is_Pow:
        base, exponent = _dimension(expression.base, units), expression.exp
        if base == PURE:
            return PURE
        rational_power = base is not None and exponent.is_Rational
        return (
            base.power(Fraction(int(exponent.p), int(exponent.q)))
            if rational_power and base
            else None
        )
    if hasattr(expression, "value_unit"):
        dimension = parse_unit(expression.value_unit).dimension
        for unit, order in zip(expression.argument_units, expression.orders, strict=True):
            dimension = dimension.times(parse_unit(unit).dimension.power(Fraction(-order)))
        return dimension
    if type(expression).__name__ in ("Abs", "Max", "Min"):
        dimensions = {d for a in expression.args if (d := _dimension(a, units)) is not None}
        return dimensions.pop() if len(dimensions) == 1 else None
    return PURE if type(expression).__name__ in NUMBERS else None


LARGEST_BLOCK = 5  # rows that hang together; the adjugate of a full 6 x 6 has 720 products an entry


def explicit(
    mass: sp.Matrix, f: tuple[sp.Expr, ...], plant: Plant, domain: Domain | None = None
) -> tuple[tuple[sp.Expr, ...], tuple[Step, ...]]:
    """Return (M^-1 f, steps of the derivation); the denominators det are kept in one piece.

    Rows that M does not couple are solved apart, so that each has the smallest determinant.

    ``domain`` : where det M must have no zero, in the plant's variables; None for the plant's box.

    Raises
    ------
    ModelError : det M contains 0 on the domain or cannot be bounded, M depends on an input or a
        disturbance, or more rows are coupled than can be solved in symbols.
    """
    import sympy as sp

    over = Domain.of_box(plant.box) if domain is None else domain
    symbols = {v.symbol for v in (*plant.states, *plant.uncertain)}
    symbols |= {p.symbol for p in plant.parameters}
    strange = mass.free_symbols - symbols
    if strange:
        names = ", ".join(sorted(map(str, strange)))
        raise ModelError(
            f"plant {plant.name!r}: the mass matrix depends on {names}; it may depend on states "
            "and parameters only"
        )
    rows = list(f)
    steps = []
    for block in _blocks(mass):
        block_matrix = mass.extract(block, block)
        labels = ", ".join(plant.states[k].name for k in block)
        if len(block) > LARGEST_BLOCK:
            raise ModelError(
                f"plant {plant.name!r}: the mass matrix couples {len(block)} rows ({labels}); up "
                f"to {LARGEST_BLOCK} are solved in symbols, solve the others by hand"
            )
        det = sp.factor_terms(sp.trigsimp(sp.expand(block_matrix.det(method="berkowitz"))))
        bounds = _bounded_away(det, plant, labels, over)
        solved = block_matrix.adjugate() * sp.Matrix([f[k] for k in block])
        for position, k in enumerate(block):
            rows[k] = sp.expand(solved[position]) / det
        if bounds is not None:
            words = f"Determinant of the mass matrix in {labels}: no zero, bounds by "
            lower, upper = bounds.outward(6).outward_floats()
            formula = rf"\det M = {sp.latex(det)} \in [{lower:.6g},\ {upper:.6g}]"
            steps.append(Step(words + "ball arithmetic.", formula))
    return tuple(rows), tuple(steps)


def _blocks(mass: sp.Matrix) -> list[list[int]]:
    """Return the sets of rows that hang together through entries off the diagonal."""
    from scipy.sparse.csgraph import connected_components

    joined = np.array([[entry != 0 for entry in mass.row(k)] for k in range(mass.rows)])
    count, group = connected_components(joined, directed=False)
    return sorted([k for k, g in enumerate(group) if g == number] for number in range(count))


def _bounded_away(det: sp.Expr, plant: Plant, labels: str, domain: Domain) -> Interval | None:
    """Return proved bounds of det without 0; None for a number."""
    advice = "shrink the ranges, or remove the state whose mass vanishes"
    if not det.free_symbols:
        if det == 0:
            raise ModelError(
                f"plant {plant.name!r}: the mass matrix is singular everywhere in the rows of "
                f"{labels}; {advice}"
            )
        return None
    try:
        det_range = expression_range(det, domain, tolerance=Fraction(1, 10**4))
    except ModelError as error:
        raise ModelError(
            f"plant {plant.name!r}: the determinant of the mass matrix in the rows of {labels}, "
            f"{det}, cannot be bounded: {error}"
        ) from error
    if det_range.outer.contains(0):
        where = _zero(det, plant) if domain.rectangle is not None else ""
        raise ModelError(
            f"plant {plant.name!r}: the mass matrix may be singular: its determinant in the rows "
            f"of {labels}, {det}, has the range {det_range.outer} on the box{where}; {advice}"
        )
    return det_range.outer


def _zero(det: sp.Expr, plant: Plant) -> str:
    """Return e.g. ``" (smallest near theta = 1.57)"`` from samples; words only, no proof."""
    import sympy as sp

    symbols = sorted(det.free_symbols, key=str)
    shares = range(0, 17)
    if len(symbols) > 3:
        return ""
    grids = [[plant.box[s].lower + plant.box[s].width * k / 16 for k in shares] for s in symbols]
    value = sp.lambdify(symbols, det)
    smallest = min(product(*grids), key=lambda point: abs(float(value(*map(float, point)))))
    at = ", ".join(f"{s} = {float(v):.4g}" for s, v in zip(symbols, smallest, strict=True))
    return f", nearest to 0 around {at}"
