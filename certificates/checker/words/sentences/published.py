"""What a claim of kind ``paper-loop`` says, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.published.inputs import Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.loop import Ends, Loop, interpolated
from takagi.certificates.checker.turbine.published.loop_claim import Cell
from takagi.certificates.checker.turbine.wind_intervals import Span, merged
from takagi.certificates.checker.words.law_words import law_words
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly

MOST_LISTED, MOST_NAMED = 12, 4
FEW_SPANS = 3
MOST_SPANS = 40
# Just below 2 degrees.
NEAR_PITCH = Fraction(349, 10000)


def said(
    plant: Plant,
    law: PublishedLaw,
    overlaps: Overlaps,
    winds: list[Span],
    proved: Sequence[Cell],
    covered: list[Span],
    missing: list[Span],
    failures: Sequence[tuple[Span, str]],
    left: list[Span],
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    winds : of the claim;  covered, missing : those for which it holds, and the others.
    failures : the winds of a cell, and the property that is not proved.
    left : winds that the file names as not proved and does not claim.
    """
    reasons = [f"{_shown([wind])} m/s: {why}" for wind, why in failures]
    text = _statement(plant, law, overlaps, proved, covered, missing, reasons)
    if left:
        text += f"; looked at but not claimed: {_shown(left)} m/s"
    return _name(law, overlaps, winds), text


def _name(law: PublishedLaw, overlaps: Overlaps, winds: list[Span]) -> str:
    spans = merged(winds)
    if len(spans) <= MOST_NAMED:
        return f"{law_words(law.name)}, {_words(overlaps)}, winds {_shown(spans)} m/s"
    return (
        f"{law_words(law.name)}, {_words(overlaps)}, {len(spans)} windows within "
        f"{_shown([(spans[0][0], spans[-1][1])])} m/s"
    )


def _words(overlaps: Overlaps) -> str:
    return (
        f"speed overlap {exactly(overlaps.width)} rad/s, "
        f"torque overlap {exactly(overlaps.torque)} N m"
    )


def _shown(spans: list[Span]) -> str:
    """Return ranges, rounded so that none is wider than the exact one."""
    if len(spans) > FEW_SPANS and len({high - low for low, high in spans}) == 1:
        return _windows([low for low, _ in spans], spans[0][1] - spans[0][0])
    shown = [f"{at_most(low, 8)} to {at_least(high, 8)}" for low, high in spans[:MOST_SPANS]]
    more = f" (+{len(spans) - MOST_SPANS} more)" if len(spans) > MOST_SPANS else ""
    return ", ".join(shown) + more


def _windows(starts: list[Fraction], width: Fraction) -> str:
    """Return windows of equal width by their lower ends; evenly spaced ones are grouped.

    Lower ends and steps are not rounded, because a shifted window would be a different one.
    """
    runs: list[list[Fraction]] = []
    for start in starts:
        run = runs[-1] if runs else []
        if len(run) == 1 or (len(run) > 1 and start - run[-1] == run[1] - run[0]):
            run.append(start)
        else:
            runs.append([start])
    shown = [
        f"{exactly(run[0])} to {exactly(run[-1])} in steps of {exactly(run[1] - run[0])}"
        if len(run) > 2
        else ", ".join(exactly(start) for start in run)
        for run in runs
    ]
    return f"in windows {at_least(width, 3)} m/s wide from {', '.join(shown)}"


def _statement(
    plant: Plant,
    law: PublishedLaw,
    overlaps: Overlaps,
    proved: Sequence[Cell],
    covered: list[Span],
    missing: list[Span],
    reasons: list[str],
) -> str:
    changed = (
        "" if overlaps == law.overlaps else " (the law with these overlaps in place of its own)"
    )
    if not proved:
        parts = [f"proved at no wind for {_words(overlaps)}{changed}"]
    else:
        rates = [cell.rate for cell in proved]
        widths = [cell.ends.widths[0] for cell in proved]
        parts = [
            f"proved for winds {_shown(covered)} m/s with {_words(overlaps)}{changed}: at each "
            f"constant wind, v_hat = v, one equilibrium in a stated set (speed within "
            f"{at_most(min(widths), 3)} to {at_most(max(widths), 3)} rad/s), reached from all of "
            f"it at no less than {at_least(min(rates), 3)} to {at_least(max(rates), 3)} 1/s (by "
            f"wind, {len(proved)} cells)",
            _rest(plant, law, overlaps, proved),
            "assumed: pitch not below its lower limit, no lag of torque, a pitch drive of first "
            "order, no states of wake, shaft, tower and blades, a law in continuous time",
        ]
    if missing:
        parts.append(f"not proved: {_shown(missing)} m/s, where no stated cell holds")
    return "; ".join([*parts, *reasons[:MOST_LISTED]])


def _rest(plant: Plant, law: PublishedLaw, overlaps: Overlaps, proved: Sequence[Cell]) -> str:
    """Return a bound of the distance between equilibrium and trim, from the proved sets."""
    error = 0
    for cell in proved:
        loop = Loop(plant, law, overlaps, cell.ends, "none")
        error = max(error, loop.error.value.magnitude())
    share = 100 * Fraction(error, ONE) / plant.rated_speed
    words = f"there the speed is within {at_most(share, 3)} % of rated of its reference"
    far = [cell.ends.wind for cell in proved if not _near_trim_pitch(law, cell.ends)]
    near = "pitch within 2 deg of the trim tables' (lines between nodes, held beyond them)"
    return f"{words}, {near}" + (f" except at {_shown(merged(far))} m/s" if far else "")


def _near_trim_pitch(law: PublishedLaw, ends: Ends) -> bool:
    """Return whether pitch is close to the trim tables for these winds on the whole set.

    Both tables form one: linear between the nodes, constant beyond the ends.
    """
    low, high = law.partial, law.full
    above = [k for k, v in enumerate(high.wind) if v > low.wind[-1]]
    wind = low.wind + [high.wind[k] for k in above]
    pitch = low.pitch + [high.pitch[k] for k in above]
    line = [z[1] for z in ends.states]
    places = [*ends.wind, *(v for v in wind if ends.wind[0] < v < ends.wind[1])]
    offsets = [
        abs(interpolated(list(ends.wind), line, v) - interpolated(wind, pitch, v)) for v in places
    ]
    return max(offsets) + ends.widths[1] <= NEAR_PITCH
