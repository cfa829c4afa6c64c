r"""A plant with two actuators behind a blend, as a plant with one input: the rate of the effort.

With U the effort, U* its rest and F the secant share of the high actuator (``ramps.effort_ramp``),

    psi(U)  = psi(U*)  + F (U - U*)            psi(-U) = psi(-U*) - (1 - F)(U - U*)

exactly.  So the actuators' commands v = idle +- direction psi(+-U)/b are written with F as a
signal that schedules, whose range is known exactly, and with the effort as a state, U' = effort
rate.  An actuator that is wrong by delta in its motion from rest is at v* + (1 + delta)(v - v*),
delta a signal too.  The law knows F, which follows from its own state U; it does not know delta.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

import sympy as sp

from takagi.models.blending.blending import SHARE, Actuator, Blending, blending_of
from takagi.models.errors import ModelError
from takagi.models.files.units import behind
from takagi.models.intervals.box_search import Range
from takagi.models.intervals.interval import Interval
from takagi.models.plant.plant import Parameter, Plant, Variable
from takagi.models.ramps import ramp
from takagi.models.ranges.expression_range import expression_range
from takagi.models.sector.model import sector_model

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import Choice, Rest
    from takagi.models.ts.model import TSModel

GRID = 9  # grid points along each side of the box, where a place for the message is sought
MOST_POINTS = 10_000
HALVINGS = 40


def check_authority(blending: Blending) -> None:
    """Raise ModelError unless b > 0 on the box and every command stays within its limits.

    The effectiveness b is enclosed rigorously.  psi(U) grows with U, so that the command is largest
    at an end of the effort's range and where b is least: psi_max / b_min must be at most the
    distance from idle to the limit.

    Raises
    ------
    ModelError : names the actuator, a place on the box, and the largest effort that fits.
    """
    for end_name, actuator in (("low", blending.low), ("high", blending.high)):
        effectiveness = effectiveness_range(blending, actuator)
        smallest = effectiveness.outer.lower
        where, value = _lowest(blending, actuator)
        if smallest <= 0:
            sure = value <= 0
            found_so_far = "" if sure else "not shown to be positive on the box, with "
            raise ModelError(
                f"{end_name}.effectiveness: {_text(actuator)} is {found_so_far}{value:.6g} "
                f"{where}; there {actuator.name} moves nothing, or the wrong way: shrink the "
                "ranges that it depends on, or correct it or its direction"
            )
        room = blending.room(actuator)
        if room is None or blending.most(actuator) <= room * smallest:
            continue
        fits = _fitting(blending, actuator, room * smallest)
        end = "upper" if actuator is blending.high else "lower"
        name, unit = actuator.name, behind(actuator.variable.unit)
        raise ModelError(
            f"effort: at its {end} end {name} would have to go "
            f"{float(blending.most(actuator) / smallest):.6g}{unit} from where it idles {where}, "
            f"and its range leaves {float(room):.6g}: beyond that no actuator acts; give effort "
            f"a range up to {fits:.6g}{behind(blending.effort.unit)} on that side, or {name} a "
            "wider one"
        )


def effectiveness_range(blending: Blending, actuator: Actuator) -> Range:
    """Return the rigorous range of an actuator's effectiveness on the box.

    Raises
    ------
    ModelError : a variable in it has no range, or it is not defined on the whole box.
    """
    b, box = blending.effectiveness(actuator), blending.plant.box
    missing = sorted(str(s) for s in b.free_symbols if s not in box)
    end = "low" if actuator is blending.low else "high"
    if missing:
        raise ModelError(
            f"{end}.effectiveness: it depends on {', '.join(missing)}, which has no range"
        )
    try:
        return expression_range(b, {s: box[s] for s in b.free_symbols})
    except ModelError as error:
        raise ModelError(f"{end}.effectiveness: {_text(actuator)}: {error}") from error


def _lowest(blending: Blending, actuator: Actuator) -> tuple[str, float]:
    """Return the grid point of the box with the least b, in words, and b there; for messages."""
    b, box = blending.effectiveness(actuator), blending.plant.box
    symbols: list[sp.Symbol] = sorted(b.free_symbols, key=str)
    sides = []
    for symbol in symbols:
        low, high = box[symbol].lower, box[symbol].upper
        sides.append([low + (high - low) * Fraction(k, GRID - 1) for k in range(GRID)])
    if GRID ** len(sides) > MOST_POINTS:
        sides = [[side[0], side[-1]] for side in sides]
    best: tuple[float, tuple[Fraction, ...]] | None = None
    for point in product(*sides):
        value = float(b.subs({s: float(x) for s, x in zip(symbols, point, strict=True)}))
        if best is None or value < best[0]:
            best = value, point
    assert best is not None  # an empty product has one point
    units = {v.symbol: behind(v.unit) for v in blending.plant.variables}
    pairs = zip(symbols, best[1], strict=True)
    words = ", ".join(f"{s} = {float(x):g}{units[s]}" for s, x in pairs)
    return (f"at {words}" if words else "everywhere"), best[0]


def _fitting(blending: Blending, actuator: Actuator, largest: Fraction) -> float:
    """Return the effort at which an actuator delivers ``largest``, rounded towards 0."""
    low, high = -blending.overlap, max(largest, blending.overlap)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if ramp(middle, blending.overlap) <= largest else (low, middle)
    return float(blending.sign(actuator) * low)


def _text(actuator: Actuator) -> str:
    return str(actuator.effectiveness).replace("**", "^")


FROM = "from [blending]"


def blended_plant(blending: Blending) -> Plant:
    """Return the plant behind the blend: the states and the effort, the effort's rate as an input.

    Signals that schedule: ``share``, F with its exact range, and ``<actuator>_error`` for each
    actuator with an error.  ``plant.blending`` keeps the blending.

    Raises
    ------
    ModelError : discrete time, premises that are fixed in actuators, a name that is taken, and what
        ``check_authority`` finds: an effectiveness that vanishes on the box, a command beyond
        limits.
    """
    plant = blending.plant
    if plant.sample_time is not None:
        raise ModelError("blending: the plant is of discrete time; the effort moves in continuous")
    check_authority(blending)
    parameters = blending_parameters(blending)
    rows = [_behind(row, blending) for row in plant.equations]
    mass = None if plant.mass is None else sp.diag(plant.mass, sp.Matrix([[1]]))
    blended_inputs = [a.variable.symbol for a in blending.actuators]
    for symbol, premise in plant.premises.items():
        if premise.has(*blended_inputs):
            raise ModelError(f"premise {symbol}: it depends on a blended actuator; leave it out")
    return replace(
        plant,
        equations=(*rows, blending.rate.symbol),
        states=(*plant.states, blending.effort),
        inputs=(*(v for v in plant.inputs if v.symbol not in blended_inputs), blending.rate),
        disturbances=(*plant.disturbances, *_signals(blending)),
        parameters=(*plant.parameters, *parameters),
        mass=mass,
        blending=blending,
    )


def _behind(row: sp.Expr, blending: Blending) -> sp.Expr:
    """Return one row with the actuators' positions put in.

    If the row is affine in them, its effectiveness is first divided by that of the law, so that
    common factors cancel.
    """
    symbols = [a.variable.symbol for a in blending.actuators]
    slopes = [sp.diff(row, symbol) for symbol in symbols]
    if any(slope.has(*symbols) for slope in slopes):
        pairs = [(a, *_parts(blending, a)) for a in blending.actuators]
        laws = {a.variable.symbol: still + moved / a.effectiveness for a, still, moved in pairs}
        return row.subs(laws, simultaneous=True)
    blended_row = row.subs(dict.fromkeys(symbols, 0))
    for actuator, slope in zip(blending.actuators, slopes, strict=True):
        if slope != 0:
            fixed, delivered = _parts(blending, actuator)
            ratio = slope / actuator.effectiveness
            ratio = sp.factor(sp.cancel(ratio)) if ratio.is_rational_function() else ratio
            blended_row += slope * fixed + ratio * delivered
    return blended_row


def _parts(blending: Blending, actuator: Actuator) -> tuple[sp.Expr, sp.Expr]:
    """Return (still, moved): the actuator is at still + moved / effectiveness.

    It is v = idle + step / b as commanded, and v* + (1 + delta)(v - v*) with the error delta.
    """
    share, effort = _symbol(SHARE), blending.effort
    names = {p.symbol.name for p in blending_parameters(blending)}

    def number(name: str) -> sp.Expr:
        return _symbol(name) if name in names else 0

    share_part = share if actuator is blending.high else share - 1
    delivered = number(f"{actuator.name}_effort_rest") + share_part * (
        effort.symbol - number("effort_rest")
    )
    step = blending.sign(actuator) * actuator.direction * delivered
    idle = number(f"{actuator.name}_idle")
    if actuator.error == 0:
        return idle, step
    wrong = 1 + _symbol(actuator.error_name)
    if blending.delivered(actuator, effort.rest) == 0:
        return idle, wrong * step
    rest = number(f"{actuator.name}_rest")
    return rest + wrong * (idle - rest), wrong * step


def blending_parameters(blending: Blending) -> tuple[Parameter, ...]:
    """Return the numbers that appear in the blended equations; those that are 0 are left out."""
    unit = blending.effort.unit
    numbers = [("effort_rest", blending.effort.rest, unit)]
    for a in blending.actuators:
        delivered = blending.delivered(a, blending.effort.rest)
        numbers.append((f"{a.name}_effort_rest", delivered, unit))
        numbers.append((f"{a.name}_idle", a.variable.rest, a.variable.unit))
        if a.error and delivered:
            numbers.append((f"{a.name}_rest", blending.at_rest(a), a.variable.unit))
    return tuple(
        Parameter(_symbol(name), value, unit, FROM) for name, value, unit in numbers if value
    )


def _signals(blending: Blending) -> tuple[Variable, ...]:
    share = Variable(
        _symbol(SHARE),
        range=blending.share,
        rest=blending.share_at_rest,
        description=f"share of {blending.high.name} in the effort's motion from rest",
        schedules=True,
    )
    errors = (
        Variable(
            _symbol(a.error_name),
            range=Interval(-a.error, a.error),
            rest=Fraction(0),
            description=f"by what share {a.name} moves the plant more than commanded",
            schedules=True,
        )
        for a in blending.actuators
        if a.error
    )
    return share, *errors


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)


def blended_model(
    plant: Plant,
    *,
    choice: Choice = "fewest-rules",
    rest: Rest = "given",
    share_apart: bool = False,
) -> TSModel:
    """Return ``sector_model(plant)``, with share and errors as premises of their own where it goes.

    Entries such as (1 + delta) F are then products of premises that are variables, and the bounds
    of the premises are those of the variables. The premises that the law knows (F) stay apart from
    those that it does not know (delta). Without errors the premises are chosen as usual, because
    the share cancels if both actuators act alike.

    Parameters
    ----------
    choice, rest : as of ``sector_model``.
    share_apart : make the share a premise of its own even without errors.

    Raises
    ------
    ModelError : as ``sector_model`` does.
    """
    premises = _wanted(plant, always=share_apart)
    if premises:
        try:
            return sector_model(
                plant, choice=choice, rest=rest, premises={**plant.premises, **premises}
            )
        except ModelError:
            # Some may not be found, if a term has another factor too. Then any factored form is
            # taken.
            return sector_model(plant, choice=choice, rest=rest)
    return sector_model(plant, choice=choice, rest=rest)


def _wanted(plant: Plant, *, always: bool) -> dict[sp.Symbol, sp.Expr]:
    """Return premise -> signal, of those that appear in the equations once they are expanded."""
    blending = blending_of(plant)
    if blending is None or not (always or any(a.error for a in blending.actuators)):
        return {}
    expanded = sp.Matrix([sp.expand(row) for row in plant.equations])
    named = {"high_share": SHARE}
    named |= {f"{a.name}_off": a.error_name for a in blending.actuators if a.error}
    signals = {sp.Symbol(k, real=True): sp.Symbol(s, real=True) for k, s in named.items()}
    return {name: signal for name, signal in signals.items() if expanded.has(signal)}
