"""What a single field of a plant file may be: numbers, texts, and their short forms."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

MAX_EXPONENT = 100
NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", re.ASCII)
FIGURE = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*"
# An uncertain parameter as a text, such as "[0.9, 1.1] kg".
RANGE = re.compile(rf"\s*\[{FIGURE},{FIGURE}\](.*)", re.ASCII)


def figure_given(value: object) -> object:
    """Return the number as a decimal.

    Raises
    ------
    ValueError : it is no number, or not a finite one of ordinary size.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, Decimal)):
        raise ValueError("a number is needed, without quotes")
    number = Decimal(repr(value)) if isinstance(value, float) else Decimal(value)
    if not number.is_finite() or abs(number.adjusted()) > MAX_EXPONENT:
        raise ValueError(f"a finite number below 10^{MAX_EXPONENT} is needed")
    return number


Figure = Annotated[Decimal, BeforeValidator(figure_given), WithJsonSchema({"type": "number"})]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=40)]
Text = Annotated[str, Field(max_length=4000)]
Expression = Annotated[
    str,
    Field(
        max_length=4000,
        description="numbers, names, + - * / ^ (also **), brackets, pi, sin cos tan asin acos atan "
        "sinh cosh tanh asinh acosh atanh exp log sqrt abs erf, and the tables of the file",
    ),
]
UnitText = Annotated[
    str, Field(max_length=60, description='e.g. "rad/s", "N m", "W/(m^2 K)"; "-" for a number')
]


def time_given(value: object) -> object:
    """Return a text as it is, a number of seconds as a decimal."""
    return value if isinstance(value, str) else figure_given(value)


Time = Annotated[
    Decimal | Text,
    BeforeValidator(time_given),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string"}]}),
]


def value_given(value: object) -> object:
    """Return a text as it is, taken as an expression, and a number as a decimal.

    Raises
    ------
    ValueError : a number stands in quotes, or it is neither of the two.
    """
    if isinstance(value, str):
        if NUMBER.fullmatch(value.strip()):
            raise ValueError("a number is needed, without quotes")
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float, Decimal)):
        raise ValueError("a number without quotes, or an expression in quotes, is needed")
    return figure_given(value)


def rest_given(value: object) -> object:
    """Return a rest: a number, an expression, or the fields of ``{ near = value }``.

    Raises
    ------
    ValueError : a table has other fields than ``near``.
    """
    if isinstance(value, dict):
        if set(value) != {"near"}:
            raise ValueError("write rest = { near = 350 }: a value from which it is sought")
        return {"near": figure_given(value["near"])}
    return value_given(value)


def parameter_given(value: object) -> object:
    """Return the fields of a parameter that is a number, an expression or a range alone."""
    if isinstance(value, list):
        return {"range": value}
    if isinstance(value, int | float | Decimal) and not isinstance(value, bool):
        return {"value": value}
    if not isinstance(value, str):
        return value
    ends = RANGE.fullmatch(value)
    if ends is None:
        return {"value": value}
    return {"range": [Decimal(ends[1]), Decimal(ends[2])], "unit": ends[3].strip() or "-"}


def rate_given(value: object) -> object:
    """Return a rate of decay [1/s] as a decimal, or ``"max"``.

    Raises
    ------
    ValueError : it is another text.
    """
    if value is None or value == "max":
        return value
    if isinstance(value, str):
        raise ValueError('a number in 1/s without quotes, or "max", is needed')
    return figure_given(value)


Rate = Annotated[
    Decimal | Literal["max"] | None,
    BeforeValidator(rate_given),
    WithJsonSchema({"anyOf": [{"type": "number", "minimum": 0}, {"const": "max"}]}),
]


def measured_given(value: object) -> object:
    """Return the list of what is measured, each with its fields.

    Raises
    ------
    ValueError : it is no list, or has something else than names and tables in it.
    """
    if not isinstance(value, list):
        raise ValueError('a list is needed, such as measured = ["angle"]')
    if any(not isinstance(entry, (str, dict)) for entry in value):
        raise ValueError("each is a name in quotes, or { name, expression, unit }")
    return [{"name": entry} if isinstance(entry, str) else entry for entry in value]
