"""Why outputs follow no reference, and which range to narrow by how much: found by trying."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.certificates.design.plant.narrower_ranges import (
    moving_slopes,
    narrowed,
    range_in_words,
    with_ranges,
)
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.design.plant.tracking_gains import TrackingGains, tracking_gains
from takagi.models.errors import ModelError
from takagi.models.tracking import held_rests, signals_of

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant, Variable

# What is left of a range's distance from rest: the first decides whether wider ones are tried.
RANGE_SHARES = (Fraction(1, 10), Fraction(1, 2), Fraction(1, 4))


def tracking_obstacle(
    plant: Plant, settings: PlantSettings, gains: TrackingGains, *, observed: bool
) -> str:
    """Return that no set was found, and which narrower ranges have one, each by itself."""
    words = "no set was found in which outputs follow their references within the ranges"
    design = gains.gains.design
    if not design.found:
        words = "no gain was found with which all slopes of the plant in its ranges settle"
        if design.answer.diagnosis:
            words += f" ({design.answer.diagnosis})"
    groups = (_widest(plant, group, settings, observed=observed) for group in _groups(plant))
    sentences = list(filter(None, groups))
    if sentences:
        return f"{words}. A set is found with {'; or with '.join(sentences)}. Change one of these"
    return (
        f"{words}, nor with all references, disturbances and ranges at a tenth of their distances "
        "from rest, one after the other. Move the rest to where the slopes of the equations are "
        "away from 0, or ask for less (decay_rate, input_limit)"
    )


def _groups(plant: Plant) -> Iterator[list[Variable]]:
    """Yield what is narrowed together: each signal, all, and what the slopes depend on likewise."""
    for group in (list(signals_of(plant)), moving_slopes(plant)):
        for variable in group:
            yield [variable]
        if len(group) > 1:
            yield group


def _widest(plant: Plant, group: list[Variable], settings: PlantSettings, *, observed: bool) -> str:
    """Return the widest of the narrower ranges with which a set is found, in words; else empty."""
    if not _works(plant, group, RANGE_SHARES[0], settings, observed=observed):
        return ""
    wider = (s for s in RANGE_SHARES[1:] if _works(plant, group, s, settings, observed=observed))
    share = next(wider, RANGE_SHARES[0])
    return " and ".join(range_in_words(v) for v in narrowed(plant, group, share).values())


def _works(
    plant: Plant, group: list[Variable], share: Fraction, settings: PlantSettings, *, observed: bool
) -> bool:
    """Return whether a set is found if these ranges are narrowed."""
    narrow = with_ranges(plant, narrowed(plant, group, share))
    try:
        held_rests(narrow)
        model = secant_model(narrow, rest=settings.rest)
        return tracking_gains(narrow, model, settings, observed=observed, few=True).jump > 0
    except ModelError:
        # The ranges no longer hold the rests at all references.
        return False
