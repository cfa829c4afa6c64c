"""Options for claims that a turbine's certificate has on request."""

from __future__ import annotations

from typing import Annotated

import typer

from takagi.models.errors import ModelError

# Options that only the effort-sharing law has.
OF_CLAIMS = ("turbulence",)

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
