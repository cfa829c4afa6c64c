"""The Takagi-Sugeno model of a plant behind a blend."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.blending.blending import SHARE, blending_of
from takagi.models.errors import ModelError
from takagi.models.sector.model import sector_model

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.plant.design_settings import Choice, Rest
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel


def blended_model(
    plant: Plant,
    *,
    choice: Choice = "fewest-rules",
    rest: Rest = "given",
    share_apart: bool = False,
) -> TSModel:
    """Return ``sector_model(plant)``, with share and errors as premises of their own where it goes.

    Entries such as (1 + delta) F are then products of premises that are variables, and the bounds
    of the premises are those of the variables. The premises that the law knows (F) stay apart from
    those that it does not know (delta). Without errors the premises are chosen as usual, because
    the share cancels if both actuators act alike.

    Parameters
    ----------
    choice, rest : as of ``sector_model``.
    share_apart : make the share a premise of its own even without errors.

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
            # Some may not be found, if a term has another factor too. Then any factored form is
            # taken.
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
