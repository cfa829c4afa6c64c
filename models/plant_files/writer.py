"""A plant as the text of its TOML file, with comments that say what each section is for."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

import sympy as sp
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from takagi.models.errors import ModelError
from takagi.models.expressions.parser import FUNCTIONS
from takagi.models.files.units import PI, parse_unit
from takagi.models.plant.plant import Parameter, Plant, Variable

PURE_UNITS = ("-", "rad")
COMMENTS = {
    "states": "In the order of x. `range` is where the model holds and a proof is about; every "
    "variable in a\n# nonlinear term needs one. `rest` is where the plant is held, 0 unless given.",
    "inputs": "What the law commands; a range is also a limit, which the law keeps.",
    "disturbances": "What comes from outside.",
    "scheduling": "Signals from outside that the law knows; they stand in coefficients alone.",
    "parameters": "Numbers, expressions of them, or a range such as "
    '"[0.9, 1.1] kg" of what is not known better.',
    "equations": "The right-hand sides of x' = ..., in SI; all functions: docs/plants.md.",
    "mass": "The rows of M in M x' = ...; a row that is not given is that of the identity.",
    "outputs": "Further quantities; `measured = [...]` above the sections names what the law has.",
    "premises": "What the rules depend on; without this section it is chosen.",
}
DISCRETE = "The right-hand sides of x(t + T) = ..., in SI; all functions: docs/plants.md."
DESIGN = """\
# What is asked of the law; all of it may be left out. More: docs/plants.md.
# [design]
# settle = "2 s"             # or decay_rate = 2.0, in 1/s
# effort = "small"           # or "large"
# initial = { %s = %s }  # half-widths of a box of starts from which the limits are kept
"""


def plant_text(plant: Plant, heading: Sequence[str] = ()) -> str:
    """Return the text of a file that gives this plant again.

    Parameters
    ----------
    heading : lines of comment above it.

    Raises
    ------
    ModelError : a plant with a table, a blend or references, whose file has more than the plant;
        a number with a unit that is no decimal.
    """
    return entries_text(plant_entries(plant), heading)


def entries_text(entries: Mapping[str, Any], heading: Sequence[str] = ()) -> str:
    """Return the entries of a plant file as TOML with comments; empty sections are left out."""
    lines = [f"# {line}" for line in heading]
    sections = {key: value for key, value in entries.items() if isinstance(value, Mapping)}
    single = {key: value for key, value in entries.items() if key not in sections}
    lines += [f"{key} = {_toml(value)}" for key, value in single.items()]
    for section, rows in sections.items():
        if not rows:
            continue
        comment = COMMENTS.get(section, "")
        if section == "equations" and "sample_time" in entries:
            comment = DISCRETE
        lines += ["", *([f"# {comment}"] if comment else []), f"[{section}]"]
        lines += [f"{key} = {_toml(value)}" for key, value in rows.items()]
    if "design" not in entries:
        name, first = next(iter(entries["states"].items()))
        low, high = first.get("range", (-2, 2))
        lines += ["", (DESIGN % (name, f"{float(high - low) / 4:.2g}")).rstrip()]
    return "\n".join(lines) + "\n"


def plant_entries(plant: Plant) -> dict[str, Any]:
    """Return the entries of a plant's file, sections in their order.

    Raises
    ------
    ModelError : as ``plant_text``.
    """
    tables = sorted(
        str(part.func)
        for _, row in plant.expressions
        for part in row.atoms(sp.Function)
        if hasattr(part, "argument_units")
    )
    for what, there in (
        (f"the table {''.join(tables[:1])}", bool(tables)),
        ("two actuators behind a blend", plant.blending is not None),
        ("references", bool(plant.references)),
    ):
        if there:
            raise ModelError(
                f"plant {plant.name!r} has {what}, which a file has in a form that the plant does "
                "not keep; copy its file, or write these sections by hand: docs/plants.md"
            )
    uncertain = {v.name: v for v in plant.disturbances if v.unknown}
    known = [v for v in plant.disturbances if v.name not in uncertain]
    signals = {"disturbances": False, "scheduling": True}
    entries: dict[str, Any] = {
        "format": 1,
        "kind": "plant",
        "name": plant.name,
        "description": plant.description,
        "source": plant.source,
        "units": "" if plant.units == "checked" else plant.units,
        "sample_time": "" if plant.sample_time is None else Decimal(repr(plant.sample_time)),
        "measured": list(plant.measured or ()),
        "states": {v.name: _variable(v) for v in plant.states},
        "inputs": {v.name: _variable(v) for v in plant.inputs},
        **{
            section: {v.name: _variable(v) for v in known if v.schedules is scheduled}
            for section, scheduled in signals.items()
        },
        "parameters": {p.symbol.name: _parameter(p) for p in plant.parameters}
        | {name: _uncertain(v) for name, v in uncertain.items()},
        "equations": {
            v.name: expression_text(row)
            for v, row in zip(plant.states, plant.equations, strict=True)
        },
        "mass": _mass(plant),
        "outputs": {
            y.name: _filled({"expression": expression_text(y.expression), "unit": y.unit})
            for y in plant.outputs
        },
        "premises": {s.name: expression_text(row) for s, row in plant.premises.items()},
    }
    return {key: value for key, value in entries.items() if value != "" and value != []}


def expression_text(expression: sp.Expr) -> str:
    """Return an expression in the grammar of plant files.

    Raises
    ------
    ModelError : a function that the grammar does not have.
    """
    return str(_Printer().doprint(sp.sympify(expression)))


class _Printer(StrPrinter):  # type: ignore[misc]
    """Expressions with decimals in the place of fractions, where these have an end."""

    def _print_Mul(self, expression: sp.Expr) -> str:
        number, rest = expression.as_coeff_Mul()
        text = "" if number.is_Integer else _decimal(number)
        if "/" in text or not text:
            return str(super()._print_Mul(expression))
        return f"{text}*{self.parenthesize(rest, PRECEDENCE['Mul'])}"

    def _print_Rational(self, expression: sp.Rational) -> str:
        return _decimal(expression)

    def _print_Abs(self, expression: sp.Expr) -> str:
        return f"abs({self._print(expression.args[0])})"

    def _print_Exp1(self, expression: sp.Expr) -> str:
        return "exp(1)"

    def _print_Function(self, expression: sp.Expr) -> str:
        name = type(expression).__name__
        if name not in FUNCTIONS:
            raise ModelError(
                f"{expression}: a plant file has no function {name}; it has "
                f"{', '.join(sorted(FUNCTIONS))}"
            )
        return f"{name}({', '.join(map(self._print, expression.args))})"


def _decimal(value: sp.Rational | Fraction) -> str:
    """Return a fraction as a decimal where it has one of up to 40 digits, else as ``1/3``."""
    fraction = Fraction(int(value.numerator), int(value.denominator))
    places = 0
    while (fraction * 10**places).denominator != 1 and places < 40:
        places += 1
    scaled = fraction * 10**places
    if scaled.denominator != 1 or abs(scaled.numerator) >= 10**40:
        return f"{fraction.numerator}/{fraction.denominator}"
    text = str(Decimal(scaled.numerator).scaleb(-places).normalize())
    return text if "E" not in text else text.replace("E", "e")


def _filled(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entry without what is said by leaving it out."""
    return {key: value for key, value in entry.items() if value not in ("", None) and value != "-"}


def _in_unit(values: Sequence[Fraction], written: str, si: str) -> tuple[str, list[Decimal]]:
    """Return a unit and the decimals in it that stand for the values; none where there are none."""
    for text in filter(None, (written, si)):
        unit = parse_unit(text)
        size = unit.factor * PI**unit.pi_power
        texts = [_decimal(round(v / size, 9) if unit.pi_power else v / size) for v in values]
        if all("/" not in t for t in texts):
            figures = [Decimal(t) for t in texts]
            if [unit.to_si(Fraction(figure)) for figure in figures] == list(values):
                return text, figures
    return si, []


def _exact_text(value: Fraction, equals: sp.Expr | None, unit: str, what: str) -> str:
    """Return an expression for a number without decimals."""
    text = expression_text(
        sp.Rational(value.numerator, value.denominator) if equals is None else equals
    )
    if unit not in PURE_UNITS:
        raise ModelError(
            f"{what} is {text} {unit}, which has no end as a decimal, and an expression of numbers "
            "has no unit; copy the plant's file, or round the number"
        )
    return text


def _variable(variable: Variable) -> dict[str, Any]:
    ends = [] if variable.range is None else [variable.range.lower, variable.range.upper]
    written, si = variable.written, variable.unit
    unit, figures = _in_unit([*ends, variable.rest], written, si)
    rest: Any = figures.pop() if figures else None
    if rest is None:
        unit, figures = _in_unit(ends, written, si)
        size = float(parse_unit(unit).factor) * math.pi ** parse_unit(unit).pi_power
        rest = Decimal(repr(float(variable.rest) / size))
    if variable.equals is not None and si in PURE_UNITS:
        rest = expression_text(variable.equals)
    elif variable.within or parse_unit(unit).to_si(Fraction(rest)) != variable.rest:
        rest = {"near": rest}
    if ends and not figures:
        raise ModelError(
            f"the range of {variable.name}, {variable.range}, has no end as decimals; round it"
        )
    return _filled(
        {
            "unit": unit,
            "range": figures or "",
            "rest": rest if rest != 0 else "",
            "description": variable.description,
        }
    )


def _parameter(parameter: Parameter) -> dict[str, Any]:
    unit, figures = _in_unit([parameter.value], parameter.written, parameter.unit)
    value: Any = figures[0] if figures else ""
    if parameter.equals is not None or not figures:
        what = f"the parameter {parameter.symbol}"
        value = _exact_text(parameter.value, parameter.equals, parameter.unit, what)
    return {"value": value} | _filled({"unit": unit, "source": parameter.source})


def _uncertain(variable: Variable) -> dict[str, Any]:
    entry = _variable(variable)
    source = entry.pop("description", "").removeprefix("uncertain parameter").lstrip(": ")
    value = entry.pop("rest", Decimal(0))
    return {"range": entry.pop("range"), "value": value, **entry} | _filled({"source": source})


def _mass(plant: Plant) -> dict[str, dict[str, str]]:
    """Return the rows of M that are not those of the identity, their entries that are not 0."""
    if plant.mass is None:
        return {}
    names = [v.name for v in plant.states]
    return {
        name: {
            column: expression_text(plant.mass[row, k])
            for k, column in enumerate(names)
            if plant.mass[row, k] != 0
        }
        for row, name in enumerate(names)
        if plant.mass[row, :] != sp.eye(len(names))[row, :]
    }


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        inside = ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, Decimal):
        plain = value == 0 or -7 < value.adjusted() < 15
        return f"{value:f}" if plain else str(value).replace("E+", "e").replace("E", "e")
    return json.dumps(value, ensure_ascii=False)
