"""A finished design of a turbine's controller as a value, and its claim in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.models.arrays import ShortRepr

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked
    from takagi.certificates.claims.turbine.cell_loop import EffortSharingCandidate
    from takagi.certificates.design.turbine.effort_sharing_gains import (
        EffortSharingGainDesign,
        ObserverDesign,
    )
    from takagi.certificates.design.turbine.settings import DesignSettings
    from takagi.lmi.turbine.effort import EffortDesign
    from takagi.lmi.turbine.regional import RegionalGains
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.laws.protocol import Law
    from takagi.models.simulation.turbine_plant import SpeedFilter
    from takagi.models.ts.model import TSModel
    from takagi.models.turbine.data import Turbine


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class TurbineDesign(ShortRepr):
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
    measured : margins and simulated runs, as ``takagi.reports`` keeps them; None before that.
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
    measured: object = None

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
    from takagi.models.simulation.turbine_plant import SpeedFilter

    if not settings.speed_filter:
        return None
    return SpeedFilter(settings.speed_filter, settings.torsion_filter)


KIND = "coherent-loop"


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimSummary:
    """The claim about the effort-sharing loop in numbers.

    Attributes
    ----------
    verdict : of the independent checker.
    winds : (low, high) of each cell [m/s];  proved : whether the checker accepted the cell.
    wind_error : largest |v - v_s| [m/s];  wind_rate : largest |v_s'| [m/s^2];  decay_rates :
        [1/s]; one per cell.
    decay_rate : the smallest over all cells [1/s], for the function of the set;  common_rate : the
        largest rate of one function for all winds [1/s].
    peaks : bound on each state's modulus on the invariant set, by name.
    overspeed : bound on rotor speed above rated, relative to rated [-].
    inertia : true over nominal inertia, (low, high);   power_coefficient : true over tabulated.
    frozen_wake : whether pitch effectiveness may reach the frozen-wake value.
    P : the Lyapunov matrix, rows.
    """

    verdict: Verdict
    winds: tuple[tuple[float, float], ...]
    proved: tuple[bool, ...]
    wind_error: tuple[float, ...]
    wind_rate: tuple[float, ...]
    decay_rates: tuple[float, ...]
    decay_rate: float
    common_rate: float
    peaks: Mapping[str, float]
    overspeed: float
    inertia: tuple[float, float]
    power_coefficient: tuple[float, float]
    frozen_wake: bool
    P: tuple[tuple[float, ...], ...]

    @property
    def edges(self) -> list[float]:
        """The cells' ends [m/s], one more than there are cells."""
        return [self.winds[0][0], *(high for _, high in self.winds)]

    @property
    def hatched(self) -> str:
        """The text about hatched cells in a figure's caption, if there are any."""
        return "" if all(self.proved) else " Hatched: not proved."


def claim_summary(design: TurbineDesign) -> ClaimSummary | None:
    """Return the certificate's statements about the loop; None without such a claim."""
    for stated, checked in zip(design.document["claims"], design.checked.claims, strict=True):
        if stated["kind"] == KIND:
            law = design.document["gains"]
            rated = design.turbine.rated_rotor_speed
            return _summary(stated, checked, max(law["rotor_speed"]), rated)
    return None


def _summary(
    stated: Mapping[str, Any], checked: Claim, fastest: float, rated_speed: float
) -> ClaimSummary:
    cells = stated["cells"]
    decays = tuple(float(cell["decay_rate"]) for cell in cells)
    low, high = stated["uncertainty"]["inertia"]
    lowest_power, highest_power = stated["uncertainty"].get("power_coefficient", (1.0, 1.0))
    return ClaimSummary(
        verdict=checked.verdict,
        winds=tuple((float(cell["wind"][0]), float(cell["wind"][1])) for cell in cells),
        proved=tuple(_accepted(cell, checked) for cell in cells),
        wind_error=tuple(float(cell["wind_error"]) for cell in cells),
        wind_rate=tuple(float(cell["wind_rate"]) for cell in cells),
        decay_rates=decays,
        decay_rate=min(decays),
        common_rate=float(stated["settling"]["decay_rate"]),
        peaks={name: float(value) for name, value in stated["peaks"].items()},
        overspeed=(fastest + float(stated["peaks"]["speed_error"])) / rated_speed - 1,
        inertia=(float(low), float(high)),
        power_coefficient=(float(lowest_power), float(highest_power)),
        frozen_wake=bool(stated["uncertainty"]["frozen_wake"]),
        P=tuple(tuple(float(value) for value in row) for row in stated["P"]),
    )


def _accepted(cell: Mapping[str, Any], checked: Claim) -> bool:
    """Return whether a cell is proved; no cell is if the checker's list is truncated."""
    if checked.verdict is Verdict.PROVED:
        return True
    low, high = cell["wind"]
    named = f"wind {low:g} to {high:g} m/s:" in checked.text
    general = any(
        words in checked.text
        for words in ("set is not inside", "P is not", "common decay rate is not")
    )
    return not (named or general or " more)" in checked.text) and cell["decay_rate"] > 0
