r"""``effort-blend``: two actuators that share one effort U give the equations of the plant.

The ramp psi is convex, with psi(U) - psi(-U) = U.  F is its secant slope from the effort U* of the
rest:

    high   v = idle + direction (psi(U*) + F dU) / b
    low    v = idle - direction (psi(-U*) - (1 - F) dU) / b

As psi is convex, F lies between its values at the ends of U's range.  The conditions are:

1. b > 0 and psi_max <= b times the room that an actuator has, on the box, by bisection; the law
   commands by b, so no signal that it does not know is in b.
2. The equations with v, or with v* + (1 + delta)(v - v*) for an actuator with a relative error
   delta, are those of the model, by algebra.
3. The law does not know delta: rules that differ only in premises with delta have equal gains.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    NotReplayed,
    Refusal,
    entry,
    line,
    whole,
)
from takagi.certificates.cross_check.plant.algebra import Algebra
from takagi.certificates.cross_check.plant.embedding import Search
from takagi.certificates.cross_check.plant.expression import (
    Tree,
    minus,
    names_in,
    number,
    parsed,
    plus,
    put,
    times,
    value_of,
)
from takagi.certificates.cross_check.plant.interval import Interval
from takagi.certificates.cross_check.plant.law_fits import goes_with_known
from takagi.certificates.cross_check.plant.plant import (
    TreePlant,
    Variable,
    constant,
    read_loop,
    read_plant,
)
from takagi.certificates.cross_check.turbine.numbers import ramp, ramp_secant


class _Side(NamedTuple):
    """One of both actuators; ``way`` is 1 for the high one, -1 for the low one."""

    name: str
    way: int
    direction: int
    b: Tree
    idle: fmpq
    limits: tuple[fmpq, fmpq] | None
    error: Variable | None


def effort_blend_obligations(model: Any, gains: Any) -> Obligations:
    """Yield the facts of the module, in its order."""
    if entry(model, "kind") != "plant":
        raise Refusal("a claim about a plant, and the model is none")
    plant, given = read_plant(model), entry(model, "blending")
    if plant.form != "sector":
        raise Refusal("a blend's share moves the matrices of a sector model alone")
    if gains is not None and entry(gains, "blending") != given:
        raise Refusal("the law has another blend than the model")
    meaning = _meaning(model, plant)
    effort = _one(plant.states, line(given, "effort"))
    rate, share = _one(plant.inputs, line(given, "rate")), _one(plant.pushes, line(given, "share"))
    own = _as_written(meaning, given, (effort, rate, share))
    sides = [_side(entry(given, key), plant, own, way) for key, way in (("low", -1), ("high", 1))]
    e, rest, at = constant(entry(given, "overlap")), value_of(effort.rest), value_of(share.rest)
    if rest is None or at is None or effort.side is None or share.side is None or e <= 0:
        raise Refusal("an overlap, an effort and a share with ranges are needed")
    ends = [rest + end for end in effort.side]
    slopes = [ramp_secant(end, rest, e) for end in ends]
    yield Fact("the share is in its range", at + share.side[0] <= slopes[0])
    yield Fact("the share is in its range", slopes[1] <= at + share.side[1])
    yield Fact("the errors are signals of their own", _own_errors(sides, share))
    yield Fact("continuous time", plant.step is None)

    laws = {one.name: _law(one, plant, effort, share, rest, e) for one in sides}
    listed = entry(given, "equations")
    if not isinstance(listed, list) or len(listed) != len(plant.states) - 1:
        raise Refusal("one equation for each state but the effort is needed")
    rows = [_written(row, {**own, **laws}) for row in listed]
    signals = [share, *(one.error for one in sides if one.error is not None)]
    yield Fact("signals stand in A and B alone", _schedule(plant, signals))
    places = [k for k, v in enumerate(plant.states) if v is not effort]
    differences = [plus(plant.f[k], minus(row)) for k, row in zip(places, rows, strict=True)]
    alone = plant.states.index(effort)
    differences.append(plus(plant.f[alone], minus(meaning[rate.name])))
    algebra = Algebra([*differences, *(one.b for one in sides)])
    search = Search(algebra, {v.symbol: v.side for v in plant.variables})
    unknown = {v.symbol for v in plant.pushes if v.unknown}
    for one in sides:
        yield Fact("the law knows the effectiveness", unknown.isdisjoint(names_in(one.b)))
        yield from _within_limits(search, one, max(ramp(one.way * end, e) for end in ends))
    for row in rows:
        yield Fact("an equation is defined", search.holds(row, lambda found: True))
    for tree in differences:
        if not algebra.vanishes(tree):
            raise NotReplayed("an equation with both actuators: not shown to be the model's")
        yield Fact("an equation with both actuators", True)
    yield Fact("the effort is by itself in the mass matrix", _alone(plant, alone))
    if gains is not None:
        hidden = {one.error.symbol for one in sides if one.error is not None}
        yield Fact("gains go with what is known", goes_with_known(plant, hidden, gains))
        loop = read_loop(model, gains)
        yield Fact("gains go with the model's weights", len(loop.K) == 1 or loop.together)


def _as_written(
    meaning: dict[str, Tree], given: Any, added: tuple[Variable, ...]
) -> dict[str, Tree]:
    """Return the names that the plant knows without its blend."""
    hidden = [entry(entry(given, key), "error") for key in ("low", "high")]
    taken = {v.name for v in added} | {name for name in hidden if isinstance(name, str)}
    return {name: tree for name, tree in meaning.items() if name not in taken}


def _within_limits(search: Search, one: _Side, most: fmpq) -> Obligations:
    """Yield that an actuator can deliver every effort up to ``most`` within its limits."""
    if one.limits is None:
        yield Fact("the effectiveness is positive", search.holds(one.b, _above(fmpq(0))))
        return
    low, high = one.limits
    room = high - one.idle if one.way * one.direction > 0 else one.idle - low
    yield Fact("the actuator idles within its limits", low <= one.idle <= high and room > 0)
    yield Fact("the actuator stays in its limits", search.holds(one.b, _above(most / room)))


def _meaning(model: Any, plant: TreePlant) -> dict[str, Tree]:
    found = {name: number(constant(value)) for name, value in model.get("parameters", {}).items()}
    return found | {v.name: plus(v.rest, ("name", v.symbol)) for v in plant.variables}


def _written(row: Any, meaning: dict[str, Tree]) -> Tree:
    tree = parsed(row)
    if set(names_in(tree)) - set(meaning) - {"pi"}:
        raise Refusal("an equation with a name that is not known")
    return put(tree, meaning)


def _schedule(plant: TreePlant, signals: list[Variable]) -> bool:
    columns = [plant.pushes.index(v) for v in signals]
    rows = plant.entries.get("E", [])
    return all(value_of(row[k]) == 0 for row in rows for k in columns)


def _one(variables: list[Variable], name: str) -> Variable:
    for v in variables:
        if v.name == name:
            return v
    raise Refusal(f"{name[:40]!a} is no variable of the model")


def _side(given: Any, plant: TreePlant, meaning: dict[str, Tree], way: int) -> _Side:
    name, direction, ends = line(given, "input"), whole(given, "direction"), entry(given, "range")
    if (
        not name.isidentifier()
        or name in meaning
        or name in {v.name for v in plant.variables}
        or abs(direction) != 1
    ):
        raise Refusal("an actuator needs a name of its own, and 1 or -1 as its direction")
    b = _written(entry(given, "effectiveness"), meaning)
    limits = None
    if ends is not None:
        if not isinstance(ends, list) or len(ends) != 2:
            raise Refusal("range: two numbers are needed")
        limits = (constant(ends[0]), constant(ends[1]))
    error = entry(given, "error")
    wrong = None if error is None else _one(plant.pushes, line(given, "error"))
    return _Side(name, way, direction, b, constant(entry(given, "idle")), limits, wrong)


def _law(
    one: _Side, plant: TreePlant, effort: Variable, share: Variable, rest: fmpq, e: fmpq
) -> Tree:
    """Return the actuator's position, in the deviations from rest."""
    part = plus(share.rest, ("name", share.symbol))
    if one.way < 0:
        part = plus(part, number(-1))
    delivered = plus(number(ramp(one.way * rest, e)), times(part, ("name", effort.symbol)))
    step: Tree = ("/", times(number(one.way * one.direction), delivered), one.b)
    told = plus(number(one.idle), step)
    if one.error is None:
        return told
    resting = put(told, {v.symbol: number(0) for v in plant.variables})
    moved = times(plus(number(1), ("name", one.error.symbol)), plus(told, minus(resting)))
    return plus(resting, moved)


def _own_errors(sides: list[_Side], share: Variable) -> bool:
    errors = [one.error for one in sides if one.error is not None]
    if any(v is share or v.side is None or value_of(v.rest) != 0 for v in errors):
        return False
    bounded = all(v.side is not None and v.side[0] > -1 for v in errors)
    return bounded and len({v.name for v in errors}) == len(errors)


def _above(least: fmpq) -> Any:
    def good(a: Interval) -> bool:
        return a is not None and a[0] > 0 and a[0] >= least

    return good


def _alone(plant: TreePlant, own: int) -> bool:
    """Return whether row and column ``own`` of the mass matrix are those of the identity."""
    return all(
        value_of(one) == int(i == j)
        for i, row in enumerate(plant.mass or [])
        for j, one in enumerate(row)
        if own in (i, j)
    )
