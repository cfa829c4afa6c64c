"""How the turbine's judges look for a counterexample: points by chance, and a climb from them."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray
from turbine_loop import At, Floats, Loop

# A counterexample counts beyond this, far wider than the rounding of floats.
MARGIN = 1e-7
ROUNDS = 20


def drawn(draw: np.random.Generator, rows: int, columns: int) -> Floats:
    """Return numbers in [0, 1], a third of them at either end."""
    z = draw.random((rows, columns))
    return np.asarray(np.clip(z * 1.5 - 0.25, 0, 1))


def first_wrong(wrong: NDArray[np.bool_], at: At, what: str) -> str:
    """Return what is wrong at the first point where it is."""
    if not wrong.any():
        return ""
    i = int(np.argmax(wrong))
    return f"{what} at v_s = {at.wind[i]:.5f} m/s, kappa {at.kappa[i]:.4f}, wake {at.wake[i]:.3f}"


def states(P: Floats, z: Floats, most: float = 1) -> Floats:
    """Return states up to V = ``most``, half of them on V = 1; z (n, 4) in [0, 1]."""
    way = 2 * z[:, :3] - 1 + 1e-9
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    root = np.linalg.inv(np.linalg.cholesky(P)).T
    beyond = np.interp(z[:, 3], [0.75, 1], [1, np.sqrt(most)])
    radius = np.where(z[:, 3] < 0.25, 4 * z[:, 3], beyond)
    return np.asarray(radius[:, None] * way @ root.T)


def climb(value: Any, draw: np.random.Generator, rows: int, columns: int) -> tuple[Floats, Floats]:
    """Return the greatest values that a search by chance finds from each of its starts."""
    z = drawn(draw, rows, columns)
    best = value(z)
    for turn in range(ROUNDS):
        size = 0.5 * 0.75**turn
        moved = np.clip(z + size * draw.standard_normal(z.shape), 0, 1)
        found = value(moved)
        better = found > best
        z[better], best[better] = moved[better], found[better]
    return z, best


def overspeed_shown(loop: Loop, statement: str) -> str:
    """Return that more overspeed is reached than is shown, if so."""
    shown = re.search(r"overspeed at most (\S+) %", statement)
    if shown and loop.overspeed() > float(shown[1]) + MARGIN:
        return f"overspeed reaches {loop.overspeed():.6g} %"
    return ""
