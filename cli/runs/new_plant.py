"""The entries of a plant's file from options, or from answers at a terminal."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models import Plant

Answer = TypeVar("Answer")
Entries = dict[str, Any]
# What each option of `takagi new` that describes a plant holds: texts as they are typed.
Options = Mapping[str, Any]
_NUMBER = r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?"
# Of "-1...1" the last dot would begin a decimal: [-1, 0.1].
_SPAN = rf"({_NUMBER})\s*\.\.(?!\.)\s*({_NUMBER})"
_NAME = r"([A-Za-z]\w*)"
_VARIABLE = re.compile(
    rf"\s*{_NAME}\s*(?:=\s*(?:{_SPAN})?\s*([^,:]*?))?\s*(?:,\s*rest\s+([^,:]+?))?\s*(?::\s*(.*))?",
    re.ASCII,
)
_PARAMETER = re.compile(rf"\s*{_NAME}\s*=\s*(?:{_SPAN}|({_NUMBER})|)\s*(.*?)\s*", re.ASCII)
_EQUATION = re.compile(rf"\s*{_NAME}\s*'?\s*=\s*(.+)", re.ASCII)
TEMPLATE: Options = {
    "name": "Pendulum with a motor",
    "state": ["theta = -60..60 deg: angle from upright", "omega = -4..4 rad/s: its rate"],
    "input": ["tau = -20..20 N m: torque of the motor"],
    "parameter": ["m = 2.0 kg", "l = 500 mm", "g = 9.81 m/s^2", "d = 0.1 N m s"],
    "equation": ["theta = omega", "omega = (m*g*l*sin(theta) - d*omega + tau) / (m*l^2)"],
}


def _match(pattern: re.Pattern[str], text: str, form: str) -> tuple[Any, ...]:
    match = pattern.fullmatch(text)
    if match is None:
        raise ModelError(f"{text!r} was given; {form} is the form")
    return match.groups()


def variable_entry(text: str) -> tuple[str, Entries]:
    """Return name and entry of ``theta = -60..60 deg, rest 0: angle from upright``."""
    form = '"theta = -60..60 deg", "T = 340..360 K, rest 350" or "x: what it is"'
    name, low, high, unit, rest, description = _match(_VARIABLE, text, form)
    entry: Entries = {"unit": unit} if unit else {}
    if low is not None:
        entry["range"] = [Decimal(low), Decimal(high)]
    if rest:
        entry["rest"] = Decimal(rest) if re.fullmatch(_NUMBER, rest) else rest
    return name, entry | ({"description": description} if description else {})


def parameter_entry(text: str) -> tuple[str, Any]:
    """Return name and entry of ``m = 2 kg``, ``m = 0.9..1.1 kg`` or ``c = 0.1*sqrt(k*m)``."""
    from takagi.models.files.units import parse_unit

    name, low, high, value, unit = _match(_PARAMETER, text, '"m = 2 kg"')
    if not (value or low) or (unit != "-" and unit[:1] in tuple("*/^+-(")):
        return name, text.partition("=")[2].strip()  # 2*m begins with a number too
    parse_unit(unit or "-")
    number = {"value": Decimal(value)} if value else {"range": [Decimal(low), Decimal(high)]}
    return name, number | ({"unit": unit} if unit else {})


def equation_entry(text: str) -> tuple[str, str]:
    """Return state and right-hand side of ``theta = omega`` or ``theta' = omega``."""
    name, expression = _match(_EQUATION, text, '"theta = omega"')
    return name, expression


READERS: dict[str, Callable[[str], tuple[str, Any]]] = {
    "state": variable_entry,
    "input": variable_entry,
    "disturbance": variable_entry,
    "parameter": parameter_entry,
    "equation": equation_entry,
}


def plant_entries(options: Options, stem: str) -> Entries:
    """Return the entries of a plant's file.

    Raises ModelError: a text of another form, no state, a state without equation.
    """
    sections: dict[str, Entries] = {}
    for what, read in READERS.items():
        rows = sections[f"{what}s"] = {}
        for name, entry in map(read, options.get(what) or ()):
            if name in rows:
                raise ModelError(f"--{what} of {name} was given twice; give it once")
            rows[name] = entry
    if not sections["states"]:
        raise ModelError(
            'no state was given; write --state "theta = -60..60 deg", and --equation '
            '"theta = omega", for each'
        )
    missing = [name for name in sections["states"] if name not in sections["equations"]]
    if missing:
        raise ModelError(
            f"no equation for {', '.join(missing)} was given; every state needs one: --equation "
            f'"{missing[0]} = ..."'
        )
    step = options.get("sample_time")
    head = {
        "format": 1,
        "kind": "plant",
        "name": options.get("name") or stem,
        "units": "unchecked" if options.get("no_units") else None,
        "sample_time": None if step is None else Decimal(repr(step)),
        "measured": options.get("measured") or None,
    }
    return {key: value for key, value in head.items() if value is not None} | sections


def plant_of_text(path: Path, text: str) -> Plant:
    """Return the plant of a text that is to be written.

    Raises ModelError: as ``load_plant``, and where the plant does not rest, or has no model on its
        box.
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


def asked_text(stem: str, text_of: Callable[[Options], str]) -> str:
    """Return the text of the plant that is asked for; without states, of the template.

    text_of : the text of options; raises ModelError where they are no plant.
    """
    names = _ask("Names of the states, with spaces between them [an example to change]:", _names)
    if not names:
        return text_of(TEMPLATE)
    answers: dict[str, Any] = {"name": _ask(f"Name of the plant [{stem}]:", str)}
    answers["state"] = [_variable(name) for name in names]
    names = _ask("Names of the inputs, with spaces between them:", _names)
    answers["input"] = [_variable(name) for name in names]
    print("Equations; a name that is neither state nor input becomes a parameter")
    states = [variable_entry(text)[0] for text in answers["state"]]
    answers["equation"] = [f"{n} = " + _ask(f"  {n}' =", _expression) for n in states]
    answers["parameter"] = []
    while True:
        answers["parameter"] += _parameters(answers)
        try:
            return text_of(answers)
        except ModelError as error:
            print(f"\n{error}\n")
            if not _changed(answers):
                raise


def _changed(answers: dict[str, Any]) -> bool:
    """Ask for what is to be changed, and change it; return False where nothing is."""

    def kind_of(text: str) -> str:
        name = text.partition("=")[0].strip()
        for what in ("state", "input"):
            if name in [READERS[what](t)[0] for t in answers[what]]:
                return what
        return "equation" if name.endswith("'") else "parameter"

    def readable(text: str) -> str:
        if text not in ("", "no units"):
            READERS[kind_of(text)](text)
        return text

    text = _ask(
        'What is right, such as "g = 9.81 m/s^2" or "theta\' = omega", or "no units" to leave '
        "them uncompared (Enter: write nothing):",
        readable,
    )
    if text == "no units":
        answers["no_units"] = True
    elif text:
        kind = kind_of(text)
        rows = {READERS[kind](t)[0]: t for t in answers[kind]}
        answers[kind] = list((rows | {READERS[kind](text)[0]: text}).values())
    return bool(text)


def _variable(name: str) -> str:
    unit = _ask(f"  {name}: unit [-]:", _unit)
    span = _ask(f"  {name}: range, such as -60..60 [none]:", _span)
    rest = _ask(f"  {name}: rest, a number or solve [0]:", str)
    return f"{name} = {span} {unit}" + (f", rest {rest}" if rest else "")


def _parameters(answers: Options) -> list[str]:
    """Ask for every name in the equations that has no meaning yet."""
    from takagi.models.expressions.parser import RESERVED, tokens_of

    known = {READERS[what](t)[0] for what in READERS for t in answers.get(what, ())}
    tokens = [t for text in answers["equation"] for t in tokens_of(equation_entry(text)[1])]
    unknown = {t.text for t in tokens if t.kind == "name"} - known - RESERVED

    def asked(name: str) -> str:
        def readable(text: str) -> str:
            if not text:
                raise ModelError(f"nothing was given; {name} needs a value, such as 2 kg")
            return text if parameter_entry(f"{name} = {text}") else ""

        return _ask(f"  {name}, such as 2 kg, 0.9..1.1 kg or 0.1*sqrt(k*m) =", readable)

    return [f"{name} = {asked(name)}" for name in sorted(unknown)]


def _ask(question: str, read: Callable[[str], Answer]) -> Answer:
    """Return the answer to a question, which is asked again where it cannot be read."""
    while True:
        try:
            return read(input(f"{question} ").strip())
        except EOFError as error:
            raise ModelError(
                f"the input ended at {question!r}; nothing was written (options give the same "
                "without questions: takagi new --help)"
            ) from error
        except ModelError as error:
            print(f"    {error}", file=sys.stderr)


def _names(text: str) -> list[str]:
    return [variable_entry(name)[0] for name in re.split(r"[\s,]+", text) if name]


def _unit(text: str) -> str:
    from takagi.models.files.units import parse_unit

    return text if not text or parse_unit(text) else text


def _span(text: str) -> str:
    return text if not text or _match(re.compile(_SPAN), text, "-60..60") else text


def _expression(text: str) -> str:
    """Return an expression whose grammar is right, whatever its names mean."""
    import sympy as sp

    from takagi.models.expressions.parser import RESERVED, Scope, parse_expression, tokens_of

    names = {t.text for t in tokens_of(text) if t.kind == "name"} - RESERVED
    parse_expression(text, Scope({name: sp.Symbol(name, real=True) for name in names}))
    return text
