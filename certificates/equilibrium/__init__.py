"""Equilibria of a turbine's closed loop at constant winds: one, none, several, a continuum.

    search       cells of wind, halved until the checker's arithmetic answers
    answers      what is found, as values, and the claim of kind ``equilibrium``

The answers come from the checker's own exact enclosures; the theorem is in docs/equilibria.md.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.equilibrium.answers import (
        ClosedLoopEquilibria,
        ClosedLoopRests,
        EquilibriumCell,
        RestCell,
    )
    from takagi.certificates.equilibrium.search import closed_loop_equilibria

__all__ = [
    "ClosedLoopEquilibria",
    "ClosedLoopRests",
    "EquilibriumCell",
    "RestCell",
    "closed_loop_equilibria",
]

_HOME = {
    "ClosedLoopEquilibria": "answers",
    "ClosedLoopRests": "answers",
    "EquilibriumCell": "answers",
    "RestCell": "answers",
    "closed_loop_equilibria": "search",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.certificates.equilibrium.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
