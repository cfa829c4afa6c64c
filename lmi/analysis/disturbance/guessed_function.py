"""A guess of the Lyapunov function that shows a norm, by the equations of one system.

A loop of high gain has fast and slow parts. In balanced states the P of its norm has a condition
number of 1e8 and more, and no solver comes near the least gain. In states where P is |x|^2 every
solver does. The guess is the P of the mean of the vertices. It only gives coordinates; nothing is
claimed from it.

Source: Zhou, Doyle and Glover (1996), Robust and Optimal Control, chapter 13.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.analysis.disturbance.channel import DisturbanceChannel, largest_response
from takagi.lmi.cone.balance import state_units
from takagi.models.arrays import Floats

# The Riccati equation is solved for a gamma above the norm, by this factor; the norm is estimated
# from a few frequencies.
ABOVE = (1.05, 2.0, 10.0)
# The weight that is added for every state to that of the observability Gramian, as a share of its
# largest weight.
MORE = 1e-6


def guessed_of_energy(channel: DisturbanceChannel) -> Floats | None:
    """Return P of the Riccati equation for a gamma a little above the norm; None if not found."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    solve = solve_continuous_are if channel.sample_time is None else solve_discrete_are
    A, B, C, D, s = _mean(channel)
    size = largest_response(channel)
    for more in ABOVE:
        level = (more * size) ** 2 * np.eye(B.shape[1])
        try:
            P = np.asarray(solve(A, B, C.T @ C, D.T @ D - level, s=C.T @ D), np.float64)
        except (np.linalg.LinAlgError, ValueError):
            continue
        found = _in_plain_states(P, s)
        if found is not None:
            return found
    return guessed_of_variance(channel)


def guessed_of_variance(channel: DisturbanceChannel) -> Floats | None:
    """Return the observability Gramian with a small weight on every state; None if not found."""
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

    A, _, C, _, s = _mean(channel)
    weight = C.T @ C
    weight = weight + MORE * (np.abs(weight).max() or 1.0) * np.eye(len(A))
    try:
        if channel.sample_time is None:
            P = np.asarray(solve_continuous_lyapunov(A.T, -weight), np.float64)
        else:
            P = np.asarray(solve_discrete_lyapunov(A.T, weight), np.float64)
    except (np.linalg.LinAlgError, ValueError):
        return None
    return _in_plain_states(P, s)


def _mean(channel: DisturbanceChannel) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return the mean vertex in balanced states, and their units."""
    s = state_units(channel.A, None, step=channel.sample_time)
    A, B, C, D = (part.mean(axis=0) for part in (channel.A, channel.B, channel.C, channel.D))
    return A * s / s[:, None], B / s[:, None], C * s, D, s


def _in_plain_states(P: Floats, s: Floats) -> Floats | None:
    P = (P + P.T) / 2 / s / s[:, None]
    size = np.sqrt(np.abs(np.diag(P)))
    if not np.isfinite(P).all() or not size.all():
        return None
    shaped = P / size / size[:, None]
    return P if np.linalg.eigvalsh(shaped)[0] > 0 else None
