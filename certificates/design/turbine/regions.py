"""The two regions of a turbine: a Takagi-Sugeno model and gains for each of them."""

from __future__ import annotations

from takagi.certificates.design.step_clock import StepClock
from takagi.certificates.design.turbine.scale import region_requirements
from takagi.lmi.turbine.regional import RegionalGains, regional_gains
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.full_load import full_load_model
from takagi.models.turbine.partial_load import partial_load_model


def regional_design(
    turbine: Turbine, *, speed_setpoint: float | None = None, clock: StepClock | None = None
) -> tuple[TSModel, TSModel, RegionalGains]:
    """Return the models of partial and full load, and the gains of both regions.

    Parameters
    ----------
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.
    clock : reports each step and measures its time; None for neither.

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
