"""Name and sentence of a claim about the loop with a published law, proved or not."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.turbine.published.inputs import Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.loop import Ends, Loop, interpolated
from takagi.certificates.checker.turbine.rotor import Plant, Span
from takagi.certificates.checker.turbine.turbine_claim import merged
from takagi.certificates.checker.words.rounded import (
    at_least,
    at_most,
    exactly,
    range_within,
)

MOST_LISTED, MOST_NAMED = 12, 4
FEW_SPANS = 3
MOST_SPANS = 40
# Just below 2 degrees.
NEAR_PITCH = Fraction(349, 10000)
# A set that is proved, and its decay rate.
ProvedSet = tuple[Ends, Fraction]


def loop_name(law: PublishedLaw, overlaps: Overlaps, winds: list[Span]) -> str:
    """Return the claim's name, from checked numbers."""
    spans, shown = merged(winds), f"Schulte's law, {_words(overlaps)}, "
    if len(spans) <= MOST_NAMED:
        return f"{shown}winds {winds_words(spans)} m/s"
    hull = winds_words([(spans[0][0], spans[-1][1])])
    return f"{shown}{len(spans)} windows within {hull} m/s"


def _words(overlaps: Overlaps) -> str:
    return (
        f"speed overlap {exactly(overlaps.width)} rad/s, "
        f"torque overlap {exactly(overlaps.torque)} N m"
    )


def winds_words(spans: list[Span]) -> str:
    """Return ranges of winds, rounded so that none is wider than the exact one."""
    if len(spans) > FEW_SPANS and len({high - low for low, high in spans}) == 1:
        return _windows([low for low, _ in spans], spans[0][1] - spans[0][0])
    shown = [range_within(low, high, 8) for low, high in spans[:MOST_SPANS]]
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


def loop_sentence(
    plant: Plant,
    law: PublishedLaw,
    overlaps: Overlaps,
    proved: Sequence[ProvedSet],
    missing: list[Span],
    reasons: list[str],
) -> str:
    """Return for which winds the claim is proved, and why not for others.

    Parameters
    ----------
    missing : winds of the claim that no proved set covers.
    reasons : the winds of each cell that is not proved, and why.
    """
    changed = (
        "" if overlaps == law.overlaps else " (the law with these overlaps in place of its own)"
    )
    if not proved:
        parts = [f"proved at no wind for {_words(overlaps)}{changed}"]
    else:
        rates = [rate for _, rate in proved]
        widths = [ends.widths[0] for ends, _ in proved]
        covered = merged([ends.wind for ends, _ in proved])
        parts = [
            f"proved for winds {winds_words(covered)} m/s with {_words(overlaps)}{changed}: at "
            f"each constant wind, v_hat = v, one equilibrium in a stated set (speed within "
            f"{at_most(min(widths), 3)} to {at_most(max(widths), 3)} rad/s), reached from all of "
            f"it at no less than {at_least(min(rates), 3)} to {at_least(max(rates), 3)} 1/s (by "
            f"wind, {len(proved)} cells)",
            _rest(plant, law, overlaps, [ends for ends, _ in proved]),
            "assumed: pitch not below its lower limit, no lag of torque, a pitch drive of first "
            "order, no states of wake, shaft, tower and blades, a law in continuous time",
        ]
    if missing:
        parts.append(f"not proved: {winds_words(missing)} m/s, where no stated cell holds")
    return "; ".join([*parts, *reasons[:MOST_LISTED]])


def _rest(plant: Plant, law: PublishedLaw, overlaps: Overlaps, proved: Sequence[Ends]) -> str:
    """Return a bound of the distance between equilibrium and trim, from the proved sets."""
    error = 0
    for ends in proved:
        loop = Loop(plant, law, overlaps, ends, "none")
        error = max(error, loop.error.value.magnitude())
    share = 100 * Fraction(error, ONE) / plant.rated_speed
    words = f"there the speed is within {at_most(share, 3)} % of rated of its reference"
    far = [ends.wind for ends in proved if not _near_trim_pitch(law, ends)]
    near = "pitch within 2 deg of the trim tables' (lines between nodes, held beyond them)"
    return f"{words}, {near}" + (f" except at {winds_words(merged(far))} m/s" if far else "")


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
