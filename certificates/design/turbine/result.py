"""A finished design of a turbine's controller, as a value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked
    from takagi.certificates.claims.turbine.largest_wind_error import EffortSharingCandidate
    from takagi.certificates.design.turbine.effort_sharing_gains import EffortSharingGainDesign
    from takagi.certificates.design.turbine.settings import DesignSettings
    from takagi.lmi.turbine.effort import EffortDesign
    from takagi.lmi.turbine.regional import RegionalGains
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.laws.protocol import Law
    from takagi.models.simulation.speed_filter import SpeedFilter
    from takagi.models.ts.model import TSModel
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.wind_observer import WindObserver


@dataclass(frozen=True, slots=True, eq=False)
class ObserverDesign:
    """The wind observer: its error model, its gains, and the value that runs in a simulation.

    Attributes
    ----------
    model : Takagi-Sugeno error system in the unmeasured premise dT_r/dv / J.
    gains : (l_1 [1/s], l_2 [m/s per rad]).
    decay_rate : the rate at which the error decays in constant wind [1/s].
    observer : the observer that a simulation runs.
    """

    model: TSModel
    gains: tuple[float, float]
    decay_rate: float
    observer: WindObserver


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TurbineDesign:
    """A finished design.

    Attributes
    ----------
    law : the law that is written to the gain file and simulated.
    partial_load, full_load : the regional Takagi-Sugeno models (4 and 8 rules).
    regional : PDC gains of both regions, in the structure of the published law.
    effort : the effort-sharing gains; None for the published laws.
    observer : wind observer.
    candidate : enclosures and P of the effort-sharing loop; None for the published laws.
    document : the certificate as plain data, as it is written to the file.
    checked : the verdicts of the independent checker on it.
    seconds : step -> time that it took [s].
    synthesis : the result of the effort-sharing synthesis; None for the published laws.
    notes : on numbers changed to keep margins and the margins then measured, or on stability.
    """

    turbine: Turbine
    settings: DesignSettings
    law: Law
    partial_load: TSModel
    full_load: TSModel
    regional: RegionalGains
    effort: EffortDesign | None
    observer: ObserverDesign
    candidate: EffortSharingCandidate | None
    document: Mapping[str, Any]
    checked: Checked
    seconds: Mapping[str, float] = field(default_factory=dict)
    synthesis: EffortSharingGainDesign | None = None
    notes: tuple[str, ...] = ()

    kind: ClassVar[Literal["turbine"]] = "turbine"
    is_about_plant: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """The name of the turbine."""
        return self.turbine.name

    @property
    def verdict_words(self) -> str:
        """PROVED, DISPROVED or UNDECIDED."""
        return self.checked.verdict.name

    @property
    def proved(self) -> bool:
        """Whether every claim of the certificate is proved."""
        return self.verdict_words == "PROVED"

    @property
    def speed_filter(self) -> SpeedFilter | None:
        """The filter of the measured speed before the law; None where there is none."""
        return speed_filter(self.settings)

    @property
    def effort_sharing_law(self) -> EffortSharingLaw | None:
        """The law where it is the effort-sharing law, else None."""
        from takagi.models.laws.effort_sharing.law import EffortSharingLaw

        return self.law if isinstance(self.law, EffortSharingLaw) else None


def speed_filter(settings: DesignSettings) -> SpeedFilter | None:
    """Return the filter of the measured speed that the settings ask for, or None."""
    # Imported here: reading a design needs no simulation.
    from takagi.models.simulation.speed_filter import SpeedFilter

    if settings.law != "coherent" or not settings.speed_filter:
        return None
    return SpeedFilter(settings.speed_filter, settings.torsion_filter)
