"""A plant from a system of python-control: its matrices, or its function called with symbols.

The function of ``control.nlsys`` is called once, with a symbol in the place of each state, input
and parameter.  Arithmetic and numpy's functions of them give expressions; whatever needs a number
(a comparison, ``math.sin``, an element of ``np.zeros``) ends in a refusal, so that no branch is
taken unseen.
"""

from __future__ import annotations

import operator
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import sympy as sp

from takagi.models.control_systems import signal_names
from takagi.models.errors import ModelError
from takagi.models.expressions.parser import RESERVED
from takagi.models.intervals.interval import Number, rational
from takagi.models.plant.plant import Plant, numeric
from takagi.models.sources.symbolic import NAME, Ranges, from_sympy

if TYPE_CHECKING:
    import control

Function = Callable[..., Any]
# The methods that numpy calls on objects, where sympy's function has another name.
_INVERSE = ("sin", "cos", "tan", "sinh", "cosh", "tanh")
_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    **{name: getattr(sp, name) for name in (*_INVERSE, "exp", "log", "sqrt")},
    **{f"arc{name}": getattr(sp, f"a{name}") for name in _INVERSE},
    "square": lambda x: x**2,
    "deg2rad": lambda x: x * sp.pi / 180,
    "radians": lambda x: x * sp.pi / 180,
    "rad2deg": lambda x: x * 180 / sp.pi,
    "degrees": lambda x: x * 180 / sp.pi,
}


def from_control(
    system: control.StateSpace | control.NonlinearIOSystem,
    ranges: Ranges | None = None,
    *,
    disturbances: Sequence[str] = (),
    rest: Mapping[Any, Number | None] | None = None,
    units: Mapping[Any, str] | None = None,
    measured: Sequence[str] | None = None,
) -> Plant:
    """Return the plant that a system of python-control is.

    Parameters
    ----------
    system : of ``control.ss``, or of ``control.nlsys`` with a function that can be called with
        symbols.  Names are the system's labels, ``x[0]`` becomes ``x_0``; parameters in floats keep
        their names.  A sample time is kept.
    disturbances : those of its inputs that no law commands.
    ranges, rest, units, measured : as ``from_sympy`` has them, by name.

    Raises
    ------
    ModelError : a system of another kind, a sample time that it does not state, a function that
        cannot be called with symbols or whose value depends on time; and whatever ``from_sympy``
        refuses.
    """
    import control

    if not isinstance(system, control.NonlinearIOSystem) or not system.nstates:
        raise ModelError(
            f"a {type(system).__name__} with {getattr(system, 'nstates', None) or 'no'} states was "
            "given; a system of control.ss or control.nlsys with states is needed (a transfer "
            "function becomes one by control.ss)"
        )
    if system.dt is True:
        raise ModelError(
            "the system is in discrete time without a sample time (dt = True); give dt in s"
        )
    names = {
        what: signal_names(getattr(system, f"{what}_labels"))
        for what in ("state", "input", "output")
    }
    if repeated := [name for name, count in Counter(names["output"]).items() if count > 1]:
        raise ModelError(f"outputs: {repeated[0]} is the name of two; give each a name of its own")
    for name in disturbances:
        if name not in names["input"]:
            raise ModelError(
                f"disturbances: {name} was given; inputs are {', '.join(names['input']) or 'none'}"
            )
    commanded = [name for name in names["input"] if name not in disturbances]
    rows, outputs, parameters = _traced(system, names)
    plant = from_sympy(
        rows,
        names["state"],
        commanded,
        ranges,
        disturbances=disturbances,
        parameters=parameters,
        rest=rest,
        units=units,
        outputs=outputs,
        measured=measured,
        sample_time=float(system.dt) if system.dt else None,
        name=signal_names([str(system.name)])[0] or "plant",
    )
    _check_values(system, plant, [*names["state"], *names["input"]])
    return plant


def _check_values(
    system: control.NonlinearIOSystem, plant: Plant, order: Sequence[str], points: int = 8
) -> None:
    """Refuse rows that differ from a function's values: it may look at types, or at the outside.

    The points are drawn from the ranges, and from 1 about the rest where there is none.
    """
    variables = {variable.name: variable for variable in plant.variables}
    listed = [variables[name] for name in order]
    ends = [
        (float(v.rest) - 1, float(v.rest) + 1)
        if v.range is None
        else (float(v.range.lower), float(v.range.upper))
        for v in listed
    ]
    arguments = [v.symbol for v in listed]
    n, (update, output) = len(plant.states), _functions(system)
    outputs = {y.name: y.expression for y in plant.outputs}
    shown = signal_names(system.output_labels) if output is not None else []
    places = [k for k, name in enumerate(shown) if name in outputs]
    rows = numeric(plant.equations, arguments, plant.rationals)
    read = numeric([outputs[shown[k]] for k in places], arguments, plant.rationals)
    low, high = np.transpose(ends)
    for point in np.random.default_rng(1).uniform(low, high, (points, len(ends))):
        at = (0.0, point[:n], point[n:], system.params)
        functions = [("update", rows, np.ravel(update(*at)))]
        if output is not None and places:
            functions.append(("output", read, np.ravel(output(*at))[places]))
        for what, expressions, true in functions:
            with np.errstate(all="ignore"):
                traced = expressions(*point)
            if not np.allclose(traced, true, rtol=1e-6, atol=1e-9, equal_nan=True):
                values = dict(zip(order, map(float, point), strict=True))
                raise ModelError(
                    f"the {what} function gives {true} at {values}, and its expressions {traced}: "
                    "it is another function of symbols than of numbers; give the equations to "
                    "from_sympy"
                )


def _functions(system: control.NonlinearIOSystem) -> tuple[Function, Function | None]:
    """Return what gives x' and y of time, state, input and parameters."""
    import control

    if not isinstance(system, control.StateSpace):
        return system.updfcn, system.outfcn
    A, B, C, D = system.A, system.B, system.C, system.D
    return (lambda t, x, u, p: A @ x + B @ u), (lambda t, x, u, p: C @ x + D @ u)


def _traced(
    system: control.NonlinearIOSystem, names: Mapping[str, list[str]]
) -> tuple[list[sp.Expr], dict[str, sp.Expr], dict[str, float]]:
    """Return the rows, outputs that are no state, and parameters that occur as symbols."""
    update, output = _functions(system)
    taken = {*RESERVED, *names["state"], *names["input"]}
    parameters = {
        key: float(value)
        for key, value in system.params.items()
        if isinstance(value, int | float) and NAME.fullmatch(key) and key not in taken
    }
    x, u = (
        np.array([Traced(sp.Symbol(name, real=True)) for name in names[what]], dtype=object)
        for what in ("state", "input")
    )
    symbols = {key: Traced(sp.Symbol(key, real=True)) for key in parameters}
    try:
        given = {**system.params, **symbols}
        rows = _called(update, "update", x, u, given)
    except ModelError:
        # A parameter may be what the function needs as a number, such as a count.
        given, parameters = dict(system.params), {}
        rows = _called(update, "update", x, u, given)
    values = [] if output is None else _called(output, "output", x, u, given)
    outputs = dict(zip(names["output"] if values else [], values, strict=True))
    states = dict(zip(names["state"], (entry.expression for entry in x), strict=True))
    for name, row in outputs.items():
        if states.get(name, row) != row:
            raise ModelError(
                f"outputs: {name} is {row}, and a state has this name; name one of them otherwise"
            )
    shown = {name: row for name, row in outputs.items() if row not in states.values()}
    return rows, shown, parameters


def _called(
    function: Function, what: str, x: Any, u: Any, parameters: Mapping[str, Any]
) -> list[sp.Expr]:
    """Return what the function gives for symbols."""
    time = sp.Symbol("time")
    try:
        values = np.asarray(function(Traced(time), x, u, parameters), dtype=object).ravel()
        rows = [_sympy(value) for value in values]
    except Exception as error:
        chain = (error, error.__cause__, error.__context__)
        reasons = [str(e) for e in chain if isinstance(e, ModelError)]
        reason = reasons[0] if reasons else f"{type(error).__name__}: {error}"
        raise ModelError(
            f"the {what} function was called with symbols: {reason}. Write it with arithmetic and "
            "numpy's functions and return a list, or give the equations to from_sympy"
        ) from error
    if any(row.has(time) for row in rows):
        raise ModelError(
            f"the {what} function depends on time; a plant does not: make the signal an input, and "
            "name it among the disturbances"
        )
    return rows


def _sympy(value: Any) -> sp.Expr:
    if isinstance(value, Traced):
        return value.expression
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return _sympy(value.item())
    return sp.sympify(value) if isinstance(value, sp.Basic) else rational(value)


class Traced:
    """An expression in the place of a number, while a function is called with symbols."""

    def __init__(self, expression: sp.Expr) -> None:
        self.expression = expression

    def __neg__(self) -> Traced:
        return Traced(-self.expression)

    def __pos__(self) -> Traced:
        return self

    def __abs__(self) -> Traced:
        return Traced(sp.Abs(self.expression))

    def _no_number(self, *_: Any) -> NoReturn:
        raise ModelError(
            f"it compares {self.expression}, or needs its number (if, max, clip, math.sin, "
            "np.zeros(n)[k] = ...)"
        )

    __bool__ = __float__ = __int__ = __index__ = _no_number
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = _no_number
    __hash__ = None  # type: ignore[assignment]

    def __getattr__(self, name: str) -> Callable[[], Traced]:
        """Return what numpy calls for ``np.sin(x)``: ``x.sin``."""
        if name.startswith("__"):
            raise AttributeError(name)
        if name not in _FUNCTIONS:
            raise ModelError(f"it calls {name} of {self.expression}, which has no expression here")
        return lambda: Traced(_FUNCTIONS[name](self.expression))


def _method(operation: Callable[[Any, Any], Any], *, reflected: bool) -> Callable[..., Any]:
    """Return ``__add__`` or ``__radd__`` of an operation; numpy spreads it over arrays."""

    def method(first: Traced, second: Any) -> Any:
        if isinstance(second, np.ndarray) and second.ndim:
            return NotImplemented
        pair = first.expression, _sympy(second)
        return Traced(operation(*(reversed(pair) if reflected else pair)))

    return method


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(Traced, f"__{_name}__", _method(getattr(operator, _name), reflected=False))
    setattr(Traced, f"__r{_name}__", _method(getattr(operator, _name), reflected=True))
