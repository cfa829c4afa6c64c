"""How far proved bounds of premises lie beyond what the premises attain, as a table."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.models import TSModel
from takagi.reports.figures.plant.weights import PremiseCurve, premise_curves

# A share below this is rounding.
EDGE = 1e-9


def bounds_table(model: TSModel) -> str:
    sampled, rows = sampled_ranges(model), []
    for premise in model.premises:
        low, high = sampled[premise.name]
        width = float(premise.upper - premise.lower)
        excess = max(low - float(premise.lower), float(premise.upper) - high) / width
        rows.append(
            (
                premise.name,
                f"{float(premise.lower):.7f}",
                f"{low:.7f}",
                f"{high:.7f}",
                f"{float(premise.upper):.7f}",
                _below(excess),
            )
        )
    heads = ("premise", "lower bound", "least", "greatest", "upper bound", "excess / range")
    return table(heads, rows)


def _below(share: float) -> str:
    """Return the next power of ten above a share."""
    return f"< $10^{{{int(np.ceil(np.log10(max(share, EDGE))))}}}$"


def sampled_ranges(model: TSModel) -> dict[str, tuple[float, float]]:
    """Return premise -> (least, greatest value found): the best point of a grid, then a search."""
    found = {}
    for curve in premise_curves(model):
        low, high = (_extreme(curve, sign) for sign in (1.0, -1.0))
        found[curve.premise.name] = (low, high)
    return found


def _extreme(curve: PremiseCurve, sign: float) -> float:
    """Return the least value for sign 1, the greatest for -1, near the best point of the grid."""
    from scipy.optimize import minimize

    names = [label.split(" [")[0] for label in curve.variables]

    def height(point: NDArray[np.float64]) -> float:
        assert curve.premise.evaluate is not None
        return sign * curve.premise.evaluate(**dict(zip(names, map(float, point), strict=True)))

    mesh = [grid.ravel() for grid in np.meshgrid(*curve.axes)]
    best = int(np.argmin(sign * curve.value.ravel()))
    start = np.array([grid[best] for grid in mesh])
    bounds = [(axis[0], axis[-1]) for axis in curve.axes]
    found = minimize(height, start, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-15})
    return sign * min(float(found.fun), height(start))


def table(heads: tuple[str, ...], rows: Any) -> str:
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    lines += [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(lines) + "\n"
