"""The sentence of a claim of kind ``running-loop``, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isqrt
from typing import Any

from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Span
from takagi.certificates.checker.turbine.running_loop.quadratic_forms import squared_reaches
from takagi.certificates.checker.turbine.wind_intervals import gaps
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly

MOST_REASONS = 12
FINE = 10**24
# Indices of the states whose half widths are stated.
SPEED, ESTIMATE = 0, 6


def said(
    law: Law,
    winds: list[Span],
    why: str = "",
    failures: Sequence[tuple[Span, str]] = (),
    machine: Machine | None = None,
    decay: Fraction = Fraction(0),
    cells: Sequence[Any] = (),
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    winds : the ranges that the cells cover.
    failures : the winds of each cell that is not proved, with the reason.
    machine, decay, cells : given where the claim is proved.
    """
    low, high = law.wind[0], law.wind[-1]
    left = gaps((low, high), winds)
    but = f", but NOT {_listed(left)}" if left else ""
    name = f"running loop with its observer, {_range_words(low, high)} m/s{but}"
    if machine is None:
        reasons = [f"wind {_range_words(*ends)} m/s: {reason}" for ends, reason in failures]
        more = f" (+{len(reasons) - MOST_REASONS} more)" if len(reasons) > MOST_REASONS else ""
        return name, "not proved: " + (why or "; ".join(reasons[:MOST_REASONS]) + more)
    return name, _statement(law, winds, machine, decay, cells)


def _statement(
    law: Law, winds: list[Span], machine: Machine, decay: Fraction, cells: Sequence[Any]
) -> str:
    left = gaps((law.wind[0], law.wind[-1]), winds)
    covered = f"from {_range_words(law.wind[0], law.wind[-1])} m/s, in {len(cells)} cells"
    if left:
        covered += f", but NOT at winds {_listed(left)}, of which nothing is said"
    speed, estimate = _widths(cells)
    limits = [at_least(of(law.limit), 3) for of in (min, max)]
    return (
        f"at every constant wind {covered}: from its set V <= 1, with the schedule wind within the "
        "law's tables, pitch not below its lower limit and torque and pitch set where the law "
        "commands them, the loop settles to its rest, and "
        f"V falls at least as exp(-{at_least(2 * decay, 3)} t), a rate of {at_least(decay, 3)} "
        f"1/s; the sets reach to {speed} rad/s of speed and to {estimate} m/s of the wind estimate "
        f"(half widths, by cell). In the loop: {measured(machine)}, {_family(machine)} and until "
        f"then leaves pitch up to {limits[0]} to {limits[1]} rad/s^2 per rad of effect (by wind). "
        "Assumed: exact measurements before the filters, no lag of torque, a pitch drive of first "
        "order, the table's c_P, rigid shaft, tower and blades, a law in continuous time"
    )


def _family(machine: Machine) -> str:
    """Return observer, wind filter, limits and the family of plants in words."""
    return (
        f"the observer with l1 = {exactly(machine.l1)} 1/s and l2 = {exactly(machine.l2)} m/s^2 "
        f"per rad/s, the wind filter of {exactly(machine.wind_filter)} s, the limits of the rates "
        "of torque and pitch, the pitch drive with its own, inertia "
        f"{_range_words(*machine.inertia)} of nominal, and a wake that follows pitch over "
        f"{_range_words(*machine.wake_length)} m of wind"
    )


def measured(machine: Machine) -> str:
    """Return the filters of the measured speed in words."""
    passed = f"the low-pass of {exactly(machine.corner)} rad/s on the measured speed"
    if machine.stop is None:
        return passed
    frequency, share = map(exactly, machine.stop)
    return f"{passed} behind a band-stop at {frequency} rad/s that passes {share}"


def _widths(cells: Sequence[Any]) -> tuple[str, str]:
    """Return the ranges of the half widths in speed and in the wind estimate, rounded down."""
    told = []
    for place in (SPEED, ESTIMATE):
        found = []
        for cell in cells:
            row = [Fraction(int(i == place)) for i in range(len(cell.P))]
            reached = squared_reaches(cell.P, [row])
            square = reached[0] if reached else Fraction(0)
            found.append(Fraction(isqrt(square.numerator * FINE**2 // square.denominator), FINE))
        least, most = at_least(min(found), 2), at_least(max(found), 2)
        told.append(f"{least} to {most}")
    return told[0], told[1]


def _listed(ranges: Sequence[Span]) -> str:
    """Return the ranges that are left out, rounded outward."""
    return ", ".join(f"{at_least(low, 6)} to {at_most(high, 6)} m/s" for low, high in ranges)


def _range_words(low: Fraction, high: Fraction) -> str:
    """Return an interval, rounded inward."""
    return f"{at_most(low, 6)} to {at_least(high, 6)}"
