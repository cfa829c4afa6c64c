"""Name and sentence of a claim about the effort-sharing loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Uncertainty
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.words.rounded import at_least, at_most, range_within

ASSUMED = (
    "assumed: continuous time, no lag of torque, a pitch drive of first "
    "order, no states of wake, shaft, tower and blades"
)


def loop_name(law: Law, uncertainty: Uncertainty) -> str:
    """Return the claim's name, from checked numbers: the name in the file proves nothing."""
    wake = "equilibrium wake"
    if _pushed(law, uncertainty):
        wake = f"pitch effectiveness up to {_reach(law)}"
    return f"effort-sharing loop, {range_within(law.wind[0], law.wind[-1])} m/s, {wake}"


def loop_sentence(
    plant: Plant,
    law: Law,
    uncertainty: Uncertainty,
    cells: Sequence[Mapping[str, Fraction]],
    peak: Fraction,
    decay_rate: Fraction,
) -> str:
    """Return the sentence of a proved claim.

    Parameters
    ----------
    cells : for each wind cell its wind error, wind rate and decay rate.
    peak : bound of the speed error.
    decay_rate : that all winds share.
    """
    overspeed = 100 * ((max(law.speed) + peak) / plant.rated_speed - 1)
    names = ("wind_error", "wind_rate", "decay_rate")
    least, most = (
        {name: at_least(extreme(cell[name] for cell in cells), 3) for name in names}
        for extreme in (min, max)
    )
    wake = _wake(law, uncertainty)
    power = (
        f", c_P {range_within(*uncertainty.power)} of the table's"
        if min(uncertainty.power) < max(uncertainty.power)
        else ""
    )
    return (
        f"winds {range_within(law.wind[0], law.wind[-1])} m/s in {len(cells)} cells, inertia "
        f"{range_within(*uncertainty.inertia)} of nominal{power}, pitch effectiveness {wake}: the "
        f"set is invariant, from pitch not below its lower limit, for v_s within the law's tables, "
        f"|v - v_s| up to {least['wind_error']} to {most['wind_error']} m/s and |v_s'| up to "
        f"{least['wind_rate']} to {most['wind_rate']} m/s^2 (by wind cell); overspeed at most "
        f"{at_most(overspeed, 3)} %; at constant wind v = v_s, wake and c_P constant too, "
        f"the loop settles at no less than {at_least(decay_rate, 3)} 1/s in one quadratic function "
        f"for all winds, up to {most['decay_rate']} 1/s by wind cell; {ASSUMED}"
    )


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
