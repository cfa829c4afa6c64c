"""The only calls of a solver: cone data in, numbers out.

solve             the solvers that are tried, one after another; units of a program's solution
sdpa_solver, cvxpy_solvers    others, where they are installed
incidence         which is first, and explicit zeros that make clarabel quicker
time_limit        a limit on all calls of one question
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.solver.solve import Session as Session
    from takagi.lmi.solver.solve import again as again
    from takagi.lmi.solver.solve import attempts as attempts
    from takagi.lmi.solver.time_limit import limited as limited
    from takagi.lmi.solver.time_limit import out_of_time as out_of_time

__getattr__, __dir__ = lazy_names(__name__)
