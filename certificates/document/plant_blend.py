"""A plant with a blend of two actuators, in a certificate: the blend, and the claim about it.

The model of the certificate is the blended plant, with the share of the high actuator and the
errors of both as signals; the claim ``effort-blend`` ties it to the plant with its two actuators.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from takagi.certificates.document.plant_text import number_data, text_data
from takagi.models.blending.blending import EFFORT, RATE, SHARE

if TYPE_CHECKING:
    from takagi.models.blending.blending import Actuator, Blending
    from takagi.models.ts.model import TSModel


def blend_of(model: TSModel) -> Blending | None:
    """Return the blend of the plant that a model was derived from; None if it has none."""
    from takagi.models.blending.blending import blending_of

    form = None if model.derivation is None else model.derivation.form
    return None if form is None or form.plant is None else blending_of(form.plant)


def unknown_premises(model: TSModel) -> list[bool]:
    """Return, for each premise, whether it depends on what a law does not know.

    That is an actuator's error, or an uncertain parameter.
    """
    form = None if model.derivation is None else model.derivation.form
    if form is None or form.plant is None:
        return [False] * len(model.premises)
    blending, pushes = blend_of(model), form.problem.equations.disturbances
    unknown = {
        str(symbol)
        for variable, symbol in zip(form.plant.disturbances, pushes, strict=True)
        if variable.unknown
    }
    if blending is not None:
        unknown |= {a.error_name for a in blending.actuators if a.error}
    expressions = form.factored.premises.values()
    return [bool(unknown & {str(s) for s in e.free_symbols}) for e in expressions]


def blend_data(blending: Blending) -> dict[str, Any]:
    """Return the member ``blending`` of a certificate's model and law; numbers in SI."""
    plant = blending.plant
    return {
        "effort": EFFORT,
        "rate": RATE,
        "share": SHARE,
        "unit": blending.effort.unit,
        "overlap": number_data(blending.overlap),
        "low": _actuator(blending.low),
        "high": _actuator(blending.high),
        "equations": [text_data(row) for row in plant.equations],
    }


def blend_claim(model: TSModel) -> dict[str, Any]:
    """Return the claim without evidence: the checker bounds effectiveness by its own search."""
    name = f"{model.name or 'the plant'} behind its blend, with both actuators within their limits"
    return {"name": name, "kind": "effort-blend"}


def _actuator(actuator: Actuator) -> dict[str, Any]:
    side = actuator.variable.range
    return {
        "input": actuator.name,
        "unit": actuator.variable.unit,
        "direction": actuator.direction,
        "effectiveness": text_data(actuator.effectiveness),
        "idle": number_data(actuator.variable.rest),
        "range": None if side is None else [number_data(side.lower), number_data(side.upper)],
        "error": actuator.error_name if actuator.error else None,
    }
