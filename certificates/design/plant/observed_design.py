"""The design of a law with measured outputs: gains, an observer, and the proof of both together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.plant.certification import Certificate
from takagi.certificates.controller.content import bound
from takagi.certificates.controller.plant_members import plant_members
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.gains import rounded_gains
from takagi.certificates.design.plant.observer_question import (
    ObserverQuestion,
    observer_question,
    slope_vertices,
)
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import certificate_document, content_of
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.observer_data import observer_member, slope_claim, slopes_data
from takagi.certificates.document.plant_embedding import law_members, plant_and_claim
from takagi.certificates.document.provenance import provenance
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.observed_loop import (
    ObservedLoop,
    loops_and_limits,
    starts_of,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.claims.plant.certificate import ClaimRequirements
    from takagi.certificates.design.step_clock import StepClock
    from takagi.lmi import Design
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# Decay rates of the estimation error that are tried, as multiples of the rate of the gains.  A
# faster observer has larger gains, which amplify noise more.
FASTER = (1.0, 2.0, 4.0, 8.0)
# The slowest observer is taken whose set of starts has this share of the best one's mean width.
NEARLY = 0.8
# The gains are designed for slightly more than the required rate: the joint proof needs the rest.
MORE = 1.02
# Share of the gains' own rate for the search of the set, if no rate is required.
SHARE_OF_RATE = 0.5
# With more matrices than this, all rules get one gain, which reduces the number.
MOST_LOOPS = 600


@dataclass(frozen=True, slots=True, eq=False)
class ObservedWork:
    """The data to design and certify an observer and gains for one model."""

    plant: Plant
    asked: PlantSettings
    model: TSModel
    requirements: ClaimRequirements
    files: tuple[Path, ...]
    clock: StepClock
    question: ObserverQuestion
    model_data: dict[str, Any]
    claims: tuple[dict[str, Any], ...]

    @classmethod
    def of(
        cls,
        plant: Plant,
        asked: PlantSettings,
        model: TSModel,
        requirements: ClaimRequirements,
        files: Sequence[Path],
        clock: StepClock,
    ) -> ObservedWork:
        """Return it, after the checks of ``observer_question``."""
        with clock("model"):
            question = observer_question(plant, model, asked)
            data, claims, _ = plant_and_claim(model)
            assert data is not None  # the question has written it already
            if question.slopes is not None:
                data |= {"slopes": slopes_data(question.slopes)}
                claims = [*claims, slope_claim(plant.name)]
            if files:
                data |= content_of(files)
        return cls(
            plant=plant,
            asked=asked,
            model=model,
            requirements=requirements,
            files=tuple(files),
            clock=clock,
            question=question,
            model_data=data,
            claims=tuple(claims),
        )

    def loop(self, gains: Floats, L: Floats) -> ClaimedLoop:
        """Return the loop with gains K (r, m, n) and L (r or 1, n, p)."""
        at_estimate = self.question.at_estimate
        own = observer_member(L, self.question.measured, at_estimate=at_estimate)
        law = pdc_law_data(self.model, gains) | law_members(self.model_data) | {"observer": own}
        return ClaimedLoop.of(self.model, gains, model_data=self.model_data, law=law)

    def certified(
        self,
        gains: Floats,
        L: Floats,
        design: Design | None,
        notes: tuple[str, ...],
        P: Floats | None = None,
    ) -> PlantDesign:
        """Return the design with its certificate; ``P`` is a function that was found before."""
        from takagi.models.laws.pdc import OutputFeedback, PdcLaw

        with self.clock("exact proof"):
            loop = self.loop(gains, L)
            limits = self.requirements.input_limits
            attempt = ObservedLoop(self.requirements.decay_rate, limits, P).attempt(loop)
            document = certificate_document(
                model=self.model_data,
                gains=loop.gains_data,
                claims=[*self.claims, attempt.claim],
                provenance=provenance(self.asked, {"observed-loop": attempt.solver}),
                files=self.files,
            )
            checked = check_document(document)
        law = document["gains"]
        trim = law["trim"]
        feedback = PdcLaw(self.model, gains, np.array(trim["state"]), np.array(trim["input"]))
        run = OutputFeedback(feedback, L, self.question.rows, self.question.at_estimate)
        members = plant_members(self.plant, self.model, law, checked, notes)
        certificate = Certificate(bound(document, members), checked, attempt.tried)
        seconds = dict(self.clock.seconds)
        parts = (self.plant, self.asked, self.model, design, gains, None, certificate)
        return PlantDesign(*parts, notes, seconds, output_law=run)


def design_observed(work: ObservedWork, digits: Sequence[int]) -> PlantDesign | NoDesign:
    """Return gains, observer and their certificate, or why there are none.

    Parameters
    ----------
    digits : numbers of significant digits of the gains, tried in this order.
    """
    from takagi.certificates.design.plant.gains import find_gains
    from takagi.certificates.design.plant.obstacle import obstacle

    asked, question = work.asked, work.question
    rate = asked.decay_rate
    wanted = replace(asked, decay_rate=MORE * rate) if isinstance(rate, float) else asked
    with work.clock("gains"):
        found = find_gains(work.plant, work.model, wanted)
        if found.design.found and _count(work) > MOST_LOOPS:
            found = find_gains(work.plant, work.model, replace(wanted, relaxation="common-gain"))
    if not found.design.found:
        first = obstacle(found, work.plant, work.model, wanted)
        return NoDesign("\n".join(part for part in (first, found.design.answer.diagnosis) if part))
    K = np.asarray(found.design.require()[0])
    own = float(found.design.decay_rate)
    notes = (*found.notes, question.note)
    with work.clock("observer"):
        choice = _observer(work, rounded_gains(K, digits[0]), own, digits[0])
    if isinstance(choice, NoDesign):
        return choice
    last: PlantDesign | None = None
    for count in digits:
        L = rounded_gains(choice.L, count)
        whole = (*notes, choice.note, f"gains to {count} significant digits")
        P = choice.P if count == digits[0] else None
        last = work.certified(rounded_gains(K, count), L, found.design, whole, P)
        if last.proved:
            break
    assert last is not None  # there is always a number of digits
    return last


@dataclass(frozen=True, slots=True, eq=False)
class _Choice:
    """Gains of an observer before rounding; P of the loop with the rounded ones; its starts."""

    L: Floats
    P: Floats
    size: float
    note: str


def _count(work: ObservedWork) -> int:
    """Return about how many matrices the joint loop has with a gain for every rule."""
    rules = len(work.model.A)
    slopes = 1 if work.question.slopes is None else len(slope_vertices(work.question)[0])
    return rules * (rules + 1) // 2 * slopes


def _observer(work: ObservedWork, K: Floats, own: float, digits: int) -> _Choice | NoDesign:
    """Return the slowest observer whose set of starts is nearly the largest."""
    tried: list[str] = []
    found = list(_candidates(work, K, own, digits, tried))
    if not found:
        return NoDesign(
            "gains were found for the states, but no observer with which the loop is proved "
            f"within the ranges; tried: {'; '.join(tried)}. Ask for a lower decay rate, narrow "
            "the ranges of what is not measured, or measure more"
        )
    best = max(one.size for one in found)
    return next(one for one in found if one.size >= NEARLY * best)


def _candidates(
    work: ObservedWork, K: Floats, own: float, digits: int, tried: list[str]
) -> Iterator[_Choice]:
    from takagi.lmi import observer
    from takagi.lmi.analysis.start_set import start_set

    question, model = work.question, work.model
    limits = {}
    if work.requirements.input_limits is not None:
        limits = {"input_limits": np.asarray(work.requirements.input_limits).tolist()}
    rate = work.requirements.decay_rate
    if question.slopes is not None:
        S, R = slope_vertices(question)
        seen = SimpleNamespace(A=S, C=R, sample_time=model.sample_time, states=model.states)
        relaxation = "common-gain"
    else:
        C = model.C[:, list(question.rows)]
        seen = SimpleNamespace(A=model.A, C=C, sample_time=model.sample_time, states=model.states)
        seen.premises, seen.rules = model.premises, model.rules
        relaxation = "wang-tanaka-griffin"
    for factor in FASTER:
        speed = factor * max(own, rate or 0.0)
        words = f"errors that decay at {speed:.3g} 1/s"
        try:
            design = observer(seen, decay_rate=speed, relaxation=relaxation)
        except ModelError as error:
            # A vertex of the hull hides a mode: no observer follows it, however slow.
            tried.append(str(error))
            return
        if not design.found:
            tried.append(f"{words}: {design.answer.diagnosis}")
            continue
        L = np.asarray(design.require()[0])
        if question.slopes is not None:
            L = L[:1]
        loop = work.loop(K, rounded_gains(L, digits))
        G, rows = loops_and_limits(loop, limits)
        N = starts_of(loop)
        asked_rate = SHARE_OF_RATE * own if rate is None else 1.0001 * rate
        step = model.sample_time
        ellipsoid = start_set(G, rows, N, decay_rate=asked_rate, sample_time=step)
        if ellipsoid.P is None:
            tried.append(f"{words}: {ellipsoid.diagnosis}")
            continue
        shape = N.T @ ellipsoid.P @ N
        size = float(np.exp(-0.5 * np.linalg.slogdet(shape)[1] / len(shape)))
        yield _Choice(L, ellipsoid.P, size, f"observer: {words}")
