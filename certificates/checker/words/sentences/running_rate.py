"""The sentence of a claim of kind ``running-rate``, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isqrt
from typing import Any

from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Span
from takagi.certificates.checker.turbine.wind_intervals import gaps
from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.certificates.checker.words.sentences.running_loop import (
    FINE,
    MOST_REASONS,
    family,
    listed,
    measured,
    range_words,
)

# pi to 20 digits from below: angles in degrees are then rounded up.
PI = Fraction("3.14159265358979323846")


def said(
    law: Law,
    winds: list[Span],
    failures: Sequence[tuple[Span, str]] = (),
    machine: Machine | None = None,
    kept: Sequence[Any] = (),
    rated_speed: Fraction = Fraction(1),
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    winds : the ranges that the cells cover.
    failures : the winds of each cell that is not proved, with the reason.
    machine, kept, rated_speed : given where the claim is proved; ``kept`` as the checker found it.
    """
    low, high = law.wind[0], law.wind[-1]
    left = gaps((low, high), winds)
    but = f", but NOT {listed(left)}" if left else ""
    name = f"running loop in moving wind, {range_words(low, high)} m/s{but}"
    if machine is None:
        reasons = [f"wind {range_words(*ends)} m/s: {reason}" for ends, reason in failures]
        more = f" (+{len(reasons) - MOST_REASONS} more)" if len(reasons) > MOST_REASONS else ""
        return name, "not proved: " + "; ".join(reasons[:MOST_REASONS]) + more
    return name, _statement(winds, machine, kept, rated_speed)


def _statement(
    winds: list[Span], machine: Machine, kept: Sequence[Any], rated_speed: Fraction
) -> str:
    ranges = ", or ".join(f"{range_words(*ends)} m/s" for ends in winds)
    stays = f"while the wind stays within {ranges}"
    if len(winds) > 1:
        stays = f"while the wind stays within ONE of {ranges}"
    return (
        f"{stays}, and moves by at most r(v) at the wind v, a motion that starts with V <= 1 keeps "
        f"V <= 1. {_rates(winds, kept)}. Then the rotor's speed stays at or below "
        f"{_overspeed(kept, rated_speed)} % of its rated speed, and from the trim at the present "
        f"wind deviate at most: the speed by {_most(kept, 'speed')} rad/s, pitch by "
        f"{at_most(_width(kept, 'pitch') * 180 / PI, 3)} deg, torque by "
        f"{at_most(max(cell.torque for cell in kept), 3)} N m, the wind estimate by "
        f"{_most(kept, 'estimate')} m/s and the schedule wind by {_most(kept, 'schedule')} m/s. "
        f"In the loop: {measured(machine)}, {family(machine)} and until then leaves pitch more "
        f"effect, up to the law's effectiveness_limit"
    )


def _rates(winds: list[Span], kept: Sequence[Any]) -> str:
    """Return the least and the largest rate of each range of winds, rounded down."""
    told = []
    for low, high in winds:
        rates = [cell.wind_rate for cell in kept if low <= cell.winds[0] and cell.winds[1] <= high]
        least, most = at_least(min(rates), 2), at_least(max(rates), 2)
        told.append(f"r is {least} to {most} m/s^2 (by cell) from {range_words(low, high)} m/s")
    return "; ".join(told)


def _overspeed(kept: Sequence[Any], rated_speed: Fraction) -> str:
    """Return the largest rotor speed in percent of the rated one, rounded up."""
    fastest = max(cell.fastest + root(cell.speed) for cell in kept)
    return at_most(100 * fastest / rated_speed, 5)


def _most(kept: Sequence[Any], name: str) -> str:
    return at_most(_width(kept, name), 3)


def _width(kept: Sequence[Any], name: str) -> Fraction:
    return root(max(getattr(cell, name) for cell in kept))


def root(square: Fraction) -> Fraction:
    """Return a number that is just above the square root."""
    return Fraction(isqrt(square.numerator * FINE**2 // square.denominator) + 1, FINE)
