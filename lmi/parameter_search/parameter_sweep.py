"""The decay rate at which a bound is least: a coarse grid, then the golden section."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.cone_program import assemble, cone_program
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
# The least objective is sought with the LMIs satisfied by this margin, in units of order one.  At
# the minimum without a margin some LMI is singular.  The solver's tolerances would then violate
# it slightly, and the unknowns would show nothing.
REQUIRED_MARGIN = 1e-6


def least_over_rate(
    value: Callable[[float], float], rates: Sequence[float], *, tolerance: float = 1e-4
) -> float | None:
    """Return an approximation of the rate at which ``value`` is least; None if no value is finite.

    If ``value`` has one local minimum, the result is that minimum, to ``tolerance``.  If it has
    several, the search is confined to the two intervals next to the best of ``rates``.  The golden
    section divides the logarithm of the rate, so that ``tolerance`` is relative.

    Parameters
    ----------
    value : function from the rate to the bound; inf where no bound exists.
    rates : ascending, at least three; the first and the last bound the search.
    tolerance : relative tolerance of the rate.
    """
    values = [value(rate) for rate in rates]
    best = int(np.argmin(values))
    if not np.isfinite(values[best]):
        return None
    low = float(np.log(rates[max(best - 1, 0)]))
    high = float(np.log(rates[min(best + 1, len(rates) - 1)]))
    inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)]
    inner_values = [value(float(np.exp(at))) for at in inner]
    while high - low > tolerance:
        if inner_values[0] <= inner_values[1]:
            high, inner[1], inner_values[1] = inner[1], inner[0], inner_values[0]
            inner[0] = high - GOLDEN * (high - low)
            inner_values[0] = value(float(np.exp(inner[0])))
        else:
            low, inner[0], inner_values[0] = inner[0], inner[1], inner_values[1]
            inner[1] = low + GOLDEN * (high - low)
            inner_values[1] = value(float(np.exp(inner[1])))
    tried = [
        (values[best], float(rates[best])),
        *zip(inner_values, np.exp(inner).tolist(), strict=True),
    ]
    return float(min(tried)[1])


def unknowns_near_least(
    condition: Condition, *, required_margin: float = REQUIRED_MARGIN
) -> Mapping[str, Floats]:
    """Return unknowns near the least objective, without a check; empty if the solver returns none.

    ``required_margin`` : the margin that the LMIs must keep.
    """
    data = assemble(condition)
    raw = Session().solve(cone_program(data, data.objective, (), margin=required_margin))
    usable = len(raw.y) == len(data.objective) and bool(np.all(np.isfinite(raw.y)))
    return data.values(raw.y) if usable else {}


def least_objective(condition: Condition) -> float:
    """Return an approximate least objective, without a margin; inf if no unknowns were found."""
    values = unknowns_near_least(condition, required_margin=0.0)
    if not values:
        return np.inf
    return float(sum(np.sum(cost * values[name]) for name, cost in condition.objective.items()))
