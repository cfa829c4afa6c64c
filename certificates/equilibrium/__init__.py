"""Equilibria of a turbine's closed loop at constant winds: one, none, several, a continuum.

    search       cells of wind, halved until the checker's arithmetic answers
    answers      what is found, as values, and the claim of kind ``equilibrium``

The answers come from the checker's own exact enclosures; the theorem is in docs/equilibria.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.equilibrium.answers import ClosedLoopEquilibria as ClosedLoopEquilibria
    from takagi.certificates.equilibrium.answers import EquilibriumCell as EquilibriumCell
    from takagi.certificates.equilibrium.search import (
        closed_loop_equilibria as closed_loop_equilibria,
    )

__getattr__, __dir__ = lazy_names(__name__)
