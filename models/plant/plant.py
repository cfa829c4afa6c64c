"""A plant as its equations say it, before anything is derived from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.blending.blending import Blending

__all__ = ["Output", "Parameter", "Plant", "Variable"]


@dataclass(frozen=True, slots=True)
class Variable:
    """A state, input or disturbance.

    Attributes
    ----------
    symbol : as it stands in the equations.
    unit : SI, e.g. ``"rad/s"``; ``"-"`` for a pure number.
    range : where the model shall hold; None for a variable that no premise may depend on.
    rest : its value at the operating point that the model is written around.
    description : in words, e.g. ``"angle from upright"``.
    schedules : of a disturbance: it stands in coefficients alone, so that A, B, C and D may depend
        on it and its column of E is 0.  It needs a range.
    """

    symbol: sp.Symbol
    unit: str = "-"
    range: Interval | None = None
    rest: Fraction = Fraction(0)
    description: str = ""
    schedules: bool = False

    @property
    def name(self) -> str:
        return str(self.symbol.name)

    @property
    def label(self) -> str:
        """Return e.g. ``"theta [rad]"``."""
        return f"{self.name} [{self.unit}]"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number with a name: exact value, SI unit, and where it comes from."""

    symbol: sp.Symbol
    value: Fraction
    unit: str = "-"
    source: str = ""


@dataclass(frozen=True, slots=True)
class Output:
    """What is measured: y = expression, in its unit."""

    name: str
    expression: sp.Expr
    unit: str = "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plant:
    """M(x) x' = f(x, u, w), y = g(x, u, w), with parameters, on a box.

    Attributes
    ----------
    equations : f, one row per state; parameters stand in it as symbols.
    states, inputs, disturbances : in the order of the model's vectors.
    mass : M, n x n in states and parameters; None for the identity.
    outputs : y.
    parameters : values that are put in before anything is derived.
    premises : symbol -> expression, where the user fixes them; empty leaves the choice.
    sample_time : T in s where x(t + T) stands in the place of x'; None for continuous time.
    units : "checked" if every unit is to fit (``takagi.models.plant.dimensions``), "unchecked" if
        nobody looked.
    name, description, source : what it is, in one line, and where its equations come from.
    blending : of a plant behind a blend (``takagi.models.blending``): what it was made of, with
        the plant as it was written; None for others.

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
    parameters: tuple[Parameter, ...] = ()
    premises: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    sample_time: float | None = None
    units: Literal["checked", "unchecked"] = "unchecked"
    name: str = ""
    description: str = ""
    source: str = ""
    blending: Blending | None = None

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
        self._check_units()

    def __hash__(self) -> int:
        # Equal plants have equal equations; a mapping has no hash of its own.
        return hash((self.name, self.states, self.inputs, self.equations))

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Return states, inputs and disturbances."""
        return (*self.states, *self.inputs, *self.disturbances)

    @property
    def box(self) -> dict[sp.Symbol, Interval]:
        """Return symbol -> range, of those that have one."""
        return {v.symbol: v.range for v in self.variables if v.range is not None}

    @property
    def values(self) -> dict[sp.Symbol, Fraction]:
        """Return symbol -> value of the parameters."""
        return {parameter.symbol: parameter.value for parameter in self.parameters}

    def _check_scheduling(self) -> None:
        for variable in (*self.states, *self.inputs):
            if variable.schedules:
                raise ModelError(
                    f"plant {self.name!r}: {variable.label} schedules, but it is a state or an "
                    "input; only a signal from outside can, so put it among the disturbances"
                )
        for variable in self.disturbances:
            if variable.schedules and variable.range is None:
                raise ModelError(
                    f"plant {self.name!r}: {variable.label} schedules and has no range; the "
                    "vertices of the model are made from it, so give one"
                )

    def _check_units(self) -> None:
        if self.units not in ("checked", "unchecked"):
            raise ModelError(
                f'plant {self.name!r}: units = {self.units!r} was given; "checked" or '
                '"unchecked" is needed'
            )
        if self.units == "checked":
            from takagi.models.plant.dimensions import check_units

            check_units(self)

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
        known = {v.symbol for v in self.variables} | {p.symbol for p in self.parameters}
        parts: list[tuple[str, Sequence[sp.Expr]]] = [
            (f"equation of {v.name}", [row])
            for v, row in zip(self.states, self.equations, strict=True)
        ]
        parts += [(f"output {y.name}", [y.expression]) for y in self.outputs]
        parts += [(f"premise {symbol}", [row]) for symbol, row in self.premises.items()]
        if self.mass is not None:
            parts.append(("mass matrix", list(self.mass)))
        for what, expressions in parts:
            unknown = sorted(
                str(s) for row in expressions for s in row.free_symbols if s not in known
            )
            if unknown:
                raise ModelError(
                    f"plant {self.name!r}, {what}: {', '.join(unknown)} is neither a variable nor "
                    "a parameter; define it, or correct its name"
                )
