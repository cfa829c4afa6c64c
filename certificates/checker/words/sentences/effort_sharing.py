"""What a claim of kind ``coherent-loop`` says, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import member, number
from takagi.certificates.checker.turbine.effort_sharing.inputs import (
    Law,
    Plant,
    Settling,
    Uncertainty,
)
from takagi.certificates.checker.words.rounded import at_least, at_most

MOST_REASONS = 12
ASSUMED = (
    "assumed: a law that is fed v_s', in continuous time, no lag of torque, a pitch drive of first "
    "order, no states of wake, shaft, tower and blades"
)


def said(
    claim: Any,
    law: Law,
    uncertainty: Uncertainty,
    why: str = "",
    failures: Sequence[tuple[int | None, str]] = (),
    plant: Plant | None = None,
    settling: Settling | None = None,
    where: str = "",
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    failures : what is not proved, with the wind cell or None for all.
    plant, settling : given where the claim is proved.
    """
    # Derived from checked numbers: the name in the file, or of its wake, proves nothing.
    wake = "equilibrium wake"
    if _pushed(law, uncertainty):
        wake = f"pitch effectiveness up to {_reach(law)}"
    name = f"effort-sharing loop, {_span(law.wind[0], law.wind[-1])} m/s, {wake}"
    if plant is None or settling is None:
        return name, why or _listed(failures, law, len(claim["cells"]))
    return name, _statement(claim, plant, law, uncertainty, settling, where)


def _pushed(law: Law, uncertainty: Uncertainty) -> bool:
    """Return whether the stated wake adds effectiveness at every wind."""
    return uncertainty.frozen_wake and min(law.limit) > 0


def _wake(law: Law, uncertainty: Uncertainty) -> str:
    """Return the limit of pitch effectiveness from the file's numbers, not from its texts."""
    if not uncertainty.frozen_wake:
        return "equilibrium wake"
    held = f"of at least {_reach(law)} (by wind)"
    if _pushed(law, uncertainty):
        return (
            f"from the equilibrium wake's to the claim's bound {held}, which is the turbine's "
            "frozen wake if its model file states that wake"
        )
    return f"equilibrium wake, for the stated limit {held} is no frozen wake's"


def _reach(law: Law) -> str:
    """Return the bound of pitch effectiveness, rounded to the side that claims less."""
    lowest, highest = (at_least(of(law.limit), 3) for of in (min, max))
    return f"{lowest} to {highest} rad/s^2 per rad"


def _listed(failures: Sequence[tuple[int | None, str]], law: Law, cells: int) -> str:
    reasons = [
        why if k is None else f"wind {_span(*law.wind[k : k + 2])} m/s: {why}"
        for k, why in failures
    ]
    left = len(reasons) - MOST_REASONS
    more = f" (+{left} more)" if left > 0 else ""
    return f"not proved, of {cells} wind cells: " + "; ".join(reasons[:MOST_REASONS]) + more


def _span(low: Fraction, high: Fraction) -> str:
    """Return the interval, rounded so that it is not wider than the proved one."""
    return f"{at_most(low, 6)} to {at_least(high, 6)}"


def _statement(
    claim: Any, plant: Plant, law: Law, uncertainty: Uncertainty, settling: Settling, where: str
) -> str:
    cells = claim["cells"]
    peak = number(member(claim, "peaks", where), "speed_error", f"{where}.peaks")
    overspeed = 100 * ((max(law.speed) + peak) / plant.rated_speed - 1)
    columns = {
        name: [number(cell, name, where) for cell in cells]
        for name in ("wind_error", "wind_rate", "decay_rate")
    }
    least = {name: at_least(min(column), 3) for name, column in columns.items()}
    most = {name: at_least(max(column), 3) for name, column in columns.items()}
    wake = _wake(law, uncertainty)
    power = (
        f", c_P {_span(*uncertainty.power)} of the table's"
        if min(uncertainty.power) < max(uncertainty.power)
        else ""
    )
    return (
        f"winds {_span(law.wind[0], law.wind[-1])} m/s in {len(cells)} cells, inertia "
        f"{_span(*uncertainty.inertia)} of nominal{power}, pitch effectiveness {wake}: the set is "
        f"invariant, from pitch not below its lower limit, for v_s within the law's tables, "
        f"|v - v_s| up to {least['wind_error']} to {most['wind_error']} m/s and |v_s'| up to "
        f"{least['wind_rate']} to {most['wind_rate']} m/s^2 (by wind cell); overspeed at most "
        f"{at_most(overspeed, 3)} %; at constant wind v = v_s, wake and c_P constant too, "
        "the loop settles at no less "
        f"than {at_least(settling.decay_rate, 3)} 1/s in one quadratic function for all winds, up "
        f"to {most['decay_rate']} 1/s by wind cell; {ASSUMED}"
    )
