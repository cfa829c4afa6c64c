"""The design of a law with measured outputs: gains, an observer, and the proof of both together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.certification import Certificate
from takagi.certificates.controller.content import bound
from takagi.certificates.controller.plant_members import plant_members
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.candidates import (
    contest_of,
    regulator_gains,
    used_gains,
)
from takagi.certificates.design.plant.gain_task import (
    FoundGains,
    GainTask,
    rounded_gains,
    weights_at_rest,
)
from takagi.certificates.design.plant.gains import find_gains
from takagi.certificates.design.plant.observed_candidates import (
    MOST_LOOPS,
    MOST_STATES,
    ObserverPair,
    best_pair,
    kalman_gains,
)
from takagi.certificates.design.plant.plain_words import obstacle
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.design.plant.work import DIGITS, PlantWork
from takagi.certificates.document.certificate_file import (
    certificate_document,
    content_of,
    provenance,
)
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import (
    law_members,
    observer_member,
    plant_and_claim,
    slope_claim,
    slopes_data,
)
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.observer import (
    ObservedLoop,
    loops_and_limits,
    starts_of,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Decay rates of the estimation error that are tried, as multiples of the rate of the gains.  A
# faster observer has larger gains, which amplify noise more.
ERROR_RATE_FACTORS = (1.0, 2.0, 4.0, 8.0)
# The slowest observer is taken whose set of starts has this share of the best one's mean width.
NEARLY_BEST = 0.8
# The gains are designed for slightly more than the required rate: the joint proof needs the rest.
RATE_FACTOR = 1.02
# Share of the gains' own rate for the search of the set, if no rate is required.
SHARE_OF_RATE = 0.5
# With more matrices than this, all rules get one gain, which reduces the number.
MOST_MATRICES = 600


@dataclass(frozen=True, slots=True, eq=False)
class ObservedWork:
    """The data to design and certify an observer and gains for one model.

    Attributes
    ----------
    slopes : the plant's slopes between any two states, where a premise depends on what is not
        measured, so that the weights are those at the estimate; None where it does not.
    note : a sentence that says which weights the observer uses, and why.
    model_data, claims : the model as certificates state it, and the claims that stand in front.
    """

    base: PlantWork
    slopes: TSModel | None
    note: str
    model_data: dict[str, Any]
    claims: tuple[dict[str, Any], ...]

    @classmethod
    def of(cls, base: PlantWork) -> ObservedWork:
        """Return it.

        Raises
        ------
        ModelError : a wish that cannot be proved of such a loop, a premise of what the observer
            does not know, an unstable mode that no measured output shows, slopes that cannot be
            bounded.
        """
        plant, model = base.task.plant, base.task.model
        with base.clock("model"):
            _refuse(base.task)
            data, claims, _ = plant_and_claim(model)
            if data is None:
                raise ModelError(
                    f"plant {model.name!r} cannot be written into a certificate, which says what "
                    "its premises depend on; an observer needs that"
                )
            slopes, note = _slopes_and_note(base.task, data)
            if slopes is not None:
                data |= {"slopes": slopes_data(slopes)}
                claims = [*claims, slope_claim(plant.name)]
            if base.files:
                data |= content_of(base.files)
        return cls(base, slopes, note, data, tuple(claims))

    @property
    def rows(self) -> list[int]:
        """Places of the measured outputs among the outputs of the model."""
        return list(self.base.task.plant.measured_rows)

    def loop(self, gains: Floats, L: Floats) -> ClaimedLoop:
        """Return the loop with gains K (r, m, n) and L (r or 1, n, p)."""
        measured, at_estimate = self.base.task.plant.measured or (), self.slopes is not None
        observer = observer_member(L, measured, at_estimate=at_estimate)
        law = pdc_law_data(self.base.task.model, gains) | law_members(self.model_data)
        law |= {"observer": observer}
        return ClaimedLoop.of(self.base.task.model, gains, model_data=self.model_data, law=law)

    def certified_pair(
        self,
        gains: Floats,
        L: Floats,
        design: Design | None,
        notes: tuple[str, ...],
        P: Floats | None = None,
        observer: Design | None = None,
    ) -> PlantDesign:
        """Return the design with its certificate; ``P`` is a function that was found before."""
        from takagi.models.laws.pdc import OutputFeedback, PdcLaw

        base, task, asked = self.base, self.base.task, self.base.requirements
        with base.clock("exact proof"):
            loop = self.loop(gains, L)
            attempt = ObservedLoop(asked.decay_rate, asked.input_limits, P).attempt(loop)
            document = certificate_document(
                model=self.model_data,
                gains=loop.gains_data,
                claims=[*self.claims, attempt.claim],
                provenance=provenance(base.task.settings, {"observed-loop": attempt.solver}),
                files=base.files,
            )
            checked = check_document(document)
        law = document["gains"]
        trim = law["trim"]
        feedback = PdcLaw(task.model, gains, np.array(trim["state"]), np.array(trim["input"]))
        run = OutputFeedback(feedback, L, tuple(self.rows), self.slopes is not None)
        members = plant_members(task.plant, task.model, law, checked, notes)
        certificate = Certificate(bound(document, members), checked, attempt.tried)
        seconds = dict(base.clock.seconds)
        values = (task.plant, task.settings, task.model, design, gains, None, certificate)
        return PlantDesign(*values, notes, seconds, output_law=run, observer=observer)


def design_observed(work: PlantWork) -> PlantDesign | NoDesign:
    """Return gains, observer and their certificate, or why there are none."""
    observed, task, rate = ObservedWork.of(work), work.task, work.task.settings.decay_rate
    if isinstance(rate, float):
        task = task.asking(decay_rate=RATE_FACTOR * rate)
    with work.clock("gains"):
        found_gains = find_gains(task)
        if found_gains.design.found and _count(observed) > MOST_MATRICES:
            found_gains = find_gains(task.asking(relaxation="common-gain"))
    if not found_gains.design.found:
        cause = obstacle(found_gains.design.answer, task.plant, task.model, task.settings)
        return NoDesign("\n".join(filter(None, (cause, found_gains.design.answer.diagnosis))))
    with work.clock("observer"):
        pairs = _pairs(observed, found_gains)
    if isinstance(pairs, NoDesign):
        return pairs
    last: PlantDesign | None = None
    for pair in pairs:
        K = np.asarray(pair.gains.design.require()[0])
        for count in DIGITS:
            notes = (*pair.gains.notes, observed.note, pair.note)
            last = observed.certified_pair(
                rounded_gains(K, count),
                rounded_gains(pair.L, count),
                pair.gains.design,
                (*notes, f"gains to {count} significant digits"),
                pair.P if count == DIGITS[0] else None,
                pair.observer,
            )
            if last.proved:
                return last
    assert last is not None  # there is always a pair, and a number of digits
    return last


def _count(work: ObservedWork) -> int:
    """Return about how many matrices the joint loop has with a gain for every rule."""
    rules = len(work.base.task.model.A)
    slopes = 1 if work.slopes is None else len(_slope_vertices(work.slopes, work.rows)[0])
    return rules * (rules + 1) // 2 * slopes


def _pairs(work: ObservedWork, first: FoundGains) -> list[ObserverPair] | NoDesign:
    """Return the pair of gains and observer to be proved, and behind it the one to fall back to.

    The latter is of the first gains, with the slowest observer by LMIs whose set of starts is
    nearly the largest.
    """
    tried: list[str] = []
    pairs = list(_by_lmis(work, first, tried))
    largest = max((pair.size for pair in pairs), default=0.0)
    chosen = [next(pair for pair in pairs if pair.size >= NEARLY_BEST * largest)] if pairs else []
    beside = _beside_regulator(work, first, pairs)
    if beside is not None:
        chosen.insert(0, beside)
    return chosen or NoDesign(
        "gains were found for the states, but no observer with which the loop is proved "
        f"within the ranges; tried: {'; '.join(tried)}. Ask for a lower decay rate, narrow "
        "the ranges of what is not measured, or measure more"
    )


def _beside_regulator(
    work: ObservedWork, first: FoundGains, pairs: list[ObserverPair]
) -> ObserverPair | None:
    """Return the best of pairs by LMIs, and gains with Kalman filters; None: no choice."""
    model = work.base.task.model
    if len(model.states) > MOST_STATES or _count(work) > MOST_LOOPS:
        return None
    contest = contest_of(work.base.task, first)
    if contest is None:
        return None
    C = np.tensordot(weights_at_rest(model), model.C[:, work.rows], axes=1)
    P = np.asarray(first.design.P)
    words, K = regulator_gains(contest)[-1]  # at rest
    set_rate = SHARE_OF_RATE * float(first.design.decay_rate)
    by_lmis, regulators = (
        [
            pair
            for note, L in kalman_gains(contest, C)
            if isinstance(pair := _pair(work, gains, L, set_rate, note), ObserverPair)
        ]
        for gains in (first, used_gains(K, P, words))
    )
    candidates, rows = [*pairs, *by_lmis], tuple(work.rows)
    return best_pair(contest, candidates, regulators, rows, at_estimate=work.slopes is not None)


def _pair(
    work: ObservedWork,
    gains: FoundGains,
    L: Floats,
    rate: float,
    note: str,
    observer: Design | None = None,
) -> ObserverPair | str:
    """Return gains and observer with their set at a decay rate [1/s], or why there is none."""
    from takagi.lmi.analysis.start_set import start_set

    model, limits = work.base.task.model, work.base.requirements.input_limits
    K = rounded_gains(np.asarray(gains.design.require()[0]), DIGITS[0])
    loop = work.loop(K, rounded_gains(L, DIGITS[0]))
    limited = {} if limits is None else {"input_limits": np.asarray(limits).tolist()}
    matrices, rows = loops_and_limits(loop, limited)
    starts = starts_of(loop)
    ellipsoid = start_set(matrices, rows, starts, decay_rate=rate, sample_time=model.sample_time)
    if ellipsoid.P is None:
        return ellipsoid.diagnosis
    return ObserverPair(gains, K, L, ellipsoid.P, starts, note, observer)


def _by_lmis(work: ObservedWork, gains: FoundGains, tried: list[str]) -> Iterator[ObserverPair]:
    """Yield the gains with observers by LMIs, the slowest first; ``tried`` gets why others fail."""
    from takagi.lmi import observer

    model = work.base.task.model
    rate, gain_rate = work.base.requirements.decay_rate, float(gains.design.decay_rate)
    observed = SimpleNamespace(sample_time=model.sample_time, states=model.states)
    if work.slopes is not None:
        observed.A, observed.C = _slope_vertices(work.slopes, work.rows)
        relaxation = "common-gain"
    else:
        observed.A, observed.C = model.A, model.C[:, work.rows]
        observed.premises, observed.rules = model.premises, model.rules
        relaxation = "wang-tanaka-griffin"
    for factor in ERROR_RATE_FACTORS:
        speed = factor * max(gain_rate, rate or 0.0)
        words = f"errors that decay at {speed:.3g} 1/s"
        try:
            design = observer(observed, decay_rate=speed, relaxation=relaxation)
        except ModelError as error:
            # A vertex of the hull hides a mode: no observer follows it, however slow.
            tried.append(str(error))
            return
        if not design.found:
            tried.append(f"{words}: {design.answer.diagnosis}")
            continue
        L = np.asarray(design.require()[0])
        if work.slopes is not None:
            L = L[:1]
        set_rate = SHARE_OF_RATE * gain_rate if rate is None else 1.0001 * rate
        pair = _pair(work, gains, L, set_rate, f"observer: {words}", design)
        if isinstance(pair, ObserverPair):
            yield pair
        else:
            tried.append(f"{words}: {pair}")


# Options that are not proved for a loop with an observer.
NOT_PROVED_OPTIONS = ("damping", "fastest", "sample_time", "initial", "gain_bound")


def _refuse(task: GainTask) -> None:
    plant = task.plant
    for name in NOT_PROVED_OPTIONS:
        if getattr(task.settings, name):
            raise ModelError(
                f"plant {plant.name!r}: {name} was given, which is not proved for a law with "
                "measured outputs; leave it out, or leave out 'measured' for a law of all states"
            )
    check_detectable(plant, task.model, plant.measured_rows, range(len(plant.states)))


def _slopes_and_note(task: GainTask, data: dict[str, Any]) -> tuple[TSModel | None, str]:
    """Return ``slopes`` and ``note`` of ``ObservedWork``."""
    plant, model, names = task.plant, task.model, task.plant.measured or ()
    # By itself and unchanged: the program computes premises of what it reads.
    expressions = {y.expression for y in plant.outputs if y.name in names}
    pairs = zip(plant.states, model.states, strict=True)
    by_themselves = {label for v, label in pairs if v.symbol in expressions}
    scheduled = ClaimedLoop.of(model, model_data=data).exact.scheduled_by or ()
    outside = [label for label in scheduled if label not in model.states]
    if outside:
        raise ModelError(
            f"plant {plant.name!r}: a premise depends on {', '.join(outside)}, which an observer "
            "does not know; choose premises of states alone in [premises], or leave out 'measured'"
        )
    hidden = [label for label in scheduled if label not in by_themselves]
    note = f"an observer of {', '.join(names)}; "
    if not hidden:
        reason = "its weights are the plant's own" if scheduled else "the plant is linear"
        return None, note + reason
    unknown = ", ".join(label.split(" [")[0] for label in hidden)
    note += (
        f"premises depend on {unknown}, which is not measured, so that its weights are those at "
        "the estimate"
    )
    try:
        slopes = secant_model(plant, rest=task.settings.rest)
        slopes_data(slopes)
    except ModelError as error:
        # The message begins with the formula of the slope, which may be long.
        _, depends, formula = str(error).partition(" depends on ")
        reason = f"a slope depends on {formula}" if depends else str(error)
        raise ModelError(
            f"premises depend on {unknown}, which is not measured; an observer at its estimate "
            f"needs bounded slopes of the plant, and has none: {reason}. Measure {unknown} too, "
            "give ranges to what the slopes depend on, or write the equations without tables and "
            "kinks"
        ) from error
    return slopes, note


def _slope_vertices(slopes: TSModel, rows: list[int]) -> tuple[Floats, Floats]:
    """Return the different pairs S (k, n, n) and R (k, p, n) of the slopes."""
    S, R = slopes.A, slopes.C[:, rows]
    pairs = np.concatenate([S, R], axis=1)
    _, first_indices = np.unique(pairs.reshape(len(pairs), -1), axis=0, return_index=True)
    distinct = np.sort(first_indices)
    return S[distinct], R[distinct]


def check_detectable(
    plant: Plant, model: TSModel, rows: tuple[int, ...], states: Sequence[int]
) -> None:
    """Refuse a mode at rest that does not decay and is not observable.

    Parameters
    ----------
    states : places of the states that are estimated.

    Raises
    ------
    ModelError : there is one; names what it moves.
    """
    from takagi.lmi.argument_checks import fixed_mode

    h, estimated = weights_at_rest(model), list(states)
    A = np.tensordot(h, model.A, axes=1)[np.ix_(estimated, estimated)]
    C = np.tensordot(h, model.C[:, list(rows)], axes=1)[:, estimated]
    # States scaled to order one, so that one tolerance fits all.
    units = np.array([
        1.0 if label not in model.box else max(float(abs(e)) for e in model.box[label])
        for label in (model.states[k] for k in estimated)
    ])  # fmt: skip
    A, C = A * units / units[:, None], C * units
    mode = fixed_mode(A.T[None], C.T[None], 0.0, step=model.sample_time)
    if mode is None:
        return
    _, eigenvalue, _ = mode
    # The right eigenvector has the states that move in this mode.
    values, vectors = np.linalg.eig(A)
    moving = np.abs(vectors[:, np.argmin(np.abs(values - eigenvalue))])
    moving_states = ", ".join(
        plant.states[k].name
        for k, size in zip(estimated, moving, strict=True)
        if size > 0.05 * moving.max()
    )
    value = f"{eigenvalue:.4g}" if eigenvalue.imag else f"{eigenvalue.real:.4g}"
    raise ModelError(
        f"at rest the mode at {value} (it moves {moving_states}) does not decay and shows in "
        f"nothing that is measured ({', '.join(plant.measured or ())}); no observer can follow "
        f"it: measure one of {moving_states} too"
    )
