"""The blend of a certificate's plant: two actuators that share one effort, as nodes."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.kernel.reader import Number, integer, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.plant.expression import NAME, Scope, read_expression
from takagi.certificates.checker.plant.graph import FUNCTIONS
from takagi.certificates.checker.plant.reading import PlantNodes, Variable


@dataclass(frozen=True)
class Acting:
    """One actuator: ``sign`` is 1 for the high one, -1 for the low one.

    ``effectiveness`` is a node; ``error`` is the signal delta, None for an exact actuator.
    """

    name: str
    unit: str
    sign: int
    direction: int
    effectiveness: int
    idle: Fraction
    side: tuple[Fraction, Fraction] | None
    error: Variable | None


@dataclass(frozen=True)
class Blend:
    """All data of the blend; ``names`` are the names that its equations may use."""

    effort: Variable
    rate: Variable
    share: Variable
    rest: Fraction
    ends: tuple[Fraction, Fraction]
    overlap: Fraction
    low: Acting
    high: Acting
    equations: list[str]
    names: dict[str, int]
    tables: dict[str, int]

    @property
    def actuators(self) -> tuple[Acting, Acting]:
        return self.low, self.high


def secant(s: Fraction, rest: Fraction, overlap: Fraction) -> Fraction:
    """Return the secant slope of psi from ``rest`` to s; its derivative if they are equal."""
    if s != rest:
        return (psi(s, overlap) - psi(rest, overlap)) / (s - rest)
    return share(s, overlap)


def read_blend(model: Any, plant: PlantNodes, where: str) -> Blend:
    """Return the member ``blending`` of a model of kind ``plant``.

    Raises
    ------
    CertificateError : a part is missing or has a wrong form, a variable does not exist, the overlap
        is not positive, the effort has no range, or an actuator's name is already in use.
    """
    stated = member(model, "blending", where)
    where = f"{where}.blending"
    names = names_of(model, plant)
    effort = _variable(stated, "effort", plant.states, where)
    rest = plant.graph.value(effort.rest)
    if rest is None or effort.side is None:
        raise CertificateError(f"{where}.effort: a rest that is a fraction and a range are needed")
    overlap = _rational(plant, member(stated, "overlap", where), f"{where}.overlap")
    if overlap <= 0:
        raise CertificateError(f"{where}.overlap: a positive number is needed")
    equations = member(stated, "equations", where)
    if not isinstance(equations, list) or len(equations) != len(plant.states) - 1:
        raise CertificateError(f"{where}.equations: one for each state but the effort is needed")
    tables = {name: table.arguments for name, table in plant.tables.items()}
    rate = _variable(stated, "rate", plant.inputs, where)
    share = _variable(stated, "share", plant.disturbances, where)
    added = {effort.name, rate.name, share.name}
    for key in ("low", "high"):
        named = member(member(stated, key, where), "error", f"{where}.{key}")
        added |= {named} if isinstance(named, str) else set()
    # The blend adds these variables; the equations with two actuators must not use them.
    plant_names = {name: node for name, node in names.items() if name not in added}
    scope = Scope(plant_names, tables)
    low, high = (
        _acting(member(stated, key, where), plant, scope, sign, f"{where}.{key}")
        for key, sign in (("low", -1), ("high", 1))
    )
    used_names = {*names, *tables, *FUNCTIONS, "pi"}
    if low.name == high.name or {low.name, high.name} & used_names:
        raise CertificateError(f"{where}: the actuators need names of their own")
    return Blend(
        effort=effort,
        rate=rate,
        share=share,
        rest=rest,
        ends=(rest + effort.side[0], rest + effort.side[1]),
        overlap=overlap,
        low=low,
        high=high,
        equations=equations,
        names=plant_names,
        tables=tables,
    )


def names_of(model: Any, plant: PlantNodes) -> dict[str, int]:
    """Return the names that equations may use: parameters and variables, each with its node."""
    g = plant.graph
    names = {
        name: read_expression(str(value), g, Scope({}), f"model.parameters.{name[:60]!a}")
        for name, value in model.get("parameters", {}).items()
    }
    for variable in (*plant.states, *plant.inputs, *plant.disturbances):
        names[variable.name] = g.add(variable.rest, g.variable(variable.symbol))
    return names


def _variable(owner: Any, key: str, variables: list[Variable], where: str) -> Variable:
    name = text(owner, key, where)
    for variable in variables:
        if variable.name == name:
            return variable
    raise CertificateError(f"{where}.{key}: {name[:60]!a} is none of the model's")


def _acting(actuator: Any, plant: PlantNodes, scope: Scope, sign: int, where: str) -> Acting:
    name = text(actuator, "input", where)
    if not NAME.fullmatch(name):
        raise CertificateError(f"{where}.input: {name[:60]!a} is no name")
    direction = integer(actuator, "direction", where)
    if direction not in (-1, 1):
        raise CertificateError(f"{where}.direction: 1 or -1 is needed")
    written = member(actuator, "effectiveness", where)
    ends = member(actuator, "range", where)
    side = None
    if ends is not None:
        if not isinstance(ends, list) or len(ends) != 2:
            raise CertificateError(f"{where}.range: two numbers are needed")
        low, high = (_rational(plant, end, f"{where}.range") for end in ends)
        side = low, high
    error = None
    if member(actuator, "error", where) is not None:
        error = _variable(actuator, "error", plant.disturbances, where)
    return Acting(
        name,
        text(actuator, "unit", where),
        sign,
        direction,
        read_expression(written, plant.graph, scope, f"{where}.effectiveness"),
        _rational(plant, member(actuator, "idle", where), f"{where}.idle"),
        side,
        error,
    )


def _rational(plant: PlantNodes, value: Any, where: str) -> Fraction:
    if isinstance(value, Number):
        return Fraction(value)
    exact_value = plant.graph.value(read_expression(value, plant.graph, Scope({}), where))
    if exact_value is None:
        raise CertificateError(f"{where}: a rational number is needed")
    return exact_value
