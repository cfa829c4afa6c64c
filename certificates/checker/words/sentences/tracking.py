"""The sentence of a proved claim of kind ``tracking``."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.plant.reading import PlantNodes, Variable
from takagi.certificates.checker.plant.references import Following
from takagi.certificates.checker.plant.tracking import Evidence, bounds_of, ranged
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(name: str, plant: PlantNodes, follow: list[Following], found: Evidence) -> tuple[str, str]:
    """Return name and sentence."""
    bounds = bounds_of(plant, found, follow)
    signals = ", ".join(
        f"{one.signal.name} in {_range(plant, one.signal)} {one.signal.unit}" for one in follow
    )
    rate = at_least(found.rate, 6)
    words = f"for every constant {signals}{_others(plant, follow)} the loop has one rest"
    words += f" with no error in a stated set, and settles there as exp(-{rate} t) from all of it"
    jumps = [
        f"{at_least(jump, 4)} {one.signal.unit} in {one.signal.name}"
        for one, jump in zip(follow, bounds["jumps"], strict=True)
        if jump is not None
    ]
    if jumps:
        alone = "" if len(follow) == 1 else ", one at a time,"
        words += f", also from rest after jumps{alone} of up to {', '.join(jumps)}"
    words += "; states and inputs keep their ranges"
    if any(found.rates):
        moving = ", ".join(
            f"|{v.name}'| <= {at_least(rho, 6)}"
            for v, rho in zip(ranged(plant), found.rates, strict=True)
            if rho
        )
        errors = ", ".join(
            f"{at_most(error, 4)} {one.signal.unit} for {one.signal.name}"
            for error, one in zip(bounds["errors"], follow, strict=True)
        )
        others = [v.name for v, rho in zip(ranged(plant), found.rates, strict=True) if not rho]
        held = f" and {', '.join(others)} constant" if others else ""
        words += f"; while {moving}{held} the error settles to at most {errors}"
    return name, words + _still(plant, follow)


def _others(plant: PlantNodes, follow: list[Following]) -> str:
    others = _other_signals(plant, follow)
    if not others:
        return ""
    return " and constant " + ", ".join(f"{v.name} in {_range(plant, v)} {v.unit}" for v in others)


def _still(plant: PlantNodes, follow: list[Following]) -> str:
    known = {one.column for one in follow}
    still = [v.name for k, v in enumerate(plant.disturbances) if k not in known and v.side is None]
    return f"; with {', '.join(still)} at rest" if still else ""


def _other_signals(plant: PlantNodes, follow: list[Following]) -> list[Variable]:
    known = {one.column for one in follow}
    return [v for k, v in enumerate(plant.disturbances) if k not in known and v.side is not None]


def _range(plant: PlantNodes, variable: Variable) -> str:
    rest = plant.graph.value(variable.rest) or Fraction(0)
    assert variable.side is not None  # asked for such variables alone
    return f"[{at_most(rest + variable.side[0], 9)}, {at_least(rest + variable.side[1], 9)}]"
