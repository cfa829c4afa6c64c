"""The plant of a certificate as formulas in the gain file's language, for the closed loop.

For a plant file the certificate's ``model`` has the equations, in the same grammar.  For a turbine
they are those of the design: one rotating mass with the table of c_Q, and a first-order pitch drive
with its limits of rate and position; torque has no delay.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import (
    Assignment,
    Constant,
    ControllerProgram,
    Signal,
    Spline,
)
from takagi.reports.code.formula import Formula, Name, names_of, parsed
from takagi.reports.code.program_reading import renamed


@dataclass(frozen=True, slots=True)
class PlantState:
    """A state of the plant, SI.

    Attributes
    ----------
    rate : x', or x one sample later; with a mass matrix the right-hand side of its row.
    limits : the state is limited to them after each step of the integration; None for no limits.
    """

    name: str
    unit: str
    meaning: str
    start: Decimal
    rate: Formula
    limits: tuple[Formula, Formula] | None = None


@dataclass(frozen=True, slots=True)
class PlantEquations:
    """M x' = f(x, u, d), or M x(t + T) = f in discrete time; M = 1 where ``mass`` is None.

    Attributes
    ----------
    steps : computed before the rates, in order, from states, commands and disturbances.
    disturbances : external signals; each is an input of the closed loop.
    commands : outputs of the law that the equations use.
    measured : input of the law -> the state or disturbance that it measures.
    """

    constants: tuple[Constant, ...]
    states: tuple[PlantState, ...]
    disturbances: tuple[Signal, ...]
    steps: tuple[Assignment, ...]
    commands: tuple[str, ...]
    measured: Mapping[str, str]
    discrete: bool
    mass: tuple[tuple[Formula, ...], ...] | None = None

    def formulas(self) -> tuple[Formula, ...]:
        """Return every formula."""
        limits = (one for state in self.states for one in state.limits or ())
        mass = (one for row in self.mass or () for one in row)
        steps = (one.formula for one in self.steps)
        return (*steps, *(state.rate for state in self.states), *mass, *limits)


def plant_equations(program: ControllerProgram, model: Mapping[str, Any]) -> PlantEquations:
    """Return the plant of a certificate's model, in loop with a law.

    Raises
    ------
    ModelError : a model without equations of a plant, or one that this law cannot run on.
    """
    try:
        if model.get("kind") == "turbine":
            return _turbine(program, model)
        if model.get("kind") == "plant" and "equations" in model:
            return _checked(program, *_plant(model))
    except (KeyError, IndexError, TypeError, ArithmeticError, AttributeError) as error:
        raise ModelError(f"the certificate's model is damaged: {error!r}") from error
    raise ModelError(
        f"the certificate is about a model of kind {model.get('kind')!r}, which has no equations "
        "of a plant"
    )


def _checked(
    program: ControllerProgram, plant: PlantEquations, others: Sequence[str]
) -> PlantEquations:
    """Return the plant with the law's inputs and outputs connected to it."""
    known = {one.name for one in plant.states} | {one.name for one in plant.disturbances}
    for signal in program.inputs:
        if signal.name not in known:
            raise ModelError(f"the law reads {signal.name!r}, which the plant does not have")
    sent = {one.name for one in program.outputs}
    for name in others:
        if name not in sent:
            raise ModelError(f"the plant has an input {name!r}, which the law does not send")
    known |= {*others, *(c.name for c in plant.constants), *(s.name for s in plant.steps)}
    for formula in plant.formulas():
        for name in names_of(formula):
            if name not in known:
                raise ModelError(f"an equation of the plant names {name!r}, which nothing sets")
    return plant


def _plant(model: Mapping[str, Any]) -> tuple[PlantEquations, list[str]]:
    """Return the plant and the names of its inputs."""
    tables = tuple(model.get("tables") or {})
    blending = model.get("blending")
    states, inputs = list(model["states"]), [one["name"] for one in model["inputs"]]
    disturbances, equations = model["disturbances"], model["equations"]
    steps: list[Assignment] = []
    acting: dict[str, str] = {}
    if blending is not None:
        # The plant as it was written, with its two actuators; the law keeps the effort itself.
        states = [one for one in states if one["name"] != blending["effort"]]
        inputs = [name for name in inputs if name != blending["rate"]]
        inputs += [blending[side]["input"] for side in ("low", "high")]
        errors = [blending[side]["error"] for side in ("low", "high")]
        disturbances = [one for one in disturbances if one["name"] in errors]
        equations = blending["equations"]
        for side in ("low", "high"):
            if blending[side]["error"] is not None:
                name, made = _acting(model, blending[side], -1 if side == "low" else 1, tables)
                acting[blending[side]["input"]] = name
                steps += made

    def formula(text: Any) -> Formula:
        return renamed(parsed(str(text), tables), acting)

    mass = model.get("mass")
    n = len(states)
    discrete = model.get("sample_time") is not None
    found = PlantEquations(
        constants=(*_parameters(model), *_tables(model), *_rests(model, steps)),
        states=tuple(
            PlantState(
                one["name"], one["unit"], "state of the plant", _decimal(one["rest"]), formula(row)
            )
            for one, row in zip(states, equations, strict=True)
        ),
        disturbances=tuple(_disturbance(one) for one in disturbances),
        steps=tuple(steps),
        commands=tuple(inputs),
        measured={one["name"]: one["name"] for one in (*states, *disturbances)},
        discrete=discrete,
        mass=None if mass is None else tuple(tuple(map(formula, row[:n])) for row in mass[:n]),
    )
    return found, inputs


def _acting(
    model: Mapping[str, Any], actuator: Mapping[str, Any], sign: int, tables: Sequence[str]
) -> tuple[str, list[Assignment]]:
    """Return what an actuator does: its motion from rest is wrong by its error."""
    name, overlap, blending = actuator["input"], model["blending"]["overlap"], model["blending"]
    rest = next(one["rest"] for one in model["states"] if one["name"] == blending["effort"])
    effort = f"({sign}*({rest}))"
    psi = f"max({effort}, (limit({effort}, -({overlap}), {overlap}) + {overlap})^2/(4*({overlap})))"
    states = [one["name"] for one in model["states"]]
    b = renamed(
        parsed(str(actuator["effectiveness"]), tables), {one: f"{one}_at_rest" for one in states}
    )
    steps = [
        Assignment(f"{name}_effectiveness", "", "at rest", b),
        Assignment(
            f"{name}_resting",
            actuator["unit"],
            "where the plant rests",
            parsed(
                f"{actuator['idle']} + ({sign * int(actuator['direction'])})*{psi}"
                f"/{name}_effectiveness"
            ),
        ),
        Assignment(
            f"{name}_acting",
            actuator["unit"],
            "as it acts, with its error",
            parsed(f"{name}_resting + (1 + {actuator['error']})*({name} - {name}_resting)"),
        ),
    ]
    return f"{name}_acting", steps


def _rests(model: Mapping[str, Any], steps: Sequence[Assignment]) -> list[Constant]:
    used = {name for step in steps for name in names_of(step.formula)}
    return [
        Constant(f"{one['name']}_at_rest", one["unit"], "states.rest", _decimal(one["rest"]))
        for one in model["states"]
        if f"{one['name']}_at_rest" in used
    ]


def _parameters(model: Mapping[str, Any]) -> list[Constant]:
    return [
        Constant(name, "SI", f"parameters.{name}", _decimal(value))
        for name, value in model.get("parameters", {}).items()
    ]


def _tables(model: Mapping[str, Any]) -> list[Constant]:
    found = []
    for name, table in (model.get("tables") or {}).items():
        rows = table["coefficients"]
        value = Spline(
            tuple(map(_row, table["knots"])),
            tuple(map(_row, rows)) if isinstance(rows[0], list) else (_row(rows),),
        )
        found.append(Constant(name, "SI", f"tables.{name}", value))
    return found


def _disturbance(one: Mapping[str, Any]) -> Signal:
    ends = one.get("range")
    low_high = None if ends is None else (_decimal(ends[0]), _decimal(ends[1]))
    return Signal(one["name"], one["unit"], "disturbance", _decimal(one["rest"]), low_high)


def _turbine(program: ControllerProgram, model: Mapping[str, Any]) -> PlantEquations:
    surface = model["torque_surface"]
    spline = Spline(
        (_row(surface["tip_speed_ratio_knots"]), _row(surface["pitch_knots"])),
        tuple(map(_row, surface["coefficients"])),
    )
    constants = [
        Constant(name, unit, name, _decimal(model[name]))
        for name, unit in (
            ("torque_constant", "kg m"),
            ("rotor_radius", "m"),
            ("rotor_inertia", "kg m^2"),
            ("generator_inertia", "kg m^2"),
            ("gear_ratio", "-"),
            ("pitch_time_constant", "s"),
            ("pitch_rate_limit", "rad/s"),
            ("pitch_min", "rad"),
            ("pitch_max", "rad"),
        )
    ]
    sent = [one.name for one in program.outputs]
    torque = "torque_sent" if "torque_sent" in sent else "torque"
    pitch = "pitch_sent" if "pitch_sent" in sent else "pitch_reference"
    # A law with a low-pass sends the filtered speed by the name "speed".
    turning = "actual_speed" if "speed" in sent else "speed"
    known = {one.name: one.rest for one in program.inputs}
    trim = program.document["trim"]
    speed, angle = (
        known.get(name) if known.get(name) is not None else trim[column][0]
        for name, column in (("speed", "rotor_speed"), ("pitch", "pitch"))
    )
    wind = trim["wind"][0]
    seen = {
        "speed": turning,
        "measured_speed": turning,
        "pitch": "pitch",
        "wind_guess": "wind_speed",
    }
    seen["wind_estimate"] = "wind_speed"
    for signal in program.inputs:
        if signal.name not in seen:
            raise ModelError(f"the law reads {signal.name!r}, which the turbine does not have")
    for name in (torque, pitch):
        if name not in sent:
            raise ModelError(f"the turbine needs {name!r}, which the law does not send")
    steps = (
        ("wind_at_rotor", "m/s", "a wind below 0.1 m/s is none", "max(wind_speed, 0.1)"),
        ("c_q", "-", "torque coefficient",
         f"spline({turning}*rotor_radius/wind_at_rotor, pitch, torque_coefficient)"),
        ("rotor_torque", "N m", "low-speed shaft", "torque_constant*wind_at_rotor^2*c_q"),
    )  # fmt: skip
    J = "(rotor_inertia + gear_ratio^2*generator_inertia)"
    drive = f"(limit({pitch}, pitch_min, pitch_max) - pitch)/pitch_time_constant"
    return PlantEquations(
        constants=(*constants, Constant("torque_coefficient", "-", "torque_surface", spline)),
        states=(
            PlantState(
                turning, "rad/s", "rotor speed", _decimal(speed),
                parsed(f"(rotor_torque - gear_ratio*{torque})/{J}"),
            ),
            PlantState(
                "pitch", "rad", "pitch of the blades", _decimal(angle),
                parsed(f"limit({drive}, -pitch_rate_limit, pitch_rate_limit)"),
                (Name("pitch_min"), Name("pitch_max")),
            ),
        ),
        disturbances=(Signal("wind_speed", "m/s", "wind over the rotor", _decimal(wind)),),
        steps=tuple(Assignment(name, unit, why, parsed(text)) for name, unit, why, text in steps),
        commands=(torque, pitch),
        measured={one.name: seen[one.name] for one in program.inputs},
        discrete=False,
    )  # fmt: skip


def _row(numbers: Sequence[Any]) -> tuple[Decimal, ...]:
    return tuple(map(_decimal, numbers))


def _decimal(number: Any) -> Decimal:
    """Return a number of a certificate, which may be a fraction: then to 28 digits.

    Of a number that is not a decimal it is the decimal that stands with its ball.
    """
    if isinstance(number, Mapping):
        return _decimal(number["value"])
    if isinstance(number, str) and "/" in number:
        exact = Fraction(number)
        return Decimal(exact.numerator) / Decimal(exact.denominator)
    return Decimal(str(number))
