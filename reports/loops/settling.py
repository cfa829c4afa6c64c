"""When every motion from the proved set is at rest to 2 %, from what the certificate proves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop

SETTLED = 0.02
# Far above the rounding of the formulas below in floating point.
_ROUNDED = 1 + 1e-6


def half_widths(loop: PlantLoop) -> Floats | None:
    """Return (n,): how far each state gets at most from rest, from anywhere in the proved set.

    None where no set is proved to be invariant.
    """
    if not (loop.bounded and loop.level_proved):
        return None
    P, level = loop.ellipsoid
    return np.asarray(np.sqrt(level * np.diag(np.linalg.inv(P))), dtype=np.float64)


def settling_time(loop: PlantLoop) -> float | None:
    """Return T [s] after which every state stays below 2 % of its half-width of the set.

    From anywhere in {x' P x <= c}, W = x' D x of the proved decay is at first lambda c at most,
    with D <= lambda P; then |x_k| <= (W (D^-1)_kk)^(1/2), and W falls at least as exp(-2 alpha t).
    The claims are proved, this conclusion from them is computed in floating point.  None without
    proved set or decay, and for a plant with disturbances, which need not come to rest.
    """
    reach = half_widths(loop)
    if loop.observed is not None:
        # V is the function of the set itself: |x_k| is at most its half-width times sqrt(V / c).
        undisturbed = reach is not None and loop.decay_rate and not loop.plant.disturbances
        return float(_ROUNDED * -np.log(SETTLED) / loop.decay_rate) if undisturbed else None
    if reach is None or not loop.decay_rate or loop.decay_P is None or loop.plant.disturbances:
        return None
    P, level = loop.ellipsoid
    D = loop.decay_P
    largest = level * float(np.linalg.eigvals(np.linalg.solve(P, D)).real.max())
    begun = np.sqrt(largest * np.diag(np.linalg.inv(D)))
    return float(_ROUNDED * np.log((begun / reach).max() / SETTLED) / loop.decay_rate)
