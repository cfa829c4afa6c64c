r"""The rate of the wind that is too fast for the turbine's loop: a search for the worst winds.

The loop is that of docs/running-rate.md, written anew from the page in floats: law, observer,
filters, limits of torque and pitch and of their rates, drive, wake.  A wind starts at the trim of
v_0 and moves by |v'| <= r; the search looks for v'(t) = +-r, a sequence of signs in steps of one
second, that brings the rotor to the highest speed.  It starts at the signs of the linear loop's
impulse response and flips signs where that helps.  The least r at which a wind is found that brings
the rotor 12 % above its rated speed is an upper bound of every r that can be proved with that
overspeed.

``python benchmarks/turbine_worst_wind.py CERTIFICATE`` prints the table of docs/running-rate.md.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import bisplev

Floats = NDArray[np.float64]
WINDS, FILTERS = (5.0, 9.0, 11.0, 13.0, 15.0, 19.0), (12.0, 5.0, 2.0, 1.0)
TARGETS = (0.1, 0.25, 0.35, 0.4, 0.5, 0.8)
MOST = 0.12
# Step of the integration, and of the wind's rate [s].
STEP, HOLD = 0.02, 1.0
# Columns of the tables of nodes and of intervals.
SPEED, EFFORT, B, GAMMA, LATE, PITCH = range(6)
NU, AHEAD, AHEAD_LIMIT = range(3)
# Places in the row of numbers.
(
    OVERLAP, RATED, PER_EFFORT, GEAR, PITCH_MIN, PITCH_MAX, TAU_F, X_MAX, LEAD, L1, L2, V_LOW,
    V_HIGH, CORNER, STOP, PASSED, LAG, DRIVE_RATE, TORQUE_RATE, RADIUS, KAPPA, LENGTH, SHARE,
    J_RATIO,
) = range(24)  # fmt: skip


@dataclass(frozen=True)
class Loop:
    """Tables and numbers of one loop; ``surface`` is T_r / (J v^2) on a fine grid.

    ``profile`` is the unit of the wind's rate at the nodes [m/s^2]: 1, or the targets.
    """

    nodes: Floats
    columns: Floats
    steps: Floats
    surface: Floats
    grid: Floats
    numbers: Floats
    rated_speed: float
    profile: Floats

    def changed(self, **new: float) -> Loop:
        """Return the loop with other numbers, by the names of their places."""
        numbers = self.numbers.copy()
        for name, value in new.items():
            numbers[globals()[name]] = value
        return replace(self, numbers=numbers)


def loop_of(document: Any) -> Loop:
    """Return the loop of a certificate of the effort-sharing law, with its gain file's observer."""
    model, law = document["model"], document["gains"]
    seen, filters = (document["controller"][name] for name in ("observer", "measurement"))
    stop = filters.get("torsion_filter", {"frequency": 1.0, "passed": 1.0})
    n = model["gear_ratio"]
    J = model["rotor_inertia"] + n * n * model["generator_inertia"]
    table = model["torque_surface"]
    spline = (
        np.array(table["tip_speed_ratio_knots"]),
        np.array(table["pitch_knots"]),
        np.array(table["coefficients"]).ravel(),
        3,
        3,
    )
    ratios = np.linspace(spline[0][0], spline[0][-1], 601)
    pitches = np.linspace(spline[1][0], spline[1][-1], 601)
    scale = model["torque_constant"] / J
    surface = scale * bisplev(ratios, pitches, spline)
    grid = np.array([ratios[0], ratios[1] - ratios[0], pitches[0], pitches[1] - pitches[0]])
    names = ("rotor_speed", "trim_effort", "effectiveness", "proportional")
    columns = [np.array(law[name], dtype=np.float64) for name in names]
    eps = law["overlap"]
    nodes = np.array(law["wind"], dtype=np.float64)
    shed = np.where(
        columns[EFFORT] <= -eps,
        0.0,
        np.where(columns[EFFORT] >= eps, columns[EFFORT], (columns[EFFORT] + eps) ** 2 / 4 / eps),
    )
    pitch = law["pitch_min"] + shed / columns[B]
    own = [
        -scale * v**2 * bisplev(w * model["rotor_radius"] / v, p, spline, dy=1)
        for v, w, p in zip(nodes, columns[SPEED], pitch, strict=True)
    ]
    late = np.maximum(np.array(law["effectiveness_limit"]) - np.array(own), 0.0)
    steps = [law[name] for name in ("integral_rate", "inertia_feedforward", "feedforward_limit")]
    numbers = np.zeros(24)
    for place, value in {
        OVERLAP: eps, RATED: law["rated_torque"], PER_EFFORT: law["effort_torque"], GEAR: n / J,
        PITCH_MIN: law["pitch_min"], PITCH_MAX: law["pitch_max"], TAU_F: law["wind_filter"],
        X_MAX: law["integral_limit"], LEAD: law["pitch_lead"], L1: seen["l1"], L2: seen["l2"],
        V_LOW: seen["wind_limits"][0], V_HIGH: seen["wind_limits"][1],
        CORNER: filters["speed_filter"], STOP: stop["frequency"], PASSED: stop["passed"],
        LAG: model["pitch_time_constant"], DRIVE_RATE: model["pitch_rate_limit"],
        TORQUE_RATE: model["torque_rate_limit"], RADIUS: model["rotor_radius"], KAPPA: 1.0,
        LENGTH: 60.0, SHARE: 0.5, J_RATIO: 1.0,
    }.items():  # fmt: skip
        numbers[place] = value
    return Loop(
        nodes,
        np.array([*columns, late, pitch]),
        np.array(steps, dtype=np.float64),
        surface,
        grid,
        numbers,
        model["rated_rotor_speed"],
        np.ones(len(nodes)),
    )


@njit(cache=True)
def _between(nodes: Floats, wind: float) -> tuple[int, float]:
    k = min(max(int(np.searchsorted(nodes, wind, side="right")) - 1, 0), len(nodes) - 2)
    return k, min(max((wind - nodes[k]) / (nodes[k + 1] - nodes[k]), 0.0), 1.0)


@njit(cache=True)
def _torque(surface: Floats, grid: Floats, ratio: float, pitch: float) -> float:
    a = min(max((ratio - grid[0]) / grid[1], 0.0), surface.shape[0] - 1.000001)
    b = min(max((pitch - grid[2]) / grid[3], 0.0), surface.shape[1] - 1.000001)
    i, j = int(a), int(b)
    a, b = a - i, b - j
    low = (1 - b) * surface[i, j] + b * surface[i, j + 1]
    high = (1 - b) * surface[i + 1, j] + b * surface[i + 1, j + 1]
    return float((1 - a) * low + a * high)


@njit(cache=True)
def _psi(s: float, eps: float) -> float:
    if s <= -eps:
        return 0.0
    return s if s >= eps else (s + eps) ** 2 / (4 * eps)


@njit(cache=True)
def run(
    nodes: Floats,
    columns: Floats,
    steps: Floats,
    surface: Floats,
    grid: Floats,
    p: Floats,
    start: float,
    low: float,
    high: float,
    rates: Floats,
    profile: Floats,
) -> Floats:
    """Return rows (v, omega - omega*(v), v_s, vhat, x, pitch, torque, omega).

    v' is a number of ``rates`` times ``profile`` at the present wind, given at the nodes.
    """
    k, f = _between(nodes, start)
    at = columns[:, k] * (1 - f) + columns[:, k + 1] * f
    w = at[SPEED]
    pitch = at[PITCH]
    x, v_s, w_m, seen_w, seen_v, wake, y1, y2 = 0.0, start, w, w, start, pitch, w, w
    eps = p[OVERLAP]
    torque = p[RATED] - p[PER_EFFORT] * _psi(-at[EFFORT], eps)
    asked = pitch
    v = start
    each = int(round(HOLD / STEP))
    out = np.zeros((len(rates) * each, 8))
    for i in range(len(rates) * each):
        k, f = _between(nodes, v)
        moved = rates[i // each] * (profile[k] * (1 - f) + profile[k + 1] * f)
        v = min(max(v + STEP * moved, low), high)
        # The law at v_s.
        ks, fs = _between(nodes, v_s)
        law = columns[:, ks] * (1 - fs) + columns[:, ks + 1] * fs
        slope = (columns[:, ks + 1] - columns[:, ks]) / (nodes[ks + 1] - nodes[ks])
        rate = (min(max(seen_v, nodes[0]), nodes[-1]) - v_s) / p[TAU_F]
        error = w_m - law[SPEED]
        signal = error - x
        U = law[EFFORT] + law[GAMMA] * signal
        limit = steps[AHEAD_LIMIT, ks]
        fed = min(max(steps[AHEAD, ks] * rate, -limit), limit)
        T_c = p[RATED] - p[PER_EFFORT] * (_psi(-U, eps) + fed)
        T_c = min(max(T_c, 0.0), p[RATED])
        F = min(max((U + eps) / (2 * eps), 0.0), 1.0)
        N = F * (slope[EFFORT] + slope[GAMMA] * signal) - _psi(U, eps) * slope[B] / law[B]
        beta_c = p[PITCH_MIN] + (_psi(U, eps) + p[LEAD] * rate * N) / law[B]
        beta_c = min(max(beta_c, p[PITCH_MIN]), p[PITCH_MAX])
        most = p[TORQUE_RATE] * STEP
        torque += min(max(T_c - torque, -most), most)
        most = p[DRIVE_RATE] * STEP
        asked += min(max(beta_c - asked, -most), most)
        # The plant at v.
        k, f = _between(nodes, v)
        at = columns[:, k] * (1 - f) + columns[:, k + 1] * f
        load = p[GEAR] * torque
        table = v * v * _torque(surface, grid, p[RADIUS] * w / v, pitch)
        late = p[SHARE] * at[LATE] * (pitch - wake)
        seen = seen_v * seen_v * _torque(surface, grid, p[RADIUS] * w_m / seen_v, pitch)
        apart = w_m - seen_w
        turned = min(max((asked - pitch) / p[LAG], -p[DRIVE_RATE]), p[DRIVE_RATE])
        left = 2 * (1 - p[PASSED])
        dw = p[KAPPA] * (table - late - load)
        dm = p[CORNER] * (w - left * (y1 - y2) - w_m)
        dy1, dy2 = p[STOP] * (w - y1), p[STOP] * (y1 - y2)
        ds = p[J_RATIO] * (seen - load) + p[L1] * apart
        dv = p[L2] * apart
        dx = -steps[NU, ks] * error
        wake += STEP * (pitch - wake) * v / p[LENGTH]
        w += STEP * dw
        w_m += STEP * dm
        y1 += STEP * dy1
        y2 += STEP * dy2
        seen_w += STEP * ds
        seen_v = min(max(seen_v + STEP * dv, p[V_LOW]), p[V_HIGH])
        v_s += STEP * rate
        x = min(max(x + STEP * dx, -p[X_MAX]), p[X_MAX])
        pitch += STEP * turned
        k, f = _between(nodes, v)
        out[i, 0], out[i, 1] = v, w - columns[SPEED, k] * (1 - f) - columns[SPEED, k + 1] * f
        out[i, 2], out[i, 3], out[i, 4] = v_s, seen_v, x
        out[i, 5], out[i, 6], out[i, 7] = pitch, torque, w
    return out


def motion(
    loop: Loop, start: float, rates: Floats, within: tuple[float, float] = (3.0, 25.0)
) -> Floats:
    """Return the rows of ``run`` for a wind of these rates, one a second, held ``within`` [m/s].

    The rates are multiples of the loop's ``profile``.
    """
    tables = (loop.nodes, loop.columns, loop.steps, loop.surface, loop.grid, loop.numbers)
    return np.asarray(run(*tables, start, *within, rates, loop.profile))


def peak(loop: Loop, start: float, rates: Floats, within: tuple[float, float]) -> float:
    """Return the largest overspeed, omega over the rated speed less 1 [-]."""
    return float(motion(loop, start, rates, within)[:, 7].max() / loop.rated_speed) - 1


def linear_gain(loop: Loop, start: float, seconds: int) -> tuple[float, Floats]:
    """Return the linear peak gain [s^2/m] of (omega - omega*) / rated speed, and the signs of v'.

    By a small pulse of one second at the trim: the differences of omega - omega* are the impulse
    response, which turned round in time has the signs of the worst v'.
    """
    small = 1e-4
    rates = np.zeros(seconds)
    rest = motion(loop, start, rates)[:, 1]
    rates[0] = small
    response = (motion(loop, start, rates)[:, 1] - rest) / small / loop.rated_speed
    each = round(HOLD / STEP)
    by_second = response[each - 1 :: each]
    return float(np.abs(by_second).sum()), np.where(by_second[::-1] >= 0, 1.0, -1.0)


def worst_wind(
    loop: Loop,
    start: float,
    rate: float,
    within: tuple[float, float],
    first: list[Floats],
    rounds: int,
    draw: np.random.Generator,
) -> tuple[float, Floats]:
    """Return the largest peak that is found, and its signs; from the best of ``first``.

    Each round turns the signs of one stretch of 1 to 12 s, and keeps what raises the peak.
    """
    found = [(peak(loop, start, rate * signs, within), signs) for signs in first]
    most, signs = max(found, key=lambda one: one[0])
    n = len(signs)
    for _ in range(rounds):
        tried = signs.copy()
        length = int(draw.integers(1, 13))
        at = int(draw.integers(0, n))
        kind = draw.integers(0, 3)
        if kind == 0:
            tried[at : at + length] *= -1
        elif kind == 1:
            tried[at : at + length] = 1.0 if draw.random() < 0.5 else -1.0
        else:
            tried = np.roll(tried, int(draw.integers(-3, 4)))
        if (value := peak(loop, start, rate * tried, within)) > most:
            most, signs = value, tried
    return most, signs


def largest_rate(
    loop: Loop, start: float, away: float, draw: np.random.Generator, seconds: int = 80
) -> tuple[float, float, Floats, Loop]:
    """Return the linear rate, the least rate found that is too fast, its wind's rates, its plant.

    Parameters
    ----------
    away : the wind stays within this of ``start`` [m/s], and within 3 to 25 m/s.
    """
    within = max(start - away, 3.0), min(start + away, 25.0)
    plants = [
        loop.changed(KAPPA=kappa, SHARE=share, LENGTH=length)
        for kappa in (1 / 1.1, 1 / 0.9)
        for share, length in ((0.0, 60.0), (1.0, 40.0), (1.0, 80.0))
    ]
    gains = [linear_gain(plant, start, seconds) for plant in plants]
    linear = MOST / max(gain for gain, _ in gains)
    ramps = [np.r_[-np.ones(seconds - k), np.ones(k)] for k in (10, 20, 40, seconds)]
    first = [signs for _, signs in gains] + ramps
    low, high, rate, best = 0.0, 4.0, linear, np.zeros(seconds)
    # The plant that is worst at the linear rate is kept.
    values = [max(peak(p, start, linear * s, within) for s in first) for p in plants]
    plant = plants[int(np.argmax(values))]
    while high - low > 0.04 * high:
        most, signs = worst_wind(plant, start, rate, within, first, 250, draw)
        if most >= MOST:
            high, best = rate, rate * signs
            first = [signs, *first[-10:]]
        else:
            low = rate
            first = [signs, *first[-10:]]
        rate = (low + high) / 2 if high < 4.0 else min(2 * rate, 3.99)
        if low > 3.9:
            break
    return linear, high, best, plant


def main() -> None:
    """Print the table."""
    given = argparse.ArgumentParser(description=main.__doc__)
    given.add_argument("certificate", type=Path)
    given.add_argument("--away", type=float, default=30.0, help="[m/s], see largest_rate")
    given.add_argument("--targets", action="store_true", help="rates as shares of the targets")
    asked = given.parse_args()
    whole = json.loads(asked.certificate.read_text(encoding="utf-8"))
    loop = loop_of(whole)
    if asked.targets:
        loop = replace(loop, profile=np.interp(loop.nodes, WINDS, TARGETS))
    for start, target in zip(WINDS, TARGETS, strict=True):
        line = f"{start:5g} m/s  target {target:5g}"
        for tau in FILTERS:
            linear, rate, _, _ = largest_rate(
                loop.changed(TAU_F=tau), start, asked.away, np.random.default_rng(0)
            )
            line += f"   {tau:g} s: linear {linear:.3f}, found {rate:.3f}"
        print(line, flush=True)


if __name__ == "__main__":
    main()
