"""What a finished design says of itself on the terminal: verdict, winds, class, consequences."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import pi
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from takagi.certificates.checker.result import Checked
    from takagi.certificates.turbine_design import TurbineDesign
    from takagi.reports.claim_summary import ClaimSummary

__all__ = ["as_data", "as_text", "claims_as_data", "claims_as_text"]


def as_data(design: TurbineDesign) -> dict[str, Any]:
    """Return the summary as plain data: verdict, claims, and for the coherent law its numbers."""
    from takagi.reports.claim_summary import claim_summary

    found = claim_summary(design)
    return {
        "model": design.turbine.name,
        "law": design.settings.law,
        **claims_as_data(design.checked),
        **({} if found is None else _numbers(found)),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: TurbineDesign) -> str:
    """Return the summary in a few lines; a claim that is not proved is quoted in full."""
    from takagi.reports.claim_summary import claim_summary

    verdict = design.checked.verdict.name
    head = f"{verdict}  {design.turbine.name}, law {design.settings.law}"
    found = claim_summary(design)
    if verdict != "PROVED" or found is None:
        return "\n".join([head, claims_as_text(design.checked)])
    rows = {
        "winds": f"{found.edges[0]:g} to {found.edges[-1]:g} m/s in {len(found.winds)} cells",
        "wind class": f"schedule wind within {_span(found.wind_error)} m/s of the wind, moving at "
        f"most {_span(found.wind_rate)} m/s^2, depending on the wind",
        "plants": _plants(found),
        "rotor speed": _speed(design, found),
        "settling": f"decay of at least {_down(found.common_rate)} 1/s while the wind is constant",
    }
    width = max(map(len, rows))
    return "\n".join([head, *(f"  {name:<{width}}  {text}" for name, text in rows.items())])


def claims_as_text(checked: Checked) -> str:
    """Return one line per claim, as `takagi check` prints them."""
    width = max((len(claim.verdict.name) for claim in checked.claims), default=0)
    return "\n".join(
        f"  {claim.verdict.name:<{width}}  {claim.name}: {claim.text}" for claim in checked.claims
    )


def claims_as_data(checked: Checked) -> dict[str, Any]:
    """Return verdict and claims as plain data."""
    claims = [
        {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
        for claim in checked.claims
    ]
    return {"verdict": checked.verdict.name, "claims": claims}


def _numbers(found: ClaimSummary) -> dict[str, Any]:
    return {
        "wind": [found.edges[0], found.edges[-1]],
        "cells": len(found.winds),
        "wind_error": [min(found.wind_error), max(found.wind_error)],
        "wind_rate": [min(found.wind_rate), max(found.wind_rate)],
        "inertia": list(found.inertia),
        "frozen_wake": found.frozen_wake,
        "overspeed": found.overspeed,
        "decay_rate": found.common_rate,
    }


def _span(values: Sequence[float]) -> str:
    return f"{_down(min(values))} to {_down(max(values))}"


def _down(value: float) -> str:
    """Return three digits that do not promise more than the value."""
    from takagi.certificates.checker.shown import at_least

    return at_least(Fraction(repr(value)), 3)


def _plants(found: ClaimSummary) -> str:
    wake = "up to the frozen wake's" if found.frozen_wake else "of the equilibrium wake"
    low, high = found.inertia
    return f"inertia {low:g} to {high:g} of nominal, pitch effectiveness {wake}"


def _speed(design: TurbineDesign, found: ClaimSummary) -> str:
    from takagi.certificates.checker.shown import at_most

    side = "above" if found.overspeed >= 0 else "below"
    top = (1 + found.overspeed) * design.turbine.rated_rotor_speed * 30 / pi
    share = at_most(Fraction(100 * found.overspeed), 3).removeprefix("-")
    return (
        f"at most {at_most(Fraction(top), 4)} rpm, {share} % {side} rated, from any start in the "
        "certified set"
    )
