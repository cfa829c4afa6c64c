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
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from decimal import Decimal
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


def require_order(program: ControllerProgram) -> None:
    """Refuse limits in the wrong order; those that are known in a sample only are not looked at.

    Raises
    ------
    ModelError : names the entries of the file, and both limits.
    """
    places = {one.name: one.place for one in program.constants}
    numbers = {one.name: floats(one.value) for one in program.constants}
    for one in program.constants:
        if one.place in RATES and numbers[one.name] < 0:
            raise ModelError(f"{one.place} is {numbers[one.name]:g}; 0 or more is needed")
    calls = [call for formula in program.formulas() for call in calls_of(formula)]
    for low, high in (call.arguments[1:] for call in calls if call.function == "limit"):
        names = [*names_of(low), *names_of(high)]
        if not set(names) <= set(numbers):
            continue
        least, most = value_of(low, numbers), value_of(high, numbers)
        if least > most:
            told = " and ".join(dict.fromkeys(places[name] for name in names))
            raise ModelError(
                f"{told}: the lower limit is {least:g} and the upper one {most:g}, so that the "
                "program would send the upper one at all times; exchange them, or give the "
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
    rows = {one.name: one for one in program.constants}
    for name in dict.fromkeys(_nodes(program)):
        values = [_rounded(value, BITS[precision]) for value in floats(rows[name].value)]
        for k, (low, high) in enumerate(pairwise(values)):
            if high <= low:
                cure = "; give --precision double for this law" if precision == "float" else ""
                raise ModelError(
                    f"{rows[name].place}: nodes {k} and {k + 1} do not increase as numbers of type "
                    f"{precision}, so that the program would divide by zero between them{cure}"
                )


def _rounded(value: float, bits: int) -> float:
    """Return the nearest number with so many binary digits."""
    share, power = frexp(value)
    return ldexp(round(ldexp(share, bits)), power - bits)


def _nodes(program: ControllerProgram) -> Iterator[str]:
    """Yield the names of constants that are nodes."""
    known = {one.name for one in program.constants}
    for formula in program.formulas():
        for call in calls_of(formula):
            if call.function in BETWEEN_NODES and len(call.arguments) > 1:
                row = call.arguments[1]
                if isinstance(row, Name) and row.name in known:
                    yield row.name


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
            "the takagi that wrote it"
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
        what = f"{error.args[0]!r} is missing" if absent else "a part cannot be read"
        raise ModelError(
            f"the gain file is damaged: {what} in its programs or in what they name; give the "
            "gains.json that `takagi design` has written"
        ) from error


class _Reading:
    def __init__(self, document: Mapping[str, Any], without: Collection[str]) -> None:
        self.document = document
        known = [part["name"] for part in document["programs"]]
        for word in without:
            if word not in known:
                raise ModelError(f"program {word!r} was given; the file has {', '.join(known)}")
        self.programs = [part for part in document["programs"] if part["name"] not in without]
        self.sent = {one["name"] for part in self.programs for one in part["send"]}
        self.read = {one["name"]: one for part in reversed(self.programs) for one in part["read"]}
        self.constants: dict[str, Constant] = {}
        # In formulas of premises a table is called by its name, as in plant files.
        places = (entry for part in self.programs for entry in part["names"].items())
        self.tables = {name for name, entry in places if entry["value"].startswith("tables.")}

    def whole(self) -> ControllerProgram:
        taken = self._taken()
        stages = tuple(self._stage(part, taken) for part in self.programs)
        known = {*self.constants, *self.read, *self.sent, "sample_time"}
        known |= {one.name for stage in stages for one in stage.kept}
        known |= {one.name for stage in stages for one in stage.assignments}
        inputs = tuple(
            self._input(one) for name, one in self._reads().items() if name not in self.sent
        )
        outputs = tuple(
            Signal(one["name"], one["unit"], one["meaning"])
            for part in self.programs
            for one in part["send"]
        )
        document = self.document
        found = ControllerProgram(
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
        for formula in found.formulas():
            for name in names_of(formula):
                if name not in known:
                    raise ModelError(f"a formula names {name!r}, which nothing in the file sets")
        require_order(found)
        require_nodes(found, "double")
        return found

    def _reads(self) -> dict[str, Any]:
        return {one["name"]: one for part in self.programs for one in part["read"]}

    def _taken(self) -> dict[str, dict[str, str]]:
        """Return, program by program, the name in the whole program for each name of its own."""
        signals = {*self.read, *self.sent, "sample_time"}
        meanings: dict[str, set[str]] = {}
        for part in self.programs:
            for name, what in self._own(part).items():
                meanings.setdefault(name, set()).add(what)
        found: dict[str, dict[str, str]] = {}
        for part in self.programs:
            word = part["name"].replace(" ", "_")
            found[part["name"]] = {
                name: f"{word}_{name}" if len(meanings[name]) > 1 or name in signals else name
                for name in self._own(part)
            }
        return found

    @staticmethod
    def _own(part: Any) -> dict[str, str]:
        """Return the names that a program sets, with a text that is equal for equal meanings."""
        own = {name: str(entry["value"]) for name, entry in part["names"].items()}
        own |= {one["name"]: f"{part['name']}: kept" for one in part["keep"]}
        return own | {one["set"]: f"{part['name']}: step" for one in part["steps"]}

    def _stage(self, part: Any, taken: Mapping[str, Mapping[str, str]]) -> Stage:
        own = taken[part["name"]]
        for name, entry in part["names"].items():
            value = _value(self.document, str(entry["value"]).split("."))
            self.constants[own[name]] = Constant(own[name], entry["unit"], entry["value"], value)
        kept = tuple(
            Kept(
                own[one["name"]],
                one["unit"],
                one["meaning"],
                self._formula(one["start"], own),
                self._formula(one["next"], own),
            )
            for one in part["keep"]
        )
        steps = tuple(self._assignment(one, own[one["set"]], own) for one in part["steps"])
        sends = tuple(self._assignment(one, one["name"], own) for one in part["send"])
        return Stage(part["name"], kept, steps, sends)

    def _formula(self, text: str, own: Mapping[str, str]) -> Formula:
        return renamed(parsed(text, self.tables), own)

    def _assignment(self, one: Any, name: str, own: Mapping[str, str]) -> Assignment:
        near = tuple(
            Near(
                self._formula(place["of"], own),
                place["within"],
                self._formula(place["formula"], own),
            )
            for place in one.get("near", ())
        )
        return Assignment(
            name,
            one["unit"],
            one["meaning"],
            self._formula(one["formula"], own),
            near,
        )

    def _input(self, one: Any) -> Signal:
        found = Signal(one["name"], one["unit"], one["meaning"])
        keys = ("measured", "states", "signals")
        for part in (one for key in keys for one in self.document.get(key, ())):
            if isinstance(part, Mapping) and part["name"] == found.name:
                ends = part.get("range")
                low_high = None if ends is None else (ends[0], ends[1])
                return replace(found, rest=part["rest"], range=low_high)
        return _turbine_input(found, self.document) if "turbine" in self.document else found


def _turbine_input(signal: Signal, document: Mapping[str, Any]) -> Signal:
    """Return a turbine's input with the range of the trim table; its rest is the lowest trim."""
    trim, limits = document["trim"], document["limits"]
    speed, wind = trim["rotor_speed"], trim["wind"]
    known = {
        "speed": (speed[0], (Decimal(0), 2 * max(speed))),
        "measured_speed": (speed[0], (Decimal(0), 2 * max(speed))),
        "pitch": (trim["pitch"][0], (limits["pitch"][0], limits["pitch"][1])),
        "wind_guess": (wind[0], (wind[0], wind[-1])),
        "wind_estimate": (wind[0], (wind[0], wind[-1])),
    }
    rest, ends = known.get(signal.name, (None, None))
    return replace(signal, rest=rest, range=ends)


def renamed(formula: Formula, names: Mapping[str, str]) -> Formula:
    """Return a formula with other names where ``names`` has some."""
    match formula:
        case Name(name):
            return Name(names.get(name, name))
        case Operation(sign, left, right):
            before = None if left is None else renamed(left, names)
            return Operation(sign, before, renamed(right, names))
        case Call(function, arguments):
            return Call(function, tuple(renamed(one, names) for one in arguments))
    return formula


def _value(part: Any, path: list[str]) -> Value:
    """Return the value at a path of the file; ``*`` in a path means all rows."""
    for k, key in enumerate(path):
        if key == "*":
            return tuple(_value(row, path[k + 1 :]) for row in part)  # type: ignore[return-value]
        part = part[int(key)] if isinstance(part, list) else part[key]
    return _number(part)


def _number(part: Any) -> Value:
    if isinstance(part, Decimal):
        return part
    if isinstance(part, str):
        return _without_names(part)
    if isinstance(part, Mapping):
        rows = [_row(row) for row in part["knots"]]
        inner = part["coefficients"]
        tables = [_row(row) for row in inner] if isinstance(inner[0], list) else [_row(inner)]
        return Spline(tuple(rows), tuple(tables))
    if part and isinstance(part[0], list):
        return tuple(_row(row) for row in part)
    return _row(part)


def _row(part: Any) -> Row:
    return tuple(_without_names(one) if isinstance(one, str) else +Decimal(one) for one in part)


def _without_names(text: str) -> Decimal:
    """Return the float nearest to a formula without names, such as ``pi/6``, as a decimal."""
    # Imported here: sympy takes half a second, and most files have no such text.
    from takagi.models.expressions.parser import Scope, parse_expression

    return Decimal(repr(float(parse_expression(text, Scope({})).evalf(30))))
