"""The option for the time that a search for a plant's gains may take."""

from __future__ import annotations

import re
from typing import Annotated

import typer

from takagi.cli.options.plant_options import seconds_of
from takagi.models.errors import ModelError

_TIME = re.compile(r"\s*([-+]?[0-9]{0,9}\.?[0-9]{1,9})\s*(\S*)\s*")


def time_options(
    time: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help="Plants: time that a gain for every rule may take, such as 60s or 5min, by an "
            "estimate; where it takes longer, fewer gains are sought. 120s unless given.",
        ),
    ] = None,
) -> None:
    """Declare the option for the time that a plant's design may take."""


def budget_asked(written: str | None, default: float) -> float:
    """Return the budget [s] of a search for gains.

    Raises
    ------
    ModelError : no number with a unit of time, or a time that is not positive.
    """
    if written is None:
        return default
    match = _TIME.fullmatch(written)
    if match is None or not match.group(2):
        raise ModelError(
            f"option --time: {written!r} was given; a number with a unit is needed, such as 60s "
            "or 5min"
        )
    seconds = seconds_of(match.group(1), match.group(2), f"option --time {written}")
    if not seconds > 0:
        raise ModelError(f"option --time {written}: a time above 0 is needed, such as 60s")
    return seconds
