"""Name and sentence of a claim about the loop as it runs."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Span
from takagi.certificates.checker.turbine.turbine_claim import gaps
from takagi.certificates.checker.words.ellipsoid_size import square_root_below, squared_reaches
from takagi.certificates.checker.words.rounded import at_least, exactly, range_around, range_within

# Indices of the states whose half widths are stated.
SPEED, ESTIMATE = 0, 6


def loop_name(law: Law, winds: list[Span]) -> str:
    """Return the claim's name; ``winds`` are the ranges that its cells cover."""
    low, high = law.wind[0], law.wind[-1]
    missing = _listed(gaps((low, high), winds))
    but = f", but NOT {missing}" if missing else ""
    return f"running loop with its observer, {range_within(low, high)} m/s{but}"


def loop_sentence(
    law: Law, winds: list[Span], machine: Machine, decay: Fraction, shapes: Sequence[Matrix]
) -> str:
    """Return the sentence of a proved claim; ``shapes`` are the P of its cells."""
    covered = f"from {range_within(law.wind[0], law.wind[-1])} m/s, in {len(shapes)} cells"
    if missing := _listed(gaps((law.wind[0], law.wind[-1]), winds)):
        covered += f", but NOT at winds {missing}, which are not covered"
    speed, estimate = _widths(shapes)
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
        f"{range_within(*machine.inertia)} of nominal, and a wake that follows pitch over "
        f"{range_within(*machine.wake_length)} m of wind"
    )


def measured(machine: Machine) -> str:
    """Return the filters of the measured speed in words."""
    passed = f"the low-pass of {exactly(machine.corner)} rad/s on the measured speed"
    if machine.stop is None:
        return passed
    frequency, share = map(exactly, machine.stop)
    return f"{passed} behind a band-stop at {frequency} rad/s that passes {share}"


def _widths(shapes: Sequence[Matrix]) -> list[str]:
    """Return the ranges of the half widths in speed and in the wind estimate, rounded down."""
    squares = zip(*(squared_reaches(P, (SPEED, ESTIMATE)) for P in shapes), strict=True)
    return [
        f"{at_least(square_root_below(min(column)), 2)} to "
        f"{at_least(square_root_below(max(column)), 2)}"
        for column in squares
    ]


def _listed(ranges: Sequence[Span]) -> str:
    """Return the ranges that are left out, rounded outward; empty for none."""
    return ", ".join(f"{range_around(low, high)} m/s" for low, high in ranges)
