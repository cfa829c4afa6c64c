"""What a turbine's design runs before anything about the whole loop is proved: law and observer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.certificates.design.turbine.result import ObserverDesign
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.models.errors import ModelError
from takagi.models.turbine.data import Turbine

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw

OBSERVER_DECAY = 0.05


def wind_observer_design(turbine: Turbine, asked: DesignSettings) -> ObserverDesign:
    """Return the wind observer with one gain for all winds.

    Raises
    ------
    ModelError : winds at which more wind does not give more torque, or no such gain.
    """
    from takagi.lmi.gains.observer import observer
    from takagi.models.turbine.wind_observer import WindObserver, wind_observer_model

    model = wind_observer_model(turbine, speed_setpoint=asked.speed_setpoint)
    design = observer(model, decay_rate=OBSERVER_DECAY, relaxation="common-gain")
    if design.gains is None:
        raise ModelError(f"wind observer: {design.answer.diagnosis}")
    l1, l2 = (round(float(gain), 4) for gain in design.gains[0, :, 0])
    return ObserverDesign(model, (l1, l2), OBSERVER_DECAY, WindObserver(turbine, l1, l2))


def wind_by_wind_law(
    turbine: Turbine, asked: DesignSettings
) -> tuple[EffortDesign, EffortSharingLaw]:
    """Return the effort-sharing law with gains found wind by wind, and what they were found for.

    Raises
    ------
    ModelError : no trim or no gain at some wind; names it.
    """
    from takagi.lmi.turbine.effort import effort_gains
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.laws.effort_sharing.schedule import effort_schedule

    schedule = effort_schedule(
        turbine,
        overlap=asked.overlap,
        effectiveness_share=asked.effectiveness_share,
        speed_setpoint=asked.speed_setpoint,
    )
    effort = effort_gains(turbine, schedule, asked.effort)
    law = EffortSharingLaw.of(turbine, schedule, effort.gains, wind_filter=asked.wind_filter)
    return effort, law
