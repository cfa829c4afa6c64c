"""The shape of a plant file's entries, and of their values.

``python -m takagi.models.plant.entries`` prints the JSON Schema.
"""

from __future__ import annotations

import json
import re
import sys
from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

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


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class NearEntry(_Entry):
    """Where to look for a rest that is to be solved."""

    near: Annotated[Figure, Field(description="a value from which its rest is sought")]


class VariableEntry(_Entry):
    """A state, input or disturbance."""

    unit: UnitText = "-"
    range: Annotated[
        tuple[Figure, Figure] | None,
        Field(description="[low, high] in the unit: where the model shall hold"),
    ] = None
    rest: Annotated[
        Figure | NearEntry | Expression,
        BeforeValidator(rest_given),
        Field(
            description="value at the operating point that the model is written around; an "
            'expression of parameters, in SI; "solve" or { near = value } to have it found'
        ),
    ] = Decimal(0)
    description: Text = ""

    @property
    def start(self) -> Decimal:
        """A figure to begin with: the rest, or where it is looked for."""
        if isinstance(self.rest, Decimal):
            return self.rest
        if isinstance(self.rest, NearEntry):
            return self.rest.near
        return Decimal(0) if self.range is None else (self.range[0] + self.range[1]) / 2


class ParameterEntry(_Entry):
    """A number with a name, or a range in which it lies."""

    value: Annotated[
        Figure | Expression | None,
        BeforeValidator(value_given),
        Field(
            description="a number in the unit, or an expression of other parameters, in SI; of an "
            "uncertain parameter the number that simulations take, the middle of its range if left "
            "out"
        ),
    ] = None
    range: Annotated[
        tuple[Figure, Figure] | None,
        Field(description="[low, high] in the unit: all that is known of an uncertain parameter"),
    ] = None
    unit: Annotated[
        UnitText | None, Field(description="of an expression: that which its parameters give it")
    ] = None
    source: Text = ""


class OutputEntry(_Entry):
    """What is measured."""

    expression: Expression
    unit: UnitText = "-"


class MeasuredEntry(_Entry):
    """What the law measures: an output or a state by its name, or an expression with a name."""

    name: Name
    expression: Expression | None = None
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


class EffortEntry(_Entry):
    """The effort that two actuators share: a state, moved by its rate."""

    unit: UnitText = "-"
    range: Annotated[
        tuple[Figure, Figure],
        Field(description="[low, high] in the unit, with 0 inside: the hand-over is around 0"),
    ]
    overlap: Annotated[
        Figure, Field(description="between -overlap and overlap both actuators act; positive")
    ]
    rest: Annotated[Figure, Field(description="effort at the operating point")] = Decimal(0)
    rate: Annotated[
        Figure | None, Field(description="largest rate of the effort, in the unit per second")
    ] = None
    description: Text = ""


class ActuatorEntry(_Entry):
    """One of the two actuators; its input's rest is where it idles, its range are its limits."""

    input: Name
    direction: Annotated[
        Literal[-1, 1],
        Field(description="1 if raising the input raises the effort, -1 if it lowers it"),
    ]
    effectiveness: Annotated[
        Expression, Field(description="effort per unit of the input, positive on the box")
    ]
    error: Annotated[
        Figure,
        Field(description="share by which it may move the plant more or less, e.g. 0.1 for 10 %"),
    ] = Decimal(0)


class BlendingEntry(_Entry):
    """Two actuators that share one effort: the low one below 0, the high one above."""

    effort: EffortEntry
    low: ActuatorEntry
    high: ActuatorEntry


class ReferenceEntry(_Entry):
    """A signal that a state or output follows, by an integral of the difference."""

    follow: Annotated[Name, Field(description="the state or output that follows it")]
    range: Annotated[
        tuple[Figure, Figure],
        Field(description="[low, high] of the reference, with what follows at rest inside"),
    ]
    rate: Annotated[
        Figure | None, Field(description="the fastest that the reference moves, in its unit per s")
    ] = None
    unit: Annotated[
        UnitText | None, Field(description="of range and rate; that of what follows if left out")
    ] = None
    integral: Annotated[
        Literal[True],
        Field(description="the law integrates the difference, so that no error stays"),
    ] = True


class OrderEntry(_Entry):
    """A controller with states of its own."""

    order: Annotated[int, Field(description="the number of the controller's states")]


def controller_given(value: object) -> object:
    """Return the controller, or explain which there are."""
    if value is None or value == "static":
        return value
    order = value.get("order") if isinstance(value, dict) and list(value) == ["order"] else None
    if type(order) is int and order > 0:
        return value
    raise ValueError(
        f'{value!r} was given; "static" is needed, or the number of the controller\'s states, such '
        "as { order = 2 }; or leave controller out for an observer"
    )


class DesignEntry(_Entry):
    """What is asked of a design; every field may be left out."""

    choice: Annotated[
        Literal["fewest-rules", "least-conservative"], Field(description="how premises are chosen")
    ] = "fewest-rules"
    rest: Annotated[
        Literal["given", "solve inputs"],
        Field(description="whether the inputs' rest values are given, or solved for"),
    ] = "given"
    decay_rate: Annotated[
        Rate, Field(description='in 1/s; "max" needs bounded gains; without it, a moderate one')
    ] = None
    settle: Annotated[
        Text | Figure | None,
        Field(
            description="in place of decay_rate: the time in which the square root of V falls to "
            '2 %, with its unit such as "2 min", or a number in s'
        ),
    ] = None
    effort: Annotated[
        Literal["small", "moderate", "large"],
        Field(description="how much of the inputs is spent on speed"),
    ] = "moderate"
    relaxation: Annotated[
        Text | None, Field(description='of the double sum, e.g. "tanaka-wang", or "auto"')
    ] = None
    input_limit: Annotated[
        dict[Name, Figure],
        Field(description="input -> largest deviation from rest, in the input's unit"),
    ] = {}
    initial: Annotated[
        dict[Name, Figure],
        Field(description="state -> half-width of the box of initial states, in the state's unit"),
    ] = {}
    gain_bound: Annotated[
        Figure | None, Field(description="on the spectral norm of every gain, SI")
    ] = None
    damping: Annotated[
        Figure | None, Field(description="least damping ratio of the poles, below 1")
    ] = None
    fastest: Annotated[Figure | None, Field(description="largest size of the poles, in 1/s")] = None
    sample_time: Annotated[
        Time | None,
        Field(
            description='in s, or with its unit such as "10 ms", of a law that holds its command '
            "on a plant in continuous time"
        ),
    ] = None
    noise: Annotated[
        dict[Name, Figure],
        Field(
            description="disturbance without a range -> root of the intensity (two-sided spectral "
            "density) of the white noise that it is, in its unit times sqrt(s)"
        ),
    ] = {}
    horizon: Annotated[
        Figure | None,
        Field(description="in s: the probability of leaving a set within it is to be bounded"),
    ] = None
    objective: Annotated[
        Literal["hinf", "h2", "peak", "decay", "effort"] | None,
        Field(
            description="what is made best beside all that is asked: a norm from disturbances to "
            "performance, the decay rate, or the share of the inputs' limits that is used"
        ),
    ] = None
    safe_start: Annotated[
        Literal["ellipsoid", "polynomial"],
        Field(
            description="polynomial: also a proved set of safe starts with a polynomial function, "
            "for a plant and a law that are polynomials in the states"
        ),
    ] = "ellipsoid"
    controller: Annotated[
        Literal["static"] | OrderEntry | None,
        BeforeValidator(controller_given),
        Field(
            description="static: gains on the measured states alone, in place of an observer; "
            "{ order = 2 }: a controller of them with so many states of its own"
        ),
    ] = None
    performance: Annotated[
        list[Name],
        Field(
            description="outputs, states and inputs that a norm is about; all outputs unless given,"
            " without any the states over their ranges"
        ),
    ] = []
    disturbances: Annotated[
        list[Name], Field(description="those that a norm is about; all unless given")
    ] = []
    norm_below: Annotated[
        Figure | None,
        Field(
            description="the norm that is enough, in units of performance per unit of the "
            "disturbance, as the file has them"
        ),
    ] = None


class PlantEntry(_Entry):
    """A plant: M(x) x' = f(x, u, w), y = g(x, u, w)."""

    format: Literal[1]
    kind: Literal["plant"]
    name: Text = ""
    description: Annotated[Text, Field(description="one line; `takagi models` prints it")] = ""
    source: Annotated[Text, Field(description="where the equations come from")] = ""
    units: Literal["checked", "unchecked"] = "checked"
    sample_time: Annotated[
        Time | None,
        Field(
            description='in s, or with its unit such as "10 ms": the equations then give '
            "x(t + T); without it, x'"
        ),
    ] = None
    states: Annotated[dict[Name, VariableEntry], Field(min_length=1)]
    inputs: dict[Name, VariableEntry] = {}
    disturbances: dict[Name, VariableEntry] = {}
    scheduling: Annotated[
        dict[Name, VariableEntry],
        Field(
            description="signals from outside that stand in coefficients alone, as w in w*x; each "
            "needs a range"
        ),
    ] = {}
    parameters: dict[Name, Annotated[ParameterEntry, BeforeValidator(parameter_given)]] = {}
    tables: dict[Name, TableEntry] = {}
    equations: Annotated[dict[Name, Expression], Field(description="state -> its derivative")]
    mass: Annotated[
        dict[Name, dict[Name, Expression]],
        Field(description="state -> {state -> entry}; a row not given is that of the identity"),
    ] = {}
    outputs: dict[Name, OutputEntry] = {}
    measured: Annotated[
        list[MeasuredEntry] | None,
        BeforeValidator(measured_given),
        Field(
            description="what the law has instead of all states: names of outputs or states, or "
            "{ name, expression, unit }"
        ),
    ] = None
    premises: Annotated[
        dict[Name, Expression], Field(description="premise -> expression; empty leaves the choice")
    ] = {}
    blending: Annotated[
        BlendingEntry | None,
        Field(description="two inputs that share one effort, handed over by a ramp"),
    ] = None
    reference: Annotated[
        dict[Name, ReferenceEntry],
        Field(description="reference -> what follows it; the law gets an integral state for each"),
    ] = {}
    design: Annotated[
        DesignEntry, Field(description="what `takagi design` is asked for, unless told otherwise")
    ] = DesignEntry()

    @property
    def all_states(self) -> dict[str, VariableEntry]:
        """The states, the effort of a blend, and the integrals of references."""
        if self.blending is None:
            integrals = {f"{name}_integral": VariableEntry() for name in self.reference}
            return {**self.states, **integrals}
        effort = self.blending.effort
        entry = VariableEntry(
            unit=effort.unit, range=effort.range, rest=effort.rest, description=effort.description
        )
        return {**self.states, "effort": entry}

    @property
    def commanded(self) -> dict[str, VariableEntry]:
        """The inputs that the law commands: with a blend its effort's rate, not its actuators."""
        if self.blending is None:
            return self.inputs
        effort, largest_rate = self.blending.effort, self.blending.effort.rate
        blended = (self.blending.low.input, self.blending.high.input)
        unit = "1/s" if effort.unit == "-" else f"{effort.unit}/s"
        if "/" in effort.unit:
            top, bottom = effort.unit.split("/", 1)
            unit = f"{top}/({bottom.strip('()')} s)"
        rate = VariableEntry(
            unit=unit,
            range=None if largest_rate is None else (-largest_rate, largest_rate),
            description="rate of the effort",
        )
        direct_inputs = {name: entry for name, entry in self.inputs.items() if name not in blended}
        return {**direct_inputs, "effort_rate": rate}


def plant_file_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of plant files."""
    schema = PlantEntry.model_json_schema()
    # A parameter may be its number, expression or range alone; the validator makes fields of it.
    (named,) = schema["properties"]["parameters"]["patternProperties"].values()
    ends = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    text = {"type": "string", "maxLength": 4000}
    named |= {"anyOf": [{"$ref": named.pop("$ref")}, {"type": "number"}, text, ends]}
    # What is measured may be its name alone.
    rows = next(
        variant for variant in schema["properties"]["measured"]["anyOf"] if "items" in variant
    )
    rows["items"] = {"anyOf": [rows["items"], {"type": "string"}]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "takagi plant file",
        **{key: value for key, value in schema.items() if key != "title"},
    }


if __name__ == "__main__":
    # The published schema, docs/plant.schema.json.
    sys.stdout.write(json.dumps(plant_file_schema(), indent=2) + "\n")
