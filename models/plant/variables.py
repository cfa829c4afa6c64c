"""The symbols of a plant's equations: variables, parameters and outputs, with their units."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.intervals.interval import Interval

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
