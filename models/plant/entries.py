"""What a plant file may contain: the pydantic models behind it, and its JSON Schema."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

__all__ = ["PlantEntry", "TableEntry", "VariableEntry", "plant_file_schema"]

MAX_EXPONENT = 100


def _decimal(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, (int, float, Decimal)):
        raise ValueError("a number is needed, without quotes")
    number = Decimal(repr(value)) if isinstance(value, float) else Decimal(value)
    if not number.is_finite() or abs(number.adjusted()) > MAX_EXPONENT:
        raise ValueError(f"a finite number below 10^{MAX_EXPONENT} is needed")
    return number


Figure = Annotated[Decimal, BeforeValidator(_decimal), WithJsonSchema({"type": "number"})]
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


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class VariableEntry(_Entry):
    """A state, input or disturbance."""

    unit: UnitText = "-"
    range: Annotated[
        tuple[Figure, Figure] | None,
        Field(description="[low, high] in the unit: where the model shall hold"),
    ] = None
    rest: Annotated[
        Figure, Field(description="value at the operating point that the model is written around")
    ] = Decimal(0)
    description: Text = ""


class ParameterEntry(_Entry):
    """A number with a name."""

    value: Figure
    unit: UnitText = "-"
    source: Text = ""


class OutputEntry(_Entry):
    """What is measured."""

    expression: Expression
    unit: UnitText = "-"


class ArgumentEntry(_Entry):
    """An argument of a table."""

    name: Text
    unit: UnitText = "-"


class TableEntry(_Entry):
    """A function given by a CSV file: a cubic spline of one argument, or bicubic of two."""

    file: Annotated[str, Field(description="a CSV file in the folder of this file, or below it")]
    arguments: Annotated[
        list[ArgumentEntry],
        Field(min_length=1, max_length=2, description="one, or first down and then across"),
    ]
    unit: UnitText = "-"
    source: Text = ""


class PlantEntry(_Entry):
    """A plant: M(x) x' = f(x, u, w), y = g(x, u, w)."""

    format: Literal[1]
    kind: Literal["plant"]
    name: Text = ""
    description: Annotated[Text, Field(description="one line; `takagi models` prints it")] = ""
    source: Annotated[Text, Field(description="where the equations come from")] = ""
    units: Literal["checked", "unchecked"] = "checked"
    sample_time: Annotated[
        Figure | None,
        Field(description="in s: the equations then give x(t + T); without it, x'"),
    ] = None
    states: Annotated[dict[Name, VariableEntry], Field(min_length=1)]
    inputs: dict[Name, VariableEntry] = {}
    disturbances: dict[Name, VariableEntry] = {}
    parameters: dict[Name, ParameterEntry] = {}
    tables: dict[Name, TableEntry] = {}
    equations: Annotated[dict[Name, Expression], Field(description="state -> its derivative")]
    mass: Annotated[
        dict[Name, dict[Name, Expression]],
        Field(description="state -> {state -> entry}; a row not given is that of the identity"),
    ] = {}
    outputs: dict[Name, OutputEntry] = {}
    premises: Annotated[
        dict[Name, Expression], Field(description="premise -> expression; empty leaves the choice")
    ] = {}


def plant_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of plant files."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "takagi plant file",
        **{key: value for key, value in PlantEntry.model_json_schema().items() if key != "title"},
    }
