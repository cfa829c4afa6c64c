r"""A controller of a given order, from the measured states to the inputs.

    x_c' = A_c x_c + B_c (y - y*),   u = u* - C_c x_c - D_c (y - y*)

is static output feedback of the plant with integrators (``static_gains.with_integrators``):
(u, v) = -F (y, x_c) with F = [D_c C_c; -B_c -A_c], the same for all rules.  No convex form of the
question is known.  F is sought by descent on an energy gain, from many starts
(``lmi/gains/descent``), in the worst vertex:

    from    pushes on every state, of its range each time constant, and noise of the sensors, a
            share of their ranges; or from what ``objective = "hinf"`` names, and that noise
    to      states and inputs over their ranges; or what ``performance`` names

Less noise makes a faster controller.  Each share of noise begins where the last one ended.  A
decay rate alpha is asked for by A + alpha I in the place of A.  Where the vertices have no common
quadratic function, gains and function are changed together (``lmi/gains/structured``).  Of the
loops with such a function that are not much slower than others, the one with the largest set of
starts (x, x_c = 0) is taken; without limits of inputs, the first; for an energy gain, the one with
the least.  x_c is written in units in which it is of order one from starts in the ranges.

Source: Burke, Henrion, Lewis, Overton (2006), 5th IFAC Symposium on Robust Control Design.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from takagi.certificates.design.plant.static_gains import beyond_search, measured_states
from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.certificates.design.plant.norm_wish import NormWish
    from takagi.certificates.requests.loop.loop import ClaimedLoop
    from takagi.lmi import Design
    from takagi.lmi.gains.descent.many_starts import GainLoops
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Noise of the sensors as shares of the ranges, and what inputs over their ranges count beside
# states; for an energy gain, which says what counts, the noise alone.
WEIGHTS, WEIGHTS_OF_GAIN = ((0.3, 1.0), (1.0, 3.0), (3.0, 10.0)), ((1e-2, 1.0), (1e-3, 1.0))
STARTS, SEED = 4, 0
# Of the descent from one share of noise to the next: steps, and the gain with which it ends.
STEPS, ENOUGH = 200, 1e-3
# The size of gains with a common function, at most, beside those without.
LARGER = 3.0
# The rate with which their search ends if none is asked, per how fast the plant moves; and how much
# slower than the fastest a controller with a larger set may be.
SLOW, SLOWER = 0.02, 0.5
# How much faster than asked the vertices are made.
FASTER = 1.1
# Share of the loop's largest decay rate for the search of the set of starts, if no rate is asked.
SHARE_OF_RATE = 0.25


def fixed_order_gains(
    plant: Plant,
    model: TSModel,
    settings: PlantSettings,
    wish: NormWish | None,
    *,
    box: Floats,
    input_limit: Floats | None,
) -> tuple[Design, tuple[str, ...]]:
    """Return the controller as gains of states and inputs of the plant with integrators, and notes.

    Parameters
    ----------
    box : (n,) half-widths of the states, inf for none.
    input_limit : (m,), inf for the integrators' inputs; None without limits.

    Returns
    -------
    A ``Design`` without gains, whose answer says what to try, where none was found.
    """
    from takagi.certificates.document.plant_embedding import plant_and_claim
    from takagi.certificates.requests.decay import common_function
    from takagi.certificates.requests.loop.loop import ClaimedLoop
    from takagi.lmi import Answer, Design

    order, rate = settings.order, settings.decay_rate
    alpha = rate if isinstance(rate, float | int) else None
    task = _Task(plant, model, settings, wish, *_sizes(model, plant, box, input_limit))
    data = plant_and_claim(model)[0]
    tried: list[str] = []
    candidates: list[tuple[float, Design, str]] = []
    for share, K in _controllers(task):
        words = f"with sensor noise of {share:g} times the ranges"
        loop = ClaimedLoop.of(model, K, model_data=data)
        answer = common_function(loop, alpha)
        if answer.P is None or (alpha is None and not (answer.decay_rate or 0.0) > 0):
            tried.append(f"{words} every rule is stable, but no common function was found")
            continue
        size, P = 1.0, np.asarray(answer.P)
        if wish is not None:
            loops = _loops(task, 0.0, 1.0)
            size = -loops.norm(loops.entries(K[:1] @ loops.C2[0].T))[0]
        elif input_limit is not None and np.isfinite(box).any():
            set_rate = SHARE_OF_RATE * (answer.decay_rate or 0.0) if alpha is None else alpha
            size, P = _set_of_starts(loop, plant, input_limit, set_rate) or (0.0, P)
        design = Design(
            gains=K,
            P=P,
            decay_rate=float(answer.decay_rate or alpha or 0.0),
            margin=answer.margin,
            relaxation="common-gain",
            answer=answer,
        )
        candidates.append((size, design, words))
        if wish is None and input_limit is None:
            break
    names = ", ".join(settings.feedback)
    sought = f"controller of {names} with {order} state{'s' if order > 1 else ''}"
    if candidates:
        slowest = SLOWER if wish is None else 0.0
        enough = slowest * max(design.decay_rate for _, design, _ in candidates)
        fast = [entry for entry in candidates if entry[1].decay_rate >= enough]
        _, design, words = max(fast, key=lambda entry: entry[0])
        note = f"a {sought}, by a local search {words}"
        return design, (note, *beyond_search(settings))
    steps = [f"a higher order than {order}"] if order < len(plant.own_states) else []
    steps += ["narrower ranges"] if len(model.A) > 1 else []
    steps += ["a lower decay rate"] if alpha else []
    steps += ["another state in measured", "no controller for an observer"]
    why = "; ".join(tried) or "no start led to stable rules"
    diagnosis = f"a local search found no {sought} ({why}); try {', or '.join(steps)}"
    unknown = Answer(status="unknown", margin=-np.inf, diagnosis=diagnosis)
    return Design(decay_rate=0.0, margin=-np.inf, relaxation="common-gain", answer=unknown), ()


class _Task(NamedTuple):
    """What is asked; sizes of the plant's states and inputs, and how fast it moves."""

    plant: Plant
    model: TSModel
    settings: PlantSettings
    wish: NormWish | None
    states: Floats
    inputs: Floats
    speed: float


def _sizes(
    model: TSModel, plant: Plant, box: Floats, input_limit: Floats | None
) -> tuple[Floats, Floats, float]:
    """Return sizes of the plant's own states and inputs, and how fast it moves, per s or sample."""
    from takagi.lmi.cone.balance import state_units

    n, m = len(plant.own_states), len(plant.inputs) - len(plant.integrators)
    A, B = np.asarray(model.A)[:, :n, :n], np.asarray(model.B)[:, :n, :m]
    s = np.where(np.isfinite(box[:n]), box[:n], state_units(A, None, step=model.sample_time))
    moved = (A if model.sample_time is None else A - np.eye(n)) * s / s[:, None]
    speed = float(np.abs(np.linalg.eigvals(moved)).max())
    reach = np.abs(B / s[:, None]).max(axis=(0, 1))
    u = (speed or 1.0) / np.where(reach > 0, reach, 1.0)
    if input_limit is not None:
        u = input_limit[:m]
    fastest = (np.abs(moved).sum(axis=2) + np.abs(B / s[:, None]) @ u).max(axis=0)
    return s, u, float(fastest.min()) or 1.0


def _controllers(task: _Task) -> Iterator[tuple[float, Floats]]:
    """Yield shares of noise and gains K (r, m, n), one for all rules.

    With stable vertices, and where it is found, with a common function.
    """
    from takagi.lmi.gains.descent.many_starts import best_gains, descend

    F: Floats | None = None
    enough = 0.0 if task.settings.decay_rate else SLOW * task.speed
    for share, price in WEIGHTS if task.wish is None else WEIGHTS_OF_GAIN:
        loops = _loops(task, share, price)
        if F is None or task.wish is not None:
            named = [] if F is None else [("before", F)]
            ends = best_gains(loops, named, starts=STARTS, seed=SEED)
            if not ends:
                return
            F = ends[0].F
        else:
            end = descend(loops.norm, loops.entries(F), steps=STEPS, enough=ENOUGH)
            F = loops.gains(end.x)
        K = _with_function(loops, F, enough) @ loops.C2[0]
        rule_gains = np.broadcast_to(K, task.model.B.transpose(0, 2, 1).shape)
        yield share, _in_even_states(task.model, task.states, rule_gains)


def _with_function(loops: GainLoops, F: Floats, enough: float) -> Floats:
    """Return gains near F (1, m, p) with a common quadratic function; F where none is found.

    ``enough`` : the decay rate with which the search ends.
    """
    from takagi.lmi.cone.balance import state_units
    from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
    from takagi.lmi.gains.structured.joint_steps import StepSearch
    from takagi.lmi.gains.structured.local_search import LocalSearch, LocalStart
    from takagi.lmi.gains.structured.structure import Structure

    if len(loops.A) == 1:
        return F
    step = 1.0 if loops.discrete else None
    search = StepSearch(
        plant=DisturbedPlant(
            A=loops.A,
            B=-loops.B2,
            E=loops.B1,
            C=loops.C1,
            D12=-loops.D12,
            D11=loops.D11,
            sample_time=step,
        ),
        structure=Structure(pattern=loops.pattern, C=loops.C2[0], group=loops.group),
        objective="decay_rate",
        relaxation="common-gain",
        deviations=np.eye(loops.A.shape[1]),
        gain_bound=LARGER * float(np.linalg.norm(F[0], 2)),
    )
    s = state_units(loops.A, None, step=step)
    point = LocalSearch(search).begun(LocalStart("descent", F, np.diag(s**-2.0)), enough)
    return F if point is None else point.F


def _loops(task: _Task, share: float, price: float) -> GainLoops:
    """Return the loops of the module's text, with (u, v) = -F (y, x_c)."""
    from takagi.lmi.gains.descent.many_starts import GainLoops

    model, rate, s, u = task.model, task.settings.decay_rate, task.states, task.inputs
    (r, n, m), count = model.B.shape, len(s)
    rows = measured_states(task.plant, task.settings)
    y = np.eye(n)[rows]
    if task.wish is None:
        E = np.eye(n, count) * task.speed * s
        C = np.vstack([np.eye(count, n) / s[:, None], np.zeros((len(u), n))])
        D12 = np.vstack([np.zeros((count, m)), price * np.eye(len(u), m) / u[:, None]])
        D11 = np.zeros((len(C), count))
        E, C, D12, D11 = (np.broadcast_to(M, (r, *M.shape)) for M in (E, C, D12, D11))
    else:
        disturbed = task.wish.plant(model, None)
        E, C, D12, D11 = disturbed.E, disturbed.C, disturbed.D12, disturbed.D11
    sensors = [k for k, row in enumerate(rows) if row < count]
    noise = np.zeros((len(rows), len(sensors)))
    noise[sensors, range(len(sensors))] = share * s[[rows[k] for k in sensors]]
    sensed, p = np.hstack([np.zeros((len(rows), E.shape[2])), noise]), C.shape[1]
    faster = FASTER * rate if isinstance(rate, float | int) else 0.0
    A, B = np.array(model.A, dtype=np.float64), np.array(model.B, dtype=np.float64)
    if model.sample_time is None:
        A = A + faster * np.eye(n)
    else:
        A, B = (np.exp(faster * model.sample_time) * M for M in (A, B))
    return GainLoops(
        A=A,
        B1=np.concatenate([E, np.zeros((r, n, len(sensors)))], axis=2),
        B2=-B,
        C1=np.asarray(C),
        C2=np.broadcast_to(y, (r, *y.shape)),
        D11=np.concatenate([D11, np.zeros((r, p, len(sensors)))], axis=2),
        D12=-np.asarray(D12),
        D21=np.broadcast_to(sensed, (r, *sensed.shape)),
        pattern=np.ones((m, len(rows)), dtype=bool),
        group=np.zeros(r, dtype=np.intp),
        discrete=model.sample_time is not None,
    )


def _in_even_states(model: TSModel, s: Floats, K: Floats) -> Floats:
    """Return K with x_c in units in which its mean square, from starts of size s, is that of 1."""
    count, n = len(s), model.A.shape[1]
    A = np.mean(np.asarray(model.A) - np.asarray(model.B) @ K, axis=0)
    start = np.zeros((n, n))
    start[:count, :count] = np.diag(s**2)
    if model.sample_time is None:
        speed = max(float(-np.linalg.eigvals(A).real.max()), 1e-9)
        spread = solve_continuous_lyapunov(A, -speed * start)
    else:
        spread = solve_discrete_lyapunov(A, start)
    values, vectors = np.linalg.eigh(spread[count:, count:])
    if not (np.isfinite(values).all() and values[0] > 1e-12 * values[-1] > 0):
        return K
    root = vectors * np.sqrt(values)
    # Eigenvectors have no sign of their own: the first input falls with each x_c.
    root *= np.where(K[0, 0, count:] @ root < 0, -1.0, 1.0)
    m = model.B.shape[2] - (n - count)
    even = K.copy()
    even[:, :, count:] = even[:, :, count:] @ root
    even[:, m:] = np.linalg.solve(root, even[:, m:])
    return even


def _set_of_starts(
    loop: ClaimedLoop, plant: Plant, input_limit: Floats, rate: float
) -> tuple[float, Floats] | None:
    """Return the mean width of the largest set of starts x, x_c = 0, and its P; or None."""
    from takagi.certificates.requests.loop.set_level import box_rows
    from takagi.lmi.analysis.start_set import start_set

    assert loop.gains is not None
    limited = np.isfinite(input_limit)
    rows = loop.gains[:, limited] / input_limit[limited, None]
    rows = np.vstack([box_rows(loop), rows.reshape(-1, rows.shape[2])])
    starts = np.eye(loop.exact.order)[:, plant.own_states]
    ellipsoid = start_set(loop.A, rows, starts, decay_rate=rate, sample_time=loop.sample_time)
    if ellipsoid.P is None:
        return None
    S = starts.T @ ellipsoid.P @ starts
    return float(np.exp(-0.5 * np.linalg.slogdet(S)[1] / len(S))), ellipsoid.P
