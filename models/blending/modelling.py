"""The Takagi-Sugeno model of a plant behind a blend."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.blending.blending import SHARE, blending_of
from takagi.models.errors import ModelError
from takagi.models.sector.model import sector_model

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.equations.equilibrium import EquilibriumOption
    from takagi.models.plant.plant import Plant
    from takagi.models.sector.choice import Choice
    from takagi.models.ts.model import TSModel


def blended_model(
    plant: Plant,
    *,
    choice: Choice = "fewest-rules",
    rest: EquilibriumOption = "given",
    share_apart: bool = False,
) -> TSModel:
    """Return ``sector_model(plant)``, with share and errors as premises of their own where it goes.

    Entries such as (1 + delta) F then are products of premises that are variables, whose bounds are
    those of the variables; and what the law knows is told from what it does not.  Without errors
    the premises are left to be chosen: where both actuators act alike the share cancels.

    Parameters
    ----------
    choice, rest : as of ``sector_model``.
    share_apart : keeps the share apart without errors too.

    Raises
    ------
    ModelError : as ``sector_model`` does.
    """
    wanted = _wanted(plant, always=share_apart)
    if wanted:
        try:
            return sector_model(
                plant, choice=choice, rest=rest, premises={**plant.premises, **wanted}
            )
        except ModelError:
            # They are not all found where a term has another factor too; then any form will do.
            return sector_model(plant, choice=choice, rest=rest)
    return sector_model(plant, choice=choice, rest=rest)


def _wanted(plant: Plant, *, always: bool) -> dict[sp.Symbol, sp.Expr]:
    """Return premise -> signal, of those that appear in the equations once they are expanded."""
    import sympy as sp

    blending = blending_of(plant)
    if blending is None or not (always or any(a.error for a in blending.actuators)):
        return {}
    expanded = sp.Matrix([sp.expand(row) for row in plant.equations])
    named = {"high_share": SHARE}
    named |= {f"{a.name}_off": a.error_name for a in blending.actuators if a.error}
    found = {sp.Symbol(k, real=True): sp.Symbol(s, real=True) for k, s in named.items()}
    return {name: signal for name, signal in found.items() if expanded.has(signal)}
