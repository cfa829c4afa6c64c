"""A law with its observer as instructions for the compiled loop, from the program of gain files.

What runs is the program that a gain file states and that every export translates: observer and
law.  The filter of the measured speed and the limits of the rates are those of the plant that is
simulated, and a run starts where the law rests at its first wind.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from typing import Any, TypeVar

import numpy as np

from takagi.certificates.checker.controller.content import FORMAT, VERSION
from takagi.certificates.checker.controller.turbine_content import turbine_content
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.controller.content import plain
from takagi.certificates.document.certificate_file import (
    effort_sharing_law_data,
    published_law_data,
    turbine_data,
)
from takagi.certificates.sweep.tasks import cores
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import Law, SampledLaw
from takagi.models.laws.published.law import PublishedLaw, SwitchedLaw
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import TIME_STEP, History, Observer, simulate
from takagi.models.simulation.compiled_loop import CompiledLaw, simulate_compiled
from takagi.models.simulation.equations import Instructions
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.code.baseline import NOT_PROVED, baseline_program
from takagi.reports.code.controller_program import (
    Assignment,
    Call,
    Constant,
    ControllerProgram,
    Formula,
    Name,
    Number,
    Operation,
    Spline,
)
from takagi.reports.code.program_reading import controller_program
from takagi.reports.code.run import floats

_Result = TypeVar("_Result")
# The programs of a file that are run; the others are the plant's.
STAGES = ("observer", "law")


class SampledLoop:
    """A law on a plant, sampled and held, to run in any wind.

    A law that has a program runs compiled, any other one as a Python object.  Both give the same.

    Attributes
    ----------
    plant : with the filter of the measured speed.
    """

    def __init__(
        self,
        plant: SimulatedTurbine,
        law: Law,
        observer: Observer | None,
        *,
        sample_time: float = TIME_STEP,
        computation_time: float = 0.0,
    ) -> None:
        """Make a loop; the times [s] are those of ``SampledLaw``."""
        self.plant, self._observer = plant, observer
        self._sampled = SampledLaw(law, sample_time, computation_time)
        self._compiled = compiled_law(plant.turbine, law, observer)

    def run(self, wind: WindSeries) -> History:
        """Return the loop over the whole wind series, from rest at its first wind.

        Raises
        ------
        ModelError : steps that do not fit.
        Diverged : a ModelError; the states grow beyond all numbers, the message says when.
        """
        if self._compiled is None:
            return simulate(self.plant, self._sampled, wind, observer=self._observer)
        sampled = self._sampled
        return simulate_compiled(
            self.plant,
            self._compiled,
            wind,
            sample_time=sampled.sample_time,
            computation_time=sampled.computation_time,
        )


def in_threads(
    tasks: Iterable[Callable[[], _Result]], workers: int | None = None
) -> Iterator[_Result]:
    """Yield the results of tasks in their order; compiled loops run side by side.

    Parameters
    ----------
    workers : threads; as many as there are cores unless given.
    """
    with ThreadPoolExecutor(workers or cores()) as pool:
        yield from pool.map(lambda task: task(), tasks)


def compiled_law(turbine: Turbine, law: Law, observer: Observer | None) -> CompiledLaw | None:
    """Return a law for the compiled loop; None of one that has no program.

    Parameters
    ----------
    turbine : of a law without an observer, which else has its own.
    observer : what estimates the wind; None lets the law see the true wind.
    """
    if type(law) is BaselineLaw:
        # It reads no wind, so that it needs no observer.
        return CompiledLaw(law, None, instructions(baseline_program(law.turbine)))
    if observer is not None and not isinstance(observer, WindObserver):
        return None
    try:
        program = _program(turbine, law, observer)
    except CertificateError:
        # A filter between the regions that gain files cannot express.
        return None
    if program is None:
        return None
    return CompiledLaw(law, observer, instructions(program, setpoints_now(law)))


def setpoints_now(law: Law) -> dict[str, float]:
    """Return the set-points [rad/s], [W] that a law has now; none for the rated ones."""
    if not isinstance(law, EffortSharingLaw) or law.setpoints is None or law.operation is None:
        return {}
    speed, torque = law.operation
    power = law.setpoints.power_per_torque * speed * torque
    return {"speed_setpoint": speed, "power_setpoint": power}


def _program(turbine: Turbine, law: Law, observer: WindObserver | None) -> ControllerProgram | None:
    if type(law) is EffortSharingLaw:
        data = effort_sharing_law_data(law)
    elif isinstance(law, PublishedLaw) and type(law) in (PublishedLaw, SwitchedLaw):
        data = published_law_data(law)
    else:
        return None
    points = [trim(turbine, wind) for wind in (turbine.cut_in, turbine.cut_out)]
    states = [law.initial_state(point.wind).tolist() for point in points]
    low, high = (turbine.cut_in, turbine.cut_out) if observer is None else observer.limits
    gains = (1.0, 1.0) if observer is None else (observer.l1, observer.l2)
    controller = {
        "name": law.name,
        "turbine": turbine.name,
        "trim": {
            "wind": [point.wind for point in points],
            "rotor_speed": [point.rotor_speed for point in points],
            "pitch": [point.pitch for point in points],
        },
        "start": {
            "wind": [point.wind for point in points],
            "integrals": [list(column) for column in zip(*states, strict=True)],
        },
        "observer": {"l1": gains[0], "l2": gains[1], "wind_limits": [low, high]},
        "certificate": {"verdict": NOT_PROVED, "sha256": {}},
    }
    seen = turbine if observer is None else observer.turbine
    content = turbine_content(turbine_data(seen, ()), data, controller)
    if observer is None:
        content["programs"] = [p for p in content["programs"] if p["name"] != "observer"]
    document = {**controller, "format": FORMAT, "version": VERSION, "law": data, **content}
    text = json.dumps(plain(document))
    return controller_program(json.loads(text, parse_float=Decimal, parse_int=Decimal))


def instructions(
    program: ControllerProgram, setpoints: Mapping[str, float] | None = None
) -> Instructions:
    """Return the stages of ``STAGES`` of a program as instructions.

    Parameters
    ----------
    setpoints : of those that the law reads, the values; None takes the rated ones.

    Raises
    ------
    ModelError : a formula names what nothing in these stages sets.
    """
    from takagi.models.simulation import equations

    writing = _Writing(program)
    rated = {s.name: float(s.rest or 0) for s in program.inputs if s.optional}
    for name, value in {**rated, **(setpoints or {})}.items():
        writing.names[name] = writing.number(value)
    stages = [stage for stage in program.stages if stage.name in STAGES]
    kept = [state for stage in stages for state in stage.kept]
    for state in kept:
        writing.names[state.name] = writing.room()
    for stage in stages:
        for assignment in stage.assignments:
            writing.names[assignment.name] = writing.assigned(assignment)
    outputs, writing.code = writing.code, []
    after = [writing.place(state.next) for state in kept]
    names = writing.names
    wind = names["wind_estimate"]
    return equations.Instructions(
        outputs=_rows(outputs),
        following=_rows(writing.code),
        memory=np.array(writing.memory),
        # Numba reads no empty row.
        tables=np.array(writing.tables or [0.0]),
        inputs=np.array([names["speed"], names["pitch"], writing.true_wind, names["sample_time"],
                         names["torque_sent"]]),
        commands=np.array([names["torque"], names["pitch_reference"], wind]),
        kept=np.array([names[state.name] for state in kept], dtype=np.int64),
        after=np.array(after, dtype=np.int64),
    )  # fmt: skip


def _rows(code: Sequence[tuple[int, ...]]) -> Any:
    return np.array(code, dtype=np.int64).reshape(len(code), 6)


class _Writing:
    """The memory, tables and instructions of a program as they grow; equal formulas are one."""

    def __init__(self, program: ControllerProgram) -> None:
        self.memory: list[float] = []
        self.tables: list[float] = []
        self.code: list[tuple[int, ...]] = []
        self.constants: dict[str, Constant] = {entry.name: entry for entry in program.constants}
        self.names: dict[str, int] = {}
        self.numbers: dict[float, int] = {}
        self.known: dict[object, int] = {}
        for name, constant in self.constants.items():
            if isinstance(constant.value, Decimal):
                self.names[name] = self.number(float(constant.value))
        for name in ("speed", "pitch", "wind_estimate", "sample_time", "torque_sent"):
            self.names[name] = self.room()
        # An observer's estimate takes this name from the true wind.
        self.true_wind = self.names["wind_estimate"]

    def room(self, value: float = 0.0) -> int:
        self.memory.append(value)
        return len(self.memory) - 1

    def number(self, value: float) -> int:
        if value not in self.numbers:
            self.numbers[value] = self.room(value)
        return self.numbers[value]

    def write(self, op: str, *reads: int) -> int:
        """Write an instruction and return where its result is; an equal one is not repeated."""
        from takagi.models.simulation import equations

        key = (op, *reads)
        if key not in self.known:
            self.known[key] = at = self.room()
            padded = (*reads, 0, 0, 0, 0)[:4]
            self.code.append((getattr(equations, op), at, *padded))
        return self.known[key]

    def assigned(self, assignment: Assignment) -> int:
        """Return the place of a step's value; near some points another formula replaces it."""
        at = self.place(assignment.formula)
        for near in reversed(assignment.near):
            within = self.number(float(near.within))
            at = self.write("NEAR", self.place(near.of), within, self.place(near.formula), at)
        return at

    def place(self, formula: Formula) -> int:
        """Write what a formula needs, and return the place of its value."""
        match formula:
            case Number(value):
                return self.number(float(value))
            case Name(name):
                return self.named(name)
            case Operation("-", None, right):
                return self.write("NEGATIVE", self.place(right))
            case Operation("^", left, Number(value)) if value == 2 and left is not None:
                base = self.place(left)
                return self.write("MULTIPLY", base, base)
            case Operation(sign, left, right):
                assert left is not None
                return self.write(_SIGNS[sign], self.place(left), self.place(right))
            case Call(function, arguments):
                return self.called(function, arguments)

    def named(self, name: str) -> int:
        if name == "pi":
            return self.number(float(np.pi))
        if name not in self.names:
            raise ModelError(
                f"a formula names {name!r}, which neither observer nor law of the program sets"
            )
        return self.names[name]

    def called(self, function: str, arguments: Sequence[Formula]) -> int:
        if function in ("first", "last"):
            row = floats(self.constant(arguments[0]).value)
            return self.number(row[0 if function == "first" else -1])
        if function in ("line", "slope", "hold"):
            nodes, values = (self.row(argument) for argument in arguments[1:])
            count = len(floats(self.constant(arguments[1]).value))
            return self.write(function.upper(), self.place(arguments[0]), nodes, values, count)
        if function == "spline":
            at = [self.place(argument) for argument in arguments[:-1]]
            return self.write("SPLINE" if len(at) == 1 else "SURFACE", *at, self.row(arguments[-1]))
        if function == "mix":
            return self.mixed(arguments)
        return self.write(function.upper(), *map(self.place, arguments))

    def constant(self, formula: Formula) -> Constant:
        assert isinstance(formula, Name)
        return self.constants[formula.name]

    def row(self, formula: Formula) -> int:
        """Return where the numbers of a row or spline begin in the tables."""
        constant = self.constant(formula)
        key = ("table", constant.name)
        if key not in self.known:
            self.known[key] = len(self.tables)
            if isinstance(constant.value, Spline):
                knots, coefficients = floats(constant.value)
                self.tables += [float(len(row)) for row in knots]
                self.tables += [number for row in (*knots, *coefficients) for number in row]
            else:
                self.tables += floats(constant.value)
        return self.known[key]

    def mixed(self, arguments: Sequence[Formula]) -> int:
        """Write the sum over the rules of value times the product of w or 1 - w."""
        rules, values = (floats(self.constant(argument).value) for argument in arguments[:2])
        if len(values) == 1:
            return self.number(values[0])
        one, shares = self.number(1.0), [self.place(argument) for argument in arguments[2:]]
        total = None
        for rule, value in zip(rules, values, strict=True):
            weight = None
            for marked, share in zip(rule, shares, strict=True):
                factor = share if marked else self.write("SUBTRACT", one, share)
                weight = factor if weight is None else self.write("MULTIPLY", weight, factor)
            term = self.number(value)
            term = term if weight is None else self.write("MULTIPLY", weight, term)
            total = term if total is None else self.write("ADD", total, term)
        assert total is not None
        return total


_SIGNS: Mapping[str, str] = {
    "+": "ADD",
    "-": "SUBTRACT",
    "*": "MULTIPLY",
    "/": "DIVIDE",
    "^": "POWER",
}
