r"""Static output feedback: gains on the measured states alone, u = u* - sum_i h_i F_i (y - y*).

The law is one of all states whose gains on the others are zero: K_i = F_i C.  Loop, claims, gain
file and exports are those of a law of all states, and the certificate shows the zeros.  Rules have
gains of their own only if every premise is computed from what is measured.

No convex form of the question is known.  The gains are the best that a local search from several
starts finds (``takagi.lmi.structured_pdc``), which knows no limits of inputs and no region of
poles; the claims about these decide.

    hinf asked for                 the energy gain
    no decay rate, all ranges      the cost, states and inputs weighed by their ranges
    else                           the largest decay rate

The gains are bounded by ``gain_bound``, or by twice the norm of gains of all states.

A controller of a given order, from the measured states to the inputs.

    x_c' = A_c x_c + B_c (y - y*),   u = u* - C_c x_c - D_c (y - y*)

is static output feedback of the plant with integrators (``with_integrators``):
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
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from takagi.certificates.design.plant.gain_task import FoundGains, GainTask
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.plant.norm_wish import NormWish
    from takagi.certificates.requests.loop.loop import ClaimedLoop
    from takagi.lmi import Design
    from takagi.lmi.gains.descent.gain_loops import GainLoops
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Random gains from which the energy gain is minimised as well.
STATIC_STARTS = 10
# Bound on the gains where none is given, in the norm of gains of all states.
STATIC_LARGER = 2.0


def plant_of_law(plant: Plant, settings: PlantSettings) -> Plant:
    """Return the plant as the law sees it.

    One with a static law needs no observer, one with a controller has the controller's states.

    Raises
    ------
    ModelError : as ``with_integrators``.
    """
    if not settings.feedback or plant.integrators:
        return plant
    return with_integrators(replace(plant, measured=None), settings.order)


def with_integrators(plant: Plant, order: int) -> Plant:
    """Return the plant with x_c' = v beside it, in discrete time x_c(t + T) = v; v are inputs.

    Raises
    ------
    ModelError : more of them than states, or a name of theirs is taken.
    """
    import sympy as sp

    from takagi.models.plant.plant import Variable

    if order > len(plant.states):
        raise ModelError(
            f"controller order={order}: plant {plant.name!r} has {len(plant.states)} states, and "
            "more are of no use to a controller; ask for at most so many"
        )
    names = [f"controller_{k + 1}" for k in range(order)]
    rate_unit = "1/s" if plant.sample_time is None else "-"
    words = "state of the controller itself, no signal of the plant"
    states = [Variable(sp.Symbol(name, real=True), "-", description=words) for name in names]
    rates = [
        Variable(sp.Symbol(f"{name}_rate", real=True), rate_unit, description=f"moves {name}")
        for name in names
    ]
    taken = {v.name for v in plant.variables} | {str(s) for s in (*plant.values, *plant.premises)}
    if clashes := sorted(taken & {v.name for v in (*states, *rates)}):
        raise ModelError(
            f"controller order={order}: {', '.join(clashes)} is a name of the controller, and one "
            f"of plant {plant.name!r}; rename it there"
        )
    return replace(
        plant,
        equations=(*plant.equations, *(v.symbol for v in rates)),
        states=(*plant.states, *states),
        inputs=(*plant.inputs, *rates),
        mass=None if plant.mass is None else sp.diag(plant.mass, sp.eye(order)),
        integrators=tuple((x.name, v.name) for x, v in zip(states, rates, strict=True)),
    )


def require_states(plant: Plant, settings: PlantSettings) -> None:
    """Raise ModelError unless the law has states alone, and searches that it can have."""
    states = tuple(v.name for v in plant.states)
    for name in settings.feedback:
        if name not in states:
            raise ModelError(
                f"controller: {name} is measured and is no state; name states in measured ("
                f"{', '.join(states)}), write the plant with {name} as a state, or leave "
                "controller out for a law with an observer"
            )
    if settings.objective in ("h2", "peak", "effort"):
        raise ModelError(
            f"objective {settings.objective}: gains of a static law are sought for hinf, for decay "
            "or for the cost by the ranges; choose one of them, or leave controller out"
        )
    if plant.integrators and settings.gain_bound is not None:
        raise ModelError(
            "gain_bound beside a controller of a given order: the sizes of its gains depend on the "
            "units of its states, which are free; bound the inputs by input_limit instead"
        )
    if plant.integrators and (settings.objective == "decay" or settings.decay_rate == "max"):
        raise ModelError(
            "the largest decay rate is not sought for a controller of a given order; give a rate "
            "in numbers, such as --decay-rate 2, and raise it as long as it is proved"
        )


def measured_states(plant: Plant, settings: PlantSettings) -> list[int]:
    """Return the places of the states that the law has: those measured, and its own."""
    known = {*settings.feedback, *(state for state, _ in plant.integrators)}
    return [k for k, v in enumerate(plant.states) if v.name in known]


def static_gains(
    task: GainTask, wish: NormWish | None, *, relaxation: str, unstructured: Design
) -> FoundGains:
    """Return the best gains that were found.

    ``unstructured`` : gains of all states with the same wishes, for the size that is natural.
    """
    from takagi.lmi import structured_pdc

    plant, settings, box, input_limit = task.plant, task.settings, task.box, task.input_limit
    rows = measured_states(plant, settings)
    names = ", ".join(plant.states[k].name for k in rows)
    if not unstructured.found:
        return FoundGains(unstructured, (f"without gains of all states there are none of {names}",))
    natural = float(np.linalg.norm(np.asarray(unstructured.gains), 2, axis=(1, 2)).max())
    options: dict[str, Any] = {
        "output": np.eye(len(plant.states))[rows],
        "gain_bound": settings.gain_bound or float(f"{STATIC_LARGER * natural:.3g}"),
        "objective": "decay_rate",
    }
    subject: Any = task.model
    costs = settings.decay_rate is None and settings.objective is None and np.isfinite(box).all()
    if wish is not None:
        subject = wish.plant(task.model, None)
        # Of one rule the descent is the whole search; of several it is a start more.
        options |= {"objective": "hinf", "starts": STATIC_STARTS if len(task.model.A) == 1 else 0}
    elif costs and input_limit is not None:
        weights = {"Q": np.diag(box**-2), "R": np.diag(input_limit**-2), "deviations": box}
        options |= {"objective": "cost", **weights}
    result = structured_pdc(subject, relaxation=relaxation, **options)
    aim = "energy gain" if wish is not None else options["objective"].replace("_", " ")
    note = f"static output feedback of {names}, by a local search for the best {aim}"
    if aim == "decay rate" and task.rate is not None and result.value < task.rate:
        note += f"; it is {result.value:.4g} 1/s, with a norm of at most {options['gain_bound']:g}"
    design = replace(
        unstructured,
        gains=result.gains,
        P=result.P,
        decay_rate=result.value if aim == "decay rate" else 0.0,
        relaxation=result.relaxation,
        answer=result.answer,
    )
    return FoundGains(design, (note, *beyond_search(settings)))


def beyond_search(settings: PlantSettings) -> tuple[str, ...]:
    """Return a note about the wishes that were made and that the search ignores."""
    outside = [name for name in ("initial", "damping", "fastest") if getattr(settings, name)]
    if not outside:
        return ()
    law = f"order={settings.order}" if settings.order else "static"
    smaller = "" if settings.order else "try a smaller gain_bound, or "
    return (
        f"{' and '.join(outside)} beside controller {law}: the search does not know them, and the "
        f"claims about the gains decide; where one is not proved, {smaller}leave controller out",
    )


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


def fixed_order_gains(task: GainTask, wish: NormWish | None) -> FoundGains:
    """Return the controller as gains of states and inputs of the plant with integrators.

    Where none was found, the answer says what to try.  The task's limits of the integrators' inputs
    are inf.
    """
    from takagi.certificates.document.plant_embedding import plant_and_claim
    from takagi.certificates.requests.decay import common_function
    from takagi.certificates.requests.loop.loop import ClaimedLoop
    from takagi.lmi import Answer, Design

    model, settings, input_limit, alpha = task.model, task.settings, task.input_limit, task.rate
    search, order = _Search(task, wish, *_sizes(task)), settings.order
    data = plant_and_claim(model)[0]
    tried: list[str] = []
    candidates: list[tuple[float, Design, str]] = []
    for share, K in _controllers(search):
        words = f"with sensor noise of {share:g} times the ranges"
        loop = ClaimedLoop.of(model, K, model_data=data)
        answer = common_function(loop, alpha)
        if answer.P is None or (alpha is None and not (answer.decay_rate or 0.0) > 0):
            tried.append(f"{words} every rule is stable, but no common function was found")
            continue
        size, P = 1.0, np.asarray(answer.P)
        if wish is not None:
            loops = _loops(search, 0.0, 1.0)
            size = -loops.norm(loops.entries(K[:1] @ loops.C2[0].T))[0]
        elif input_limit is not None and np.isfinite(task.box).any():
            set_rate = SHARE_OF_RATE * (answer.decay_rate or 0.0) if alpha is None else alpha
            size, P = _set_of_starts(loop, task, input_limit, set_rate) or (0.0, P)
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
        return FoundGains(design, (note, *beyond_search(settings)))
    steps = [f"a higher order than {order}"] if order < len(task.plant.own_states) else []
    steps += ["narrower ranges"] if len(model.A) > 1 else []
    steps += ["a lower decay rate"] if alpha else []
    steps += ["another state in measured", "no controller for an observer"]
    why = "; ".join(tried) or "no start led to stable rules"
    diagnosis = f"a local search found no {sought} ({why}); try {', or '.join(steps)}"
    unknown = Answer(status="unknown", margin=-np.inf, diagnosis=diagnosis)
    none = Design(decay_rate=0.0, margin=-np.inf, relaxation="common-gain", answer=unknown)
    return FoundGains(none)


class _Search(NamedTuple):
    """What is asked; sizes of the plant's states and inputs, and how fast it moves."""

    task: GainTask
    wish: NormWish | None
    states: Floats
    inputs: Floats
    speed: float


def _sizes(task: GainTask) -> tuple[Floats, Floats, float]:
    """Return sizes of the plant's own states and inputs, and how fast it moves, per s or sample."""
    from takagi.lmi.cone.balance import state_units

    plant, model, box, input_limit = task.plant, task.model, task.box, task.input_limit
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


def _controllers(search: _Search) -> Iterator[tuple[float, Floats]]:
    """Yield shares of noise and gains K (r, m, n), one for all rules.

    With stable vertices, and where it is found, with a common function.
    """
    from takagi.lmi.gains.descent.many_starts import best_gains, descend

    F: Floats | None = None
    model, wish = search.task.model, search.wish
    enough = 0.0 if search.task.settings.decay_rate else SLOW * search.speed
    for share, price in WEIGHTS if wish is None else WEIGHTS_OF_GAIN:
        loops = _loops(search, share, price)
        if F is None or wish is not None:
            named = [] if F is None else [("before", F)]
            ends = best_gains(loops, named, starts=STARTS, seed=SEED)
            if not ends:
                return
            F = ends[0].F
        else:
            end = descend(loops.norm, loops.entries(F), steps=STEPS, enough=ENOUGH)
            F = loops.gains(end.x)
        K = _with_function(loops, F, enough) @ loops.C2[0]
        rule_gains = np.broadcast_to(K, model.B.transpose(0, 2, 1).shape)
        yield share, _in_even_states(model, search.states, rule_gains)


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


def _loops(search: _Search, share: float, price: float) -> GainLoops:
    """Return the loops of the module's text, with (u, v) = -F (y, x_c)."""
    from takagi.lmi.gains.descent.gain_loops import GainLoops

    task, wish, s, u, speed = search
    model, rate = task.model, task.rate
    (r, n, m), count = model.B.shape, len(s)
    rows = measured_states(task.plant, task.settings)
    y = np.eye(n)[rows]
    if wish is None:
        E = np.eye(n, count) * speed * s
        C = np.vstack([np.eye(count, n) / s[:, None], np.zeros((len(u), n))])
        D12 = np.vstack([np.zeros((count, m)), price * np.eye(len(u), m) / u[:, None]])
        D11 = np.zeros((len(C), count))
        E, C, D12, D11 = (np.broadcast_to(M, (r, *M.shape)) for M in (E, C, D12, D11))
    else:
        disturbed = wish.plant(model, None)
        E, C, D12, D11 = disturbed.E, disturbed.C, disturbed.D12, disturbed.D11
    sensors = [k for k, row in enumerate(rows) if row < count]
    noise = np.zeros((len(rows), len(sensors)))
    noise[sensors, range(len(sensors))] = share * s[[rows[k] for k in sensors]]
    sensed, p = np.hstack([np.zeros((len(rows), E.shape[2])), noise]), C.shape[1]
    faster = FASTER * (rate or 0.0)
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
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

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
    loop: ClaimedLoop, task: GainTask, input_limit: Floats, rate: float
) -> tuple[float, Floats] | None:
    """Return the mean width of the largest set of starts x, x_c = 0, and its P; or None."""
    from takagi.certificates.requests.loop.set_level import box_rows
    from takagi.lmi.analysis.start_set import start_set

    assert loop.gains is not None
    limited = np.isfinite(input_limit)
    rows = loop.gains[:, limited] / input_limit[limited, None]
    rows = np.vstack([box_rows(loop), rows.reshape(-1, rows.shape[2])])
    starts = np.eye(loop.exact.order)[:, task.plant.own_states]
    ellipsoid = start_set(loop.A, rows, starts, decay_rate=rate, sample_time=loop.sample_time)
    if ellipsoid.P is None:
        return None
    S = starts.T @ ellipsoid.P @ starts
    return float(np.exp(-0.5 * np.linalg.slogdet(S)[1] / len(S))), ellipsoid.P
