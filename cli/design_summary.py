"""What a finished design says of itself on the terminal: verdict, winds, class, consequences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from takagi.certificates.turbine_design import TurbineDesign

__all__ = ["as_data", "as_text"]


def as_data(design: TurbineDesign) -> dict[str, Any]:
    """Return the summary as plain data: verdict, claims, and for the coherent law its numbers."""
    claims = [
        {"name": claim.name, "verdict": claim.verdict.name, "text": claim.text}
        for claim in design.checked.claims
    ]
    return {
        "model": design.turbine.name,
        "law": design.settings.law,
        "verdict": design.checked.verdict.name,
        "claims": claims,
        **_coherent(design),
        "seconds": {step: round(spent, 2) for step, spent in design.seconds.items()},
    }


def as_text(design: TurbineDesign) -> str:
    """Return the summary in a few lines; a claim that is not proved is quoted in full."""
    verdict = design.checked.verdict.name
    head = f"{verdict}  {design.turbine.name}, law {design.settings.law}"
    numbers = _coherent(design)
    if verdict != "PROVED" or not numbers:
        claims = [f"  {c.verdict.name}  {c.name}: {c.text}" for c in design.checked.claims]
        return "\n".join([head, *claims])
    rows = {
        "winds": "{:g} to {:g} m/s".format(*numbers["wind"]) + f" in {numbers['cells']} cells",
        "wind class": _wind_class(numbers),
        "plants": _plants(numbers),
        "overspeed": f"at most {numbers['overspeed_percent']:.2f} % of rated speed, from any "
        "start in the certified set",
        "settling": f"decay at least {numbers['decay_rate']:.3g} 1/s while the wind is constant",
    }
    width = max(map(len, rows))
    return "\n".join([head, *(f"  {name:<{width}}  {text}" for name, text in rows.items())])


def _wind_class(numbers: Mapping[str, Any]) -> str:
    error, rate = numbers["wind_error"], numbers["wind_rate"]
    return (
        f"schedule wind within {error[0]:.2g} to {error[1]:.2g} m/s of the wind, moving at "
        f"{rate[0]:.2g} to {rate[1]:.2g} m/s^2 at most, depending on the wind"
    )


def _plants(numbers: Mapping[str, Any]) -> str:
    wake = "up to the frozen wake's" if numbers["frozen_wake"] else "of the equilibrium wake"
    return "inertia {:g} to {:g} of nominal, pitch effectiveness ".format(*numbers["inertia"]) + wake


def _coherent(design: TurbineDesign) -> dict[str, Any]:
    """Return the numbers of the coherent claim as the certificate states them, or nothing."""
    claims = [c for c in design.document["claims"] if c["kind"] == "coherent-loop"]
    if not claims:
        return {}
    claim, speeds = claims[0], design.document["gains"]["rotor_speed"]
    cells = claim["cells"]
    top = max(speeds) + claim["peaks"]["speed_error"]
    return {
        "wind": [cells[0]["wind"][0], cells[-1]["wind"][1]],
        "cells": len(cells),
        "wind_error": _span(cells, "wind_error"),
        "wind_rate": _span(cells, "wind_rate"),
        "inertia": claim["uncertainty"]["inertia"],
        "frozen_wake": claim["uncertainty"]["frozen_wake"],
        "overspeed_percent": 100 * (top / design.turbine.rated_rotor_speed - 1),
        "decay_rate": min(cell["decay_rate"] for cell in cells),
    }


def _span(cells: list[Mapping[str, Any]], name: str) -> list[float]:
    values = [cell[name] for cell in cells]
    return [min(values), max(values)]
