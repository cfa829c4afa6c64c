"""Where a plant rests, found from its equations: decimals next to it, and the ball that holds it.

A rest that is given in part leaves some values of states and inputs to be found.  Newton's method
with exact points and residuals in ball arithmetic finds them; nothing is proved here.  The checker
proves that a rest lies in the balls (``takagi.certificates.checker.plant.balls``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from takagi.models.equations.equilibrium import decimal_near, refuse_residuals, residuals
from takagi.models.equations.problem import cleaned
from takagi.models.errors import ModelError
from takagi.models.files.units import behind
from takagi.models.intervals.interval import Number, exact, rational
from takagi.models.plant.plant import Plant, Variable
from takagi.models.ranges.expression_range import expression_value

if TYPE_CHECKING:
    RestValues = Mapping[sp.Symbol, Fraction]

SHARES = (Fraction(1, 2), Fraction(1, 8), Fraction(7, 8))  # of a range, to start from
MOST_STARTS, MOST_STEPS = 27, 40
DIGITS, POINT_DIGITS = 26, 60  # to which steps shrink, and which points have
SAME = Fraction(1, 10**9)  # of the size: two rests that are no nearer are two
SIMPLE = 1000  # largest denominator of a rest that is tried as a fraction


def solve_rest(plant: Plant, starts: Mapping[sp.Symbol, Number | None]) -> Plant:
    """Return the plant with the rests found that ``starts`` names, at values near the given ones.

    A rest that is a short decimal or fraction is found exactly; another one has the decimal next
    to it, ``within`` thirteen digits.  Without a value to start from the range is searched.

    Raises
    ------
    ModelError : a symbol that is no state or input, fewer equations than values to find, no rest,
        several rests in the ranges, a rest outside its range.
    """
    for symbol in starts:
        if symbol not in {v.symbol for v in (*plant.states, *plant.inputs)}:
            raise ModelError(
                f"plant {plant.name!r}: the rest of {symbol} was to be found; only states and "
                "inputs rest where the equations say, give the others a number"
            )
    search = _Search(plant, [v for v in plant.variables if v.symbol in starts])
    rests = search.only({s: None if v is None else exact(v) for s, v in starts.items()})
    simple = search.fractions(rests)
    return replace(
        plant,
        states=tuple(_resting(v, rests, simple) for v in plant.states),
        inputs=tuple(_resting(v, rests, simple) for v in plant.inputs),
    )


def _resting(variable: Variable, rests: RestValues, simple: RestValues) -> Variable:
    if variable.symbol in simple:
        return replace(variable, rest=simple[variable.symbol], within=Fraction(0), equals=None)
    if variable.symbol not in rests:
        return variable
    middle, radius = decimal_near(rests[variable.symbol])
    return replace(variable, rest=middle, within=radius, equals=None)


class _Search:
    """The equations at rest, in the values that are to be found."""

    def __init__(self, plant: Plant, unknowns: Sequence[Variable]) -> None:
        self.plant, self.wanted = plant, tuple(unknowns)
        values = {
            p.symbol: rational(p.value) if p.equals is None else p.equals for p in plant.parameters
        }
        self.given = {
            v.symbol: rational(v.rest) if v.equals is None else v.equals
            for v in plant.variables
            if v not in unknowns
        }
        mass = None
        if plant.mass is not None:
            mass = sp.Matrix(*plant.mass.shape, cleaned(list(plant.mass), values))
        values_known = {v.symbol: self.given.get(v.symbol, v.symbol) for v in plant.variables}
        self.rows = residuals(plant, cleaned(plant.equations, values), mass, values_known)
        self.left = [k for k, row in enumerate(self.rows) if sp.simplify(row) != 0]
        self._check_count()
        self.slopes = [[self.rows[k].diff(v.symbol) for v in self.wanted] for k in self.left]

    def _check_count(self) -> None:
        names = ", ".join(v.name for v in self.wanted)
        if len(self.left) < len(self.wanted):
            rows = ", ".join(f"{self.plant.states[k].name}'" for k in self.left) or "none"
            raise ModelError(
                f"plant {self.plant.name!r}: the rests of {names} are to be found, but only "
                f"{len(self.left)} of the equations at rest depend on what is not known ({rows}); "
                f"give the rest of {len(self.wanted) - len(self.left)} of them"
            )

    def only(self, starts: Mapping[sp.Symbol, Fraction | None]) -> RestValues:
        """Return the one rest that is found in the ranges."""
        inside: list[RestValues] = []
        outside: list[RestValues] = []
        nearest: dict[sp.Symbol, Fraction] = {}
        for point in self._starts(starts):
            solution, solved = self._newton(point)
            nearest = nearest or solution
            if not solved:
                continue
            fits = all(v.range is None or v.range.contains(solution[v.symbol]) for v in self.wanted)
            solutions = inside if fits else outside
            if not any(_same(solution, earlier) for earlier in solutions):
                solutions.append(solution)
        if not inside:
            self._none(outside, nearest)
        if len(inside) > 1:
            solution_texts = "; or ".join(self._told(solution) for solution in inside)
            name = self.wanted[0].name
            raise ModelError(
                f"plant {self.plant.name!r}: it has several rests in its ranges: {solution_texts}; "
                f"say which by rest = {{ near = ... }} for {name}, or with a smaller range"
            )
        return inside[0]

    def fractions(self, rests: RestValues) -> RestValues:
        """Return those of the values that are short fractions, if the equations then hold."""
        simple = {s: v for s, value in rests.items() for v in [_simple(value)] if v is not None}
        written = {s: sp.Rational(v.numerator, v.denominator) for s, v in simple.items()}
        rows = [row.subs(written) for row in self.rows]
        if sum(sp.simplify(row) != 0 for row in rows) == len(rests) - len(simple):
            return simple
        if len(self.left) > len(self.wanted):
            equation_names = ", ".join(f"{self.plant.states[k].name}'" for k in self.left)
            raise ModelError(
                f"plant {self.plant.name!r}: it rests at {self._told(rests)}, but {equation_names} "
                "are more equations than values to find, so that no exact rest can be proved; let "
                f"{len(self.left) - len(self.wanted)} more be found"
            )
        return {}

    def _starts(
        self, start_values: Mapping[sp.Symbol, Fraction | None]
    ) -> Iterator[dict[sp.Symbol, Fraction]]:
        choices = []
        for v in self.wanted:
            start = start_values[v.symbol]
            if start is not None:
                choices.append([start])
            elif v.range is not None:
                choices.append([v.range.lower + share * v.range.width for share in SHARES])
            else:
                choices.append([Fraction(0), Fraction(1), Fraction(-1)])
        for picks in islice(product(*choices), MOST_STARTS):
            yield {v.symbol: value for v, value in zip(self.wanted, picks, strict=True)}

    def _newton(self, start: dict[sp.Symbol, Fraction]) -> tuple[dict[sp.Symbol, Fraction], bool]:
        """Return where the steps end, and whether all equations hold there."""
        point = dict(start)
        symbols = [v.symbol for v in self.wanted]
        for _ in range(MOST_STEPS):
            at = self._values(point)
            if at is None:
                return point, False
            rows, slopes = at
            if not np.all(np.isfinite(slopes)):
                return point, False
            step = np.linalg.lstsq(slopes, rows, rcond=None)[0]
            converged = True
            for symbol, move in zip(symbols, step, strict=True):
                size = abs(point[symbol])
                point[symbol] = round(point[symbol] - Fraction(float(move)), POINT_DIGITS)
                converged &= (
                    abs(Fraction(float(move))) <= max(size, Fraction(1, 10**9)) / 10**DIGITS
                )
            if converged:
                return point, self._holds(point)
        return point, False

    def _values(self, point: RestValues) -> tuple[np.ndarray, np.ndarray] | None:
        try:
            rows = [expression_value(self.rows[k], _of(self.rows[k], point)) for k in self.left]
            slopes = [[expression_value(s, _of(s, point)) for s in line] for line in self.slopes]
        except ModelError:
            return None
        return np.array(rows), np.array(slopes)

    def _holds(self, point: RestValues) -> bool:
        """Return whether a residual is explained by the last digits of the point."""
        at = self._values(point)
        if at is None:
            return False
        rows, slopes = at
        if np.linalg.matrix_rank(slopes) < len(self.wanted):
            return False
        size = np.array([max(float(abs(point[v.symbol])), 1e-9) for v in self.wanted])
        return bool(np.all(np.abs(rows) <= 1e-18 * (np.abs(slopes) @ size)))

    def _told(self, rests: RestValues) -> str:
        return ", ".join(
            f"{v.name} = {float(rests[v.symbol]):.6g}{behind(v.unit)}" for v in self.wanted
        )

    def _none(self, outside: Sequence[RestValues], nearest: RestValues) -> None:
        """Refuse: a rest outside the ranges, or none with every residual."""
        if outside:
            bent = [
                f"{v.name} = {float(outside[0][v.symbol]):.6g}{behind(v.unit)} outside {v.range}"
                for v in self.wanted
                if v.range is not None and not v.range.contains(outside[0][v.symbol])
            ]
            raise ModelError(
                f"plant {self.plant.name!r}: the rest that its equations have lies outside its "
                f"ranges: {', '.join(bent)}; widen the ranges, or give other rests"
            )
        at = {v.symbol: nearest.get(v.symbol, v.rest) for v in self.plant.variables}
        sizes: dict[Variable, Fraction | None] = {}
        for variable, row in zip(self.plant.states, self.rows, strict=True):
            sizes[variable] = _number(row, at)
        names = ", ".join(v.name for v in self.wanted)
        advice = f"no rest of {names} was found; give other values at rest, or let more be found"
        refuse_residuals(self.plant, sizes, at, advice)


def _number(row: sp.Expr, at: RestValues) -> Fraction | None:
    try:
        return Fraction(expression_value(row, _of(row, at)))
    except ModelError:
        return None


def _of(expression: sp.Expr, point: RestValues) -> RestValues:
    return {s: point[s] for s in expression.free_symbols}


def _simple(value: Fraction) -> Fraction | None:
    """Return the short decimal or fraction that a value is to all its digits, if there is one."""
    for short_number in (round(value, 12), value.limit_denominator(SIMPLE)):
        if abs(value - short_number) <= Fraction(1, 10**22) * max(abs(value), Fraction(1, 1000)):
            return short_number
    return None


def _same(first: RestValues, second: RestValues) -> bool:
    return all(abs(first[s] - second[s]) <= SAME * max(abs(first[s]), SAME) for s in first)
