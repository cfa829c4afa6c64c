"""The design of a law that follows references, within narrower ranges of states where they help.

A set that stays in narrower ranges of states stays in the wider ones of the file, so that the claim
holds for the file's plant.  Slopes that vary less allow a larger set: a series motor, whose torque
is K i^2, may jump 12 times as far if the current stays in [2, 9] A in place of [0.5, 12] A.
Where outputs follow no reference, ``_obstacle`` says which ranges to narrow by how much.

Gains with integral action: a quadratic cost in the ranges, as fast as the limits allow.

One gain K of u = u* - K (X - X*) for all vertices of the secant model, with the cost

    int |x / half-widths|^2 + |u / limits|^2 + |xi / (T r_half)|^2 dt

where T is the time in which an error of the whole range of the reference, integrated, uses all of
an input.  The cost is made small where the plant rests (LQR), and at every vertex at once
(guaranteed cost).  The latter gains, mostly larger, are taken where references are proved to jump
5 % further with them.  T is reduced from slow to fast.  The fastest T is taken whose jumps are
nearly the largest.

Where part of the states is measured, a constant observer stands beside the gains: the plant in the
middle of its slopes,

    s' = A s + B (u - u*) + L (y - y* - C s),

and L minimises, for all slopes at once, the guaranteed cost of the dual problem: states pushed over
half their ranges in the time of the integral, outputs off by a share of theirs.  The share is
reduced from slow to fast; the slowest observer is taken whose proved jumps are nearly the largest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.design import NoDesign, StepClock
from takagi.certificates.design.plant.candidates import regulator_gain, used_gains
from takagi.certificates.design.plant.gain_task import (
    FoundGains,
    GainTask,
    rounded_gains,
    weights_at_rest,
)
from takagi.certificates.design.plant.plain_words import in_plant_words, require_sensible
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.models.arrays import Floats
from takagi.models.equilibrium_line import ConstantObserver
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.plant.plant import range_in_file_units
from takagi.models.tracking import held_rests, signals_of

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.plant.plant import Plant, Variable
    from takagi.models.ts.model import TSModel

# Shares of the ranges of states that are tried for a set in which outputs follow references, what
# they have to gain in jumps, and the share of a reference's range that is jump enough.
NARROWER = (Fraction(1, 2), Fraction(1, 4))
LEAST_INCREASE, ENOUGH_JUMP = 1.5, 0.5


def design_tracking(task: GainTask, clock: StepClock) -> tuple[GainTask, FoundGains] | NoDesign:
    """Return gains with integral action and what they hold on; or why none and what would help.

    What they hold on is the task, with narrower ranges of the plant where they help.
    """
    plant = task.plant
    require_sensible(plant, task.model, task.settings)
    if plant.hides_states:
        require_measured(plant, task.model)
    with clock("gains"), in_plant_words(plant):
        gains = tracking_gains(task)
        best = task, gains
        if claims_alone(plant):  # all claims say that states stay in their ranges
            best = _within_narrower_ranges(task, gains)
    if best[1].jump > 0:
        return best
    with clock("what would help"):
        return NoDesign(_obstacle(task, gains.design))


def claims_alone(plant: Plant) -> bool:
    """Return whether a plant's claims are those about its references alone."""
    return bool(plant.references) and (plant.hides_states or not plant.rests_exactly)


def _within_narrower_ranges(task: GainTask, gains: FoundGains) -> tuple[GainTask, FoundGains]:
    """Return gains and set within narrower ranges of states, where they allow larger jumps."""
    plant, best = task.plant, (task, gains)
    states = [v for v in moving_slopes(plant) if v in plant.states]
    for share in NARROWER if states else ():
        if best[1].jump >= ENOUGH_JUMP:
            break
        ranges = narrowed(plant, states, share)
        try:
            narrow = _narrow_task(task, ranges)
            narrower = tracking_gains(narrow)
        except ModelError:
            # The rests leave no room in these ranges.
            break
        if narrower.jump > LEAST_INCREASE * best[1].jump:
            note = (
                "states are proved to stay in narrower ranges, where slopes vary less: "
                f"{', '.join(map(range_in_words, ranges.values()))}"
            )
            best = narrow, replace(narrower, notes=(note, *narrower.notes))
    return best


def _narrow_task(task: GainTask, ranges: dict[str, Variable]) -> GainTask:
    """Return the task within other ranges."""
    narrow = with_ranges(task.plant, ranges)
    return GainTask.of(narrow, secant_model(narrow, rest=task.settings.rest), task.settings)


def moving_slopes(plant: Plant) -> list[Variable]:
    """Return the states and inputs with a range on which slopes of the equations depend."""
    import sympy as sp

    rows = sp.Matrix([sp.sympify(row) for row in plant.equations])
    variables = [*plant.states, *plant.inputs]
    slopes = rows.jacobian([v.symbol for v in variables])
    return [v for v in variables if v.range is not None and v.symbol in slopes.free_symbols]


def with_ranges(plant: Plant, replaced: dict[str, Variable]) -> Plant:
    """Return the plant with these variables in the place of those of the same name."""
    return replace(
        plant,
        states=tuple(replaced.get(v.name, v) for v in plant.states),
        inputs=tuple(replaced.get(v.name, v) for v in plant.inputs),
        disturbances=tuple(replaced.get(v.name, v) for v in plant.disturbances),
    )


def narrowed(plant: Plant, group: Sequence[Variable], share: Fraction) -> dict[str, Variable]:
    """Return the variables with this share of the distance from where they rest to each end."""
    states = [plant.states[k] for k in plant.own_states]
    values = held_rests(plant).values
    rests = {
        v.name: (Fraction(float(low)), Fraction(float(high)))
        for v, low, high in zip(
            (*states, *plant.inputs), values.min(axis=0), values.max(axis=0), strict=True
        )
    }
    narrower = {}
    for v in group:
        assert v.range is not None  # such variables are narrowed
        low, high = rests.get(v.name, (v.rest, v.rest))
        ends = (low + share * (v.range.lower - low), high + share * (v.range.upper - high))
        narrower[v.name] = replace(v, range=Interval(*(Fraction(f"{float(e):.6g}") for e in ends)))
    return narrower


def range_in_words(variable: Variable) -> str:
    """Return "w in [35, 130] rad/s", in the units of the file."""
    return f"{variable.name} in {range_in_file_units(variable)}"


# What is left of a range's distance from rest: the first decides whether wider ones are tried.
RANGE_SHARES = (Fraction(1, 10), Fraction(1, 2), Fraction(1, 4))


def _obstacle(task: GainTask, design: Design) -> str:
    """Return that no set was found, and which narrower ranges have one, each by itself."""
    words = "no set was found in which outputs follow their references within the ranges"
    if not design.found:
        words = "no gain was found with which all slopes of the plant in its ranges settle"
        if design.answer.diagnosis:
            words += f" ({design.answer.diagnosis})"
    sentences = [*filter(None, (_widest(task, group) for group in _groups(task.plant)))]
    if sentences:
        return f"{words}. A set is found with {'; or with '.join(sentences)}. Change one of these"
    return (
        f"{words}, nor with all references, disturbances and ranges at a tenth of their distances "
        "from rest, one after the other. Move the rest to where the slopes of the equations are "
        "away from 0, or ask for less (decay_rate, input_limit)"
    )


def _groups(plant: Plant) -> Iterator[list[Variable]]:
    """Yield what is narrowed together: each signal, all, and what the slopes depend on likewise."""
    for group in (list(signals_of(plant)), moving_slopes(plant)):
        for variable in group:
            yield [variable]
        if len(group) > 1:
            yield group


def _widest(task: GainTask, group: list[Variable]) -> str:
    """Return the widest of the narrower ranges with which a set is found, in words; else empty."""
    if not _works(task, group, RANGE_SHARES[0]):
        return ""
    wider = (s for s in RANGE_SHARES[1:] if _works(task, group, s))
    share = next(wider, RANGE_SHARES[0])
    return " and ".join(range_in_words(v) for v in narrowed(task.plant, group, share).values())


def _works(task: GainTask, group: list[Variable], share: Fraction) -> bool:
    """Return whether a set is found if these ranges are narrowed."""
    ranges = narrowed(task.plant, group, share)
    try:
        held_rests(with_ranges(task.plant, ranges))
        return tracking_gains(_narrow_task(task, ranges), few=True).jump > 0
    except ModelError:
        # The ranges no longer hold the rests at all references.
        return False


# T over the plant's time scale, slowest first.
TIMES = (32.0, 16.0, 8.0, 4.0, 2.0, 1.0, 0.5, 0.25)
FURTHER = 1.05  # times LQR's jumps, for which other gains are taken
# Share of the largest jump that a faster integral must still allow.
LEAST_JUMP_SHARE = {"small": 0.97, "moderate": 0.9, "large": 0.75}
SLOWER = 1  # how many slower integrals are tried with an observer
WISHES = ("initial", "gain_bound", "damping", "fastest", "relaxation", "sample_time")


def tracking_gains(task: GainTask, *, few: bool = False) -> FoundGains:
    """Return one gain for all vertices of a model with references.

    Parameters
    ----------
    few : whether few gains are tried, and the first with a set is taken.

    Raises
    ------
    ModelError : an option that this design does not have; a state or input without a range.
    """
    _refuse(task)
    model, sizes_at = task.model, _sizes(task)
    shifted, at_rest = _faster(model, task.rate or 0.0), weights_at_rest(model)
    trials: list[tuple[float, float, Design]] = []
    first: Design | None = None
    for time in _times(model)[1::3] if few else _times(model):
        designs = _gains_of_cost(shifted, at_rest, *sizes_at(time))
        first = first or designs[0]
        jumps = [_jump(task, design, None) if design.found else -1.0 for design in designs]
        k = 1 if len(jumps) > 1 and FURTHER * jumps[1] >= jumps[0] else 0
        if jumps[k] >= 0:
            trials.append((jumps[k], time, designs[k]))
            if few and jumps[k] > 0:
                break
    assert first is not None  # there is always a time
    largest_jump = max((jump for jump, _, _ in trials), default=0.0)
    if largest_jump <= 0:
        return FoundGains(trials[-1][2] if trials else first)
    accepted_jump = LEAST_JUMP_SHARE[task.settings.effort] * largest_jump
    index = max(k for k, trial in enumerate(trials) if trial[0] >= accepted_jump)
    if task.plant.hides_states:
        return _with_observer(task, trials[max(index - SLOWER, 0) : index + 1])
    jump, time, design = trials[index]
    return FoundGains(design, (_note(time, jump),), sizes=sizes_at(time), jump=jump)


def _gains_of_cost(
    model: TSModel, at_rest: Floats, states: Floats, inputs: Floats
) -> tuple[Design, ...]:
    """Return gains of the least cost in these sizes at every vertex, then where the plant rests.

    Parameters
    ----------
    at_rest : (r,) weights of the rules where the plant rests.
    states, inputs : (n,) and (m,) sizes.
    """
    from scipy.linalg import solve_continuous_lyapunov

    from takagi.lmi import lqr_pdc

    Q, R = np.diag(states**-2), np.diag(inputs**-2)
    everywhere = lqr_pdc(model, Q, R, relaxation="common-gain")
    A, B = (np.tensordot(at_rest, stack, axes=1) for stack in (model.A, model.B))
    gain = regulator_gain(A, B, states, inputs, None)
    if len(model.A) == 1 or gain is None:
        return (everywhere,)
    K = np.broadcast_to(gain, (len(model.A), *gain.shape)).copy()
    P = np.asarray(
        solve_continuous_lyapunov((A - B @ gain).T, -(Q + gain.T @ R @ gain)), dtype=np.float64
    )
    return everywhere, used_gains(K, P, "LQR's gains were used").design


def _note(time: float, jump: float) -> str:
    return (
        "integral action is tuned so that a step over the reference's whole range, integrated over "
        f"{time:.3g} s, uses all of an input; steps of {min(jump, 9.99):.0%} of that range "
        "keep all limits"
    )


def _jump(task: GainTask, design: Design, observer: ConstantObserver | None) -> float:
    """Return the least share of a range by which a reference may jump; 0 where no set was found."""
    from takagi.certificates.document.plant_embedding import plant_data
    from takagi.certificates.requests.loop.loop import ClaimedLoop
    from takagi.certificates.requests.tracking import Tracking, jump_shares

    gains, data = np.asarray(design.require()[0]), plant_data(task.model)
    loop = ClaimedLoop.of(task.model, gains, model_data=data)
    try:
        evidence = Tracking("jumps", observer=observer).candidate(loop)
    except ModelError:
        # The loop's rests leave no room in the ranges.
        return 0.0
    return 0.0 if evidence is None else max(min(jump_shares(task.plant, evidence)), 0.0)


def _with_observer(task: GainTask, trials: list[tuple[float, float, Design]]) -> FoundGains:
    """Return the slowest observer, with the fastest gains, that nearly have the largest jumps."""
    candidates = []
    for _, time, design in trials:
        for observer, share in _constant_observers(task, time):
            jump = _jump(task, design, observer)
            notes = (
                _note(time, jump),
                f"observer of {', '.join(observer.measured)}, constant matrices in the middle of "
                f"the plant's slopes; outputs count as off by {share:.0%} of half their ranges",
            )
            candidates.append(FoundGains(design, notes, observer=observer, jump=jump))
    largest_jump = max((candidate.jump for candidate in candidates), default=0.0)
    if largest_jump <= 0:
        return FoundGains(trials[-1][2])
    accepted_jump = LEAST_JUMP_SHARE[task.settings.effort] * largest_jump
    accepted = [candidate for candidate in candidates if candidate.jump >= accepted_jump]
    return next(candidate for candidate in accepted if candidate.design is accepted[-1].design)


def _faster(model: TSModel, rate: float) -> TSModel:
    """Return the model with A + rate I: its gains make the loop of A faster by the rate [1/s]."""
    if not rate:
        return model
    from takagi.models import TSModel as Model

    A = np.asarray(model.A) + rate * np.eye(len(model.states))
    return Model(A, np.asarray(model.B), states=model.states, inputs=model.inputs)


def _refuse(task: GainTask) -> None:
    plant, settings = task.plant, task.settings
    refused = [name for name in WISHES if getattr(settings, name)]
    if refused or settings.decay_rate == "max":
        name = refused[0] if refused else 'decay_rate = "max"'
        raise ModelError(
            f"plant {plant.name!r} follows a reference; its gains are found with decay_rate, "
            f"settle and input_limit, not with {name}: leave that out"
        )


def _sizes(task: GainTask) -> Callable[[float], tuple[Floats, Floats]]:
    """Return T -> (n,) and (m,), the sizes of states and inputs that cost the same."""
    plant, limits = task.plant, task.input_limit
    integrals = {reference.integral: reference for reference in plant.references}
    signals = {v.name: v for v in plant.disturbances}
    missing = [v.name for v in plant.states if v.range is None and v.name not in integrals]
    if missing or limits is None:
        subject = f"state {missing[0]}" if missing else "an input"
        raise ModelError(
            f"plant {plant.name!r}: {subject} has no range; to follow a reference gains are found "
            "and proved within ranges, so give every state and input one"
        )

    def at(time: float) -> tuple[Floats, Floats]:
        states = []
        for variable in plant.states:
            if variable.name in integrals:
                signal = signals[integrals[variable.name].name]
                assert signal.range is not None  # a reference has one
                states.append(time * float(signal.range.width) / 2)
            else:
                assert variable.range is not None  # asked above
                states.append(float(variable.range.width) / 2)
        return np.array(states), limits

    return at


def _times(model: TSModel) -> list[float]:
    """Return times T [s] from slow to fast, about the time scale that ranges give the plant."""
    halves, limits = (
        np.array([float(model.box[k][1] - model.box[k][0]) / 2 for k in names if k in model.box])
        for names in (model.states, model.inputs)
    )
    ranged = [k for k, name in enumerate(model.states) if name in model.box]
    A = np.abs(np.asarray(model.A))[:, ranged][:, :, ranged]
    fastest = (A @ halves + np.abs(np.asarray(model.B))[:, ranged] @ limits).max(axis=0)
    scale = float((halves / np.maximum(fastest, 1e-300)).max())
    return [float(f"{share * scale:.2g}") for share in TIMES]


# Errors of the outputs over half their ranges, slowest observer first.
OUTPUT_SHARES = (1.0, 0.3, 0.1, 0.03)
DIGITS = 6  # of A, B, C and L


def require_measured(plant: Plant, model: TSModel) -> None:
    """Refuse a plant with references whose law cannot know what it needs.

    Raises
    ------
    ModelError : what follows is not measured, an output with an input in it, a mode that no
        measured output shows.
    """
    from takagi.certificates.design.plant.observed_design import check_detectable

    rows = plant.measured_rows
    measured = [plant.outputs[row].expression for row in rows]
    alone = {v.symbol for v in plant.states if v.symbol in measured}
    parameters = {p.symbol for p in plant.parameters}
    signals = {v.name: v.symbol for v in plant.disturbances}
    equations = {v.name: row for v, row in zip(plant.states, plant.equations, strict=True)}
    for reference in plant.references:
        followed = equations[reference.integral] + signals[reference.name]
        if followed not in measured and not followed.free_symbols - parameters <= alone:
            raise ModelError(
                f"plant {plant.name!r}: {reference.follows} follows {reference.name}, but it is "
                f"not measured ({', '.join(plant.measured or ())}): its integral is a part of the "
                f"law, which needs it; measure {reference.follows} too, or let follow what is "
                "measured"
            )
    if np.any(model.D[:, list(rows)]):
        raise ModelError(
            f"plant {plant.name!r}: a measured output depends on an input; with a reference, "
            "measure outputs that depend on states alone"
        )
    check_detectable(plant, model, rows, plant.own_states)


def _constant_observers(task: GainTask, time: float) -> Iterator[tuple[ConstantObserver, float]]:
    """Yield observers from slow to fast, and the share of the outputs' ranges that made them.

    Parameters
    ----------
    time : in s, within which the states are pushed over half their ranges.
    """
    from takagi.lmi import lqr_pdc
    from takagi.models import TSModel as Model

    plant, model = task.plant, task.model
    states, rows = plant.own_states, list(plant.measured_rows)
    A, B = model.A[:, states][:, :, states], model.B[:, states]
    C = model.C[:, rows][:, :, states]
    half = np.array([float(v.range.width) / 2 for k in states if (v := plant.states[k]).range])
    output_sizes = np.abs(C).max(axis=0) @ half
    dual = Model(A.transpose(0, 2, 1), C.transpose(0, 2, 1))
    means = [(stack.min(axis=0) + stack.max(axis=0)) / 2 for stack in (A, B, C)]
    means = [np.array([[float(f"{x:.{DIGITS}g}") for x in row] for row in mean]) for mean in means]
    for share in OUTPUT_SHARES:
        Q, R = np.diag(half**2) / time, np.diag((share * output_sizes) ** 2) * time
        design = lqr_pdc(dual, Q, R, relaxation="common-gain")
        if not design.found:
            continue
        L = np.asarray(design.require()[0])[:1].transpose(0, 2, 1)
        A_mean, B_mean, C_mean = means
        gain = rounded_gains(L, DIGITS)[0]
        yield ConstantObserver(A_mean, B_mean, C_mean, gain, plant.measured or ()), share
