"""Options for claims that a turbine's certificate has on request."""

from __future__ import annotations

from typing import Annotated

import typer

from takagi.models.errors import ModelError

# Options that only the effort-sharing law has.
OF_CLAIMS = ("moving_wind", "moving_wind_above_rated", "turbulence")

MovingWind = Annotated[
    bool,
    typer.Option(
        "--moving-wind",
        help="Turbines: claim also that the loop with its observer keeps a set around its "
        "operating point while the wind moves, up to a rate that is found for each wind: some "
        "minutes more. Effort-sharing law.",
    ),
]

MovingWindAboveRated = Annotated[
    bool,
    typer.Option(
        "--moving-wind-above-rated",
        help="Turbines: claim also that above rated wind the loop with its observer keeps a set "
        "around the operating point at the wind that the law works with, and stays below a rotor "
        "speed, while the wind moves several times faster than --moving-wind proves; for the "
        "NREL 5-MW turbine 0.008 m/s^2 from 12.4 m/s, 0.016 from 13.5 and 0.03 from 15.8 to "
        "23.5 m/s: ten minutes more. Effort-sharing law.",
    ),
]

Turbulence = Annotated[
    str | None,
    typer.Option(
        "--turbulence",
        metavar="CLASS",
        help="Turbines: claim also how rarely turbulence of class A, B or C drives the rotor's "
        "speed away from its reference within ten minutes, for the loop with its observer, "
        "linearised at ten mean winds, and a speed that the nonlinear loop seldom reaches at "
        "5 m/s: some 30 s more. Effort-sharing law.",
    ),
]


def turbulence_class(written: str | None) -> str | None:
    """Return the class of the option --turbulence as a capital letter; None where none is given.

    Raises
    ------
    ModelError : there is no such class.
    """
    # Imported here: few designs ask.
    from takagi.models.turbine.turbulence import CLASSES

    if written is None:
        return None
    if written.upper() not in CLASSES:
        raise ModelError(
            f"option --turbulence: {written!r} was given; a class of turbulence is needed, one of "
            f"{', '.join(CLASSES)}"
        )
    return written.upper()
