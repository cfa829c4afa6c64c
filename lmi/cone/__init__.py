"""A condition as cone-program data.

program      what a solver is given, and what it gives back
assemble     from a condition to cone data, without a loop over items
balance      coordinates in which the numbers are of order one
duality      bounds on the optimum that multipliers give
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.cone.assemble import pack as pack
    from takagi.lmi.cone.assemble import unpack as unpack
    from takagi.lmi.cone.balance import balanced_states as balanced_states
    from takagi.lmi.cone.duality import least_objective_bound as least_objective_bound
    from takagi.lmi.cone.program import ConeProgram as ConeProgram
    from takagi.lmi.cone.program import Raw as Raw
    from takagi.lmi.cone.program import SolverRow as SolverRow
    from takagi.lmi.cone.program import cone_program as cone_program

__getattr__, __dir__ = lazy_names(__name__)
