"""Where a plant rests, exactly or in a proved ball.

Numbers of a plant that are not decimals: a decimal next to each, and how far it is at most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.files.units import behind
from takagi.models.intervals.interval import Interval, rational
from takagi.models.plant.design_settings import Rest
from takagi.models.plant.dimensions import short
from takagi.models.plant.plant import Plant, Variable
from takagi.models.ranges.expression_range import expression_range

DIGITS = 13  # of the number that its ball settles
PRECISION = 60  # decimals worked with


@dataclass(frozen=True, slots=True)
class Ball:
    """A number within ``radius`` of the decimal ``middle``, under the name ``symbol``.

    ``equals`` is the expression without symbols that it is; None for a rest that was solved for.
    """

    symbol: sp.Symbol
    middle: Fraction
    radius: Fraction
    equals: sp.Expr | None = None

    @property
    def side(self) -> Interval:
        return Interval(self.middle - self.radius, self.middle + self.radius)


def decimal_near(value: sp.Expr | Fraction) -> tuple[Fraction, Fraction]:
    """Return the decimal that the nearest float prints, and a radius that settles 13 digits.

    Raises
    ------
    ModelError : no finite real number, or 0.
    """
    if isinstance(value, Fraction):
        nearest = float(value)
    else:
        number = sp.N(value, PRECISION)
        if not (number.is_real and number.is_finite):
            raise ModelError(f"{value} is no finite real number")
        nearest = float(number)
    middle = Fraction(repr(nearest))
    if middle == 0:
        raise ModelError(f"{value} is too small to stand apart from 0")
    power = int(f"{float(middle):e}".partition("e")[2]) - DIGITS
    return middle, Fraction(10) ** power


def balls_of(plant: Plant) -> dict[sp.Symbol, Ball]:
    """Return variable or parameter -> its ball; a rest of x has the name ``x_rest``.

    Raises
    ------
    ModelError : a name that is taken.
    """
    balls = {
        p.symbol: Ball(p.symbol, p.value, p.within, p.equals)
        for p in plant.parameters
        if p.within > 0
    }
    names = {v.name for v in plant.variables} | {p.symbol.name for p in plant.parameters}
    names |= {s.name for s in plant.premises}
    for variable in plant.variables:
        if variable.within == 0:
            continue
        name = f"{variable.name}_rest"
        if name in names:
            raise ModelError(
                f"plant {plant.name!r}: the rest of {variable.name} is called {name}, which is "
                "another name of the plant; rename that one"
            )
        symbol = sp.Symbol(name, real=True)
        balls[variable.symbol] = Ball(symbol, variable.rest, variable.within, variable.equals)
    return balls


ROUNDING = 1e-12  # of the ranges, by which decimals miss a rest


def with_inputs_at_rest(
    plant: Plant, rows: Sequence[sp.Expr], rest: Mapping[sp.Symbol, sp.Expr]
) -> tuple[dict[sp.Symbol, sp.Expr], Plant]:
    """Return the rest with the inputs that hold the plant there, and the plant at that rest.

    It is another one if an input with a range is not a decimal: that rests in a ball.

    Raises
    ------
    ModelError : no inputs hold the states at the equilibrium, or an input enters nonlinearly.
    """
    solved = _inputs_at_equilibrium(plant, rows, rest)
    held = {**rest, **solved}
    if all(v.range is None or solved[v.symbol].is_Rational for v in plant.inputs):
        return held, plant
    inputs = []
    for variable in plant.inputs:
        value = solved[variable.symbol]
        if value.is_Rational:
            inputs.append(replace(variable, rest=Fraction(int(value.p), int(value.q))))
        else:
            middle, radius = decimal_near(value)
            inputs.append(replace(variable, rest=middle, within=radius))
    return held, replace(plant, inputs=tuple(inputs))


def _inputs_at_equilibrium(
    plant: Plant, rows: Sequence[sp.Expr], rest: Mapping[sp.Symbol, sp.Expr]
) -> dict[sp.Symbol, sp.Expr]:
    """Return u* with rows(x*, u*, w*) = 0 for the given x* and w*, exact expressions.

    Inputs that the rows leave free keep their given rest values.
    """
    inputs = [v.symbol for v in plant.inputs]
    fixed = {symbol: value for symbol, value in rest.items() if symbol not in inputs}
    at_rest = [row.subs(fixed) for row in rows]
    try:
        slopes, offsets = sp.linear_eq_to_matrix(at_rest, inputs)
    except ValueError as error:
        raise ModelError(
            f"plant {plant.name!r}: the rest of the inputs was to be solved for, but an input "
            f"enters nonlinearly ({error}); give their rest values"
        ) from error
    solutions = list(sp.linsolve((slopes, offsets), *inputs))
    if not solutions:
        return {s: rest[s] for s in inputs}
    free = {s: rest[s] for s in inputs}
    solved = {s: value.subs(free) for s, value in zip(inputs, solutions[0], strict=True)}
    for variable in plant.inputs:
        value, side = solved[variable.symbol], variable.range
        if side is not None and not side.lower <= value <= side.upper:
            raise ModelError(
                f"plant {plant.name!r}: {variable.label} has to be {_short(value, 9)} to hold the "
                f"states at rest, outside its range {side}; widen the range, or move the rest"
            )
    return solved


def check_equilibrium(
    plant: Plant, rows: Sequence[sp.Expr], rest: Mapping[sp.Symbol, sp.Expr], how: Rest
) -> None:
    """Raise ModelError unless every row vanishes at the equilibrium, exactly.

    Of a plant with references it may be off by the rounding of decimals: its law finds the rest.
    The rows have to vanish for all values of uncertain parameters.  The message lists every
    residual with its equation and unit.
    """
    for variable, row in zip(plant.states, rows, strict=True):
        require_value(plant, row, rest, f"equation of {variable.name}")
    residual_rows = [
        (variable, row, residual)
        for variable, row in zip(plant.states, rows, strict=True)
        for residual in [row.subs(rest)]
        if residual != 0 and sp.simplify(residual) != 0
        if not (plant.references and _is_rounding(plant, row, rest, residual))
    ]
    if not residual_rows:
        _check_equilibrium_stays(plant, rows, rest)
        return
    advice = (
        "no input makes it vanish; give rest values of the states at which one does"
        if how == "solve inputs"
        else "give rest values at which every row vanishes exactly; where those of the source are "
        "rounded, write rest = 'solve' or rest = { near = ... } for as many variables as there are "
        "such equations, and they are found; or let rest='solve inputs' (on the command line "
        "--solve-rest) find the inputs that hold the states there"
    )
    from takagi.models.ranges.tape import tables_class

    tables = tables_class()
    if any(
        not residual.is_rational or (tables is not None and row.has(tables))
        for _, row, residual in residual_rows
    ):
        # exp(350) is not a decimal: a ball around one is proved, or a parameter is the rest itself.
        advice += (
            "; where no decimals do, write rest = 'solve' for a state or input, and its rest is "
            "found in a proved ball; or write the equation with its value at rest, such as "
            "k*exp(b/T0 - b/T) for a*exp(-b/T), or f(p0) for what flows in"
        )
    first = residual_rows[0][0].name
    residual_texts = "; ".join(
        residual_text(plant, v, residual, alone=len(residual_rows) == 1)
        for v, _, residual in residual_rows
    )
    raise ModelError(
        f"plant {plant.name!r}, equation of {first}: at rest ({equilibrium_text(rest)}) "
        f"{residual_texts}, so the model cannot be written around this point; {advice}"
    )


def _is_rounding(
    plant: Plant, row: sp.Expr, rest: Mapping[sp.Symbol, sp.Expr], residual: sp.Expr
) -> bool:
    """Return whether a residual is what the rounding of the values at rest leaves."""
    size = 0.0
    for v in plant.variables:
        wide = 0.0 if v.range is None else float(v.range.width)
        size += abs(float(row.diff(v.symbol).subs(rest))) * max(wide, abs(float(v.rest)))
    return abs(float(residual)) <= ROUNDING * size


def equilibrium_text(rest: Mapping[sp.Symbol, sp.Expr]) -> str:
    """Return the values at rest; figures are SI, whatever unit the file has."""
    return ", ".join(f"{s} = {_short(value, 9)}" for s, value in rest.items())


def residual_text(
    plant: Plant, variable: Variable, residual: sp.Expr, *, alone: bool = False
) -> str:
    """Return the residual of an equation at rest, with its unit; ``alone`` calls the state x."""
    x, discrete = "x" if alone else variable.name, plant.sample_time is not None
    quantity = f"{x}(t + T) - {x}" if discrete else f"{x}'"
    unit = behind(variable.unit) + " per second" * (not discrete)
    return f"{quantity} is {_short(residual, 6)}{unit}, not 0"


def require_value(
    plant: Plant, row: sp.Expr, rest: Mapping[sp.Symbol, sp.Expr], where: str
) -> None:
    """Raise ModelError where an expression has no finite real value at rest, with the part."""
    if _is_finite(row.subs(rest)):
        return
    term = next((p for p in sp.postorder_traversal(row) if not _is_finite(p.subs(rest))), row)
    raise ModelError(
        f"plant {plant.name!r}, {where}: at rest ({equilibrium_text(rest)}) {_why(term, rest)}, so "
        "the equation has no value there; give rest values at which it has one"
    )


def _is_finite(value: sp.Expr) -> bool:
    if value.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        return False
    return not value.is_number or value.is_real is not False


def _why(term: sp.Expr, rest: Mapping[sp.Symbol, sp.Expr]) -> str:
    """Return what is wrong with the smallest part that has no value."""
    if term.is_Pow and term.base.subs(rest) == 0:
        return f"{short(term.base)} is 0, and the equation divides by it"
    if term.is_Pow:
        return f"{short(term.base)} is negative, and the equation takes its root"
    inner = ", ".join(f"{short(a)} = {_short(a.subs(rest), 6)}" for a in term.args)
    return f"{short(term)} has no finite value ({inner})"


def _short(value: sp.Expr, digits: int) -> str:
    number = sp.N(value, digits)
    return f"{float(number):.{digits}g}" if number.is_real else str(number)


def _check_equilibrium_stays(
    plant: Plant, rows: Sequence[sp.Expr], rest: Mapping[sp.Symbol, sp.Expr]
) -> None:
    """Raise ModelError where the rest moves with an uncertain parameter.

    Every row has to vanish at rest for all values of such parameters, by algebra.
    """
    free = {v.symbol for v in plant.uncertain if v.schedules}
    if not free:
        return
    fixed = {symbol: value for symbol, value in rest.items() if symbol not in free}
    for variable, row in zip(plant.states, rows, strict=True):
        residual = row.subs(fixed)
        moving = sorted(str(s) for s in residual.free_symbols & free)
        if not moving or sp.simplify(residual) == 0:
            continue
        ends = _at_ends(plant, residual)
        raise ModelError(
            f"plant {plant.name!r}, equation of {variable.name}: the rest moves with the uncertain "
            f"{', '.join(moving)}: there {short(residual)} is left, {ends}, and no law that does "
            f"not know {', '.join(moving)} holds the plant at one rest; follow a state by "
            "[reference] with an integral, which finds the input that holds it, or measure the "
            "parameter and put it into [scheduling], or give it a value"
        )


def _at_ends(plant: Plant, residual: sp.Expr) -> str:
    """Return the residuals with every uncertain parameter at its lower, and at its upper end."""
    texts = []
    for end in ("lower", "upper"):
        values = {v.symbol: getattr(v.range, end) for v in plant.uncertain}
        values_there = {
            s: rational(value) for s, value in values.items() if s in residual.free_symbols
        }
        end_text = ", ".join(f"{s} = {float(value):.4g}" for s, value in values_there.items())
        texts.append(f"{float(residual.subs(values_there)):.4g} at {end_text}")
    return " and ".join(texts)


def residuals(
    plant: Plant, f: Sequence[sp.Expr], mass: sp.Matrix | None, rest: Mapping[sp.Symbol, sp.Expr]
) -> list[sp.Expr]:
    """Return the rows of f at rest, in discrete time less M x*: 0 where the plant rests.

    Raises
    ------
    ModelError : a row that has no value there as it is written, such as sin(x)/x at 0.
    """
    next_values = sp.zeros(len(f), 1)
    if plant.sample_time is not None:
        next_values = sp.Matrix([rest[v.symbol] for v in plant.states])
        next_values = next_values if mass is None else mass * next_values
    rows = [(row - next_value).subs(rest) for row, next_value in zip(f, next_values, strict=True)]
    for variable, row in zip(plant.states, rows, strict=True):
        if row.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
            raise ModelError(
                f"plant {plant.name!r}, equation of {variable.name}: it divides by 0 at rest, so "
                "that no rest can be found from it; write it without that quotient, or give all "
                "rests as numbers"
            )
    return rows


def less_residuals(
    plant: Plant,
    f: Sequence[sp.Expr],
    mass: sp.Matrix | None,
    rest: Mapping[sp.Symbol, sp.Expr],
    balls: Mapping[sp.Symbol, Ball],
) -> tuple[tuple[sp.Expr, ...], dict[sp.Symbol, sp.Expr]]:
    """Return f less what it is at rest, which is 0 though no algebra shows it; and relations.

    A number that is no decimal -> what a linear equation at rest says it is.
    """
    rows = residuals(plant, f, mass, rest)
    _require_zero(plant, rows, balls)
    relations = _relations(rows, [b.symbol for b in balls.values() if b.equals is None])
    return tuple(row - value for row, value in zip(f, rows, strict=True)), relations


def _relations(
    residual_rows: Sequence[sp.Expr], symbols: Sequence[sp.Symbol]
) -> dict[sp.Symbol, sp.Expr]:
    """Return the last of the symbols in each row that is linear in them, from row = 0."""
    solutions: dict[sp.Symbol, sp.Expr] = {}
    for value in residual_rows:
        row = sp.expand(value.subs(solutions))
        occurring = [s for s in symbols if s in row.free_symbols]
        polynomial = (
            row.as_poly(*occurring) if occurring and row.is_polynomial(*occurring) else None
        )
        if polynomial is None:
            continue
        if polynomial.total_degree() == 1 and all(c.is_Rational for c in polynomial.coeffs()):
            symbol = occurring[-1]
            solved = sp.expand(symbol - row / row.coeff(symbol))
            solutions = {s: e.subs(symbol, solved) for s, e in solutions.items()} | {symbol: solved}
    return solutions


def _require_zero(
    plant: Plant, residuals_of_rows: Sequence[sp.Expr], balls: Mapping[sp.Symbol, Ball]
) -> None:
    """Raise ModelError, with every residual, unless each may be 0 in the balls."""
    box = {ball.symbol: ball.side for ball in balls.values()}
    ranges = [
        expression_range(row, {s: box[s] for s in row.free_symbols}).outer
        for row in residuals_of_rows
    ]
    if all(residual_range.contains(0) for residual_range in ranges):
        return
    sizes = {
        v: residual_range.centre for v, residual_range in zip(plant.states, ranges, strict=True)
    }
    refuse_residuals(plant, sizes, {v.symbol: v.rest for v in plant.variables}, "give another rest")


def refuse_residuals(
    plant: Plant,
    sizes: Mapping[Variable, Fraction | None],
    at: Mapping[sp.Symbol, Fraction],
    advice: str,
) -> None:
    """Raise ModelError with every residual that is not 0, its equation and its unit."""
    texts = [
        f"{v.name}' has no value"
        if size is None
        else residual_text(plant, v, sp.Float(float(size)))
        for v, size in sizes.items()
        if size is None or abs(size) > 0
    ]
    where = equilibrium_text({s: sp.Float(float(v)) for s, v in at.items()})
    raise ModelError(f"plant {plant.name!r}: at ({where}) {'; '.join(texts)}; {advice}")
