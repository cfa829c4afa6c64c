"""A plant: its variables, parameters and outputs, its units, its expressions in floats."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError
from takagi.models.files.units import PURE, Dimension, behind, parse_unit
from takagi.models.intervals.interval import Interval, rational
from takagi.models.plant.dimensions import ADVICE, dimension_of, short, without_matrix_row

if TYPE_CHECKING:
    import sympy as sp


@dataclass(frozen=True, slots=True)
class Variable:
    """A state, input or disturbance.

    Attributes
    ----------
    symbol : as it appears in the equations.
    unit : SI, e.g. ``"rad/s"``; ``"-"`` for a pure number.
    range : where the model shall hold; None for a variable that no premise may depend on.
    rest : its value at the operating point that the model is written around.
    within : if the true rest is not a decimal: the largest distance of the true rest from ``rest``,
        the decimal nearest to it. The model is written around the true rest.
    equals : the expression without variables and parameters that such a rest is, e.g. 100*pi; None
        for one that was solved for.
    description : in words, e.g. ``"angle from upright"``.
    schedules : of a disturbance: it appears in coefficients alone, so that A, B, C and D may depend
        on it and its column of E is 0.  It needs a range.
    unknown : of a disturbance that schedules: no law knows it, so no gain may depend on it.  An
        uncertain parameter is such a signal.
    written : the unit that its file gives it, e.g. ``"deg"``, for words alone; empty without a
        file.
    """

    symbol: sp.Symbol
    unit: str = "-"
    range: Interval | None = None
    rest: Fraction = Fraction(0)
    description: str = ""
    schedules: bool = False
    within: Fraction = Fraction(0)
    equals: sp.Expr | None = None
    unknown: bool = False
    written: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        return str(self.symbol.name)

    @property
    def label(self) -> str:
        """Return e.g. ``"theta [rad]"``."""
        return f"{self.name} [{self.unit}]"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number with a name: exact value, SI unit, and where it comes from.

    If its exact value is not a decimal, ``equals`` is that value as an expression without variables
    and parameters, and ``within`` is its largest distance from ``value``.  ``written`` is the
    unit in its file and is used in texts alone.
    """

    symbol: sp.Symbol
    value: Fraction
    unit: str = "-"
    source: str = ""
    within: Fraction = Fraction(0)
    equals: sp.Expr | None = None
    written: str = field(default="", compare=False)


@dataclass(frozen=True, slots=True)
class Output:
    """A measured output: y = expression, in its unit."""

    name: str
    expression: sp.Expr
    unit: str = "-"


@dataclass(frozen=True, slots=True)
class Reference:
    """A signal that a state or output follows, by an integral state of the law.

    Attributes
    ----------
    name, integral : of the signal among the disturbances, and of the state xi' = y - r.
    follows : name of the state or output.
    rate : the fastest that the signal is said to move, SI per s; None where nothing is said.
    """

    name: str
    integral: str
    follows: str
    rate: Fraction | None = None


PER_SECOND = parse_unit("1/s").dimension


class Blended(Protocol):
    """The blending from which a plant was made: ``takagi.models.blending.Blending``."""

    @property
    def plant(self) -> Plant: ...


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Plant(ShortRepr):
    """M(x) x' = f(x, u, w), y = g(x, u, w), with parameters, on a box.

    Attributes
    ----------
    equations : f, one row per state; parameters appear in it as symbols.
    states, inputs, disturbances : in the order of the model's vectors.
    mass : M, n x n in states and parameters; None for the identity.
    outputs : y.
    measured : names of the outputs that a law has; None for a law that has all states.
    parameters : values that are put in before anything is derived.
    premises : symbol -> expression, where the user fixes them; empty leaves the choice.
    sample_time : T in s where x(t + T) replaces x'; None for continuous time.
    units : "checked" if every unit is to fit (``takagi.models.plant.dimensions``), "unchecked" if
        they were not compared.
    name, description, source : what it is, in one line, and where its equations come from.
    blending : the ``takagi.models.blending.Blending`` from which a blended plant was made; it has
        the plant as it was written. None for other plants.
    references : what follows what, by integral states that are among the states
        (``takagi.models.tracking``).
    integrators : names (x_c, v) of the states x_c' = v and inputs that a controller has itself, at
        the end of states and inputs (``with_integrators``).

    Two plants are equal if all of this is, symbol by symbol; expressions are compared as sympy
    holds them, not simplified.

    Raises
    ------
    ModelError : as many rows as states are needed, every symbol must be known, each name may be
        used once, a rest value lies in its range, a variable that schedules is a disturbance with
        a range, units fit if they are to be checked.
    """

    equations: tuple[sp.Expr, ...]
    states: tuple[Variable, ...]
    inputs: tuple[Variable, ...] = ()
    disturbances: tuple[Variable, ...] = ()
    mass: sp.Matrix | None = None
    outputs: tuple[Output, ...] = ()
    measured: tuple[str, ...] | None = None
    parameters: tuple[Parameter, ...] = ()
    premises: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    sample_time: float | None = None
    units: Literal["checked", "unchecked"] = "unchecked"
    name: str = ""
    description: str = ""
    source: str = ""
    blending: Blended | None = None
    references: tuple[Reference, ...] = ()
    integrators: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        if not self.states or len(self.equations) != len(self.states):
            raise ModelError(
                f"plant {self.name!r}: {len(self.equations)} equations for {len(self.states)} "
                "states; give one each, and at least one"
            )
        if self.mass is not None and self.mass.shape != (len(self.states),) * 2:
            raise ModelError(
                f"plant {self.name!r}: the mass matrix is {self.mass.rows} x {self.mass.cols}; "
                f"{len(self.states)} x {len(self.states)} is needed"
            )
        self._check_names()
        self._check_symbols()
        self._check_measured()
        for variable in self.variables:
            if variable.range is not None and not variable.range.contains(
                Interval(variable.rest, variable.rest)
            ):
                raise ModelError(
                    f"plant {self.name!r}: {variable.label} rests at {float(variable.rest):.9g}, "
                    f"outside its range {variable.range}; widen the range or move the rest"
                )
        self._check_scheduling()
        object.__setattr__(self, "premises", MappingProxyType(dict(self.premises)))
        if self.mass is not None:
            object.__setattr__(self, "mass", self.mass.as_immutable())
        if self.units not in ("checked", "unchecked"):
            raise ModelError(
                f'plant {self.name!r}: units = {self.units!r} was given; "checked" or '
                '"unchecked" is needed'
            )
        if self.units == "checked":
            _check_units(self)

    def __hash__(self) -> int:
        # Equal plants have equal equations; a mapping has no hash of its own.
        return hash((self.name, self.states, self.inputs, self.equations))

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Return states, inputs and disturbances."""
        return (*self.states, *self.inputs, *self.disturbances)

    @property
    def own_states(self) -> list[int]:
        """Return the places of the states that are no states of a law."""
        integrals = {reference.integral for reference in self.references}
        integrals |= {state for state, _ in self.integrators}
        return [k for k, v in enumerate(self.states) if v.name not in integrals]

    @property
    def measured_rows(self) -> tuple[int, ...]:
        """Return the places of the measured outputs among the outputs."""
        names = [y.name for y in self.outputs]
        return tuple(names.index(name) for name in self.measured or ())

    @property
    def hides_states(self) -> bool:
        """Return whether one of its own states is not measured by itself: an observer is due."""
        alone = {self.outputs[row].expression for row in self.measured_rows}
        own = {self.states[k].symbol for k in self.own_states}
        return self.measured is not None and not own <= alone

    @property
    def rests_exactly(self) -> bool:
        """Return whether every equation is 0 at rest by algebra, not up to rounding."""
        import sympy as sp

        at = self.at_rest | self.rationals
        return all(sp.simplify(sp.sympify(row).subs(at)) == 0 for row in self.equations)

    @property
    def uncertain(self) -> tuple[Variable, ...]:
        """Return the parameters that are known within a range only."""
        return tuple(v for v in self.disturbances if v.unknown)

    @property
    def box(self) -> dict[sp.Symbol, Interval]:
        """Return symbol -> range, of those that have one."""
        return {v.symbol: v.range for v in self.variables if v.range is not None}

    @property
    def values(self) -> dict[sp.Symbol, Fraction]:
        """Return symbol -> value of the parameters, or the nearest decimal to it."""
        return {parameter.symbol: parameter.value for parameter in self.parameters}

    @property
    def rationals(self) -> dict[sp.Symbol, sp.Rational]:
        """Return ``values`` as numbers of sympy, to put into expressions."""
        return {symbol: rational(value) for symbol, value in self.values.items()}

    @property
    def at_rest(self) -> dict[sp.Symbol, sp.Rational]:
        """Return symbol -> rest of the variables, as numbers of sympy."""
        return {v.symbol: rational(v.rest) for v in self.variables}

    @property
    def expressions(self) -> list[tuple[str, sp.Expr]]:
        """Return (place, expression): of all equations, the mass matrix, outputs and premises."""
        labelled = [
            (f"equation of {v.name}", row)
            for v, row in zip(self.states, self.equations, strict=True)
        ]
        labelled += [("mass matrix", entry) for entry in (() if self.mass is None else self.mass)]
        labelled += [(f"output {y.name}", y.expression) for y in self.outputs]
        return [*labelled, *((f"premise {symbol}", row) for symbol, row in self.premises.items())]

    def _check_measured(self) -> None:
        if self.measured is None:
            return
        names = [y.name for y in self.outputs]
        wrong = [name for name in self.measured if names.count(name) != 1]
        if wrong or not self.measured or len(set(self.measured)) < len(self.measured):
            raise ModelError(
                f"plant {self.name!r}: measured = {self.measured} was given; different names of "
                f"its outputs are needed: {', '.join(names) or 'it has none'}"
            )

    def _check_scheduling(self) -> None:
        for variable in (*self.states, *self.inputs):
            if variable.schedules:
                raise ModelError(
                    f"plant {self.name!r}: {variable.label} schedules, but it is a state or an "
                    "input; only a signal from outside can, so put it among the disturbances"
                )
        for variable in self.disturbances:
            if variable.unknown and not variable.schedules and not self.references:
                raise ModelError(
                    f"plant {self.name!r}: {variable.label} is unknown to the law, but does not "
                    "schedule; a disturbance is unknown anyhow, so leave unknown out"
                )
            if variable.schedules and variable.range is None:
                raise ModelError(
                    f"plant {self.name!r}: {variable.label} schedules and has no range; the "
                    "vertices of the model are made from it, so give one"
                )

    def _check_names(self) -> None:
        names = [v.name for v in self.variables] + [p.symbol.name for p in self.parameters]
        names += [symbol.name for symbol in self.premises]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ModelError(
                f"plant {self.name!r}: {', '.join(twice)} is used more than once; give every "
                "variable, parameter and premise a name of its own"
            )

    def _check_symbols(self) -> None:
        symbols = {v.symbol for v in self.variables} | {p.symbol for p in self.parameters}
        for label, row in self.expressions:
            unknown = sorted(str(s) for s in row.free_symbols if s not in symbols)
            if unknown:
                raise ModelError(
                    f"plant {self.name!r}, {label}: {', '.join(unknown)} is neither a variable nor "
                    "a parameter; define it, or correct its name"
                )


def _check_units(plant: Plant) -> None:
    """Raise ModelError unless every equation, mass entry, output and premise fits by its units.

    What is added must have one unit; arguments of sin, exp, ... are pure numbers or in rad; the
    derivative of a state has its unit per second (in discrete time: its unit); arguments and values
    of tables have the units that the table states.  Numbers in an expression are pure; 0 fits
    everything, and so do numbers that are entries of a matrix: of M, or of a row of the equations
    that is a sum of numbers times variables (1 and -1 are pure there too).

    The check reads the expressions as sympy stores them, so terms that cancel are not checked.
    """
    values = plant.values
    units = {v.symbol: _si(v.unit, f"variable {v.name}").dimension for v in plant.variables}
    units |= {p.symbol: _si(p.unit, f"parameter {p.symbol}").dimension for p in plant.parameters}
    rates = _rate_dimensions(plant, units, values)
    for variable, row, dimension in zip(plant.states, plant.equations, rates, strict=True):
        owner = f"equation of {variable.name}"
        checked = without_matrix_row(row, {v.symbol for v in plant.variables})
        row_dimension = dimension_of(checked, units, values, owner=owner)
        if dimension is not None and row_dimension is not None and row_dimension != dimension:
            left_name = "the left side" if plant.mass is not None else _left(plant, variable.name)
            raise ModelError(
                f"{owner}: {short(row)} has the unit {row_dimension}, but {left_name} has "
                f"{dimension}; {ADVICE}"
            )
    for output in plant.outputs:
        owner = f"output {output.name}"
        row_dimension = dimension_of(output.expression, units, values, owner=owner)
        stated = _si(output.unit, owner).dimension
        if row_dimension is not None and row_dimension != stated:
            raise ModelError(
                f"{owner}: {short(output.expression)} has the unit {row_dimension}, but "
                f"{output.unit!r} is stated ({stated}); {ADVICE}"
            )
    for symbol, expression in plant.premises.items():
        dimension_of(expression, units, values, owner=f"premise {symbol}")


def _rate_dimensions(
    plant: Plant, units: Mapping[sp.Symbol, Dimension], values: Mapping[sp.Symbol, Fraction]
) -> list[Dimension | None]:
    """Return the unit of each row of M x'; None for a row of zeros."""
    step = PER_SECOND if plant.sample_time is None else PURE
    rates = [units[variable.symbol].times(step) for variable in plant.states]
    if plant.mass is None:
        return list(rates)
    dimensions: list[Dimension | None] = []
    for row, variable in enumerate(plant.states):
        owner = f"mass row of {variable.name}"
        first_term: tuple[str, Dimension] | None = None
        for column, rate in enumerate(rates):
            written = plant.mass[row, column]
            entry = dimension_of(written, units, values, owner=owner)
            # A number that is an entry of the matrix is in SI, with the unit that fits.
            if entry is None or (written.is_number and abs(written) != 1):
                continue
            term = f"({short(plant.mass[row, column])}) {_left(plant, plant.states[column].name)}"
            total = entry.times(rate)
            if first_term is not None and first_term[1] != total:
                raise ModelError(
                    f"{owner}: {first_term[0]} has the unit {first_term[1]} and {term} has "
                    f"{total}, but they are added; {ADVICE}"
                )
            first_term = first_term or (term, total)
        dimensions.append(None if first_term is None else first_term[1])
    return dimensions


def _left(plant: Plant, name: str) -> str:
    return f"{name}'" if plant.sample_time is None else f"{name}(t + T)"


def _si(text: str, owner: str) -> Any:
    unit = parse_unit(text)
    if not unit.is_si:
        raise ModelError(
            f"{owner}: the unit {text!r} is not SI; give the value in {unit.si!r} (plant files "
            "convert, a Plant in Python does not)"
        )
    return unit


_NAME = re.compile(r"[A-Za-z%]+")
SECOND = parse_unit("s")


def file_unit(variable: Variable) -> tuple[float, str]:
    """Return (size of the unit in SI, its name) of a variable: as its file has it, else SI."""
    return _size(variable.written), variable.written or variable.unit


def in_file_units(variable: Variable, value: float, digits: int = 4) -> str:
    """Return a value in SI as the variable's file would have it, with its unit."""
    size, unit = file_unit(variable)
    return f"{value / size:.{digits}g}{behind(unit)}"


def range_in_file_units(variable: Variable, digits: int = 4) -> str:
    """Return ``"[35, 130] rad/s"`` of a variable that has a range."""
    assert variable.range is not None  # the caller looked
    size, unit = file_unit(variable)
    low, high = (float(end) / size for end in (variable.range.lower, variable.range.upper))
    return f"[{low:.{digits}g}, {high:.{digits}g}]{behind(unit)}"


def time_in_file_units(plant: Plant, seconds: float) -> tuple[float, str]:
    """Return (number, unit) of a time [s].

    The unit is the largest in which the number is at least 1, of s and the units of time that
    occur in the file's units, such as min in ``L/min``; else the smallest of them.
    """
    sizes = sorted((_size(unit), unit) for unit in _times(plant))
    size, unit = max(
        (time_unit for time_unit in sizes if seconds >= time_unit[0]), default=sizes[0]
    )
    return seconds / size, unit


def rate_in_file_units(plant: Plant, rate: float) -> tuple[float, str]:
    """Return (number, unit) of a rate [1/s], in the unit of time that suits its time constant."""
    if not rate > 0:
        return rate, "1/s"
    unit = time_in_file_units(plant, 1 / rate)[1]
    return rate * _size(unit), f"1/{unit}"


def _times(plant: Plant) -> set[str]:
    """Return s, and the units of time that occur in what the file's figures are written in."""
    units_written = [v.written for v in plant.variables] + [p.written for p in plant.parameters]
    names = {name for unit in units_written for name in _NAME.findall(unit)}
    return {"s"} | {name for name in names if _is_time(name)}


def _is_time(name: str) -> bool:
    try:
        return parse_unit(name).dimension == SECOND.dimension
    except ModelError:
        return False


def _size(unit: str) -> float:
    unit_read = parse_unit(unit or "-")
    return float(unit_read.factor) * math.pi**unit_read.pi_power


def numeric(
    rows: Iterable[sp.Expr], symbols: Sequence[sp.Symbol], values: Mapping[sp.Symbol, sp.Expr]
) -> Callable[..., Floats]:
    """Return the function of the symbols' values that gives the values of the rows, (rows,).

    ``values`` : of all other symbols, put in first.
    """
    import sympy as sp

    from takagi.models.ranges.float_value import float_function

    expressions = [sp.sympify(row).subs(values) for row in rows]
    function = float_function(symbols, expressions)
    return lambda *point: np.array(function(*point), dtype=np.float64)


def explicit_rows(
    plant: Plant, symbols: Sequence[sp.Symbol], values: Mapping[sp.Symbol, sp.Expr]
) -> Callable[..., Floats]:
    """Return f of the plant's equations, or M^-1 f, as a function of the symbols in floats."""
    right_sides = numeric(plant.equations, symbols, values)
    if plant.mass is None:
        return right_sides
    mass, shape = numeric(plant.mass, symbols, values), plant.mass.shape

    def solved(*point: float) -> Floats:
        M, f = mass(*point).reshape(shape), right_sides(*point)
        return np.asarray(np.linalg.solve(M, f), dtype=np.float64)

    return solved
