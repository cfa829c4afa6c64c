"""What a claim of kind ``actuator-rates`` says, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.kernel.reader import number
from takagi.certificates.checker.kernel.result import Outcome
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly
from takagi.certificates.checker.words.saying import in_words

NAME = "actuator rates of the effort-sharing loop"
ACTUATORS = ("pitch", "torque")
MOST_REASONS = 12


def said(
    unproved: Outcome | None = None,
    failures: Sequence[tuple[list[Fraction], str]] = (),
    cells: Sequence[Any] = (),
    fed: Sequence[bool] = (),
    data: Any = None,
    law: Law | None = None,
    step: Fraction = Fraction(0),
    where: str = "",
    kept: Fraction | None = None,
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    unproved : the claim that this one depends on, if it is not proved.
    failures : what is not proved, with the ends of the wind cell, or none of the whole.
    fed : for each cell, whether its torque uses the schedule wind's rate.
    kept : the largest |v_s''| there in the winds of the claim on the wind's rate; None where none
        is named.
    """
    if unproved:
        return NAME, f"the claim that it rests on is not proved: {in_words(unproved).name}"
    if law is None:
        reasons = [f"wind {_span(*ends)} m/s: {why}" if ends else why for ends, why in failures]
        left = len(reasons) - MOST_REASONS
        more = f" (+{left} more)" if left > 0 else ""
        return NAME, "not proved: " + "; ".join(reasons[:MOST_REASONS]) + more
    return NAME, _statement(cells, fed, data, law, step, where, kept)


def _statement(
    cells: Sequence[Any],
    fed: Sequence[bool],
    data: Any,
    law: Law,
    step: Fraction,
    where: str,
    kept: Fraction | None,
) -> str:
    pitch, torque = ([number(c, f"{name}_rate", where) for c in cells] for name in ACTUATORS)
    most, own = (number(data["model"], f"{name}_rate_limit", "model") for name in ACTUATORS)
    fed_cells = [cell for cell, is_fed in zip(cells, fed, strict=True) if is_fed]
    bends = [number(cell, "schedule_bend", where) for cell in fed_cells]
    turning = ""
    if bends:
        held = (
            "NOT for every wind of the wind class"
            if kept is None
            else "as in every wind of the claim on the wind's rate, which keeps it at most "
            f"{at_most(kept, 3)} m/s^3"
        )
        turning = (
            f" (where it is fed the schedule wind's rate, in {len(bends)} of them, while |v_s''| "
            f"is at most {at_least(min(bends), 3)} m/s^3, {held})"
        )
    within = [k for k, one in enumerate(torque) if one <= own]
    # A limit is rounded down; a value stated to be below it is compared after rounding.
    limit = at_least(most, 6)
    below = sum(one < Fraction(limit) for one in pitch)
    beyond = "".join(f", NOT for {_span(*ends)} m/s" for ends in _beyond(within, law.wind))
    return (
        f"on the proved set and in its wind class, under what the claim about these assumes, of "
        f"{len(cells)} wind cells: pitch moves at most "
        f"at {at_most(max(pitch), 6)} rad/s, and in {below} stays below the drive's limit of "
        f"{limit} rad/s; the torque asked for moves, between the law's wind nodes, at most at "
        f"{at_most(max(torque), 4)} N m/s{turning}, and in {len(within)} within the turbine's "
        f"limit of {exactly(own)} N m/s{beyond}; it steps by "
        f"at most {at_most(step, 4)} N m where the schedule wind passes a node"
    )


def _beyond(within: list[int], wind: list[Fraction]) -> list[list[Fraction]]:
    """Return the winds of the other cells, with adjacent cells joined."""
    found: list[list[Fraction]] = []
    for k, (low, high) in enumerate(pairwise(wind)):
        if k in within:
            continue
        if found and found[-1][1] == low:
            found[-1][1] = high
        else:
            found.append([low, high])
    return found


def _span(low: Fraction, high: Fraction) -> str:
    return f"{at_least(low, 6)} to {at_most(high, 6)}"
