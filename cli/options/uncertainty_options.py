"""Options for the uncertainty of a turbine's certificate: inertia, power coefficient, wake."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.intervals.interval import Interval
    from takagi.models.laws.effort_sharing.loop_cell import LoopUncertainty

# Options that only the effort-sharing law has.
OF_UNCERTAINTY = ("inertia", "power_coefficient", "equilibrium_wake")

Inertia = Annotated[
    tuple[str, str] | None,
    typer.Option(
        metavar="LOW HIGH",
        help="Turbines: true over nominal inertia that gains and certificate must cover; 0.9 1.1 "
        "unless given. Effort-sharing law.",
    ),
]
PowerCoefficient = Annotated[
    tuple[str, str] | None,
    typer.Option(
        metavar="LOW HIGH",
        help="Turbines: true over tabulated power coefficient that the certificate must cover, "
        "such as 0.99 1.01; the table's own unless given. Effort-sharing law.",
    ),
]
EquilibriumWake = Annotated[
    bool,
    typer.Option(
        "--equilibrium-wake",
        help="Turbines: leave the frozen wake out of the pitch effectiveness that the certificate "
        "covers: a larger wind class, for a smaller family of plants.",
    ),
]


def uncertainty_asked(
    inertia: tuple[str, str] | None,
    power_coefficient: tuple[str, str] | None,
    equilibrium_wake: bool,
) -> LoopUncertainty:
    """Return the uncertainty that the certificate must cover.

    Raises
    ------
    ModelError : an inertia or a power coefficient that is not an interval around 1.
    """
    from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_UNCERTAINTY
    from takagi.models.laws.effort_sharing.loop_cell import LoopUncertainty

    default = DEFAULT_UNCERTAINTY
    span, power = default.inertia, default.power_coefficient
    if inertia is not None:
        span = _around_one("inertia", inertia)
    if power_coefficient is not None:
        power = _around_one("power-coefficient", power_coefficient)
    return LoopUncertainty(span, frozen_wake=not equilibrium_wake, power_coefficient=power)


def _around_one(option: str, written: tuple[str, str]) -> Interval:
    """Return the interval; its ends are exactly the typed decimals, without a float."""
    from takagi.models.intervals.interval import Interval

    try:
        span = Interval.of(*written)
    except ModelError as error:
        raise ModelError(f"option --{option}: {error}") from error
    if not 0 < span.lower <= 1 <= span.upper:
        raise ModelError(
            f"option --{option}: {written[0]} {written[1]} was given; 0 < LOW <= 1 <= HIGH is "
            "needed, relative to the model's own"
        )
    return span
