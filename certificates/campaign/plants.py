"""The plants and the starts of a campaign: members of the certified family, drawn at random.

Starts lie on V = level, at the points where each bound is attained, or anywhere below. Pitch never
starts below its lower limit, because the theorem requires it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.certificates.campaign.motion import At, Cells, at_wind, ramp
from takagi.models.arrays import Floats

# Rows h of h xi: e, zeta, e - x, x.
DIRECTIONS = np.array([[1.0, 0, 0], [0, 1.0, 0], [1.0, 0, -1.0], [0, 0, 1.0]])
# Fractions of the starts: on the boundary, and at boundary points where a bound is attained.
ON_BOUNDARY, AT_CORNERS = 0.4, 0.25
AT_NODES = 0.1
# A boundary start lies inside by this much, so that rounding does not put it outside.
INSIDE = 1e-12
PITCHES = 40


class TrialStart(NamedTuple):
    """n runs at time 0: (3, n) omega, beta, x; the cell and the schedule there."""

    state: Floats
    cell: Cells
    at: At


def quadratic(P: Floats, xi: Floats) -> Floats:
    """Return xi' P xi for xi (3, n)."""
    return np.asarray(np.einsum("in,in->n", P @ xi, xi))


def inertia_factors(inertia: tuple[float, float], count: int, draw: np.random.Generator) -> Floats:
    """Return kappa = nominal over true inertia; half of the values lie at the two ends."""
    low, high = inertia
    ends = draw.choice([low, high], count)
    return np.asarray(1 / np.where(draw.random(count) < 0.5, ends, draw.uniform(low, high, count)))


def drawn_starts(
    loop: CertifiedLoop, count: int, draw: np.random.Generator, *, level: float = 1.0
) -> TrialStart:
    """Return starts with V <= ``level``, at winds spread evenly over all cells.

    If a state's pitch would start below its limit, its mirror image is used: there zeta <= 0 <=
    psi(U), so pitch starts above the limit.
    """
    cell = draw.integers(len(loop.wind) - 1, size=count)
    share = draw.random(count)
    share = np.where(draw.random(count) < AT_NODES, np.round(share), share)
    at = at_wind(loop, cell, loop.wind[cell] * (1 - share) + loop.wind[cell + 1] * share)
    xi = _states(loop.P, count, draw) * np.sqrt(level * (1 - INSIDE))
    xi = np.where(_pitch(loop, at, xi) < loop.pitch_min, -xi, xi)
    pitch = np.minimum(_pitch(loop, at, xi), loop.pitch_max)
    return TrialStart(np.stack([at.speed + xi[0], pitch, xi[2]]), cell, at)


def wake_fits(loop: CertifiedLoop) -> NDArray[np.bool_]:
    """Return per cell whether every wake up to the frozen one belongs to the family on the set.

    Finite differences test for b_fw + s_P d(T_r/J)/dbeta < 0 over the pitch that the set can reach.
    Where it occurs, runs use the equilibrium wake in the cell.
    """
    if not loop.frozen_wake:
        return np.zeros(len(loop.wind) - 1, dtype=bool)
    fits = np.ones(len(loop.wind) - 1, dtype=bool)
    for part in (0.0, 0.5, 1.0):
        cell = np.arange(len(fits))
        at = at_wind(loop, cell, loop.wind[:-1] + part * np.diff(loop.wind))
        lowest = ramp(at.effort - at.gain * loop.peaks[2], loop.overlap) - loop.peaks[1]
        highest = ramp(at.effort + at.gain * loop.peaks[2], loop.overlap) + loop.peaks[1]
        shed = np.linspace(np.maximum(lowest, 0.0), highest, PITCHES)
        pitch = loop.pitch_min + shed / at.effectiveness
        ratio = np.broadcast_to(loop.rotor_radius * at.speed / at.wind, pitch.shape)
        scale = loop.power[1] * loop.torque_scale * at.wind**2
        torque = scale * loop.surface(ratio.ravel(), pitch.ravel()).reshape(pitch.shape)
        fits &= np.all(np.diff(torque + at.limit * pitch, axis=0) >= 0, axis=0)
    return fits


def _states(P: Floats, count: int, draw: np.random.Generator) -> Floats:
    """Return (3, count) states with V <= 1."""
    way = draw.standard_normal((3, count))
    root = np.linalg.inv(np.linalg.cholesky(P)).T
    on_boundary = root @ (way / np.linalg.norm(way, axis=0))
    inverse = np.linalg.inv(P)
    corners = [inverse @ h / np.sqrt(h @ inverse @ h) for h in DIRECTIONS]
    picked = np.array(corners)[draw.integers(len(corners), size=count)].T
    corner = picked * draw.choice([-1.0, 1.0], count)
    kind = draw.random(count)
    inside = on_boundary * draw.random(count) ** (1 / 3)
    found = np.where(kind < ON_BOUNDARY, on_boundary, inside)
    return np.asarray(np.where(kind > 1 - AT_CORNERS, corner, found))


def _pitch(loop: CertifiedLoop, at: At, xi: Floats) -> Floats:
    effort = at.effort + at.gain * (xi[0] - xi[2])
    owed: Floats = ramp(effort, loop.overlap) - xi[1]
    return np.asarray(loop.pitch_min + owed / at.effectiveness)
