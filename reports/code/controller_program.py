"""The programs of a gain file as one value: constants, signals, kept values, steps in order.

All targets (C, MATLAB, structured text) read this value and not the file, so that they cannot
interpret the file differently.  Every name in it has one meaning: where two programs of the file
use a name for two things, the program's name is put in front, such as ``observer_v_rate``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, TypeAlias

from takagi.reports.code.formula import Formula

Row: TypeAlias = tuple[Decimal, ...]
Value: TypeAlias = "Decimal | Row | tuple[Row, ...] | Spline"


@dataclass(frozen=True, slots=True)
class Spline:
    """A cubic spline of one or two arguments.

    Attributes
    ----------
    knots : for each argument all knots, those at the ends repeated.
    coefficients : one row for a spline of one argument; for two arguments, one row for each basis
        function of the first.
    """

    knots: tuple[Row, ...]
    coefficients: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Constant:
    """A number, row, matrix or spline of the file; ``place`` is its path in the file."""

    name: str
    unit: str
    place: str
    value: Value


@dataclass(frozen=True, slots=True)
class Signal:
    """A value that is read or sent at every sample.

    Attributes
    ----------
    rest : value in SI that is used before the first finite measurement.
    range : interval in SI in which the model holds; None where the file states none.
    """

    name: str
    unit: str
    meaning: str
    rest: Decimal | None = None
    range: tuple[Decimal, Decimal] | None = None


@dataclass(frozen=True, slots=True)
class Near:
    """Where |of| <= within, ``formula`` replaces the step's own formula.

    It serves a quotient near a point where numerator and denominator vanish.
    """

    of: Formula
    within: Decimal
    formula: Formula


@dataclass(frozen=True, slots=True)
class Assignment:
    """One step of a program, or a value that it sends: ``name = formula``."""

    name: str
    unit: str
    meaning: str
    formula: Formula
    near: tuple[Near, ...] = ()


@dataclass(frozen=True, slots=True)
class Kept:
    """A value that is kept from sample to sample: ``start`` at the first one, then ``next``."""

    name: str
    unit: str
    meaning: str
    start: Formula
    next: Formula


@dataclass(frozen=True, slots=True)
class Stage:
    """One program of the file: its kept values, its steps in order, and what it then sends."""

    name: str
    kept: tuple[Kept, ...]
    steps: tuple[Assignment, ...]
    sends: tuple[Assignment, ...]

    @property
    def assignments(self) -> tuple[Assignment, ...]:
        """Steps and sends in the order in which they are computed."""
        return self.steps + self.sends


@dataclass(frozen=True, slots=True)
class ControllerProgram:
    """One sample of a controller.

    The stages run in order.  At the first sample the kept values of a stage take their ``start``;
    then its steps are computed, then the values that it sends.  After the last stage all kept
    values take their ``next`` at once.  ``sample_time`` [s] is a name in formulas.

    Attributes
    ----------
    name : the file's title.
    plant : the name of the plant or turbine.
    kind : "turbine" or "plant".
    sample_time : T [s] of a law in discrete time; None where the user chooses it.
    constants, inputs, outputs : each name once; outputs are all values that the stages send.
    verdict : the verdict of the certificate, as the gain file states it.
    hashes : SHA-256 of the certificate's members, as the gain file states them.
    document : the gain file as plain data, numbers as Decimals.
    """

    name: str
    plant: str
    kind: str
    sample_time: Decimal | None
    constants: tuple[Constant, ...]
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    stages: tuple[Stage, ...]
    verdict: str
    hashes: Mapping[str, str]
    document: Mapping[str, Any]

    @property
    def kept(self) -> tuple[Kept, ...]:
        """The kept values of all stages."""
        return tuple(one for stage in self.stages for one in stage.kept)

    @property
    def assignments(self) -> tuple[Assignment, ...]:
        """The steps and sent values of all stages, in the order in which they are computed."""
        return tuple(one for stage in self.stages for one in stage.assignments)

    def names(self) -> Iterator[str]:
        """Yield every name: constants, inputs, kept values, steps and outputs."""
        for part in (self.constants, self.inputs, self.kept, self.assignments):
            yield from (one.name for one in part)
