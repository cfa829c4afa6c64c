"""The claim about the effort-sharing loop in numbers, cell by cell, read from the certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.result import Claim, Verdict

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

KIND, RUNNING = "coherent-loop", "running-loop"


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


def running_loop_summary(design: TurbineDesign) -> tuple[float, str] | None:
    """Return decay rate [1/s] and winds, with every gap, of the loop with its observer.

    None where no such claim is proved.
    """
    for stated, checked in zip(design.document["claims"], design.checked.claims, strict=False):
        if stated["kind"] == RUNNING and checked.verdict is Verdict.PROVED:
            return float(stated["decay_rate"]), checked.name.partition(", ")[2]
    return None


def _summary(
    stated: Mapping[str, Any], checked: Claim, fastest: float, rated_speed: float
) -> ClaimSummary:
    cells = stated["cells"]
    decays = tuple(float(cell["decay_rate"]) for cell in cells)
    low, high = stated["uncertainty"]["inertia"]
    least, most = stated["uncertainty"].get("power_coefficient", (1.0, 1.0))
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
        power_coefficient=(float(least), float(most)),
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
