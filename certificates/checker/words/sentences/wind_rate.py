"""What a claim of kind ``wind-rate`` says, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import member, number
from takagi.certificates.checker.kernel.result import Outcome
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range
from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.certificates.checker.words.saying import in_words

# The rates that the verdict names the winds of [m/s^2].
TOLD = tuple(map(Fraction, ("0.02", "0.05", "0.1", "0.2", "0.5", "1", "1.5", "2", "3", "5")))


def said(
    ranges: list[Range],
    wind_filter: Fraction,
    unproved: Outcome | None = None,
    failures: Sequence[tuple[Range, str, Fraction | None]] = (),
    loop: Any = None,
    data: Any = None,
    law: Law | None = None,
    where: str = "",
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    unproved : the claim that this one rests on, where that is not proved.
    failures : ranges, and what is not proved of them, with {} for the wind where.
    loop, data, law : given where the claim is proved.
    """
    name = f"wind rate, {_span(ranges[0])}"
    if unproved:
        return name, f"the claim that it rests on is not proved: {in_words(unproved).name}"
    if failures:
        reasons = [
            f"{_span(one)}: {why if wind is None else why.format(at_least(wind, 6))}"
            for one, why, wind in failures
        ]
        return name, "not proved: " + "; ".join(reasons)
    if law is None:
        return name, "the law has no wind filter: no rate is bounded"
    return name, _statement(ranges, loop, data, law, wind_filter, where)


def _span(one: Range) -> str:
    """Return the range, not wider than it is."""
    return f"{at_most(one.wind[0], 6)} to {at_least(one.wind[-1], 6)} m/s"


def _statement(
    ranges: list[Range], loop: Any, data: Any, law: Law, filter_: Fraction, where: str
) -> str:
    peaks = member(loop, "peaks", where)
    peak = number(peaks, "speed_error", f"{where}.peaks")
    rated = number(member(data, "model", "certificate"), "rated_rotor_speed", "model")
    overspeed = 100 * ((max(law.speed) + peak) / rated - 1)
    listed = "; ".join(_range_words(one) for one in ranges)
    return (
        f"with the law's wind filter of {at_most(filter_, 6)} s, from any start with V <= 1 and "
        f"the filter at its estimate, the loop stays in its proved wind class, under what the "
        "claim of that assumes, so that V <= 1 and overspeed at most "
        f"{at_most(overspeed, 3)} %, for every wind whose estimate moves no faster than the "
        f"claim's rate: {listed}"
    )


def _range_words(one: Range) -> str:
    known = "known exactly" if one.error == 0 else f"known to {at_least(one.error, 3)} m/s"
    steps = [f"{at_least(min(one.estimate), 3)} m/s^2 everywhere"]
    for rate in TOLD:
        start = _from(one, rate)
        if start is not None and rate > min(one.estimate):
            steps.append(f"{at_most(rate, 3)} m/s^2 from {at_most(start, 6)} m/s on")
    return f"wind and estimate within {_span(one)}, {known}: at least {', '.join(steps)}"


def _from(one: Range, rate: Fraction) -> Fraction | None:
    """Return the least wind from which r is at least the rate up to the range's end."""
    if one.estimate[-1] < rate:
        return None
    for i in range(len(one.wind) - 2, -1, -1):
        low, high = one.estimate[i : i + 2]
        if low < rate:
            return one.wind[i] + (one.wind[i + 1] - one.wind[i]) * (rate - low) / (high - low)
    return one.wind[0]
