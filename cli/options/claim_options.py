"""Options for claims that a turbine's certificate has on request."""

from __future__ import annotations

from typing import Annotated

import typer

# Options that only the law coherent has.
OF_CLAIMS = ("moving_wind",)

MovingWind = Annotated[
    bool,
    typer.Option(
        "--moving-wind",
        help="Turbines: claim also that the loop with its observer keeps a set around its "
        "operating point while the wind moves, up to a rate that is found for each wind: some "
        "minutes more. Law effort-sharing.",
    ),
]
