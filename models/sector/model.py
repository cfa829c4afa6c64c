"""The front door of symbolic sector nonlinearity: equations of motion in, TSModel out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.enclosure.interval import Interval, Number, exact
from takagi.models.errors import ModelError
from takagi.models.premise import Premise, round_outward
from takagi.models.sector.assemble import LETTERS, Equations, Factored, assemble
from takagi.models.ts_model import TSModel

if TYPE_CHECKING:
    import sympy as sp

__all__ = ["sector_model"]


def sector_model(
    f: Sequence[sp.Expr],
    states: Sequence[sp.Symbol],
    inputs: Sequence[sp.Symbol] = (),
    *,
    box: Mapping[sp.Symbol, tuple[Number, Number]],
    disturbances: Sequence[sp.Symbol] = (),
    outputs: Sequence[sp.Expr] = (),
    parameters: Mapping[sp.Symbol, Number] | None = None,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None = None,
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    bounds: Mapping[sp.Symbol, tuple[Number, Number]] | None = None,
    units: Mapping[sp.Symbol, str] | None = None,
    tolerance: Number = "1e-6",
    name: str = "",
    source: str = "",
) -> TSModel:
    """Return xdot = f(x, u, w) as sum_i h_i(z) (A_i x + B_i u + E_i w), equal to f on the box.

    Each premise z_k is an expression whose range over the box is enclosed rigorously and rounded
    outward to decimals; the rules are the corners of those ranges.  That the factored form is f
    is checked symbolically.

    Parameters
    ----------
    f : n expressions; floats in them are read as the decimals they print as.
    box : a range for every variable that a premise depends on.
    outputs : p expressions in x and u.
    parameters : values put in first.
    matrices : ``{"A": ..., "B": ..., "E": ...}`` (and "C", "D" with outputs) factored by hand,
        with entries in constants and the symbols of ``premises``.  None factors f itself and
        makes each nonlinear entry a premise; with ``premises`` given, these are looked for in
        the entries first.
    premises : symbol -> expression in states, inputs and disturbances.
    bounds : exact bounds of some premises, e.g. (0, 1); a bound that an attained value contradicts
        is refused, and the evidence says that the bound was given.
    units : by symbol, also for premises.
    tolerance : excess of a bound, as a share of the premise's range.

    Returns
    -------
    The model; its ``derivation`` tells plant, factored form, premises and bounds in LaTeX, and
    ``premise_values(**point)`` takes the variables by name.

    Raises
    ------
    ModelError : the form is not exact, an entry is not multilinear in the premises, a premise
        cannot be bounded, or a variable has no range.

    Source: Tanaka and Wang (2001), Fuzzy Control Systems Design and Analysis, section 2.2.
    """
    values = {symbol: _rational(value) for symbol, value in (parameters or {}).items()}
    plant = Equations(
        f=_cleaned(f, values),
        states=tuple(states),
        inputs=tuple(inputs),
        disturbances=tuple(disturbances),
        outputs=_cleaned(outputs, values),
        units=dict(units or {}),
    )
    if len(plant.f) != len(plant.states):
        raise ModelError(
            f"f has {len(plant.f)} rows, but there are {len(plant.states)} states; give one each"
        )
    wanted = dict(zip(premises or {}, _cleaned((premises or {}).values(), values), strict=True))
    factored = _factored(plant, matrices, wanted, values)
    sides = {symbol: Interval.of(*ends) for symbol, ends in box.items()}
    members = [
        _premise(symbol, expression, sides, (bounds or {}).get(symbol), plant, exact(tolerance))
        for symbol, expression in factored.premises.items()
    ]
    named = {plant.named([s])[0]: (side.lower, side.upper) for s, side in sides.items()}
    return assemble(plant, factored, members, box=named, name=name, source=source)


def _rational(value: Number) -> sp.Rational:
    import sympy as sp

    return sp.Rational(*exact(value).as_integer_ratio())


def _cleaned(
    expressions: Iterable[sp.Expr], values: Mapping[sp.Symbol, sp.Rational]
) -> tuple[sp.Expr, ...]:
    """Return the expressions with parameters put in and floats as rationals."""
    import sympy as sp

    found = []
    for expression in expressions:
        whole = sp.sympify(expression).subs(values)
        floats = {number: _rational(float(number)) for number in whole.atoms(sp.Float)}
        found.append(whole.xreplace(floats))
    return tuple(found)


def _factored(
    plant: Equations,
    matrices: Mapping[str, Sequence[Sequence[sp.Expr]]] | None,
    premises: dict[sp.Symbol, sp.Expr],
    values: Mapping[sp.Symbol, sp.Rational],
) -> Factored:
    import sympy as sp

    shapes = _shapes(plant)
    if matrices is None:
        from takagi.models.sector.factor import factor

        return _with_premises(factor(plant), premises)
    unknown = set(matrices) - set(LETTERS)
    if unknown or "A" not in matrices:
        raise ModelError(
            f"matrices {', '.join(sorted(matrices)) or 'none'} were given; A is needed, and of "
            "B, C, D, E those that are not zero"
        )
    found = {}
    for letter, shape in shapes.items():
        matrix = sp.Matrix(matrices[letter]) if letter in matrices else sp.zeros(*shape)
        if matrix.shape != shape:
            raise ModelError(f"{letter} has shape {matrix.shape}; {shape} is needed")
        found[letter] = sp.Matrix(*shape, _cleaned(list(matrix), values))
    return Factored(found, premises)


def _shapes(plant: Equations) -> dict[str, tuple[int, int]]:
    n, m, p = len(plant.states), len(plant.inputs), len(plant.outputs)
    return {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m), "E": (n, len(plant.disturbances))}


def _with_premises(matrices: Mapping[str, sp.Matrix], wanted: dict[sp.Symbol, sp.Expr]) -> Factored:
    """Replace the wanted expressions, then make every entry that is still nonlinear a premise."""
    import sympy as sp

    symbols: dict[sp.Expr, sp.Symbol] = {}
    taken = {symbol.name for symbol in wanted}
    fresh = (s for s in sp.numbered_symbols("z", start=1) if s.name not in taken)

    def entry(expression: sp.Expr) -> sp.Expr:
        written = expression.subs({e: s for s, e in wanted.items()})
        if not written.free_symbols - set(wanted):
            return written
        simplified = sp.simplify(expression)
        if simplified not in symbols:
            symbols[simplified] = next(fresh)
        return symbols[simplified]

    found = {letter: matrix.applyfunc(entry) for letter, matrix in matrices.items()}
    used = {s for matrix in found.values() for s in matrix.free_symbols}
    unused = [str(symbol) for symbol in wanted if symbol not in used]
    if unused:
        raise ModelError(
            f"premise {', '.join(unused)} was not found in the factored entries; give the "
            "matrices factored by hand"
        )
    return Factored(found, {**wanted, **{symbol: e for e, symbol in symbols.items()}})


def _premise(
    symbol: sp.Symbol,
    expression: sp.Expr,
    sides: Mapping[sp.Symbol, Interval],
    given: tuple[Number, Number] | None,
    plant: Equations,
    tolerance: Fraction,
) -> Premise:
    import sympy as sp

    from takagi.models.sector.ball import expression_range, expression_value

    names = {s.name: s for s in expression.free_symbols}

    def evaluate(**point: float) -> float:
        return expression_value(expression, {s: point[n] for n, s in names.items() if n in point})

    found = expression_range(expression, sides, tolerance=tolerance)
    if given is None:
        bounds = round_outward(found.outer)
        evidence = f"ball arithmetic, {found.boxes} boxes, rounded outward"
    else:
        bounds = Interval.of(*given)
        if found.inner.lower < bounds.lower or bounds.upper < found.inner.upper:
            raise ModelError(
                f"premise {symbol} = {expression}: the given bounds {bounds} leave out values that "
                f"it attains, {found.inner}; widen them, or shrink the box"
            )
        proved = bounds.contains(found.outer)
        evidence = "given by the user" + (", confirmed by ball arithmetic" if proved else "")
    return Premise(
        symbol.name,
        bounds.lower,
        bounds.upper,
        unit=plant.units.get(symbol, "-"),
        latex=sp.latex(symbol),
        evidence=evidence,
        evaluate=evaluate,
    )
