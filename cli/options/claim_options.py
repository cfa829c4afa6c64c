"""Options for claims that a turbine's certificate has on request."""

from __future__ import annotations

from typing import Annotated

import typer

# Options that only the effort-sharing law has.
OF_CLAIMS = ("moving_wind", "moving_wind_above_rated")

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
