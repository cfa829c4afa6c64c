"""Observer, filters, family and box of a claim about the running loop, as exact numbers."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
)
from takagi.certificates.cross_check.turbine.surface import NumberRange

SIDES = (
    "speed",
    "measured",
    "pitch",
    "signal",
    "effort",
    "schedule",
    "estimate",
    "integral",
    "measured_rate",
    "innovation",
)


class Machine:
    """Numbers that are not in the law; ``stop`` is (frequency, share passed), or None."""

    def __init__(self, claim: Any, model: Any, gains: Any) -> None:
        seen, filters = entry(claim, "observer"), entry(claim, "measurement")
        family = entry(claim, "uncertainty")
        self.l1, self.l2 = rational(seen, "l1"), rational(seen, "l2")
        self.least_wind, self.most_wind = rationals(seen, "wind_limits", 2)
        self.corner, self.lag = rational(filters, "speed_filter"), rational(gains, "wind_filter")
        self.stop: tuple[fmpq, fmpq] | None = None
        positive = [self.l1, self.l2, self.least_wind, self.corner, self.lag]
        _no_other_filters(filters)
        if "torsion_filter" in filters:
            self.stop = _band_stop(filters["torsion_filter"])
            positive.append(self.stop[0])
            if self.stop[1] < 0 or self.stop[1] > 1:
                raise Refusal("torsion_filter: a share from 0 to 1 must pass")
        self.torque_rate = rational(model, "torque_rate_limit")
        light, heavy = rationals(family, "inertia", 2)
        short, long = rationals(family, "wake_length", 2)
        positive += [self.torque_rate, light, short]
        in_order = light <= heavy and short <= long and self.least_wind < self.most_wind
        if min(positive) <= 0 or not in_order:
            raise Refusal("a number of observer, filters or family that is not in its range")
        self.kappa, self.length = NumberRange(1 / heavy, 1 / light), NumberRange(short, long)
        self.inertia_ratio = _inertia_ratio(model)

    @property
    def states(self) -> int:
        return 8 if self.stop is None else 10


def box(cell: Any) -> dict[str, fmpq]:
    """Return the sides of a cell's box."""
    sides = {name: rational(entry(cell, "sides"), name) for name in SIDES}
    if min(sides.values()) <= 0:
        raise Refusal("sides: positive numbers are needed")
    return sides


def same_controller(claim: Any, document: Any) -> bool:
    """Return whether observer and filters are those of the file's controller, if there is one."""
    if not isinstance(document, dict) or document.get("controller") is None:
        return True
    own = document["controller"]
    parts = ("observer", "measurement")
    return all(_numbers(claim, part) == _numbers(own, part) for part in parts)


def _numbers(owner: Any, part: str) -> list[fmpq] | None:
    """Return the numbers of one part, or None where it is missing."""
    if not isinstance(owner, dict) or part not in owner:
        return None
    found = owner[part]
    if part == "observer":
        return [rational(found, "l1"), rational(found, "l2"), *rationals(found, "wind_limits", 2)]
    _no_other_filters(found)
    numbers = [rational(found, "speed_filter")]
    if "torsion_filter" in found:
        numbers += _band_stop(found["torsion_filter"])
    return numbers


def _no_other_filters(stated: Any) -> None:
    if not isinstance(stated, dict) or not set(stated) <= {"speed_filter", "torsion_filter"}:
        raise Refusal("measurement: a low-pass and a band-stop, and nothing else")


def _band_stop(stated: Any) -> tuple[fmpq, fmpq]:
    """Return frequency and share passed; refuses what else a filter of another form has."""
    found = rational(stated, "frequency"), rational(stated, "passed")
    if len(stated) > len(found):
        raise Refusal("torsion_filter: frequency and passed, and nothing else")
    return found


def _inertia_ratio(model: Any) -> fmpq:
    """Return J / J_o: the observer divides by the nearest float of J, written in decimals."""
    n = rational(model, "gear_ratio")
    J = rational(model, "rotor_inertia") + n * n * rational(model, "generator_inertia")
    if J <= 0:
        raise Refusal("model: a positive inertia is needed")
    p, q = Decimal(repr(int(J.p) / int(J.q))).as_integer_ratio()
    return J / fmpq(p, q)
