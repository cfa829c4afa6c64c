r"""The law of a design where nothing is asked: several candidates, judged beside LQR.

A user sees three things of a law: the set from which it is proved to settle, how long it takes, and
how much of the stated disturbance it withstands.  A linear-quadratic regulator with Bryson's
weights costs one line elsewhere, so that a law that is worse in these is not worth its proof.

Both laws are measured in the same way, in floating point:

    set           the ellipsoid that the certificate will claim for these gains, by the same search
                  within ranges and limits; one is at least as large as the other if its volume is,
                  or the largest multiple of the ranges that it holds
    settling      the slowest of the plant's motions from both ends of every axis of the law's set,
                  inputs cut at their ranges, until each state stays within 2 % of the set's reach;
                  of the regulator, from the same starts
    disturbance   the share of the stated disturbances that some ellipsoid withstands

A law is good enough if it withstands all of what is stated, its set is at least as large as that of
the regulator's gains, and it settles within 1.2 times the regulator's time.  The candidates are

    1. the largest set at a moderate rate (``gains``), which is taken if it is good enough
    2. the same at other rates: faster ones where the first is slow, slower ones where its set is
       small, then between the last two
    3. the regulator of each rule, and the regulator itself, where they have a set

The first that is good enough is taken.  Where none is, it is the one with the most of the three,
the disturbance first, and a note says what is missing and what to ask for.  Where inputs have no
limits, commands are at most 1.5 times those of the first law, or the regulator's.

Source: Bryson and Ho (1975), Applied Optimal Control, section 5.2, for the weights.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from takagi.certificates.design.plant.gain_task import (
    ALL_PAIRS,
    ONE_GAIN,
    FoundGains,
    GainTask,
    rounded_gains,
    weights_at_rest,
)
from takagi.certificates.design.plant.gains import find_gains
from takagi.certificates.design.plant.many_rules import work_of
from takagi.certificates.design.plant.plain_words import in_file_rates
from takagi.certificates.design.plant.wishes import NO_RATE, TRIED_RATES
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.certificates.requests.invariant_ellipsoid import set_in_floats, withstood_share
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import Answer, Design
from takagi.models.arrays import Floats
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant_simulation.settling import ManyMotions

LONGEST = 8.0  # time [s], by an estimate, of a law at one rate with its proof; else none is tried
MORE = 1.5  # times the first law's commands, which others may take
SLOWER = 1.2  # times the regulator's settling time, which is good enough
STEP = 2**0.5  # from one rate to the next
STEPS, HALVINGS = 4, 2
# Measured in floating point, to which sets and times are compared.
EQUAL = 1e-3
DIGITS = 4  # of the gains that are judged, as they are emitted
HORIZONS = 10.0  # time constants of the slowest mode at rest, that motions are simulated for
JUST_INSIDE = 0.999
BESIDE = "beside LQR the law"  # with which the note begins that says what it is worse in


def regulator_gain(
    A: Floats, B: Floats, states: Floats, inputs: Floats, step: float | None
) -> Floats | None:
    """Return K (m, n) of u = -K x for the least integral of |x / states|^2 + |u / inputs|^2.

    Parameters
    ----------
    A, B : (n, n), (n, m); of x(t + T) where ``step`` = T [s] is given, with a sum for the integral.
    states, inputs : (n,), (m,) sizes.

    Returns
    -------
    None where the Riccati equation has no stabilising solution.
    """
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    A, B = A * states / states[:, None], B * inputs / states[:, None]
    Q, R = np.eye(len(A)), np.eye(B.shape[1])
    try:
        if step is None:
            K: Floats = np.asarray(B.T @ solve_continuous_are(A, B, Q, R), dtype=np.float64)
        else:
            X = solve_discrete_are(A, B, Q, R)
            K = np.asarray(np.linalg.solve(R + B.T @ X @ B, B.T @ X @ A), dtype=np.float64)
    except (ValueError, np.linalg.LinAlgError):
        return None
    return K * inputs[:, None] / states if np.all(np.isfinite(K)) else None


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A law with what a user sees of it.

    Attributes
    ----------
    gains : with the notes about them; of a law other than the first, one: what was used.
    K : (r, m, n), rounded as they are emitted.
    P : (n, n), of the set {x' P x <= 1}.
    size : volume of the set, and the largest multiple of the ranges in it, as lengths.
    share : of the ranges that is in the set: the first of these, or where a state has no range the
        second, for its reach was not asked for.
    larger : whether the set is at least as large as the regulator's.
    times : settling time of the law and of the regulator from the law's set [s].
    affordable : whether its commands are within the largest that are allowed.
    withstood : share of the stated disturbances, at most 1; 1 where none is stated.
    """

    gains: FoundGains
    K: Floats
    P: Floats
    size: tuple[float, float]
    share: float
    larger: bool
    times: tuple[float, float]
    withstood: float
    affordable: bool

    @property
    def fast(self) -> bool:
        """Whether it settles within 1.2 times the regulator's time."""
        return bool(self.times[0] <= SLOWER * (1 + EQUAL) * self.times[1])

    @property
    def good(self) -> bool:
        """Whether nothing is missing."""
        return self.withstood >= 1 and self.larger and self.fast and self.affordable

    @property
    def rank(self) -> tuple[Any, ...]:
        """What to compare: the most first."""
        withstood = self.withstood if self.withstood >= 1 else float(f"{self.withstood:.1g}")
        return self.affordable, withstood, self.larger + self.fast, self.fast, self.share


@dataclass(frozen=True, slots=True, eq=False)
class Contest:
    """What candidates are judged by: the plant's loop, and the regulator beside them.

    Attributes
    ----------
    first_set : P of the first law's set {x' P x <= 1}.
    sizes, inputs : (n,), (m,), which make the regulator's weights: half-widths and limits, or the
        reach of the first law's set and the commands on it.
    data : the model as certificates state it; None for a model without symbols.
    at_rest : A (n, n), B (n, m) of the linear plant at rest.
    relaxation : of the laws at other rates.
    regulator : its K (m, n).
    largest_commands : (m,) that a law may give.
    regulator_size : as ``Judged.size``; 0 without a set.
    """

    task: GainTask
    first_set: Floats
    sizes: Floats
    inputs: Floats
    data: dict[str, Any] | None
    motions: ManyMotions
    at_rest: tuple[Floats, Floats]
    relaxation: str
    regulator: Floats
    largest_commands: Floats
    regulator_size: tuple[float, float] = (0.0, 0.0)

    def loop(self, K: Floats) -> ClaimedLoop:
        return ClaimedLoop.of(self.task.model, K, model_data=self.data)

    def size(self, P: Floats | None) -> tuple[float, float]:
        """Return n-th root of the volume, and multiple of the ranges, over the ranges."""
        from takagi.lmi.gains.requirements.limits import corners_of_box

        if P is None:
            return 0.0, 0.0
        volume = np.exp(-np.linalg.slogdet(P * self.sizes * self.sizes[:, None])[1] / 2 / len(P))
        ranged = np.isfinite(self.task.box)
        if not ranged.any():
            return float(volume), 0.0
        corners = np.zeros((2 ** (int(ranged.sum()) - 1), len(P)))
        corners[:, ranged] = corners_of_box(self.task.box[ranged])
        multiple = np.einsum("ki,ij,kj->k", corners, P, corners).max() ** -0.5
        return float(volume), float(multiple)

    def judged(self, gains: FoundGains, K: Floats | None = None) -> Judged | None:
        """Return the law with its measures, None without a set; K in place of an LMI's gains."""
        if K is None:
            K = rounded_gains(np.asarray(gains.design.require()[0]), DIGITS)
        P = set_in_floats(self.loop(K), self.task.input_limit)
        return None if P is None else self.with_set(gains, K, P)

    def with_set(self, gains: FoundGains, K: Floats, P: Floats) -> Judged:
        """Return the law with its measures, of its set {x' P x <= 1}."""
        size = self.size(P)
        larger = any(
            own >= (1 - EQUAL) * other for own, other in zip(size, self.regulator_size, strict=True)
        )
        share = size[0] if np.isfinite(self.task.box).all() else size[1]
        withstood = min(withstood_share(self.loop(K)), 1.0)
        affordable = bool(np.all(_commands(K, P) <= self.largest_commands))
        return Judged(gains, K, P, size, share, larger, self.times(K, P), withstood, affordable)

    def times(self, K: Floats, P: Floats) -> tuple[float, float]:
        """Return the settling times [s] from the set, under the law and under the regulator."""
        A, B = self.at_rest
        starts, reach = ends_of_axes(P)
        regulator = np.broadcast_to(self.regulator, K.shape)
        loops = [A - B @ gain for gain in (K.mean(axis=0), regulator[0])]
        horizon = horizon_of(loops, self.task.model.sample_time)
        law, other = (
            float(self.motions.settling_times(gain, starts, reach, horizon).max())
            for gain in (K, regulator)
        )
        return law, other


def laws_beside_regulator(
    task: GainTask, first: FoundGains | None = None
) -> tuple[FoundGains, ...]:
    """Return the law to be proved, and behind it the one to fall back to.

    Parameters
    ----------
    first : the law that was found already, beside which others have one gain for all rules; None
        finds it.

    The first that was found alone, where something is asked, or where there is no regulator to
    compare with: a plant with tables, one that it cannot stabilise.

    Raises
    ------
    ModelError : as ``find_gains``.
    """
    common = first is not None
    first = first or find_gains(task)
    contest = contest_of(task, first) if first.design.found else None
    if contest is None:
        return (first,)
    if common:
        contest = replace(contest, relaxation=ONE_GAIN)
    K = rounded_gains(np.asarray(first.design.require()[0]), DIGITS)
    judged = contest.with_set(first, K, contest.first_set)
    sizes = (contest.sizes, contest.inputs)
    if judged.good:
        return (replace(first, sizes=sizes),)
    candidates = [judged]
    if _search_time(contest) <= LONGEST:
        candidates += _at_other_rates(contest, judged)
    if not candidates[-1].good:
        candidates += _regulators(contest, first)
    best = max(candidates, key=lambda law: law.rank)
    note = _note(best, contest)
    notes = best.gains.notes
    if best is not judged:
        (used,) = notes
        better = ", so that the law is no worse than LQR" if best.larger and best.fast else ""
        notes = _with_rate(first.notes, f"{used}{better}")
    chosen = replace(best.gains, notes=(*notes, *note), sizes=sizes)
    return (chosen,) if best is judged else (chosen, replace(first, sizes=sizes))


def _search_time(contest: Contest) -> float:
    """Return about how long gains at one rate and their proof take [s]."""
    model, single = contest.task.model, contest.relaxation == ONE_GAIN
    sizes = (len(model.states), len(model.inputs))
    at_rate = replace(contest.task.settings, decay_rate=1.0)
    return work_of(len(model.A), sizes, at_rate, one_gain=single).seconds


def _nothing_asked(settings: PlantSettings) -> bool:
    """Return whether the gains are left to the design; limits and proofs may be asked for."""
    kept = ("choice", "rest", "input_limit", "sample_time", "noise", "horizon")
    return settings == PlantSettings(**{name: getattr(settings, name) for name in kept})


def contest_of(task: GainTask, first: FoundGains) -> Contest | None:
    """Return what candidates are judged by beside the first law; None where there is nothing."""
    # A regulator of all states would have those of a controller as well.
    model, limits, box = task.model, task.input_limit, task.box
    if not _nothing_asked(task.settings) or task.plant.integrators:
        return None
    motions = ManyMotions.of(model, limits)
    if motions is None or not np.isfinite(box).any():
        return None
    data = plant_and_claim(model)[0]
    K = rounded_gains(np.asarray(first.design.require()[0]), DIGITS)
    P = set_in_floats(ClaimedLoop.of(model, K, model_data=data), limits)
    if P is None:
        return None
    sizes = np.where(np.isfinite(box), box, np.sqrt(np.diag(np.linalg.inv(P))))
    inputs = _commands(K, P) if limits is None else limits
    weights = weights_at_rest(model)
    at_rest = np.tensordot(weights, model.A, axes=1), np.tensordot(weights, model.B, axes=1)
    if not np.all(inputs > 0):
        return None
    gain = regulator_gain(*at_rest, sizes, inputs, model.sample_time)
    if gain is None:
        return None
    gain = rounded_gains(gain[None], DIGITS)[0]
    relaxation, most = task.with_one_gain()[0].settings.relaxation or ALL_PAIRS, MORE * inputs
    contest = Contest(task, P, sizes, inputs, data, motions, at_rest, relaxation, gain, most)
    everywhere = np.broadcast_to(gain, (len(model.rules), *gain.shape)).copy()
    beside = set_in_floats(contest.loop(everywhere), limits)
    if beside is None:
        return contest
    return replace(
        contest,
        regulator_size=contest.size(beside),
        largest_commands=np.maximum(most, (1 + EQUAL) * _commands(everywhere, beside)),
    )


def _commands(K: Floats, P: Floats) -> Floats:
    """Return (m,): the largest |K_i x| of any rule where x' P x <= 1."""
    squares = np.einsum("rmi,ij,rmj->rm", K, np.linalg.inv(P), K)
    return np.asarray(np.sqrt(squares.max(axis=0)), dtype=np.float64)


def _at_other_rates(contest: Contest, first: Judged) -> Iterator[Judged]:
    """Yield laws at other rates, until one is good enough."""
    rate = float(first.gains.design.decay_rate)
    faster = not (first.fast and not first.larger and first.withstood >= 1)
    if rate == 0:  # None of the rates that were tried has gains.
        return
    edge: tuple[float, float] | None = None  # rates on both sides of what is sought
    for k in range(1, STEPS + 1):
        next_rate = rate * STEP ** (k if faster else -k)
        law = _law_at(contest, first.gains, next_rate)
        if law is None:
            break
        yield law
        if law.good:
            return
        if (faster and law.fast) or (not faster and law.larger):
            edge = (next_rate / STEP, next_rate) if faster else (next_rate, next_rate * STEP)
            break
    for _ in range(HALVINGS if edge else 0):
        slow, quick = edge or (rate, rate)
        middle = (slow * quick) ** 0.5
        law = _law_at(contest, first.gains, middle)
        if law is None:
            return
        yield law
        if law.good:
            return
        edge = (middle, quick) if law.larger else (slow, middle)


def _law_at(contest: Contest, first: FoundGains, rate: float) -> Judged | None:
    """Return the law with the largest set at a rate, of at most the inputs of the first law."""
    from takagi.lmi import attraction_pdc

    rate = float(f"{rate:.3g}")
    design = attraction_pdc(
        contest.task.model,
        decay_rate=rate,
        input_limit=contest.inputs,
        state_box=contest.task.box,
        saturation=None,
        relaxation=contest.relaxation,
    )
    if not design.found:
        return None
    used = f"{rate:.4g} 1/s was used in place of {first.design.decay_rate:.4g} 1/s"
    return contest.judged(FoundGains(design, (in_file_rates(used, contest.task.plant),)))


def _with_rate(notes: tuple[str, ...], used: str) -> tuple[str, ...]:
    """Return the notes with what was used in place of the first law's rate.

    The advice to give ranges to the states that have none stays.
    """

    def changed(note: str) -> str:
        return f"{NO_RATE}; {used}" + "".join(note.partition(f"; {TRIED_RATES}")[1:])

    return tuple(changed(note) if note.startswith(NO_RATE) else note for note in notes)


def _regulators(contest: Contest, first: FoundGains) -> Iterator[Judged]:
    """Yield the regulator of each rule, where the gains may differ, and that at rest."""
    for words, K in regulator_gains(contest):
        law = contest.judged(first, K)
        if law is not None:
            yield replace(law, gains=used_gains(K, law.P, words))


def regulator_gains(contest: Contest) -> list[tuple[str, Floats]]:
    """Return words and K (r, m, n) of the regulator of each rule, and last of that at rest."""
    model, step = contest.task.model, contest.task.model.sample_time
    rules, (m, n) = len(model.rules), contest.regulator.shape
    at_rules = [
        regulator_gain(np.asarray(A), np.asarray(B), contest.sizes, contest.inputs, step)
        for A, B in zip(model.A, model.B, strict=True)
    ]
    kinds = [("at rest, one for all rules", np.broadcast_to(contest.regulator, (rules, m, n)))]
    if contest.relaxation != ONE_GAIN and rules > 1 and all(K is not None for K in at_rules):
        kinds.insert(0, ("of each rule", np.array(at_rules)))
    return [
        (f"LQR's gains {words} were used", rounded_gains(np.array(K, dtype=np.float64), DIGITS))
        for words, K in kinds
    ]


def used_gains(K: Floats, P: Floats, words: str) -> FoundGains:
    """Return gains that no LMI was asked for, with the note that says so."""
    answer = Answer(status="candidate", P=P, margin=np.nan)
    design = Design(gains=K, P=P, decay_rate=0.0, margin=np.nan, relaxation="", answer=answer)
    return FoundGains(design, (words,))


def _note(best: Judged, contest: Contest) -> tuple[str, ...]:
    """Return what the chosen law is worse in than the regulator, and what to ask for."""
    worse = []
    if not best.fast:
        law, other = best.times
        ratio = f"{law / other:.2g} times as long as" if np.isfinite(law) else "later than"
        worse.append(f"settles {ratio} LQR does from the law's set")
    if not best.larger:
        worse.append("has a smaller proved set")
    if not worse:
        return ()
    ask = "--effort small asks for a larger set"
    if not best.fast:
        ask = "--settle TIME or --effort large asks for a faster law with a smaller set"
    if not best.fast and best.gains.design.decay_rate == 0:
        ask = "faster rates were tried and have no gains"
    why = "nothing better is proved over these ranges: narrow those of the states in the premises"
    if contest.task.input_limit is None:
        why = "its commands were kept near the least: give the inputs ranges"
    return (f"{BESIDE} {' and '.join(worse)}; {why}; {ask}",)


def ends_of_axes(P: Floats) -> tuple[Floats, Floats]:
    """Return both ends (n, 2 n) of every axis of {x' P x <= 1}, and its half-widths (n,)."""
    reach = np.sqrt(np.diag(np.linalg.inv(P)))
    values, axes = np.linalg.eigh(P * reach * reach[:, None])
    ends = JUST_INSIDE * reach[:, None] * axes / np.sqrt(values)
    return np.concatenate([ends, -ends], axis=1), reach


def horizon_of(loops: Sequence[Floats], step: float | None) -> float:
    """Return the time [s] to simulate loops for, by their slowest modes at rest."""
    rates = [slowest_rate(A, step) for A in loops]
    return HORIZONS / max(min(rates), max(rates) / 100)


def slowest_rate(A: Floats, step: float | None) -> float:
    """Return the least decay rate [1/s] of the modes of A."""
    values = np.linalg.eigvals(A)
    if step is None:
        return float(-values.real.max())
    return float(-np.log(np.maximum(np.abs(values).max(), 1e-300)) / step)
