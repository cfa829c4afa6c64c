"""Gains with a structure: prescribed zeros, shared gains, output feedback."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Design, GainsWithAnswer
from takagi.lmi.argument_checks import (
    check_stabilisable,
    input_stack,
    positive_number,
    sample_time_of,
    symmetric,
    vertex_stack,
    whole_number,
)
from takagi.lmi.cone.balance import state_units
from takagi.lmi.gains.cost.regulator import initial_factor, lqr_pdc, weight_factor
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.decay.pdc import pdc
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant, Performance, plant_of
from takagi.lmi.gains.disturbance.energy_gain import hinf_pdc
from takagi.lmi.gains.structured.joint_steps import StepSearch, StructuredPoint
from takagi.lmi.gains.structured.local_search import (
    LocalSearch,
    LocalStart,
    LocalStep,
    descended,
    shown,
)
from takagi.lmi.gains.structured.structure import Objective, check_movable, structure_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError, did_you_mean


def plant_for(
    model: Controlled,
    objective: Objective,
    *,
    Q: ArrayLike | None,
    R: ArrayLike | None,
    deviations: ArrayLike,
    performance: Performance | None,
    sample_time: float | None,
) -> tuple[DisturbedPlant, Floats]:
    """Return the plant, and L of the covariance L L' of x(0).

    For "cost" the output is z = [F x; G u] with Q = F' F, R = G' G, so that |z|^2 is the cost's
    integrand.

    Raises
    ------
    ModelError : an argument that the objective needs is missing, or one that it does not use is
        given; otherwise as ``lqr_pdc`` and ``hinf_pdc``.
    """
    _check_given(objective, {"Q": Q, "R": R}, performance)
    A = vertex_stack(model).astype(np.float64)
    n = A.shape[1]
    if objective == "hinf":
        return plant_of(model, performance, sample_time), np.eye(n)
    B = input_stack(model, A).astype(np.float64)
    r, _, m = B.shape
    C, D12 = np.zeros((r, 1, n)), np.zeros((r, 1, m))
    if objective == "cost":
        assert Q is not None and R is not None  # _check_given has checked this
        F = weight_factor(symmetric("Q", Q, n, definite=False))
        G = weight_factor(symmetric("R", R, m, definite=True))
        C = np.broadcast_to(np.concatenate([F, np.zeros((m, n))]), (r, len(F) + m, n))
        D12 = np.broadcast_to(np.concatenate([np.zeros((len(F), m)), G]), (r, len(F) + m, m))
    plant = DisturbedPlant(
        A=A,
        B=B,
        E=np.zeros((r, n, 1)),
        C=C,
        D12=D12,
        D11=np.zeros((r, C.shape[1], 1)),
        sample_time=sample_time_of(model, sample_time),
        premises=tuple(getattr(model, "premises", ())),
        rules=tuple(getattr(model, "rules", ())),
    )
    return plant, np.asarray(initial_factor(deviations, n), dtype=np.float64)


def _check_given(objective: Objective, weights: Mapping[str, object], performance: object) -> None:
    for name, value in weights.items():
        if objective == "cost" and value is None:
            raise ModelError(f'objective is "cost", but there is no {name}; give Q and R')
        if objective != "cost" and value is not None:
            raise ModelError(f'{name} was given, but objective is "{objective}"; leave it out')
    if objective != "hinf" and performance is not None:
        raise ModelError(f'performance was given, but objective is "{objective}"; leave it out')


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class StructuredDesign(ShortRepr, GainsWithAnswer):
    """Structured gains, their value, and the loss due to the structure.

    Attributes
    ----------
    gains : (r, m, n), K_i = F_i C for u = -sum_i h_i K_i x; None unless found.
    output_gains : (r, m, p), F_i for u = -sum_i h_i F_i C x, exactly zero off the pattern.
    P : (n, n) for V = x' P x; None unless found.
    objective : "decay_rate", "cost" or "hinf".
    value : decay rate in 1/s, mean cost, or gamma, that P shows for these gains; nan without gains.
    unstructured : the best value known without the structure, one gain a rule; nan if unknown.
    loss : relative loss of the value due to the structure, at least 0: 1 - value / unstructured of
        a decay rate, value / unstructured - 1 of a cost or gamma.
    relaxation : name of the double-sum relaxation.
    steps : the accepted steps from all starts, in order.
    answer : the answer of the last LMI, in which the returned gains are fixed and P is unknown.
    """

    gains: Floats | None = None
    output_gains: Floats | None = None
    P: Floats | None = None
    objective: Objective
    value: float = np.nan
    unstructured: float = np.nan
    loss: float = np.nan
    relaxation: str
    steps: tuple[LocalStep, ...] = ()
    answer: Answer


def found_at(
    search: StepSearch, spot: StructuredPoint, unstructured: float, local: LocalSearch
) -> StructuredDesign:
    """Return the design of the best spot.

    ``unstructured`` : the best value known without the structure.
    """
    value = spot.value
    ratio = value / unstructured
    P = spot.P
    if search.objective == "decay_rate":
        # A decay rate does not depend on the size of P: the least eigenvalue is brought to 1 ... 2,
        # by a power of two, which rounds no entry.
        P = P / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    answer = replace(
        spot.outcome.as_answer(spot.condition, None),
        status="candidate",
        P=P,
        decay_rate=value if search.objective == "decay_rate" else None,
        gain=value if search.objective == "hinf" else None,
        tries=tuple(search.tries),
    )
    return StructuredDesign(
        gains=search.structure.gains(spot.F),
        output_gains=spot.F[search.structure.group],
        P=P,
        objective=search.objective,
        value=value,
        unstructured=unstructured,
        loss=1.0 - ratio if search.sense > 0 else ratio - 1.0,
        relaxation=search.relaxation,
        steps=tuple(local.steps),
        answer=answer,
    )


def unsettled(local: LocalSearch) -> Answer:
    """Return the answer for the case that no start led to a stable loop."""
    rate = local.reached()
    return Answer(
        status="unknown",
        margin=-np.inf,
        diagnosis=(
            f"from no start were gains of this structure found; the largest decay rate of one "
            f"quadratic function was {rate:.6g} 1/s: let the law see more, share fewer gains, "
            "raise gain_bound, shrink the box, or take a richer relaxation"
        ),
        tries=tuple(local.search.tries),
    )


# Tolerances of the unstructured H-infinity designs that serve as starts. Near the least gamma the
# feedback gains grow without bound, and a projection of such large gains is a poor start.
MODEST = (1e-1, 1e-2)
# So many ends of descents are starts of the convex steps, where there are several rules.
DESCENTS = 2


def structured_pdc(
    model: Controlled,
    pattern: ArrayLike | None = None,
    *,
    objective: Objective = "decay_rate",
    output: ArrayLike | None = None,
    shared: ArrayLike | None = None,
    relaxation: str = "wang-tanaka-griffin",
    gain_bound: float | None = None,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    deviations: ArrayLike = 1.0,
    performance: Performance | None = None,
    tolerance: float = 1e-5,
    starts: int = 0,
    seed: int = 0,
    sample_time: float | None = None,
) -> StructuredDesign:
    """Return gains F_i for u = -sum_i h_i F_i C x, F_i zero off the pattern, of the best value.

    The result is the best point that a local search reaches from several starts: the projected
    unstructured design, and u = 0.  Each step changes gains and V = x' P x
    together inside a convex inner approximation, then finds the best P for the new gains; so the
    value never gets worse.  Use it for static output feedback, decentralised laws, and gains that
    some rules share.

    Parameters
    ----------
    model : A (r, n, n), B (r, n, m); for "hinf" also E (r, n, q), and C, or ``performance``.
    pattern : (m, p), True where input k may depend on state (output) l; None for all.
    objective : "decay_rate", the largest alpha in 1/s with V' <= -2 alpha V (V(x+) <=
        e^(-2 alpha T) V in discrete time); "cost", the least bound on the mean quadratic cost;
        "hinf", the least gamma in |z|_2 <= gamma |w|_2.
    output : C (p, n) of the measurement y = C x, the same in all vertices; None for the states.
    shared : (r,) labels; rules of one label share a gain.
    relaxation : as for ``pdc``; with "common-gain" all rules share one.
    gain_bound : bound on the spectral norm of every K_i = F_i C.  Needed for "decay_rate", which
        has no largest value without a bound.
    Q, R, deviations : for "cost", as for ``lqr_pdc``.
    performance : for "hinf", as for ``hinf_pdc``.
    tolerance : relative gain of a step at which the search ends.
    starts : for "hinf": the number of random gains from which the norm itself is minimised as well,
        by descent over the entries of F.  As a rule it finds a smaller gamma than the convex steps,
        in less time.  With one rule its gains are the result, and the convex steps are left out;
        with several they are starts of these steps.  0 for the convex steps alone.
    seed : of the random numbers of ``starts``.
    sample_time : T in s of x+ = A x + B u; None takes the model's own.

    Returns a ``StructuredDesign``.  Its value comes from LMIs that were checked by eigenvalues with
    exactly the returned gains.  If the unstructured design is infeasible with a relaxation, so is
    the structured one with the same relaxation.

    The gains need not be the best structured gains, as the problem is not convex; and "unknown"
    without gains does not mean that there are none.  With a gain bound ``unstructured`` is the
    result of the same search without the structure, which is also a local optimum.

    Raises ModelError: wrong shapes, a pattern without True, dependent outputs, an unknown
    relaxation or objective, a missing argument of an objective, or a vertex with an undamped mode
    that no input moves, or that no gain of the pattern moves.

    Source: derived in ``structure``, with the literature.
    """
    relaxation_named(relaxation)
    if objective not in get_args(Objective):
        objectives = get_args(Objective)
        raise ModelError(
            f"objective {objective!r} is not known; there are {', '.join(objectives)}"
            + did_you_mean(str(objective), list(objectives))
        )
    if objective == "decay_rate" and gain_bound is None:
        raise ModelError(
            "a largest decay rate needs bounded gains; give gain_bound, a bound on the spectral "
            "norm of every K_i"
        )
    descents = (whole_number("starts", starts), whole_number("seed", seed))
    if starts and objective != "hinf":
        raise ModelError(
            f'starts is {starts}, but objective is "{objective}"; the descent is on the norm, for '
            '"hinf" alone: leave starts out'
        )
    plant, factor = plant_for(
        model,
        objective,
        Q=Q,
        R=R,
        deviations=deviations,
        performance=performance,
        sample_time=sample_time,
    )
    r, n, m = plant.B.shape
    common = relaxation == "common-gain"
    search = StepSearch(
        plant=plant,
        structure=structure_of((r, n, m), pattern, output, np.zeros(r) if common else shared),
        objective=objective,
        relaxation=relaxation,
        deviations=factor,
        gain_bound=None if gain_bound is None else positive_number("gain_bound", gain_bound),
    )
    _check_modes(search, tuple(getattr(model, "states", ())))
    plain = _unstructured(model, search, Q, R, deviations, performance, sample_time)
    if not plain or plain[0].gains is None:
        return StructuredDesign(objective=objective, relaxation=relaxation, answer=plain[0].answer)
    local = LocalSearch(search)
    spot = _best(local, list(_starts(search, plain)), tolerance, descents)
    if spot is None:
        return StructuredDesign(
            objective=objective,
            relaxation=relaxation,
            steps=tuple(local.steps),
            answer=unsettled(local),
        )
    spot = search.assessed(spot.F, spot.P, value=spot.value, settle=True) or spot
    return found_at(search, spot, _best_without(search, plain, spot, tolerance), local)


def _best(
    local: LocalSearch, named_starts: list[LocalStart], tolerance: float, descents: tuple[int, int]
) -> StructuredPoint | None:
    """Return the best point from the known starts, and from descents on the norm if asked for."""
    starts, seed = descents
    if not starts:
        return local.best(named_starts, tolerance)
    ends = descended(local.search, named_starts, starts=starts, seed=seed)
    if len(local.search.plant.A) > 1:
        return local.best([*ends[:DESCENTS], *named_starts], tolerance)
    spot, steps = shown(local.search, ends)
    local.steps.extend(steps)
    return spot if spot is not None else local.best(named_starts, tolerance)


def _check_modes(search: StepSearch, names: tuple[str, ...]) -> None:
    plant = search.plant
    step = plant.sample_time
    s = state_units(plant.A, None, step=step)
    A, B = plant.A * s / s[:, None], plant.B / s[:, None]
    # Inputs of order one, as ``check_movable`` assumes; 1e-300 leaves an input without effect at 0.
    B = B / np.maximum(np.abs(B).max(axis=(0, 1)), 1e-300)
    check_stabilisable(A, B, units=s, names=names, step=step)
    check_movable(A, B, search.structure, units=s, names=names, step=step)


def _unstructured(
    model: Controlled,
    search: StepSearch,
    Q: ArrayLike | None,
    R: ArrayLike | None,
    deviations: ArrayLike,
    performance: Performance | None,
    sample_time: float | None,
) -> list[Design]:
    """Return designs without structure, the best first; if none exists, one infeasible answer."""
    name, bound = search.relaxation, search.gain_bound
    if search.objective == "cost":
        assert Q is not None and R is not None  # plant_for has checked this
        designs = [
            lqr_pdc(model, Q, R, relaxation=name, deviations=deviations, sample_time=sample_time)
        ]
    elif search.objective == "hinf":
        designs = [
            hinf_pdc(
                model,
                performance=performance,
                relaxation=name,
                gain_bound=bound,
                tolerance=tolerance,
                sample_time=sample_time,
            )
            for tolerance in (1e-6, *reversed(MODEST))
        ]
    else:
        designs = [
            pdc(model, decay_rate="max", relaxation=name, gain_bound=bound, sample_time=sample_time)
        ]
    plain = pdc(search.plant.reaching, relaxation=name)
    good = [design for design in designs if design.gains is not None]
    if plain.gains is not None and len(plain.gains[0]) == search.plant.B.shape[2]:
        good.append(plain)
    return good or [plain if plain.gains is None else designs[0]]


def _starts(search: StepSearch, plain: list[Design]) -> Iterator[LocalStart]:
    n = search.plant.A.shape[1]
    s = state_units(search.plant.A, None, step=search.plant.sample_time)
    for number, design in enumerate(plain):
        if design.gains is None or design.P is None or (number == 0 and len(plain) > 2):
            # The feedback gains grow without bound as gamma approaches its least value.
            continue
        for metric, name in ((np.linalg.inv(design.P), "by P"), (np.diag(s**2), "by size")):
            F = search.structure.projected(design.gains, (metric + metric.T) / 2)
            yield LocalStart(f"unstructured {number + 1}, projected {name}", F, design.P)
    zero = np.zeros((search.structure.groups, *search.structure.pattern.shape))
    yield LocalStart("no control", zero, np.diag(s ** (-2.0)) + np.zeros((n, n)))


def _best_without(
    search: StepSearch, plain: list[Design], spot: StructuredPoint, tolerance: float
) -> float:
    """Return the best value known without the structure; the structured gains count as well."""
    sense = search.sense
    free = replace(search, structure=search.structure.free)
    values = [spot.value]
    if search.gain_bound is None:
        first = plain[0]
        convex = first.cost if search.objective == "cost" else first.answer.gain
        values += [convex] if convex is not None else [np.nan]
    else:
        K = search.structure.gains(spot.F)
        starts = [LocalStart("structured", K, spot.P)]
        starts += [
            LocalStart("unstructured", design.gains, design.P)
            for design in plain
            if design.gains is not None and design.P is not None
        ]
        best_point = LocalSearch(free).best(starts, tolerance)
        values += [best_point.value] if best_point is not None else []
    if np.isnan(values).any():
        return float("nan")
    return float(sense * max(sense * value for value in values))
