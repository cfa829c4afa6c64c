"""What the regional models share: from symbols, an operating band and premises to a TSModel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from takagi.models.equations.equations import Equations, Factored
from takagi.models.equations.step import Step
from takagi.models.intervals.interval import exact
from takagi.models.sector.assembly import assemble
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import OperatingBand

SPEED_ERROR = "rotor speed error [rad/s]"
INTEGRAL = "integral of speed deficit [rad]"
PITCH_DEVIATION = "pitch deviation [rad]"
WIND_DEVIATION = "wind deviation [m/s]"
WIND_ESTIMATE = "wind estimate [m/s]"
SOURCE = (
    "sector nonlinearity: Tanaka and Wang (2001), section 2.2; regional schemes: Schulte (2024), "
    "Coherent Design of Wind Turbine Controllers, section II"
)


@dataclass(frozen=True, slots=True, eq=False)
class RegionalPlant:
    """A regional plant in symbols, its factored form, and the names with units."""

    plant: Equations
    factored: Factored
    names: Mapping[str, tuple[str, ...]]
    steps: tuple[Step, ...]


def region_model(
    region: RegionalPlant, band: OperatingBand, premises: tuple[Premise, ...], *, name: str
) -> TSModel:
    """Return the TSModel of a region over its band, after the symbolic check of exactness."""
    return assemble(
        region.plant,
        region.factored,
        premises,
        steps=region.steps,
        names=region.names,
        box=band_box(band),
        name=name,
        source=f"{band.turbine.name}; {SOURCE}",
    )


def band_box(band: OperatingBand) -> dict[str, tuple[Fraction, Fraction]]:
    """Return the tube as a box in the deviations from the trim and in the wind estimate."""
    box = {SPEED_ERROR: (-band.speed_band, band.speed_band)}
    if band.pitch_band:
        box[PITCH_DEVIATION] = (-band.pitch_band, band.pitch_band)
    box[WIND_DEVIATION] = (-band.wind_band, band.wind_band)
    box[WIND_ESTIMATE] = (band.wind_range.lower, band.wind_range.upper)
    return box


def inertia_value(turbine: Turbine) -> Fraction:
    """Return J = J_r + n_g^2 J_g from the decimals of the turbine's figures [kg m^2]."""
    at_rotor = exact(turbine.gear_ratio) ** 2 * exact(turbine.generator_inertia)
    return exact(turbine.rotor_inertia) + at_rotor
