"""Plant and estimate over time, under a law with outputs: simulated, not proved."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.reports.loops.observed import ObservedMotion

Rate = Callable[[Floats, Floats], Floats]


class ObservedPath(NamedTuple):
    """Times (k,), deviations x - x* and their estimates (k, n), commands u (k, m) as they act and
    as the law wants them, and whether the path was run to its end."""

    time: Floats
    state: Floats
    estimate: Floats
    command: Floats
    wanted: Floats
    whole: bool


def observed_flow(
    observed: ObservedMotion,
    rest: Floats,
    rate: Rate,
    x0: Floats,
    times: Floats,
    far: Floats,
    limits: Floats,
) -> ObservedPath:
    """Return the path in continuous time, law and plant integrated together.

    Parameters
    ----------
    rest : x* (n,);  rate : (x, u) -> x'.
    x0 : deviation (n,) at the start.
    times : (k,) at which the path is wanted, s.
    far : (n,) deviations at which it is ended.
    limits : (m, 2), the ranges of the inputs: commands are cut at their ends before they act, and
        the observer knows what acts.
    """
    from scipy.integrate import solve_ivp

    n = len(x0)

    def slope(_: float, both: Floats) -> Floats:
        x, s = rest + both[:n], both[n:]
        u = np.clip(observed.command(x, s), *limits.T)
        return np.concatenate([rate(x, u), observed.following(x, s, u)])

    def leaves(_: float, both: Floats) -> float:
        return float(np.min(far - np.abs(both[:n])))

    leaves.terminal = True  # type: ignore[attr-defined]
    begin = np.concatenate([x0, observed.start(x0)])
    found = solve_ivp(
        slope, (0.0, float(times[-1])), begin, method="LSODA", rtol=1e-7, atol=1e-9,
        t_eval=times, events=leaves,
    )  # fmt: skip
    return _path(observed, rest, found.t, found.y.T, limits, whole=found.status == 0)


def observed_steps(
    observed: ObservedMotion,
    rest: Floats,
    rate: Rate,
    x0: Floats,
    times: Floats,
    far: Floats,
    limits: Floats,
) -> ObservedPath:
    """Return the path in discrete time; the parameters are those of ``observed_flow``."""
    n = len(x0)
    both = [np.concatenate([x0, observed.start(x0)])]
    whole = True
    for _ in times[1:]:
        x, s = rest + both[-1][:n], both[-1][n:]
        u = np.clip(observed.command(x, s), *limits.T)
        following = np.concatenate([rate(x, u) - rest, observed.following(x, s, u)])
        whole = bool(np.all(np.abs(following[:n]) <= far))
        if not whole:
            break
        both.append(following)
    return _path(observed, rest, times[: len(both)], np.array(both), limits, whole=whole)


def _path(
    observed: ObservedMotion,
    rest: Floats,
    time: Floats,
    both: Floats,
    limits: Floats,
    *,
    whole: bool,
) -> ObservedPath:
    n = len(rest)
    x, s = both[:, :n], both[:, n:]
    u = np.array([observed.command(rest + a, b) for a, b in zip(x, s, strict=True)])
    wanted = u.reshape(len(time), -1)
    return ObservedPath(time, x, s, np.clip(wanted, *limits.T), wanted, whole)
