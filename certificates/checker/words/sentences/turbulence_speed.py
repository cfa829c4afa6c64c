"""The sentence of a claim of kind ``turbulence-speed``, proved or not."""

from __future__ import annotations

from takagi.certificates.checker.turbine.overspeed.speed_inputs import StatedSpeed
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly


def said(stated: StatedSpeed, failure: str = "") -> tuple[str, str]:
    """Return name and sentence; ``failure`` is what is not shown, if something is not."""
    wind, law = stated.wind, stated.law
    name = f"rotor speed in turbulence, mean wind {exactly(wind.mean)} m/s"
    if failure:
        return name, f"not proved: {failure}"
    over = at_most(100 * stated.speed / stated.plant.rated_speed, 5)
    until = ""
    if stated.least_estimate > law.wind[0]:
        until = (
            f", or until the wind estimate first falls below {exactly(stated.least_estimate)} m/s"
        )
    excess = ""
    if stated.excess:
        excess = f" plus J times {at_least(stated.excess, 4)} rad/s^2"
    return name, (
        f"the probability that the rotor's speed reaches {at_most(stated.speed, 6)} rad/s, {over} "
        f"% of its rated speed, within {at_least(stated.horizon, 6)} s{until} is at most "
        f"{at_most(stated.probability, 6)}: in wind of mean {exactly(wind.mean)} m/s whose "
        f"standard deviation is {exactly(wind.deviation)} m/s and whose rate has an rms of "
        f"{exactly(wind.rate)} m/s^2, from the trim of the mean wind. The wind "
        f"reaches {exactly(stated.highest)} m/s with at most this probability, and below it the "
        "generator of the nonlinear loop takes more than the rotor gives at that speed, whatever "
        f"the wind estimate says. In the loop: {_filters(stated)}, the law with its limits, the "
        "limit of the torque's rate, inertia "
        f"{exactly(stated.inertia[0])} to {exactly(stated.inertia[1])} of nominal, and a "
        f"rotor torque of at most the table's{excess}, at any pitch from the lower limit on"
    )


def _filters(stated: StatedSpeed) -> str:
    told = f"the low-pass of {exactly(stated.corner)} rad/s on the measured speed"
    if stated.stop:
        frequency, passed = map(exactly, stated.stop)
        told += f" and the band-stop at {frequency} rad/s that passes {passed}"
    return told
