r"""The controller that the unknowns of the LMIs stand for, and what its loop does.

Mixed sensitivity: the controller with the least norm of [W1 S; W2 K S; W3 T].

With e = r - y, u = K e, y = G u, the sensitivity is S = (I + G K)^-1 and T = I - S.  W1 asks for
a small error where it is large, W2 limits the input, W3 the bandwidth:

    || [ W1 S ; W2 K S ; W3 T ] ||_inf  =  gamma,     least over all K that stabilise the loop.

Source: Skogestad and Postlethwaite (2005), Multivariable Feedback Control, 2nd edition, sections
2.8.3 and 9.3.5; Kwakernaak (1993), Automatica 29.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from takagi.lmi.analysis.disturbance.guessed_function import norm_seen
from takagi.lmi.answer import Answer, ObjectiveUnit, Status, Try
from takagi.lmi.argument_checks import fixed_mode, positive_number
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import decide, optimise
from takagi.lmi.gains.output_feedback.generalised_plant import (
    ControllerFound,
    GeneralisedPlant,
    StateSpace,
    controller_matrices,
    hinf_output_feedback_condition,
    state_space,
)
from takagi.lmi.gains.output_feedback.moderate import (
    central_controllers,
    entry_size,
    in_even_states,
    loop_norm,
    nearer_controller,
    plain_controller,
    rounded_rows,
    without_fast_poles,
)
from takagi.lmi.refutation.refutation import objective_below
from takagi.lmi.solver.solve import number_of_solvers
from takagi.lmi.solver.time_limit import out_of_time
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

# How far above the least gamma the controller is taken, relative: at the least one X and Y^-1 meet,
# and the controller's numbers grow without bound.
ABOVE = 1e-3
# Entries so much larger than a plain controller's are absurd; what smaller ones may cost of gamma,
# and of a plain loop's norm where gamma is zero.
ABSURD, PER_CENT, ZERO = 1e5, 0.01, 1e-4
# Norms that differ by less are the same.
AGREED = 1e-6
# Other coordinates are tried so often, where the loop misses the gain that the LMIs promise.
ROUNDS = 4
# What is added to weights that may be singular in the Riccati equations of the first coordinates.
LITTLE = 1e-6


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class OutputFeedback(ShortRepr, ControllerFound):
    """x_K' = A_K x_K + B_K y, u = C_K x_K + D_K y.

    Attributes
    ----------
    controller : (A_K, B_K, C_K, D_K); None unless found.
    gain : gamma in units of z over units of w, the largest gain of the closed loop over
        frequencies, from its matrices; None unless found.
    lower_bound : no linear controller has a smaller gamma, to solver accuracy.
    plant : the generalised plant.
    loop : from w to z, closed; None unless found.
    answer : how it was found; its condition is in states of the LMIs' own.
    """

    controller: StateSpace | None
    gain: float | None
    lower_bound: float
    plant: GeneralisedPlant
    loop: StateSpace | None
    answer: Answer

    @property
    def status(self) -> Status:
        """Return "candidate", "infeasible" or "unknown", as of an ``Answer``."""
        return self.answer.status

    @property
    def diagnosis(self) -> str:
        """Return why there is no controller; empty if there is one."""
        return self.answer.diagnosis


def hinf_output_feedback(
    plant: GeneralisedPlant,
    *,
    norm_below: float | None = None,
    tolerance: float = ABOVE,
) -> OutputFeedback:
    """Return a controller u = K(s) y with the least |z|_2 <= gamma |w|_2, within the tolerance.

    plant : the generalised plant, in continuous time.
    norm_below : a gamma of at most this is enough, and the controller is a mild one; None asks for
        the least.
    tolerance : how far above the least gamma the controller may be, relative.  Nearer to it the
        controller gets faster poles.

    Returns an ``OutputFeedback``.  Where its entries would be absurd, fast poles are replaced by
    their gains, or gamma is a per cent above the least; ``answer.note`` says so, and how far gamma
    is above the bound where no solver came within the tolerance.

    ``gain`` is the largest gain of its loop over a grid of frequencies with
    a search about each maximum, from the matrices that are handed back, whose loop is stable by its
    eigenvalues.  Nothing is proved here: ``certify`` of the loop, with ``L2Gain``, is a proof.

    Raises ModelError: a tolerance or ``norm_below`` that is not positive.

    Not promised: a controller of lower order, or without fast poles.

    Source: Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42.
    """
    if not tolerance > 0:
        raise ModelError(f"tolerance is {tolerance!r}; a positive number is needed")
    why = unmoved_mode(plant)
    if why:
        no = Answer(status="infeasible", margin=-np.inf, diagnosis=why)
        return OutputFeedback(
            controller=None, gain=None, lower_bound=np.inf, plant=plant, loop=None, answer=no
        )
    T = first = _first_states(plant)
    if norm_below is not None:
        return _below(plant, T, positive_number("norm_below", norm_below))
    best: OutputFeedback | None = None
    tries: tuple[Try, ...] = ()
    for _ in range(ROUNDS):
        result, values = _in_states(plant, T, tolerance)
        tries += result.answer.tries
        if best is None or (result.gain or np.inf) < (best.gain or np.inf):
            best = result
        if not values or (best.gain or np.inf) <= (1 + 2 * tolerance) * best.lower_bound:
            break
        balanced = _balanced(values["X"][0], values["Y"][0])
        if balanced is None:
            break
        T = T @ balanced
    assert best is not None  # there is a round
    best = _improved(replace(best, answer=replace(best.answer, tries=tries)), first, tolerance)
    return _moderate(best, first, tolerance)


def _improved(best: OutputFeedback, T: Floats, tolerance: float) -> OutputFeedback:
    """Return the central controller where the LMIs' is not near the bound and it is nearer."""
    plain = plain_controller(best.plant, T) if best.gain is None and not out_of_time() else None
    if plain is not None:
        best = _with_controller(best, plain)
    if best.gain is None or best.gain <= (1 + 2 * tolerance) * best.lower_bound:
        return best
    low = max(best.lower_bound, 0.0)
    nearer = nearer_controller(best.plant, low, best.gain, tolerance / 10)
    if nearer is not None:
        best = _with_controller(best, nearer[0])
    assert best.gain is not None  # of either
    if best.gain <= (1 + 2 * tolerance) * best.lower_bound:
        return best
    note = "no bound shows how near the least gamma is"
    if low > 0:
        note = f"gamma is {best.gain / low - 1:.1%} above its bound; no solver came nearer"
    return replace(best, answer=replace(best.answer, note=note))


def _moderate(best: OutputFeedback, T: Floats, tolerance: float) -> OutputFeedback:
    """Return a controller without absurd entries, where there is one; else a note."""
    if best.controller is None or best.gain is None:
        return best
    plain = plain_controller(best.plant, T)
    unit = 1.0 if plain is None else max(entry_size(plain), 1e-300)
    if entry_size(best.controller) > ABSURD * unit:
        best = _with_controller(best, in_even_states(best.controller))
        size = 0.0 if plain is None else loop_norm(best.plant, plain)
        best = _without_absurd(best, tolerance, ABSURD * unit, ZERO * size)
    assert best.controller is not None and best.gain is not None  # of either
    exact = rounded_rows(best.controller)
    same = loop_norm(best.plant, exact) <= (1 + AGREED) * best.gain
    return _with_controller(best, exact) if same else best


def _without_absurd(
    best: OutputFeedback, tolerance: float, largest_entry: float, zero: float
) -> OutputFeedback:
    """Return a controller with entries of at most ``largest_entry``, or the same with a note.

    ``zero`` : a norm that is zero but for the tolerance.
    """
    controller, gain = best.controller, best.gain
    assert controller is not None and gain is not None  # asked by the caller
    size = entry_size(controller)
    for norm in ((1 + tolerance) * gain, gain + max(PER_CENT * gain, zero)):
        central = central_controllers(best.plant, norm)
        for candidate in chain([controller], central):
            for reduced in chain([candidate], without_fast_poles(candidate)):
                if entry_size(reduced) <= largest_entry and loop_norm(best.plant, reduced) <= norm:
                    note = f"gamma = {gain:.5g} would need entries of {size:.1g}"
                    within = norm <= (1 + tolerance) * gain
                    return _with_controller(best, reduced, "" if within else note)
        if out_of_time():
            break
    return _with_controller(
        best, controller, f"the largest entry is {size:.1g}; a larger norm_below has smaller ones"
    )


def _with_controller(result: OutputFeedback, K: StateSpace, note: str = "") -> OutputFeedback:
    """Return the result with another controller, its loop, and a note on top of what is noted."""
    gain = loop_norm(result.plant, K)
    notes = "; ".join(note_text for note_text in (result.answer.note, note) if note_text)
    answer = replace(result.answer, status="candidate", gain=gain, note=notes, diagnosis="")
    return replace(result, controller=K, gain=gain, loop=result.plant.closed(K), answer=answer)


def _below(plant: GeneralisedPlant, T: Floats, value: float) -> OutputFeedback:
    """Return a mild controller with at most this norm, or why there is none."""
    condition = objective_below(hinf_output_feedback_condition(plant.in_states(T)), value)
    outcome = decide(condition)
    answer = replace(outcome.as_answer(condition, None), objective_unit=ObjectiveUnit("gain", 1.0))
    nothing = OutputFeedback(
        controller=None, gain=None, lower_bound=0.0, plant=plant, loop=None, answer=answer
    )
    if outcome.status == "infeasible":
        why = f"no controller has a norm of at most {value:g}; ask for a larger one"
        return replace(nothing, answer=replace(answer, diagnosis=why))
    controllers = list(central_controllers(plant, value))
    if outcome.values:
        controllers.append(controller_of(plant.in_states(T), outcome.values))
    fits = [controller for controller in controllers if loop_norm(plant, controller) <= value]
    if not fits:
        why = outcome.unsettled(f"ask for a norm a little above {value:g}")
        return replace(nothing, answer=replace(answer, status="unknown", diagnosis=why))
    mild = min(fits, key=entry_size)
    return _moderate(_with_controller(nothing, mild), T, ABOVE)


def _first_states(plant: GeneralisedPlant) -> Floats:
    """Return states in which a regulator and a filter of the plant are balanced; else plain ones.

    Their Riccati equations are those of the same plant for white noise.
    """
    from scipy.linalg import solve_continuous_are

    s = np.diag(state_units(plant.A[None], None))
    scaled_plant = plant.in_states(s)
    R = scaled_plant.D12.T @ scaled_plant.D12
    R += LITTLE * max(float(np.trace(R)), 1.0) * np.eye(len(R))
    V = scaled_plant.D21 @ scaled_plant.D21.T
    V += LITTLE * max(float(np.trace(V)), 1.0) * np.eye(len(V))
    little = LITTLE * np.eye(len(scaled_plant.A))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            P = solve_continuous_are(
                scaled_plant.A,
                scaled_plant.B2,
                scaled_plant.C1.T @ scaled_plant.C1 + little,
                R,
                s=scaled_plant.C1.T @ scaled_plant.D12,
            )
            F = solve_continuous_are(
                scaled_plant.A.T,
                scaled_plant.C2.T,
                scaled_plant.B1 @ scaled_plant.B1.T + little,
                V,
                s=scaled_plant.B1 @ scaled_plant.D21.T,
            )
        regulator, filtered = (np.linalg.inv((solution + solution.T) / 2) for solution in (P, F))
        T = _balanced(np.asarray(regulator, np.float64), np.asarray(filtered, np.float64))
    except (np.linalg.LinAlgError, ValueError):
        T = None
    return s if T is None or not np.isfinite(T).all() else s @ T


def unmoved_mode(plant: GeneralisedPlant) -> str:
    """Return which mode that is not stable no controller changes; empty where none is."""
    for A, B, why in (
        (plant.A, plant.B2, "u does not move it"),
        (plant.A.T, plant.C2.T, "y does not see it"),
    ):
        mode = fixed_mode(A[None], B[None], 0.0)
        if mode is not None:
            return (
                f"no controller stabilises the plant: the mode {mode[1]:.4g} is not stable, and "
                f"{why}; an unstable or integrating weight has to be made stable, any other such "
                "mode needs another input or measurement"
            )
    return ""


def _in_states(
    plant: GeneralisedPlant, T: Floats, tolerance: float
) -> tuple[OutputFeedback, Mapping[str, Floats]]:
    """Return the controller from the LMIs posed in x = T xhat, and their unknowns."""
    scaled_plant = plant.in_states(T)
    condition = hinf_output_feedback_condition(scaled_plant)
    outcome = optimise(condition, slack=tolerance, most=number_of_solvers())
    values = outcome.values if outcome.status == "candidate" else outcome.feasible
    answer = replace(outcome.as_answer(condition, None), objective_unit=ObjectiveUnit("gain", 1.0))
    nothing = OutputFeedback(
        controller=None,
        gain=None,
        lower_bound=outcome.lower_bound,
        plant=plant,
        loop=None,
        answer=answer,
    )
    if not values:
        why = outcome.unsettled("weigh u and the noise of y a little more")
        return replace(nothing, answer=replace(answer, diagnosis=why)), {}
    try:
        controller = controller_of(scaled_plant, values)
    except np.linalg.LinAlgError:
        why = "the controller was lost to rounding: I - X Y is singular"
        return replace(nothing, answer=replace(answer, status="unknown", diagnosis=why)), values
    loop = plant.closed(controller)
    slowest = float(np.linalg.eigvals(loop.A).real.max())
    if not slowest < 0:
        why = f"the controller was lost to rounding: its loop has a pole at {slowest:.3g} 1/s"
        return replace(nothing, answer=replace(answer, status="unknown", diagnosis=why)), values
    gain = norm_seen(loop.A, loop.B, loop.C, loop.D)
    result = replace(
        nothing,
        controller=controller,
        gain=gain,
        loop=loop,
        answer=replace(answer, status="candidate", gain=gain),
    )
    return result, values


def _balanced(X: Floats, Y: Floats) -> Floats | None:
    """Return T with T^-1 X T^-T = T' Y T diagonal; None where one of them is not positive.

    In these states both functions have the same axes, and neither a controller's numbers nor the
    solver's unknowns are larger than they must be.
    """
    try:
        L, R = np.linalg.cholesky(X), np.linalg.cholesky(Y)
    except np.linalg.LinAlgError:
        return None
    U, sizes, _ = np.linalg.svd(L.T @ R)
    return np.asarray(L @ U / np.sqrt(sizes))


def controller_of(plant: GeneralisedPlant, values: Mapping[str, Floats]) -> StateSpace:
    """Return the controller of the LMIs' unknowns, by the change of variables."""
    X, Y, Ah, Bh, Ch, Dh = (values[name][0] for name in ("X", "Y", "Ah", "Bh", "Ch", "Dh"))
    matrices = controller_matrices((plant.A, plant.B2, plant.C2), X, Y, (Ah, Bh, Ch, Dh))
    return StateSpace(*matrices)


def mixed_sensitivity(
    plant: Any,
    W1: Any = None,
    W2: Any = None,
    W3: Any = None,
    *,
    norm_below: float | None = None,
    tolerance: float = ABOVE,
) -> OutputFeedback:
    """Return the controller u = K(s) (r - y) with the least norm of [W1 S; W2 K S; W3 T].

    Parameters
    ----------
    plant : G, strictly proper: a transfer function or state space of python-control, or (A, B, C,
        D); p outputs, m inputs, in continuous time.
    W1, W2, W3 : weights of r - y (p columns), of u (m columns) and of y (p columns): as the plant,
        or a number for that number in every channel; at least one.  Stable and proper.
    norm_below, tolerance : as for ``hinf_output_feedback``.

    Returns an ``OutputFeedback``: ``controller`` from e = r - y to u, of the order of plant and
    weights together at most, and ``gain``, gamma, recomputed from the closed loop.

    Raises ModelError: no weight, systems that do not fit, of discrete time or improper; a plant
    with a direct term, a weight that is not stable.

    Source: Skogestad and Postlethwaite (2005), sections 2.8.3 and 9.3.5.
    """
    G = state_space("the plant", plant)
    if not G.order or G.D.any():
        raise ModelError(
            "the plant has a direct term from u to y, or no states; a strictly proper plant is "
            "needed: put the actuator's or the sensor's lag into it"
        )
    p, m = G.D.shape
    weights = {"W1": (W1, p), "W2": (W2, m), "W3": (W3, p)}
    loop_weights = {
        name: _weight(name, weight, width)
        for name, (weight, width) in weights.items()
        if weight is not None
    }
    if not loop_weights:
        raise ModelError("no weight was given; give at least one of W1, W2, W3")
    return hinf_output_feedback(
        augmented(G, loop_weights),
        norm_below=norm_below,
        tolerance=tolerance,
    )


def augmented(G: StateSpace, weights: dict[str, StateSpace]) -> GeneralisedPlant:
    """Return the generalised plant: w = r, z the weighted signals, y the error e = r - G u."""
    n, (p, m) = G.order, G.D.shape
    # The input of each weight, as rows over x, r and u.
    sees = {
        "W1": (-G.C, np.eye(p), np.zeros((p, m))),
        "W2": (np.zeros((m, n)), np.zeros((m, p)), np.eye(m)),
        "W3": (G.C, np.zeros((p, p)), np.zeros((p, m))),
    }
    orders = [weight.order for weight in weights.values()]
    total = n + sum(orders)
    A, B1, B2 = np.zeros((total, total)), np.zeros((total, p)), np.zeros((total, m))
    A[:n, :n], B2[:n] = G.A, G.B
    C1, D11, D12 = [], [], []
    start = n
    for name, weight in weights.items():
        x, r, u = sees[name]
        weight_states = slice(start, start + weight.order)
        A[weight_states, :n], A[weight_states, weight_states] = weight.B @ x, weight.A
        B1[weight_states], B2[weight_states] = weight.B @ r, weight.B @ u
        rows = np.zeros((len(weight.D), total))
        rows[:, :n], rows[:, weight_states] = weight.D @ x, weight.C
        C1.append(rows)
        D11.append(weight.D @ r)
        D12.append(weight.D @ u)
        start += weight.order
    C2 = np.zeros((p, total))
    C2[:, :n] = -G.C
    return GeneralisedPlant(
        A=A,
        B1=B1,
        B2=B2,
        C1=np.vstack(C1),
        C2=C2,
        D11=np.vstack(D11),
        D12=np.vstack(D12),
        D21=np.eye(p),
    )


def _weight(name: str, weight: Any, width: int) -> StateSpace:
    system = state_space(name, weight)
    if system.D.shape == (1, 1) and width > 1:
        matrices = (system.A, system.B, system.C, system.D)
        system = StateSpace(*(np.asarray(np.kron(np.eye(width), M), np.float64) for M in matrices))
    if system.D.shape[1] != width:
        raise ModelError(
            f"{name} has {system.D.shape[1]} inputs; {width} are needed, or one for a weight that "
            "is the same in every channel"
        )
    if system.order and np.linalg.eigvals(system.A).real.max() >= 0:
        raise ModelError(
            f"{name} has a pole at {np.linalg.eigvals(system.A).real.max():g}; a stable weight is "
            "needed: move an integrator a little to the left, s + 1e-4 for s"
        )
    return system
