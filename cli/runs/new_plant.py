"""The entries of a plant's file from options, or from answers at a terminal."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from takagi.models import Plant

Answer = TypeVar("Answer")
Entries = dict[str, Any]
_NUMBER = r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?"
_SPAN = rf"({_NUMBER})\s*\.\.\s*({_NUMBER})"
_NAME = r"([A-Za-z]\w*)"
_VARIABLE = re.compile(
    rf"\s*{_NAME}\s*(?:=\s*(?:{_SPAN})?\s*([^,:]*?))?\s*(?:,\s*rest\s+([^,:]+?))?\s*(?::\s*(.*))?",
    re.ASCII,
)
_PARAMETER = re.compile(rf"\s*(?:{_SPAN}|({_NUMBER}))\s*(.*?)\s*", re.ASCII)
_EQUATION = re.compile(rf"\s*{_NAME}\s*'?\s*=\s*(.+)", re.ASCII)
VARIABLE_FORM = '"theta = -60..60 deg", "T = 340..360 K, rest 350" or "x: what it is"'


@dataclass(frozen=True)
class PlantOptions:
    """What a plant's options say, as typed."""

    name: str | None = None
    states: Sequence[str] = ()
    inputs: Sequence[str] = ()
    disturbances: Sequence[str] = ()
    parameters: Sequence[str] = ()
    equations: Sequence[str] = ()
    measured: Sequence[str] = ()
    sample_time: float | None = None
    no_units: bool = False

    @property
    def given(self) -> bool:
        return self != PlantOptions()


TEMPLATE = PlantOptions(
    name="Pendulum with a motor",
    states=(
        "theta = -60..60 deg: angle from upright",
        "omega = -4..4 rad/s: its rate",
    ),
    inputs=("tau = -20..20 N m: torque of the motor",),
    parameters=("m = 2.0 kg", "l = 500 mm", "g = 9.81 m/s^2", "d = 0.1 N m s"),
    equations=("theta = omega", "omega = (m*g*l*sin(theta) - d*omega + tau) / (m*l^2)"),
)


def variable_entry(text: str) -> tuple[str, Entries]:
    """Return name and entry of ``theta = -60..60 deg, rest 0: angle from upright``.

    Raises
    ------
    ModelError : a text of another form.
    """
    match = _VARIABLE.fullmatch(text)
    if match is None:
        raise ModelError(f"{text!r} was given; a variable is written {VARIABLE_FORM}")
    name, low, high, unit, rest, description = match.groups()
    entry: Entries = {"unit": unit} if unit else {}
    if low is not None:
        entry["range"] = [Decimal(low), Decimal(high)]
    if rest:
        entry["rest"] = _rest(rest)
    return name, entry | ({"description": description} if description else {})


def _rest(text: str) -> Any:
    if text.startswith("near "):
        return {"near": _decimal(text.removeprefix("near "))}
    return _decimal(text) if re.fullmatch(_NUMBER, text.strip()) else text.strip()


def _decimal(text: str) -> Decimal:
    if not re.fullmatch(_NUMBER, text.strip()):
        raise ModelError(f"{text.strip()!r} was given; a number is needed")
    return Decimal(text.strip())


def parameter_entry(text: str) -> Any:
    """Return the entry of ``2 kg``, of ``0.9..1.1 kg``, or of an expression of other parameters."""
    from takagi.models.files.units import parse_unit

    match = _PARAMETER.fullmatch(text)
    if match is None:
        return text.strip()
    low, high, value, unit = match.groups()
    if unit != "-" and unit[:1] in tuple("*/^+-("):
        return text.strip()  # 2*m begins with a number too
    parse_unit(unit or "-")
    number = {"value": Decimal(value)} if value else {"range": [Decimal(low), Decimal(high)]}
    return number | ({"unit": unit} if unit else {})


def entries_of_options(options: PlantOptions, stem: str) -> Entries:
    """Return the entries of a plant's file.

    Raises
    ------
    ModelError : a text of another form, no state, an equation of what is no state.
    """
    if not options.states:
        raise ModelError(
            f"no state was given; write --state {VARIABLE_FORM.partition(',')[0]}, and --equation "
            '"theta = omega", for each'
        )
    equations = {}
    for text in options.equations:
        match = _EQUATION.fullmatch(text)
        if match is None:
            raise ModelError(f'--equation {text!r} was given; "theta = omega" is the form')
        equations[match[1]] = match[2]
    states = dict(map(variable_entry, options.states))
    missing = [name for name in states if name not in equations]
    if missing:
        raise ModelError(
            f"no equation for {', '.join(missing)} was given; every state needs one: --equation "
            f'"{missing[0]} = ..."'
        )
    parameters = {}
    for text in options.parameters:
        name, equals, value = text.partition("=")
        if not equals:
            raise ModelError(f'--parameter {text!r} was given; "m = 2 kg" is the form')
        parameters[name.strip()] = parameter_entry(value)
    sections = {
        "states": states,
        "inputs": dict(map(variable_entry, options.inputs)),
        "disturbances": dict(map(variable_entry, options.disturbances)),
        "parameters": parameters,
        "equations": equations,
    }
    head: Entries = {"format": 1, "kind": "plant", "name": options.name or stem}
    if options.no_units:
        head["units"] = "unchecked"
    if options.sample_time is not None:
        head["sample_time"] = Decimal(repr(options.sample_time))
    if options.measured:
        head["measured"] = list(options.measured)
    return head | sections


def plant_of_text(path: Path, text: str) -> Plant:
    """Return the plant of a text that is to be written.

    Raises
    ------
    ModelError : as ``load_plant``, and where the plant does not rest, or has no model on its box.
    """
    import tomllib

    from takagi.models import rule_count
    from takagi.models.files.library import Document, decimal_of
    from takagi.models.plant_files.loader import PlantFile

    document = Document(path, text, tomllib.loads(text, parse_float=decimal_of))
    try:
        plant = PlantFile(path, document).model
        rule_count(plant)
    except ModelError as error:
        # The file is not there yet, so its lines say nothing.
        raise ModelError(re.sub(rf"{re.escape(str(path))}(:\d+)?: ", "", str(error))) from error
    return plant


@dataclass
class Questions:
    """The questions at a terminal, and what was answered."""

    stem: str
    states: dict[str, Entries] = field(default_factory=dict)
    inputs: dict[str, Entries] = field(default_factory=dict)
    equations: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)
    name: str = ""
    checked: bool = True

    @property
    def entries(self) -> Entries:
        """The entries of the file."""
        head: Entries = {"format": 1, "kind": "plant", "name": self.name or self.stem}
        units = {} if self.checked else {"units": "unchecked"}
        sections = {
            "states": self.states,
            "inputs": self.inputs,
            "parameters": self.parameters,
            "equations": self.equations,
        }
        return head | units | sections

    def ask_all(self) -> None:
        """Ask for the whole plant."""
        self.name = _ask("Name of the plant", str, default=self.stem)
        for name in _ask("States, such as: theta omega", _names):
            self.states[name] = self._variable(name)
        for name in _ask("Inputs (none: Enter)", _names, default=""):
            self.inputs[name] = self._variable(name)
        print("Equations; a name that is neither state nor input becomes a parameter")
        for name in self.states:
            self._equation(name)
        self._parameters()

    def ask_again(self, problem: str) -> bool:
        """Ask for what is to be changed; return False where nothing is."""
        print(f"\n{problem}\n")
        names = [*self.states, *self.inputs, *self.parameters, "units"]
        wanted = _ask(
            f"Change which of {', '.join(names)} (units: not compared; Enter: write nothing)",
            lambda text: _one_of(text, names),
            default="",
        )
        if not wanted:
            return False
        if wanted == "units":
            self.checked = False
        elif wanted in self.parameters:
            self.parameters[wanted] = _ask(f"  {wanted} =", parameter_entry)
        elif wanted in self.inputs:
            self.inputs[wanted] = self._variable(wanted)
        else:
            self.states[wanted] = self._variable(wanted)
            self._equation(wanted)
            self._parameters()
        return True

    def _variable(self, name: str) -> Entries:
        unit = _ask(f"  {name}: unit", _unit, default="-")
        entry: Entries = {} if unit == "-" else {"unit": unit}
        span = _ask(f"  {name}: range, low and high (none: Enter)", _span, default="")
        if span:
            entry["range"] = span
        rest = _ask(f"  {name}: rest, a number or solve", _rest, default="0")
        return entry if rest == 0 else entry | {"rest": rest}

    def _equation(self, name: str) -> None:
        self.equations[name] = _ask(f"  {name}' =", _expression)

    def _parameters(self) -> None:
        """Ask for every name in the equations that has no meaning yet."""
        from takagi.models.expressions.parser import RESERVED, tokens_of

        tokens = [t for text in self.equations.values() for t in tokens_of(text)]
        known = {*self.states, *self.inputs, *RESERVED}
        used = {t.text for t in tokens if t.kind == "name"} - known
        self.parameters = {k: v for k, v in self.parameters.items() if k in used}
        if used - self.parameters.keys():
            print("Parameters, such as 2 kg, 0.9..1.1 kg or 0.1*sqrt(k*m)")
        for name in sorted(used - self.parameters.keys()):
            self.parameters[name] = _ask(f"  {name} =", parameter_entry)


def _ask(question: str, read: Callable[[str], Answer], *, default: str | None = None) -> Answer:
    """Return the answer to a question, which is asked again where it cannot be read.

    Raises
    ------
    ModelError : the input ends.
    """
    shown = f" [{default}]" if default else ""
    while True:
        try:
            mark = "" if question.endswith("=") else ":"
            text = input(f"{question}{shown}{mark} ").strip() or default
        except EOFError as error:
            raise ModelError(
                f"the input ended at the question {question!r}; nothing was written (options give "
                "the same without questions: takagi new --help)"
            ) from error
        if text is None:
            print("    an answer is needed", file=sys.stderr)
            continue
        try:
            return read(text)
        except ModelError as error:
            print(f"    {error}", file=sys.stderr)


def _names(text: str) -> list[str]:
    names = re.split(r"[\s,]+", text.strip()) if text.strip() else []
    wrong = [name for name in names if not re.fullmatch(_NAME, name, re.ASCII)]
    if wrong:
        raise ModelError(f"{wrong[0]!r} is no name; a letter, then letters, digits and _")
    return names


def _unit(text: str) -> str:
    from takagi.models.files.units import parse_unit

    parse_unit(text)
    return text


def _span(text: str) -> list[Decimal]:
    if not text:
        return []
    match = re.fullmatch(rf"\[?\s*({_NUMBER})\s*(?:\.\.|,|\s)\s*({_NUMBER})\s*\]?", text, re.ASCII)
    if match is None:
        raise ModelError(f"{text!r} was given; two numbers are needed, such as -60 60")
    return [Decimal(match[1]), Decimal(match[2])]


def _expression(text: str) -> str:
    """Return an expression whose grammar is right, whatever its names mean."""
    import sympy as sp

    from takagi.models.expressions.parser import RESERVED, Scope, parse_expression, tokens_of

    written = text.removeprefix("=").strip()
    names = {t.text for t in tokens_of(written) if t.kind == "name"} - RESERVED
    parse_expression(written, Scope({name: sp.Symbol(name, real=True) for name in names}))
    return written


def _one_of(text: str, names: Sequence[str]) -> str:
    if text and text not in names:
        raise ModelError(f"{text!r} is none of them{did_you_mean(text, names)}")
    return text


def named_ranges(texts: Sequence[str]) -> tuple[list[str] | None, dict[str, Any], dict[str, str]]:
    """Return names, ranges in SI and SI units of variables whose equations are matrices.

    Raises
    ------
    ModelError : a text of another form, or a rest: matrices are about theirs.
    """
    from fractions import Fraction

    from takagi.models.files.units import parse_unit

    entries: Mapping[str, Entries] = dict(map(variable_entry, texts))
    ranges, units = {}, {}
    for name, entry in entries.items():
        if "rest" in entry:
            raise ModelError(
                f"{name}: a rest was given, and matrices are about theirs; leave it out"
            )
        unit = parse_unit(entry.get("unit", "-"))
        if "range" in entry:
            ranges[name] = tuple(unit.to_si(Fraction(end)) for end in entry["range"])
        if "unit" in entry:
            units[name] = unit.text
    return list(entries) or None, ranges, units
