"""Weaker claims for given gains if the plant's whole box is not proved: smaller ranges, lower rate.

The gains are not changed.  All ranges of states are multiplied by one factor about rest.  A decay
that is proved on a box holds on every smaller box, so bisection finds the largest factor.  The
sentence states a factor that was proved, not an estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.claims.certification import certify
from takagi.certificates.design.design import Tell
from takagi.certificates.design.given.kept_model import law_for
from takagi.certificates.design.plant.tracking_design import range_in_words
from takagi.certificates.requests.decay import Decay
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import Plant, Variable, rate_in_file_units

# Factors are multiples of this: five proofs find the factor to 3 % of the whole box.
FINEST = Fraction(1, 32)
# With more rules than this each of the proofs may take half a minute.
MOST_RULES = 64


@dataclass(frozen=True, slots=True)
class LargestChange:
    """The largest claims that are proved with unchanged gains.

    Attributes
    ----------
    rate : largest decay rate [1/s] found on the whole box; None if none is proved there.
    share : largest factor on the ranges of the states in which decay is proved; 1 for the whole
        box, 0 if not even ``FINEST`` of it.
    share_rate : decay rate [1/s] that is proved in it.
    """

    rate: float | None
    share: Fraction
    share_rate: float | None


def largest_change(
    plant: Plant,
    path: Path,
    settings: PlantSettings,
    *,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
) -> LargestChange | None:
    """Return the largest claims for the gains of a file; None if they are not searched.

    They are not searched for a plant with [blending] or measured outputs, or without a range of
    any state.

    Raises
    ------
    CertificateError : the gain file is not for this plant.
    """
    ranges = any(v.range is not None for v in plant.states)
    if plant.blending is not None or plant.measured is not None or not ranges:
        return None
    full_rate = _rate(plant, path, settings, files, Fraction(1))
    if full_rate is None:
        return None
    if full_rate > 0:
        return LargestChange(full_rate, Fraction(1), full_rate)
    proved_share, failing_share, best = Fraction(0), Fraction(1), None
    while failing_share - proved_share > FINEST:
        middle = (proved_share + failing_share) / 2
        if tell is not None:
            tell(f"ranges of states times {float(middle):.3g}")
        rate = _rate(plant, path, settings, files, middle)
        if rate:
            proved_share, best = middle, rate
        else:
            failing_share = middle
    return LargestChange(None, proved_share, best)


def as_sentences(change: LargestChange, plant: Plant, settings: PlantSettings) -> list[str]:
    """Return the claims in words, with ranges and rates in the units of the plant's file."""
    required_rate = settings.decay_rate if isinstance(settings.decay_rate, float | int) else None
    if change.rate is not None:
        number, unit = rate_in_file_units(plant, change.rate)
        if required_rate is None or required_rate <= change.rate:
            return [f"with these gains a decay of {number:.4g} {unit} is proved on the whole box"]
        required, its_unit = rate_in_file_units(plant, required_rate)
        return [
            f"the plant's file asks for a decay rate of {required:.4g} {its_unit}; with these "
            f"gains {number:.4g} {unit} is proved on the whole box: ask for less in [design], or "
            "design gains anew"
        ]
    if not change.share or change.share_rate is None:
        return [
            f"not even with {float(FINEST):.2g} of the ranges of the states is a decay proved: "
            "these gains do not hold the new plant near its rest; design gains anew"
        ]
    number, unit = rate_in_file_units(plant, change.share_rate)
    narrower = (drawn_in(v, change.share) for v in plant.states if v.range is not None)
    sides = ", ".join(map(range_in_words, narrower))
    return [
        f"with these gains a decay of {number:.4g} {unit} is proved where the ranges of the states "
        f"are {float(change.share):.3g} times as wide about rest: {sides}. Give the states such "
        "ranges in the plant's file, or design gains anew"
    ]


def _rate(
    plant: Plant, path: Path, settings: PlantSettings, files: Sequence[Path], share: Fraction
) -> float | None:
    """Return the proved decay rate, 0 if none is proved; None if it would take too long."""
    from takagi.models.sector.model import sector_model

    smaller = plant if share == 1 else replace(
        plant, states=tuple(drawn_in(v, share) for v in plant.states)
    )  # fmt: skip
    try:
        model = sector_model(smaller, rest=settings.rest, choice=settings.choice)
        law = law_for(smaller, model, path, settings, files=files if share == 1 else ())
    except (ModelError, CertificateError):
        if share == 1:
            raise
        return 0.0
    if len(law.model.rules) > MOST_RULES:
        return None
    certificate = certify(law.model, law.gains, claims=[Decay()], law=law.law)
    if certificate.verdict is not Verdict.PROVED:
        return 0.0
    (claim,) = (c for c in certificate.document["claims"] if c["kind"] == "decay")
    return float(claim["decay_rate"])


def drawn_in(variable: Variable, share: Fraction) -> Variable:
    """Return the variable with its range times ``share`` about its rest."""
    side = variable.range
    if side is None:
        return variable
    low, high = (variable.rest + share * (end - variable.rest) for end in (side.lower, side.upper))
    return replace(variable, range=Interval(low, high))
