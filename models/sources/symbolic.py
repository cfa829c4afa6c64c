"""A plant from sympy expressions, with ranges, rests and units beside them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

import sympy as sp

from takagi.models.equations.solved_rest import solve_rest
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.expressions.parser import FUNCTIONS, RESERVED
from takagi.models.files.units import Unit, parse_unit
from takagi.models.intervals.interval import Interval, Number, exact, rational
from takagi.models.plant.dimensions import dimension_of
from takagi.models.plant.plant import Output, Parameter, Plant, Variable

Quantity: TypeAlias = "sp.Symbol | sp.Function | str"
Row: TypeAlias = "sp.Expr | float"
Rows: TypeAlias = "Sequence[Row] | Mapping[Any, Row] | sp.MatrixBase"
Ranges: TypeAlias = "Mapping[Any, tuple[Number, Number]]"
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}", re.ASCII)
KNOWN_FUNCTIONS = frozenset(FUNCTIONS.values())


def from_sympy(
    f: Rows,
    states: Sequence[Quantity],
    inputs: Sequence[Quantity] = (),
    ranges: Ranges | None = None,
    *,
    disturbances: Sequence[Quantity] = (),
    scheduling: Sequence[Quantity] = (),
    parameters: Mapping[Any, Number] | None = None,
    rest: Mapping[Any, Number | None] | None = None,
    units: Mapping[Any, str] | None = None,
    compare_units: bool = True,
    mass: sp.MatrixBase | None = None,
    outputs: Mapping[str, Row] | None = None,
    measured: Sequence[Quantity] | None = None,
    premises: Mapping[str, Row] | None = None,
    sample_time: float | None = None,
    name: str = "plant",
) -> Plant:
    """Return the plant x' = f(x, u, w), or M x' = f, or x(t + T) = f, of sympy expressions.

    Parameters
    ----------
    f : one row a state, in the order of the states, or state -> row.  Numbers in floats stand for
        their shortest decimals.
    states, inputs, disturbances : symbols, functions of time (``dynamicsymbols``), or names of
        symbols in f.  Assumptions on symbols are dropped: every quantity is real.
    ranges : quantity -> (low, high), where the model shall hold.  Every quantity in a nonlinear
        term needs one; that of an input is its limit.
    parameters : symbol -> value.
    rest : quantity -> value at the operating point, 0 if left out; None has it found from the
        equations, for states and inputs.
    units : quantity or parameter -> unit, such as ``"rad/s"`` or ``"deg"``.  Ranges, rests and
        values are in these units, the equations in SI.  With ``units`` they are compared ("-"
        where none is given) unless ``compare_units`` is False.
    mass : M, n x n.
    scheduling : signals from outside that stand in coefficients alone, as w in w*x; each needs a
        range.
    outputs : name -> expression;  measured : outputs or states that the law has, if not all states.
    premises : name -> expression, where they are to be fixed.
    sample_time : T [s] of a plant in discrete time.

    Raises
    ------
    ModelError : a name that no file may have, rows that do not fit, a symbol without meaning, a
        function without a rigorous range, and whatever ``Plant`` refuses.
    """
    quantities = [*states, *inputs, *disturbances, *scheduling]
    names = [_name(given) for given in [*quantities, *(parameters or {})]]
    symbol_of = {name: sp.Symbol(name, real=True) for name in names}
    rows = _rows(f, [_name(given) for given in states])
    keyed = partial(_keyed, names=names)
    unit_of = {key: parse_unit(text) for key, text in keyed(units, "units").items()}
    range_of, rest_of = keyed(ranges, "ranges"), keyed(rest, "rest")
    read = partial(_expression, symbol_of=symbol_of, place=name)

    def variables(listed: Sequence[Quantity]) -> tuple[Variable, ...]:
        return tuple(
            _variable(symbol_of[key], unit_of.get(key), range_of.get(key), rest_of.get(key, 0))
            for key in map(_name, listed)
        )

    values = {_name(given): value for given, value in (parameters or {}).items()}
    read_outputs = {key: read(row) for key, row in (outputs or {}).items()}
    measured_names = None if measured is None else tuple(map(_name, measured))
    for key in measured_names or ():
        if key not in read_outputs and key in symbol_of:
            read_outputs[key] = symbol_of[key]
    plant = Plant(
        equations=tuple(read(row) for row in rows),
        states=variables(states),
        inputs=variables(inputs),
        disturbances=(
            *variables(disturbances),
            *(replace(signal, schedules=True) for signal in variables(scheduling)),
        ),
        mass=None if mass is None else sp.Matrix(mass).applyfunc(read),
        outputs=tuple(Output(key, row) for key, row in read_outputs.items()),
        measured=measured_names,
        parameters=tuple(
            _parameter(symbol_of[key], unit_of.get(key), value) for key, value in values.items()
        ),
        premises={
            sp.Symbol(_name(key), real=True): read(row) for key, row in (premises or {}).items()
        },
        sample_time=sample_time,
        name=name,
    )
    if units is not None and compare_units:
        plant = _checked(plant)
    rests_sought = {symbol_of[key]: None for key, value in rest_of.items() if value is None}
    return solve_rest(plant, rests_sought) if rests_sought else plant


def _name(given: Any) -> str:
    """Return the name of a symbol, a function of time or a text."""
    name = given if isinstance(given, str) else ""
    if isinstance(given, sp.Symbol):
        name = given.name
    elif isinstance(given, sp.core.function.AppliedUndef):
        name = type(given).__name__
    if not name:
        raise ModelError(f"{given!r} was given; a symbol, a function of time or a name is needed")
    if not NAME.fullmatch(name) or name in RESERVED:
        raise ModelError(
            f"the name {name!r} was given; a letter, then letters a-z, A-Z, digits and _, at most "
            f"40 together, and no name of a function are needed: use another symbol"
        )
    return name


def _rows(f: Rows, states: Sequence[str]) -> list[Any]:
    """Return the rows in the order of the states."""
    if isinstance(f, Mapping):
        rows = _keyed(f, "f", states)
        missing = [name for name in states if name not in rows]
        if missing:
            raise ModelError(f"f has no row for {', '.join(missing)}; every state needs one")
        return [rows[name] for name in states]
    listed = list(f) if isinstance(f, (Sequence, sp.MatrixBase)) else [f]
    if len(listed) != len(states):
        raise ModelError(
            f"f has {len(listed)} rows, and {len(states)} states were given "
            f"({', '.join(states)}); one row for each, in their order, is needed"
        )
    return listed


def _keyed(given: Mapping[Any, Any] | None, what: str, names: Sequence[str]) -> dict[str, Any]:
    """Return name -> value, refusing names that are not there."""
    values = {_name(key): value for key, value in (given or {}).items()}
    for name in values:
        if name not in names:
            raise ModelError(
                f"{what} of {name} was given{did_you_mean(name, names)}; there are "
                f"{', '.join(names)}"
            )
    return values


def _expression(row: Any, *, symbol_of: Mapping[str, sp.Symbol], place: str) -> sp.Expr:
    """Return a row in the plant's symbols and rationals."""
    if isinstance(row, str):
        raise ModelError(
            f"{place}: {row!r} is a text; a sympy expression is needed, or a plant file, whose "
            "equations are texts"
        )
    expression = sp.sympify(row)
    for part in expression.atoms(sp.core.function.AppliedUndef):
        if type(part).__name__ in symbol_of and not all(a.is_Symbol for a in part.args):
            raise ModelError(
                f"{place}: {part} was given; a plant knows {type(part).__name__} at the present "
                "time alone: write what is delayed or fixed as a state, a disturbance or a "
                "parameter of its own"
            )
    renamed = {
        part: symbol_of[name]
        for part in expression.atoms(sp.Symbol, sp.core.function.AppliedUndef)
        if (name := getattr(part, "name", type(part).__name__)) in symbol_of
    }
    expression = expression.xreplace(renamed)
    for part in expression.atoms(sp.Function, sp.Derivative, sp.Piecewise):
        function = type(part).__name__
        if function not in KNOWN_FUNCTIONS and not hasattr(part, "argument_units"):
            raise ModelError(
                f"{place}: {part} was given; its rigorous range is not known. Known are "
                f"{', '.join(sorted(FUNCTIONS))}: write it with these, or give a table"
            )
    strange = [str(part) for part in expression.atoms(sp.I, sp.nan, sp.oo, -sp.oo, sp.zoo)]
    if strange:
        raise ModelError(f"{place}: {strange[0]} occurs in {row}; real finite numbers are needed")
    return expression.xreplace({part: rational(float(part)) for part in expression.atoms(sp.Float)})


def _in_si(unit: Unit | None, value: Number) -> Fraction:
    number = exact(value)
    return number if unit is None else unit.to_si(number)


def _variable(
    symbol: sp.Symbol, unit: Unit | None, ends: tuple[Number, Number] | None, rest: Number | None
) -> Variable:
    """Return a variable in SI; a rest that is to be found begins in the middle of the range."""
    side = None
    if ends is not None:
        if len(ends) != 2 or exact(ends[0]) > exact(ends[1]):
            raise ModelError(
                f"ranges of {symbol}: {ends} was given; (low, high) with the smaller end first is "
                "needed"
            )
        side = Interval(*(_in_si(unit, end) for end in ends))
    if rest is None:
        start = Fraction(0) if side is None else (side.lower + side.upper) / 2
    else:
        start = _in_si(unit, rest)
    si, written = ("-", "") if unit is None else (unit.si, unit.text)
    return Variable(symbol, si, side, start, written=written)


def _parameter(symbol: sp.Symbol, unit: Unit | None, value: Number) -> Parameter:
    si, written = ("-", "") if unit is None else (unit.si, unit.text)
    return Parameter(symbol, _in_si(unit, value), si, written=written)


def _checked(plant: Plant) -> Plant:
    """Return the plant with its units compared, its outputs in the unit that fits."""
    units = {v.symbol: parse_unit(v.unit).dimension for v in plant.variables}
    units |= {p.symbol: parse_unit(p.unit).dimension for p in plant.parameters}

    def with_unit(output: Output) -> Output:
        dimension = dimension_of(
            output.expression, units, plant.values, owner=f"output {output.name}"
        )
        return output if dimension is None else replace(output, unit=str(dimension))

    outputs = tuple(map(with_unit, plant.outputs))
    return replace(plant, outputs=outputs, units="checked")
