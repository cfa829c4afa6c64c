"""Whether each actuator can deliver its part of the effort's range, everywhere on the box."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

from takagi.models.blending.blending import Actuator, Blending, unit_text
from takagi.models.errors import ModelError
from takagi.models.ramps.effort_ramp import ramp

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.ranges.branch_and_bound import Range

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
    for place, actuator in (("low", blending.low), ("high", blending.high)):
        found = effectiveness_range(blending, actuator)
        least = found.outer.lower
        where, value = _lowest(blending, actuator)
        if least <= 0:
            sure = value <= 0
            found_so_far = "" if sure else "not shown to be positive on the box, with "
            raise ModelError(
                f"{place}.effectiveness: {_text(actuator)} is {found_so_far}{value:.6g} {where}; "
                f"there {actuator.name} moves nothing, or the wrong way: shrink the ranges that it "
                "depends on, or correct it or its direction"
            )
        room = blending.room(actuator)
        if room is None or blending.most(actuator) <= room * least:
            continue
        fits = _fitting(blending, actuator, room * least)
        end = "upper" if actuator is blending.high else "lower"
        name, unit = actuator.name, unit_text(actuator.variable.unit)
        raise ModelError(
            f"effort: at its {end} end {name} would have to go "
            f"{float(blending.most(actuator) / least):.6g}{unit} from where it idles {where}, "
            f"and its range leaves {float(room):.6g}: beyond that no actuator acts; give effort "
            f"a range up to {fits:.6g}{unit_text(blending.effort.unit)} on that side, or {name} a "
            "wider one"
        )


def effectiveness_range(blending: Blending, actuator: Actuator) -> Range:
    """Return the rigorous range of an actuator's effectiveness on the box.

    Raises
    ------
    ModelError : a variable in it has no range, or it is not defined on the whole box.
    """
    from takagi.models.ranges.expression_range import expression_range

    b, box = blending.effectiveness(actuator), blending.plant.box
    missing = sorted(str(s) for s in b.free_symbols if s not in box)
    place = "low" if actuator is blending.low else "high"
    if missing:
        raise ModelError(
            f"{place}.effectiveness: it depends on {', '.join(missing)}, which has no range"
        )
    try:
        return expression_range(b, {s: box[s] for s in b.free_symbols})
    except ModelError as error:
        raise ModelError(f"{place}.effectiveness: {_text(actuator)}: {error}") from error


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
    units = {v.symbol: unit_text(v.unit) for v in blending.plant.variables}
    pairs = zip(symbols, best[1], strict=True)
    words = ", ".join(f"{s} = {float(x):g}{units[s]}" for s, x in pairs)
    return (f"at {words}" if words else "everywhere"), best[0]


def _fitting(blending: Blending, actuator: Actuator, most: Fraction) -> float:
    """Return the effort at which an actuator delivers ``most``, rounded towards 0."""
    low, high = -blending.overlap, max(most, blending.overlap)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if ramp(middle, blending.overlap) <= most else (low, middle)
    return float(blending.sign(actuator) * low)


def _text(actuator: Actuator) -> str:
    return str(actuator.effectiveness).replace("**", "^")
