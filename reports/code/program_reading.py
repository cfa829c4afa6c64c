"""Reading a gain file as a ``ControllerProgram``: names that are unique, constants, formulas.

Limits that are numbers of the file must be in order.  ``limit(x, low, high)`` is
min(max(x, low), high): with the limits in the wrong order it is ``high`` whatever x is, so that the
program would send one value at all times.

Nodes of a table must increase in the floats that the code computes with.  ``line`` and ``slope``
divide by the distance of two nodes.  Two decimals may differ and be one float: then nothing finite
is computed there.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from itertools import pairwise
from math import frexp, ldexp
from pathlib import Path
from typing import Any

from takagi.certificates.checker.controller.content import VERSION
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import (
    Assignment,
    Call,
    Constant,
    ControllerProgram,
    Formula,
    Kept,
    Name,
    Near,
    Operation,
    Row,
    Signal,
    Spline,
    Stage,
    Value,
    calls_of,
    names_of,
    parsed,
)
from takagi.reports.code.run import floats, value_of

RATES = ("limits.torque_rate", "limits.pitch_rate")
MILLI = Decimal("0.001")


def require_order(program: ControllerProgram) -> None:
    """Refuse limits in the wrong order; those that are known in a sample only are not looked at.

    Raises
    ------
    ModelError : names the entries of the file, and both limits.
    """
    file_places = {constant.name: constant.path for constant in program.constants}
    numbers = {constant.name: floats(constant.value) for constant in program.constants}
    for constant in program.constants:
        if constant.path in RATES and numbers[constant.name] < 0:
            raise ModelError(f"{constant.path} is {numbers[constant.name]:g}; 0 or more is needed")
    calls = [call for formula in program.formulas() for call in calls_of(formula)]
    for low, high in (call.arguments[1:] for call in calls if call.function == "limit"):
        names = [*names_of(low), *names_of(high)]
        if not set(names) <= set(numbers):
            continue
        lower, upper = value_of(low, numbers), value_of(high, numbers)
        if lower > upper:
            places_text = " and ".join(dict.fromkeys(file_places[name] for name in names))
            raise ModelError(
                f"{places_text}: the lower limit is {lower:g} and the upper one {upper:g}, so that "
                "the program would send the upper one at all times; exchange them, or give the "
                "gains.json that `takagi design` has written"
            )


# Functions whose second argument is a row of nodes, and the digits of a float of each precision.
BETWEEN_NODES = ("line", "slope", "hold")
BITS = {"double": 53, "float": 24}


def require_nodes(program: ControllerProgram, precision: str) -> None:
    """Refuse nodes that do not increase as floats of this precision, "double" or "float".

    Raises
    ------
    ModelError : names the row of the file.
    """
    rows = {constant.name: constant for constant in program.constants}
    calls = [call for formula in program.formulas() for call in calls_of(formula)]
    nodes = [call.arguments[1] for call in calls if call.function in BETWEEN_NODES]
    names = (node.name for node in nodes if isinstance(node, Name) and node.name in rows)
    for name in dict.fromkeys(names):
        values = [_rounded(value, BITS[precision]) for value in floats(rows[name].value)]
        for k, (low, high) in enumerate(pairwise(values)):
            if high <= low:
                cure = "; give --precision double for this law" if precision == "float" else ""
                raise ModelError(
                    f"{rows[name].path}: nodes {k} and {k + 1} do not increase as numbers of type "
                    f"{precision}, so that the program would divide by zero between them{cure}"
                )


def _rounded(value: float, bits: int) -> float:
    """Return the nearest number with so many binary digits."""
    share, power = frexp(value)
    return ldexp(round(ldexp(share, bits)), power - bits)


def read_controller(path: Path, *, without: Collection[str] = ()) -> ControllerProgram:
    """Return the program of a gain file; ``without`` names programs to leave out.

    Raises
    ------
    ModelError : the file is not a gain file, has no programs, or one that cannot be read.
    """
    try:
        document = json.loads(
            path.read_text(encoding="utf-8"), parse_float=Decimal, parse_int=Decimal
        )
    except (ValueError, RecursionError) as error:
        raise ModelError(f"{path}: no gain file, for it is not valid JSON ({error})") from error
    try:
        return controller_program(document, without=without)
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from error


def controller_program(
    document: Mapping[str, Any], *, without: Collection[str] = ()
) -> ControllerProgram:
    """Return the program of a gain file's content, numbers as Decimals; see ``read_controller``."""
    if not isinstance(document, Mapping) or document.get("format") != "takagi-gains":
        raise ModelError(
            "this is no gain file of takagi; give gains.json of a design (a certificate goes to "
            "`takagi export CERT --coq FILE`)"
        )
    version = document.get("version")
    if isinstance(version, Decimal | int) and version > VERSION:
        raise ModelError(
            f"a gain file of version {version}; this takagi reads versions up to {VERSION}: use "
            "the takagi that wrote it, or a newer one"
        )
    if not document.get("programs"):
        raise ModelError(
            f"a gain file of version {version} has no programs; write a new one "
            "with `takagi certify MODEL --gains OLD --out CERT`"
        )
    try:
        return _Reading(document, without).whole()
    except (KeyError, IndexError, TypeError, ArithmeticError, AttributeError) as error:
        absent = isinstance(error, KeyError)
        damage = f"{error.args[0]!r} is missing" if absent else "a part cannot be read"
        raise ModelError(
            f"the gain file is damaged: {damage} in its programs or in what they name; give the "
            "gains.json that `takagi design` has written"
        ) from error


class _Reading:
    def __init__(self, document: Mapping[str, Any], without: Collection[str]) -> None:
        self.document = document
        names = [stated["name"] for stated in document["programs"]]
        for word in without:
            if word not in names:
                raise ModelError(f"program {word!r} was given; the file has {', '.join(names)}")
        self.programs = [stated for stated in document["programs"] if stated["name"] not in without]
        self.sent = {signal["name"] for stated in self.programs for signal in stated["send"]}
        self.read = {
            signal["name"]: signal for stated in self.programs for signal in stated["read"]
        }
        self.constants: dict[str, Constant] = {}
        # In formulas of premises a table is called by its name, as in plant files.
        entries = (entry for stated in self.programs for entry in stated["names"].items())
        self.tables = {name for name, entry in entries if entry["value"].startswith("tables.")}

    def whole(self) -> ControllerProgram:
        full_names = self._taken()
        stages = tuple(self._stage(stated, full_names) for stated in self.programs)
        defined = {*self.constants, *self.read, *self.sent, "sample_time"}
        defined |= {state.name for stage in stages for state in stage.kept}
        defined |= {assignment.name for stage in stages for assignment in stage.assignments}
        inputs = tuple(
            self._input(signal) for name, signal in self.read.items() if name not in self.sent
        )
        outputs = tuple(
            Signal(signal["name"], signal["unit"], signal["meaning"])
            for stated in self.programs
            for signal in stated["send"]
        )
        document = self.document
        program = ControllerProgram(
            name=document["name"],
            plant=document.get("turbine") or document["plant"],
            kind="turbine" if "turbine" in document else "plant",
            sample_time=document["law"].get("sample_time"),
            constants=tuple(self.constants.values()),
            inputs=inputs,
            outputs=outputs,
            stages=stages,
            verdict=document["certificate"]["verdict"],
            hashes=document["certificate"]["sha256"],
            document=document,
        )
        for formula in program.formulas():
            for name in names_of(formula):
                if name not in defined:
                    raise ModelError(f"a formula names {name!r}, which nothing in the file sets")
        require_order(program)
        require_nodes(program, "double")
        return program

    def _taken(self) -> dict[str, dict[str, str]]:
        """Return, program by program, the name in the whole program for each name of its own."""
        signals = {*self.read, *self.sent, "sample_time"}
        meanings: dict[str, set[str]] = {}
        for stated in self.programs:
            for name, meaning in self._own(stated).items():
                meanings.setdefault(name, set()).add(meaning)
        full_names: dict[str, dict[str, str]] = {}
        for stated in self.programs:
            word = stated["name"].replace(" ", "_")
            full_names[stated["name"]] = {
                name: f"{word}_{name}" if len(meanings[name]) > 1 or name in signals else name
                for name in self._own(stated)
            }
        return full_names

    @staticmethod
    def _own(stated: Any) -> dict[str, str]:
        """Return the names that a program sets, with a text that is equal for equal meanings."""
        meanings = {name: str(entry["value"]) for name, entry in stated["names"].items()}
        meanings |= {state["name"]: f"{stated['name']}: kept" for state in stated["keep"]}
        return meanings | {step["set"]: f"{stated['name']}: step" for step in stated["steps"]}

    def _stage(self, stated: Any, full_names: Mapping[str, Mapping[str, str]]) -> Stage:
        stage_names = full_names[stated["name"]]
        for name, entry in stated["names"].items():
            value = _value(self.document, str(entry["value"]).split("."))
            self.constants[stage_names[name]] = Constant(
                stage_names[name], entry["unit"], entry["value"], value
            )

        def formula(text: str) -> Formula:
            return renamed(parsed(text, self.tables), stage_names)

        def assignment(entry: Any, name: str) -> Assignment:
            nears = tuple(
                Near(formula(near["of"]), near["within"], formula(near["formula"]))
                for near in entry.get("near", ())
            )
            text = formula(entry["formula"])
            return Assignment(name, entry["unit"], entry["meaning"], text, nears)

        kept = tuple(
            Kept(
                stage_names[state["name"]], state["unit"], state["meaning"],
                formula(state["start"]), formula(state["next"]),
            )
            for state in stated["keep"]
        )  # fmt: skip
        steps = tuple(assignment(step, stage_names[step["set"]]) for step in stated["steps"])
        sends = tuple(assignment(signal, signal["name"]) for signal in stated["send"])
        return Stage(stated["name"], kept, steps, sends)

    def _input(self, entry: Any) -> Signal:
        signal = Signal(entry["name"], entry["unit"], entry["meaning"])
        keys = ("measured", "states", "signals")
        for variable in (entry for key in keys for entry in self.document.get(key, ())):
            if isinstance(variable, Mapping) and variable["name"] == signal.name:
                ends = variable.get("range")
                low_high = None if ends is None else (ends[0], ends[1])
                return replace(signal, rest=variable["rest"], range=low_high)
        return _turbine_input(signal, self.document) if "turbine" in self.document else signal


def _turbine_input(signal: Signal, document: Mapping[str, Any]) -> Signal:
    """Return a turbine's input with its range; it rests at the lowest trim, set-points at rated."""
    trim, limits = document["trim"], document["limits"]
    speed, wind = trim["rotor_speed"], trim["wind"]
    at_speed = speed[0], (Decimal(0), 2 * max(speed))
    at_wind = wind[0], (wind[0], wind[-1])
    inputs: dict[str, Any] = {
        **dict.fromkeys(("speed", "measured_speed"), at_speed),
        **dict.fromkeys(("wind_guess", "wind_estimate"), at_wind),
        "pitch": (trim["pitch"][0], (limits["pitch"][0], limits["pitch"][1])),
    }
    if "setpoints" in (law := document["law"]):
        stated, rated = law["setpoints"], law["rotor_speed"][-1]
        lowest, factor = stated["lowest_speed"], stated["power_per_torque"]
        # Rounded outwards to mW: the law limits the torque, so that at rest it is the rated one.
        lowest_power = (factor * lowest * stated["lowest_torque"]).quantize(MILLI, ROUND_FLOOR)
        most = (factor * rated * law["rated_torque"]).quantize(MILLI, ROUND_CEILING)
        inputs["speed_setpoint"] = rated, (lowest, rated)
        inputs["power_setpoint"] = most, (lowest_power, most)
    rest, ends = inputs.get(signal.name, (None, None))
    optional = signal.name.endswith("_setpoint") and ends is not None
    return replace(signal, rest=rest, range=ends, optional=optional)


def renamed(formula: Formula, names: Mapping[str, str]) -> Formula:
    """Return a formula with other names where ``names`` has some."""
    match formula:
        case Name(name):
            return Name(names.get(name, name))
        case Operation(sign, left, right):
            renamed_left = None if left is None else renamed(left, names)
            return Operation(sign, renamed_left, renamed(right, names))
        case Call(function, arguments):
            return Call(function, tuple(renamed(argument, names) for argument in arguments))
    return formula


def _value(content: Any, path: list[str]) -> Value:
    """Return the value at a path of the file; ``*`` in a path means all rows."""
    for k, key in enumerate(path):
        if key == "*":
            return tuple(_value(row, path[k + 1 :]) for row in content)  # type: ignore[return-value]
        content = content[int(key)] if isinstance(content, list) else content[key]
    return _number(content)


def _number(content: Any) -> Value:
    if isinstance(content, Decimal):
        return content
    if isinstance(content, str):
        return _without_names(content)
    if isinstance(content, Mapping):
        rows = [_row(row) for row in content["knots"]]
        inner = content["coefficients"]
        tables = [_row(row) for row in inner] if isinstance(inner[0], list) else [_row(inner)]
        return Spline(tuple(rows), tuple(tables))
    if content and isinstance(content[0], list):
        return tuple(_row(row) for row in content)
    return _row(content)


def _row(content: Any) -> Row:
    return tuple(
        _without_names(number) if isinstance(number, str) else +Decimal(number)
        for number in content
    )


def _without_names(text: str) -> Decimal:
    """Return the float nearest to a formula without names, such as ``pi/6``, as a decimal."""
    # Imported here: sympy takes half a second, and most files have no such text.
    from takagi.models.expressions.parser import Scope, parse_expression

    return Decimal(repr(float(parse_expression(text, Scope({})).evalf(30))))
