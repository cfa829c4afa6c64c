r"""One run of the certified loop: the law with its limits, the pitch drive and the rotor.

Plant, law and claim are read from the certificate's own document: no object of the design or its
proof is used, so the simulated loop is exactly the one in the file.

    omega' = kappa (s_P c v^2 c_Q(omega R / v, beta) + Delta - n_g T_g / J)
    beta'  = sat((beta_ref - beta) / tau)
    x'     = -nu (omega - omega*)

Formulas and symbols are those of docs/effort-sharing-loop.md.  The states are omega, beta, x, so
the certificate's error coordinates xi = (e, zeta, x) do not enter; they are computed to compare
them with its bounds.  Delta is a share w of the whole way to the frozen wake,

    Delta(beta; v_s) = -w int_{beta*}^{beta} (b_fw + s_P d(T_r/J)/dbeta) dbeta
              = -w (b_fw (beta - beta*) + s_P c v_s^2 (c_Q(lambda*, beta) - c_Q(lambda*, beta*))).

During a step four inputs u are constant: the wind error v - v_s [m/s], the rate v_s' [m/s^2], w,
and s_P, the true over the table's power coefficient.  A step ends where v_s reaches a node of the
tables.  The adversaries choose, one input after the other, the end of its range at which
xi' Q xi grows fastest: with Q = P it is V, with h h' one bound.

Numba compiles this file, which therefore has all functions that call each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, inf, log, nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from takagi.models.arrays import Floats, compiled
from takagi.models.errors import ModelError
from takagi.models.ramps import effort_ramp
from takagi.models.splines.spline import Surface, patch_coefficients

KIND = "coherent-loop"
PEAKS = ("speed_error", "effort_lag", "speed_signal", "integral")
# Rows h of the peaks |h xi|, xi = (e, zeta, x): e, zeta, e - x, x.
DIRECTIONS = np.array([[1.0, 0, 0], [0, 1.0, 0], [1.0, 0, -1.0], [0, 0, 1.0]])
# The order of the rows of ``CertifiedLoop.tables``.
TABLES = ("rotor_speed", "trim_effort", "effectiveness", "proportional", "effectiveness_limit")
PITCHES = 40
OF_MODEL = ("rotor_radius", "pitch_rate_limit", "pitch_min", "pitch_max")
OF_LAW = ("overlap", "rated_torque", "effort_torque", "integral_limit")

# Ratios of simulated quantities to their certified bounds; a correct certificate gives at most 1:
# V; |h xi| over its peak; (omega - max omega*) over p_e; (T_rated - T) / T_rated before the limiter
# at 0; the demanded pitch's share of its range, before the limiter; 0, and above 1 below the least
# pitch; 0, and 2 outside of the table, where the run ends; and, at constant wind alone, the
# certified over the observed mean decay rate, in P and R.
BOUNDS = (
    *("set", "speed error", "effort lag", "speed signal", "integral", "rotor speed"),
    *("torque asked", "pitch asked", "least pitch", "coefficient table", "decay", "common decay"),
)
TABLE, DECAY, COMMON = 9, 10, 11
# The first bound but the set to be exceeded, as index into ``BOUNDS``, and the schedule wind then;
# V at the end.
EVENTS = ("first", "first_wind", "end_value")
# A run's winds: constant; random telegraphs; adversaries of V, and of one bound.  Of 25 runs so
# many are of each kind.
PLAYERS = (4, 9, 7, 5)
CALM, SWITCHES, AGAINST_SET, AGAINST_BOUND = range(4)

# Mean times between two switches [s]; the period of the loop, about 20 s, is among them.
SHORTEST, LONGEST = 0.1, 30.0
# Shares of the starts on V = 1, and where a peak is attained; and of those at nodes of the tables.
ON_BOUNDARY, AT_CORNERS, AT_NODES = 0.4, 0.25, 0.1
# A start lies inside by this much, so that rounding does not put it outside.
WITHIN = 1e-12
# A ratio may exceed 1 by this, because steps are finite.
TOLERANCE = 1e-4
# A step is this share of the pitch drive's time constant.  At the start the drive may leave its
# rate limit within a step, so the steps of the first time constants are shorter.
STEP_SHARE, EARLY_LAGS, EARLY_PARTS = 0.1, 2.0, 8.0
BISECTIONS = 60
# An adversary compares values after this time [s].
AHEAD = 1e-4
# Below these distances to the equilibrium rounding dominates, so decay is not compared.
NEAREST, NEARLY_THERE = 1e-12, 1e-14
LEAST_WIND = 0.1

State = tuple[float, float, float]
Inputs = tuple[float, float, float, float]
Schedule = tuple[float, float, float, float, float]


class CertifiedLoop(NamedTuple):
    """The loop of a certificate of kind ``coherent-loop``, and what is claimed of it.

    Symbols of docs/effort-sharing-loop.md, in SI units.  Arrays, since numba counts references to
    each member.
    """

    torque_scale: float  # c / J, where T_r = c v^2 c_Q
    gear_scale: float  # n_g / J
    rotor_radius: float
    pitch_lag: float
    pitch_rate_limit: float
    pitch_min: float
    pitch_max: float
    overlap: float
    rated_torque: float
    effort_torque: float  # E
    integral_limit: float
    # c_Q(lambda, beta) as in ``patch_coefficients``.
    ratio: Floats
    pitch: Floats
    patches: Floats
    # A row for each wind cell: its ends; ``TABLES`` at its lower end; their slopes over wind; nu.
    cells: Floats
    rated_speed: float
    top_speed: float  # the greatest omega*
    wind: Floats  # nodes of the schedule
    P: Floats  # of the set, in (e, zeta, x)
    R: Floats  # of the common decay
    common_rate: float
    root: Floats  # its columns span the set
    corners: Floats  # points of the set where a peak is attained
    peaks: Floats  # of e, zeta, e - x, x
    # In each cell: delta, rho, d_k, and the largest share of the way to the frozen wake.
    wind_error: Floats
    wind_rate: Floats
    decay_rate: Floats
    wake: Floats
    # Least and greatest true over nominal inertia, and over table's c_P.
    inertia: Floats
    power: Floats


def certified_loop(document: Mapping[str, Any]) -> CertifiedLoop:
    """Return the loop of a certificate; ``document`` is the file's JSON.

    Raises
    ------
    ModelError : no claim of kind ``coherent-loop``, or a part that is missing or does not fit.
    """
    listed = [claim for claim in document.get("claims", ()) if isinstance(claim, dict)]
    claim = next((claim for claim in listed if claim.get("kind") == KIND), None)
    if claim is None:
        kinds = ", ".join(sorted({str(claim.get("kind")) for claim in listed})) or "none"
        raise ModelError(
            f"the certificate has claims of kind {kinds}; a campaign needs one of kind {KIND}, "
            "which `takagi design TURBINE` makes with the effort-sharing law"
        )
    try:
        return _read(document["model"], document["gains"], claim)
    except (KeyError, TypeError, ValueError, np.linalg.LinAlgError) as error:
        raise ModelError(
            f"the certificate cannot be simulated ({type(error).__name__}: {error}); "
            "`takagi check` says what is wrong with it"
        ) from error


def _read(model: dict[str, Any], law: dict[str, Any], claim: dict[str, Any]) -> CertifiedLoop:
    table = model["torque_surface"]
    surface = Surface(table["tip_speed_ratio_knots"], table["pitch_knots"], table["coefficients"])
    wind = _row(law["wind"])
    tables = np.array([law[name] for name in TABLES], dtype=np.float64).reshape(5, len(wind))
    cells, uncertainty = claim["cells"], claim["uncertainty"]
    P = _row(claim["P"]).reshape(3, 3)
    inverse = np.linalg.inv(P)
    ratio, pitch, patches = patch_coefficients(surface)
    gear = float(model["gear_ratio"])
    J = float(model["rotor_inertia"]) + gear**2 * float(model["generator_inertia"])
    members: dict[str, Any] = {name: float(model[name]) for name in OF_MODEL}
    members |= {name: float(law[name]) for name in OF_LAW}
    for name in ("wind_error", "wind_rate", "decay_rate"):
        members[name] = _row([cell[name] for cell in cells]).reshape(len(wind) - 1)
    rows = [wind[:-1], wind[1:], *tables[:, :-1], *(np.diff(tables, axis=1) / np.diff(wind))]
    loop = CertifiedLoop(
        **members,
        torque_scale=float(model["torque_constant"]) / J,
        gear_scale=gear / J,
        pitch_lag=float(model["pitch_time_constant"]),
        ratio=np.array(ratio),
        pitch=np.array(pitch),
        patches=patches,
        cells=np.ascontiguousarray(np.vstack([*rows, _row(law["integral_rate"])]).T),
        rated_speed=float(model["rated_rotor_speed"]),
        top_speed=float(tables[0].max()),
        wind=wind,
        P=P,
        R=_row(claim["settling"]["P"]).reshape(3, 3),
        common_rate=float(claim["settling"]["decay_rate"]),
        root=np.ascontiguousarray(np.linalg.inv(np.linalg.cholesky(P)).T),
        corners=np.array([inverse @ h / np.sqrt(h @ inverse @ h) for h in DIRECTIONS]),
        peaks=_row([claim["peaks"][name] for name in PEAKS]),
        inertia=_row(uncertainty["inertia"]).reshape(2),
        # A file without this member means the power coefficient of the table.
        power=_row(uncertainty.get("power_coefficient", (1.0, 1.0))).reshape(2),
        wake=np.zeros(len(cells)),
    )
    return loop._replace(wake=_wake(loop, surface)) if uncertainty["frozen_wake"] else loop


def _wake(loop: CertifiedLoop, surface: Surface) -> Floats:
    """Return 1 in the cells where every wake up to the frozen one belongs to the family, else 0.

    There b_fw + s_P d(T_r/J)/dbeta is not negative over the pitch that the set can reach.
    """
    low, high = loop.cells[:, 0], loop.cells[:, 1]
    tables, slopes = loop.cells[:, 2:7].T, loop.cells[:, 7:12].T
    fits = np.ones(len(low), dtype=bool)
    for middle in (0.0, 0.5, 1.0):
        wind = low + middle * (high - low)
        speed, effort, b, gain, limit = tables + (wind - low) * slopes
        reach = gain * loop.peaks[2]
        high_effort = effort_ramp(effort + reach, loop.overlap) + loop.peaks[1]
        low_effort = np.maximum(effort_ramp(effort - reach, loop.overlap) - loop.peaks[1], 0.0)
        pitch = loop.pitch_min + np.linspace(low_effort, high_effort, PITCHES) / b
        slope = surface(loop.rotor_radius * speed / wind, pitch, dy=1, clip=True)
        fits &= np.all(limit + loop.power[1] * loop.torque_scale * wind**2 * slope >= 0, axis=0)
    return fits.astype(np.float64)


def _row(values: Any) -> Floats:
    return np.array(values, dtype=np.float64)


@compiled
def _coefficient(p: CertifiedLoop, ratio: float, pitch: float) -> float:
    """Return c_Q; outside the table it is held at the edge."""
    x = min(max(ratio, p.ratio[0]), p.ratio[-1])
    y = min(max(pitch, p.pitch[0]), p.pitch[-1])
    i = min(np.searchsorted(p.ratio, x, "right"), len(p.ratio) - 1) - 1
    j = min(np.searchsorted(p.pitch, y, "right"), len(p.pitch) - 1) - 1
    x, y, value = x - p.ratio[i], y - p.pitch[j], 0.0
    for n in range(3, -1, -1):
        row = p.patches[i, j, n, 3]
        for m in range(2, -1, -1):
            row = row * y + p.patches[i, j, n, m]
        value = value * x + row
    return value


@compiled
def _ramp(effort: float, overlap: float) -> float:
    if effort <= -overlap:
        return 0.0
    above = effort + overlap
    return effort if effort >= overlap else above * above / (4.0 * overlap)


@compiled
def _quadratic(M: Floats, xi: State) -> float:
    a, b, c = xi
    value: float = M[0, 0] * a * a + M[1, 1] * b * b + M[2, 2] * c * c
    value += 2.0 * (M[0, 1] * a * b + M[0, 2] * a * c + M[1, 2] * b * c)
    return value


@compiled
def schedule(p: CertifiedLoop, k: int, wind: float) -> Schedule:
    """Return omega*, q*, b, gamma and b_fw at a wind of cell k."""
    row, beyond = p.cells[k], wind - p.cells[k, 0]
    return (
        row[2] + beyond * row[7],
        row[3] + beyond * row[8],
        row[4] + beyond * row[9],
        row[5] + beyond * row[10],
        row[6] + beyond * row[11],
    )


@compiled
def command(p: CertifiedLoop, k: int, wind: float, state: State) -> tuple[float, float, float]:
    """Return torque [N m] and pitch [rad] before their limits, and psi(U)."""
    reference, trim, b, gain, _ = schedule(p, k, wind)
    signal = state[0] - reference - state[2]
    effort = trim + gain * signal
    shed, reserve = _ramp(effort, p.overlap), _ramp(-effort, p.overlap)
    return p.rated_torque - p.effort_torque * reserve, p.pitch_min + shed / b, shed


@compiled
def rates(p: CertifiedLoop, k: int, wind: float, u: Inputs, kappa: float, state: State) -> State:
    """Return omega', beta', x' at a schedule wind of cell k, under the inputs u."""
    reference, effort, b, _, limit = schedule(p, k, wind)
    torque, demanded, _ = command(p, k, wind, state)
    torque = min(max(torque, 0.0), p.rated_torque)
    demanded = min(max(demanded, p.pitch_min), p.pitch_max)
    v = max(wind + u[0], LEAST_WIND)
    ratio = state[0] * p.rotor_radius / v
    driving = u[3] * p.torque_scale * v * v * _coefficient(p, ratio, state[1])
    if u[2] > 0.0:
        trim = p.pitch_min + _ramp(effort, p.overlap) / b
        ratio = reference * p.rotor_radius / wind
        change = _coefficient(p, ratio, state[1]) - _coefficient(p, ratio, trim)
        scale = u[3] * p.torque_scale * wind * wind
        driving -= u[2] * (limit * (state[1] - trim) + scale * change)
    fastest, turn = p.pitch_rate_limit, -p.cells[k, 12] * (state[0] - reference)
    saturated = abs(state[2]) >= p.integral_limit and turn * state[2] > 0.0
    return (
        kappa * (driving - p.gear_scale * torque),
        min(max((demanded - state[1]) / p.pitch_lag, -fastest), fastest),
        0.0 if saturated else turn,
    )


@compiled
def _moved(state: State, time: float, rate: State) -> State:
    return state[0] + time * rate[0], state[1] + time * rate[1], state[2] + time * rate[2]


@compiled
def step(
    p: CertifiedLoop, k: int, wind: float, u: Inputs, kappa: float, x: State, time: float
) -> State:
    """Return the state a time [s] later, by one step of Kutta's fourth-order method (1901)."""
    half = wind + time / 2.0 * u[1]
    k1 = rates(p, k, wind, u, kappa, x)
    k2 = rates(p, k, half, u, kappa, _moved(x, time / 2.0, k1))
    k3 = rates(p, k, half, u, kappa, _moved(x, time / 2.0, k2))
    k4 = rates(p, k, wind + time * u[1], u, kappa, _moved(x, time, k3))
    x = _moved(_moved(x, time / 6.0, k1), time / 3.0, k2)
    return _moved(_moved(x, time / 3.0, k3), time / 6.0, k4)


@compiled
def errors(p: CertifiedLoop, k: int, wind: float, state: State) -> State:
    """Return xi = (e, zeta, x), zeta = psi(U) - b (beta - beta_min)."""
    reference, _, b, _, _ = schedule(p, k, wind)
    shed = command(p, k, wind, state)[2]
    return state[0] - reference, shed - b * (state[1] - p.pitch_min), state[2]


@compiled
def _inputs(p: CertifiedLoop, k: int, shares: Floats) -> Inputs:
    """Return the inputs that are these shares of the class in cell k."""
    power = p.power[0] + shares[3] * (p.power[1] - p.power[0])
    return shares[0] * p.wind_error[k], shares[1] * p.wind_rate[k], shares[2] * p.wake[k], power


@compiled
def _push(
    p: CertifiedLoop, k: int, wind: float, kappa: float, state: State, Q: Floats, shares: Floats
) -> None:
    """Write the shares at which xi' Q xi grows fastest, one input after the other."""
    for i in range(4):
        largest = -inf
        for end in (-1.0 if i < 2 else 0.0, 1.0):
            former, shares[i] = shares[i], end
            u = _inputs(p, k, shares)
            ahead = _moved(state, AHEAD, rates(p, k, wind, u, kappa, state))
            value = _quadratic(Q, errors(p, k, wind + AHEAD * u[1], ahead))
            if largest > value:
                shares[i] = former
            else:
                largest = value


@compiled
def _measure(
    loop: CertifiedLoop, k: int, wind: float, u: Inputs, state: State, now: Floats
) -> State:
    """Write the ratio to each bound except the decays; return xi."""
    torque, pitch, _ = command(loop, k, wind, state)
    e, lag, x = errors(loop, k, wind, state)
    now[0] = _quadratic(loop.P, (e, lag, x))
    now[1], now[2] = abs(e) / loop.peaks[0], abs(lag) / loop.peaks[1]
    now[3], now[4] = abs(e - x) / loop.peaks[2], abs(x) / loop.peaks[3]
    now[5] = (state[0] - loop.top_speed) / loop.peaks[0]
    now[6] = (loop.rated_torque - torque) / loop.rated_torque
    reach, below = loop.pitch_max - loop.pitch_min, loop.pitch_min - state[1]
    now[7] = (pitch - loop.pitch_min) / reach
    now[8] = 1.0 + below / reach if below > 0.0 else 0.0
    ratio = loop.rotor_radius * state[0] / max(wind + u[0], LEAST_WIND)
    inside = (
        loop.ratio[0] <= ratio <= loop.ratio[-1] and loop.pitch[0] <= state[1] <= loop.pitch[-1]
    )
    now[TABLE] = 0.0 if inside else 2.0
    return e, lag, x


@compiled
def _equilibrium(loop: CertifiedLoop, k: int, wind: float, u: Inputs, kappa: float) -> float:
    """Return x* of the equilibrium (0, 0, x*) at constant wind, by bisection."""
    reference, effort, b, gain, _ = schedule(loop, k, wind)
    low, high = -2.0 * loop.peaks[3], 2.0 * loop.peaks[3]
    for _ in range(BISECTIONS):
        x = (low + high) / 2.0
        pitch = loop.pitch_min + _ramp(effort - gain * x, loop.overlap) / b
        # e' grows with x: a larger x asks for less effort.
        if rates(loop, k, wind, u, kappa, (reference, pitch, x))[0] < 0.0:
            low = x
        else:
            high = x
    middle: float = (low + high) / 2.0
    return middle


@compiled
def _decay(rate: float, time: float, first: float, last: float) -> float:
    """Return the certified rate over the mean one since the start; 0 where nothing is left."""
    if not (rate > 0.0 and time > 0.0 and first > NEAREST and last > NEARLY_THERE * first):
        return 0.0
    ratio: float = 2.0 * rate * time / log(first / last) if last < first else inf
    return ratio


@compiled
def _start(
    loop: CertifiedLoop, draw: np.random.Generator, level: float
) -> tuple[int, float, State]:
    """Return cell, schedule wind and state of a start with V <= level.

    If pitch would start below its limit, which the theorem excludes, the mirror image is used:
    there zeta <= 0 <= psi(U).
    """
    k, share = int(draw.integers(0, len(loop.cells))), draw.random()
    if draw.random() < AT_NODES:
        share = round(share)
    wind = loop.wind[k] * (1.0 - share) + loop.wind[k + 1] * share
    kind = draw.random()
    if kind > 1.0 - AT_CORNERS:
        sign = 1.0 if draw.random() < 0.5 else -1.0
        xi = sign * loop.corners[draw.integers(0, len(loop.corners))]
    else:
        direction = draw.standard_normal(3)
        xi = loop.root @ (direction / sqrt((direction * direction).sum()))
        if kind >= ON_BOUNDARY:
            xi = xi * draw.random() ** (1.0 / 3.0)
    xi = xi * sqrt(level * (1.0 - WITHIN))
    reference, effort, b, gain, _ = schedule(loop, k, wind)
    pitch = 0.0
    for _ in range(2):
        pitch = loop.pitch_min + (_ramp(effort + gain * (xi[0] - xi[2]), loop.overlap) - xi[1]) / b
        if pitch >= loop.pitch_min:
            break
        xi = -xi
    return k, wind, (reference + xi[0], min(pitch, loop.pitch_max), xi[2])


@compiled
def run(
    loop: CertifiedLoop,
    draw: np.random.Generator,
    kind: int,
    level: float,
    duration: float,
    share: Floats,
    events: Floats,
) -> None:
    """Write what one run did: ``share`` and ``events``, nan where there is nothing.

    Parameters
    ----------
    loop : with the class and the plants of the campaign;  kind : index into ``PLAYERS``.
    level : starts have V up to this;  duration : of the run [s].
    share : the largest ratio to each bound;  events : as ``EVENTS`` names them.
    """
    k, wind, state = _start(loop, draw, level)
    inertia = loop.inertia[0] + draw.random() * (loop.inertia[1] - loop.inertia[0])
    if draw.random() < 0.5:
        inertia = loop.inertia[draw.integers(0, 2)]
    kappa, equilibrium = 1.0 / inertia, 0.0
    now, shares = np.zeros(len(BOUNDS)), np.zeros(4)
    mean = np.empty(4)
    for i in range(4):
        mean[i] = SHORTEST * (LONGEST / SHORTEST) ** draw.random()
        # Constant wake and c_P: a third at each end of the range, the others between.
        shares[i] = min(max(3.0 * draw.random() - 1.0, 0.0), 1.0) if i > 1 else 0.0
    Q = loop.P
    if kind == AGAINST_BOUND:
        h = DIRECTIONS[draw.integers(0, 3)]
        Q = np.outer(h, h)
    first, first_common = 0.0, 0.0
    share[:], events[:] = nan, nan
    time, last, end = 0.0, inf, len(loop.cells) - 1
    while True:
        if kind == SWITCHES:
            for i in range(4):
                if draw.random() < 1.0 - exp(-last / mean[i]):
                    # The first time either end, then the other one.
                    high = draw.random() < 0.5 if time == 0.0 else shares[i] < 1.0
                    shares[i] = 1.0 if high else (-1.0 if i < 2 else 0.0)
        elif kind >= AGAINST_SET:
            _push(loop, k, wind, kappa, state, Q, shares)
        if wind >= loop.wind[k + 1] and shares[1] > 0.0:
            k = min(k + 1, end)
        elif wind <= loop.wind[k] and shares[1] < 0.0:
            k = max(k - 1, 0)
        u = _inputs(loop, k, shares)
        # The law limits its schedule wind to the range of its tables.
        if (wind >= loop.wind[-1] and u[1] > 0.0) or (wind <= loop.wind[0] and u[1] < 0.0):
            u = (u[0], 0.0, u[2], u[3])
        e, lag, x = _measure(loop, k, wind, u, state, now)
        if kind == CALM:
            if time == 0.0:
                equilibrium = _equilibrium(loop, k, wind, u, kappa)
                first = _quadratic(loop.P, (e, lag, x - equilibrium))
                first_common = _quadratic(loop.R, (e, lag, x - equilibrium))
            off = (e, lag, x - equilibrium)
            now[DECAY] = _decay(loop.decay_rate[k], time, first, _quadratic(loop.P, off))
            now[COMMON] = _decay(loop.common_rate, time, first_common, _quadratic(loop.R, off))
        for i in range(len(BOUNDS) if kind == CALM else DECAY):
            share[i] = now[i] if time == 0.0 else max(share[i], now[i])
            if i > 0 and now[i] > 1.0 + TOLERANCE and np.isnan(events[0]):
                events[0], events[1] = i, wind
        events[2] = now[0]
        if time >= duration or now[TABLE] > 1.0:
            return
        early = EARLY_PARTS if time < EARLY_LAGS * loop.pitch_lag else 1.0
        last = min(STEP_SHARE * loop.pitch_lag / early, duration - time)
        node = loop.wind[k + 1] if u[1] > 0.0 else loop.wind[k]
        meets = u[1] != 0.0 and (node - wind) / u[1] <= last
        if meets:
            last = (node - wind) / u[1]
        state = step(loop, k, wind, u, kappa, state, last)
        wind = node if meets else wind + last * u[1]
        time += last
