"""The models and gains of both regions; from them a published law and the claims about it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.claims.turbine.loop_claims import published_bumpless_claim
from takagi.certificates.claims.turbine.published import published_candidate, published_claim
from takagi.certificates.design.design import StepClock
from takagi.certificates.design.turbine.scale import region_requirements
from takagi.certificates.document.certificate_file import (
    certificate_document,
    provenance,
    published_law_data,
    turbine_data,
)
from takagi.lmi.turbine.regional import RegionalGains, regional_gains
from takagi.models.arrays import Floats
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.region_models import full_load_model, partial_load_model

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.settings import DesignSettings
    from takagi.models.laws.published.law import PublishedLaw
    from takagi.models.laws.published.regional_schedule import Variant

# Decimals of the emitted gains: N m s/rad and N m/rad; s, - and 1/rad.
TORQUE_DIGITS, PITCH_DIGITS = 1, 6


def claimed_law(
    turbine: Turbine,
    settings: DesignSettings,
    models: tuple[TSModel, TSModel, RegionalGains],
    files: Sequence[Path],
    clock: StepClock,
) -> tuple[PublishedLaw, Callable[[], dict[str, Any]]]:
    """Return the law that ``asked.law`` names, and a function that returns its certificate.

    Raises
    ------
    ModelError : a region without gains (the diagnosis says why), or overlaps that do not fit.
    """
    with clock("Schulte's law"):
        law = designed_law(turbine, settings, models)
    with clock("joint analysis, wind by wind"):
        candidate = published_candidate(law)

    def stated() -> dict[str, Any]:
        model, gains = turbine_data(turbine, files), published_law_data(law)
        claims = [published_claim(candidate)]
        if not candidate.unproved:
            # With a wind that is left out the claim about the loop is not proved.
            claims.append(published_bumpless_claim(model, gains, claims[0]))
        return certificate_document(
            model=model,
            gains=gains,
            claims=claims,
            provenance=provenance(settings, {"joint analysis": "Lyapunov equations, no solver"}),
            files=files,
        )

    return law, stated


def designed_law(
    turbine: Turbine,
    settings: DesignSettings,
    models: tuple[TSModel, TSModel, RegionalGains],
    variant: Variant = "saturated",
) -> PublishedLaw:
    """Return the law with emitted decimals as gains, equal at the two corners of the premise d.

    That premise changes no input alone, so the gains at its two corners agree up to the solver's
    tolerance; their mean is used.
    """
    from takagi.models.laws.published.law import published_law
    from takagi.models.laws.published.regional_schedule import coupling_filter, regional_schedule

    low, high, regional = models
    schedules = []
    for model, region, digits in (
        (low, regional.partial, TORQUE_DIGITS),
        (high, regional.full, PITCH_DIGITS),
    ):
        k_x, k_I = region.require()
        schedules.append(
            regional_schedule(
                turbine,
                model,
                k_x=_emitted(k_x, model, digits),
                k_I=_emitted(k_I[:, None], model, digits)[:, 0],
                speed_setpoint=settings.speed_setpoint,
            )
        )
    return published_law(
        turbine,
        partial=schedules[0],
        full=schedules[1],
        coupling=coupling_filter(
            turbine,
            variant=variant,
            speed_overlap=settings.speed_overlap,
            torque_overlap=settings.torque_overlap,
            placement=settings.ramp_placement,
            shape=settings.ramp_shape,
            speed_setpoint=settings.speed_setpoint,
        ),
        speed_setpoint=settings.speed_setpoint,
    )


def _emitted(gains: Floats, model: TSModel, digits: int) -> Floats:
    """Return gains rounded, and alike for rules that differ in their last premise alone."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for i, rule in enumerate(model.rules):
        groups.setdefault(tuple(rule[:-1]), []).append(i)
    rounded = np.array(gains, dtype=np.float64)
    for rows in groups.values():
        rounded[rows] = np.round(rounded[rows].mean(axis=0), digits)
    return rounded


def regional_design(
    turbine: Turbine, *, speed_setpoint: float | None = None, clock: StepClock | None = None
) -> tuple[TSModel, TSModel, RegionalGains]:
    """Return the models of partial and full load, and the gains of both regions.

    ``speed_setpoint`` is the de-rated rotor speed [rad/s]; None takes the rated speed.

    Raises
    ------
    ModelError : a set-point outside the turbine's range.
    """
    step = clock or StepClock(None)
    with step("partial-load model"):
        low = partial_load_model(turbine, speed_setpoint=speed_setpoint)
    with step("full-load model"):
        high = full_load_model(turbine, speed_setpoint=speed_setpoint)
    with step("regional gains"):
        partial_load, full_load = region_requirements(turbine)
        gains = regional_gains(
            turbine,
            partial_load=partial_load,
            full_load=full_load,
            partial_model=low,
            full_model=high,
            speed_setpoint=speed_setpoint,
        )
    return low, high, gains
