"""The sentence of a claim of kind ``schedule-rate``, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Span
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly
from takagi.certificates.checker.words.sentences.running_loop import (
    MOST_REASONS,
    family,
    measured,
    range_words,
)
from takagi.certificates.checker.words.sentences.running_rate import PI, root


def said(
    law: Law,
    winds: list[Span],
    failures: Sequence[tuple[Span, str]] = (),
    machine: Machine | None = None,
    kept: Sequence[Sequence[Any]] = (),
    rated_speed: Fraction = Fraction(1),
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    winds : the ranges in which the wind stays.
    failures : the schedule winds of each cell that is not proved, with the reason.
    machine, kept, rated_speed : given where the claim is proved; ``kept`` has the cells of each
        range, as the checker found them.
    """
    ranges = ", or ".join(f"{range_words(*ends)} m/s" for ends in winds)
    name = f"loop about the schedule wind in moving wind, {ranges}"
    if machine is None:
        reasons = [f"schedule wind {range_words(*ends)} m/s: {reason}" for ends, reason in failures]
        more = f" (+{len(reasons) - MOST_REASONS} more)" if len(reasons) > MOST_REASONS else ""
        return name, "not proved: " + "; ".join(reasons[:MOST_REASONS]) + more
    told = "; ".join(
        _statement(ends, cells, rated_speed) for ends, cells in zip(winds, kept, strict=True)
    )
    return name, (
        f"{told}. In the loop: {measured(machine)}, {family(machine)} and until then leaves pitch "
        "more effect, at the trim of the present wind up to the law's effectiveness_limit"
    )


def _statement(winds: Span, cells: Sequence[Any], rated_speed: Fraction) -> str:
    # The schedule wind starts in this range, and stays in it: it may be rounded to neither side.
    low, high = cells[0].winds[0], cells[-1].winds[1]
    fastest = max(cell.fastest + root(cell.speed) for cell in cells)
    pitch = root(max(cell.pitch for cell in cells)) * 180 / PI
    wind = root(max(max(cell.wind) for cell in cells))
    return (
        f"while the wind stays within {range_words(*winds)} m/s and moves by at most "
        f"{at_least(min(cell.wind_rate for cell in cells), 3)} m/s^2, a motion that starts with "
        f"V <= 1 and a schedule wind within {exactly(low)} to {exactly(high)} m/s keeps both. "
        f"Then the rotor's speed stays at or below {at_most(100 * fastest / rated_speed, 5)} % of "
        "its rated "
        "speed, and from the trim at the schedule wind deviate at most: the speed by "
        f"{_most(cells, 'speed')} rad/s, pitch by {at_most(pitch, 3)} deg, the wind estimate by "
        f"{_most(cells, 'estimate')} m/s and the wind itself by {at_most(wind, 3)} m/s; torque "
        "stays at its rated value"
    )


def _most(cells: Sequence[Any], name: str) -> str:
    return at_most(root(max(getattr(cell, name) for cell in cells)), 3)
