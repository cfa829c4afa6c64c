"""Options of the search for a turbine's gains: in two steps or in one, and its objective."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from takagi.models.errors import ModelError

# Options that only the effort-sharing law has.
OF_SYNTHESIS = ("two_step", "one_step", "objective")

TwoStep = Annotated[
    bool,
    typer.Option(
        "--two-step",
        help="Turbines: find the gains wind by wind and prove them afterwards. This is the default "
        "unless --one-step or --objective is given. Effort-sharing law.",
    ),
]
OneStep = Annotated[
    bool,
    typer.Option(
        "--one-step",
        help="Turbines: change gains and proof together, starting from the two-step gains. This "
        "takes about two minutes more and gives a larger wind class and faster decay; pitch then "
        "travels more. Effort-sharing law.",
    ),
]
ObjectiveName = Annotated[
    str | None,
    typer.Option(
        "--objective",
        metavar="NAME",
        help="Turbines: what the one-step search improves: balanced (wind class, and some decay), "
        "wind-class, decay, calm-pitch or calm-tower; --one-step alone means balanced. With the "
        "first three the wind class is no smaller than that of the two-step gains, on average and "
        "at the weakest wind; with the calm ones by up to 15 %. Effort-sharing law.",
    ),
]


def synthesis_settings(*, two_step: bool, one_step: bool, objective: str | None) -> dict[str, Any]:
    """Return the fields of ``DesignSettings`` that these options set.

    Raises
    ------
    ModelError : an objective that has no such name, or --two-step beside one step.
    """
    from takagi.lmi.turbine.one_step.objective import objective_named

    if two_step:
        if one_step:
            raise ModelError("options --two-step and --one-step: leave one of the two out")
        if objective is not None:
            raise ModelError(
                f"options --two-step and --objective {objective}: an objective steers the search "
                "in one step; leave one of the two out"
            )
        return {"synthesis": "two-step"}
    if objective is None:
        return {"synthesis": "one-step"} if one_step else {}
    try:
        return {"synthesis": "one-step", "objective": objective_named(objective)}
    except ModelError as error:
        raise ModelError(f"option --objective: {error}") from error
