"""What may be asked of the search for a turbine's gains: in one step or two, and what for."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from takagi.models.errors import ModelError

# Options that the law coherent alone has.
OF_SYNTHESIS = ("two_step", "objective")

TwoStep = Annotated[
    bool,
    typer.Option(
        "--two-step",
        help="Turbines: find the gains wind by wind and prove them afterwards: about a minute "
        "less, for a smaller wind class and slower decay. Without it, gains and proof are found "
        "together. Law coherent.",
    ),
]
ObjectiveName = Annotated[
    str | None,
    typer.Option(
        "--objective",
        metavar="NAME",
        help="Turbines: what gains found together make better: balanced (wind class, and some "
        "decay), wind-class, decay, calm-pitch or calm-tower; balanced unless given. The first "
        "three give up no wind class that the two-step gains have on average or "
        "at the weakest wind, the calm ones up to 15 %. Law coherent.",
    ),
]


def synthesis_settings(*, two_step: bool, objective: str | None) -> dict[str, Any]:
    """Return the fields of ``DesignSettings`` that these options set.

    Raises
    ------
    ModelError : an objective that has no such name, or one beside --two-step.
    """
    from takagi.lmi.turbine.one_step.objective import objective_named

    if objective is None:
        return {"synthesis": "two-step"} if two_step else {}
    if two_step:
        raise ModelError(
            f"options --two-step and --objective {objective}: an objective steers the search in "
            "one step; leave one of the two out"
        )
    try:
        return {"objective": objective_named(objective)}
    except ModelError as error:
        raise ModelError(f"option --objective: {error}") from error
