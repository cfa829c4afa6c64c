"""One certificate with all claims about a plant and its law, requested and found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.plant.certification import Certificate, refuse_sampled
from takagi.certificates.claims.plant.useful_overshoot import useful_overshoot
from takagi.certificates.document.certificate_file import certificate_document, content_of
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.certificates.document.provenance import provenance
from takagi.certificates.requests.all_claims import proved_of, requests_for
from takagi.certificates.requests.decay import Decay
from takagi.certificates.requests.exit_probability import ExitProbability
from takagi.certificates.requests.input_limits import InputLimits
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.on_pieces import attempted
from takagi.certificates.requests.pole_region import Poles
from takagi.certificates.requests.request import Attempt, Request
from takagi.certificates.requests.sampled_loop import SampledLoop
from takagi.certificates.requests.tracking import Tracking
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import PlantSettings

if TYPE_CHECKING:
    from takagi.lmi import EigenvalueRegion
    from takagi.models.ts.model import TSModel

# Each claim other than decay needs a few solver runs; with more blends they take minutes.
MOST_BLENDS = 2500


@dataclass(frozen=True, slots=True, eq=False)
class ClaimRequirements:
    """Requirements for the gains, which must also be proved.

    Attributes
    ----------
    decay_rate : alpha in 1/s; None for none.
    input_limits : (m,) largest deviations from the equilibrium values; None for none.
    region : of the poles; None for none.
    sample_time : T in s of a command that is held; None for none.
    noise : label of a disturbance -> root of the intensity of the white noise that it is, SI.
    horizon : T in s within which the probability of leaving a set is to be bounded.
    """

    decay_rate: float | None = None
    input_limits: Floats | None = None
    region: EigenvalueRegion | None = None
    sample_time: float | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    horizon: float | None = None


def plant_certificate(
    model: TSModel,
    gains: Floats | None,
    settings: PlantSettings,
    requirements: ClaimRequirements,
    *,
    files: Sequence[Path] = (),
    law: Mapping[str, Any] | None = None,
) -> Certificate:
    """Return the certificate: embedding, decay, requested claims, and further proved claims.

    Requested claims are included even if they cannot be proved. Further claims are included only if
    they are proved; ``tried`` lists the others.

    Parameters
    ----------
    files : the data files of the plant; the certificate records their content.
    law : a law with its own weights and these gains, as it is written to the file; None for a law
        with the weights of the model.

    Raises
    ------
    ModelError : a premise whose bounds are sampled.
    """
    refuse_sampled(model)
    model_data, before, notes = plant_and_claim(model)
    if model_data is not None and files:
        model_data |= content_of(files)
    loop = ClaimedLoop.of(model, gains, model_data=model_data, law=law)
    attempts, tried = _attempts(loop, requirements)
    document = certificate_document(
        model=loop.model_data,
        gains=loop.gains_data,
        claims=[*before, *(attempt.claim for attempt in attempts)],
        provenance=provenance(
            settings, {str(attempt.claim["kind"]): attempt.solver for attempt in attempts}
        ),
        files=files,
    )
    words = (*notes, *(word for attempt in attempts for word in attempt.tried), *tried)
    return Certificate(document, check_document(document), words)


def _attempts(
    loop: ClaimedLoop, requirements: ClaimRequirements
) -> tuple[list[Attempt], list[str]]:
    decay = attempted(Decay(), loop)
    wanted = requirements.decay_rate
    if wanted is not None and not (decay.proved and decay.claim["decay_rate"] >= wanted):
        decay = attempted(Decay(wanted), loop)
    asked = [decay, *(attempted(request, loop) for request in _demanded(loop, requirements))]
    asked += [*_sampled(loop, requirements.sample_time), *_under_noise(loop, requirements)]
    asked += _tracking(loop)
    if not decay.proved:
        return asked, ["without decay nothing else was tried"]
    if len(loop.exact.groups()) > MOST_BLENDS:
        return asked, [f"more than {MOST_BLENDS} blends: nothing beside what was asked was tried"]
    limited = requirements.input_limits is not None
    others = (
        request
        for request in requests_for(loop)
        if not (limited and isinstance(request, InputLimits))
    )
    found, notes = proved_of(others, loop)
    useful, more = useful_overshoot(loop, found)
    return [*asked, *useful], [*notes, *more]


def _sampled(loop: ClaimedLoop, step: float | None) -> Iterator[Attempt]:
    """Yield the claim at a sample time; if it is not proved, the claim at the largest one below."""
    if step is None:
        return
    wanted = SampledLoop(step).attempt(loop)
    yield wanted
    if not wanted.proved:
        largest = SampledLoop(below=step).attempt(loop)
        if largest.proved:
            yield largest


def _under_noise(loop: ClaimedLoop, requirements: ClaimRequirements) -> Iterator[Attempt]:
    """Yield the claim under white noise, the other disturbances in their ranges or else at rest."""
    if requirements.horizon is None:
        return
    names, box = loop.exact.disturbances, loop.exact.other_box or {}
    for name in requirements.noise:
        if name in box:
            raise ModelError(
                f"noise: {name} has a range, and white noise has none; remove the range, or the "
                "premises that depend on it"
            )
    noise = [requirements.noise.get(name, 0.0) for name in names]
    held = [float(min(-box[k][0], box[k][1])) if k in box else 0.0 for k in names]
    # A signal that only schedules pushes no state.
    bounds = np.where(loop.model.E.any(axis=(0, 1)), held, 0.0).tolist()
    first = ExitProbability(noise, requirements.horizon, disturbance="disturbances")
    if any(bounds):
        found = attempted(replace(first, disturbance_bounds=bounds), loop)
        if found.proved:
            yield found
            return
    yield attempted(first, loop)


def _tracking(loop: ClaimedLoop) -> Iterator[Attempt]:
    """Yield the claims about references; where a rate is not proved, also one that is."""
    form = None if loop.model.derivation is None else loop.model.derivation.form
    if form is None or form.plant is None or not form.plant.references or loop.gains is None:
        return
    yield Tracking("jumps").attempt(loop)
    if any(one.rate is not None for one in form.plant.references):
        wanted = Tracking("rate").attempt(loop)
        yield wanted
        if not wanted.proved:
            slower = Tracking("rate", slower=True).attempt(loop)
            if slower.proved:
                yield slower


def _demanded(loop: ClaimedLoop, requirements: ClaimRequirements) -> Iterator[Request]:
    if loop.gains is None:
        return
    if requirements.region is not None:
        yield Poles(requirements.region)
    if requirements.input_limits is not None:
        if not any(side is not None for side in loop.exact.box):
            raise ModelError(
                f"plant {loop.model.name!r}: its inputs are limited, but no state has a range, so "
                "there is no set of states to keep the limits on; give the states ranges"
            )
        yield InputLimits(limits=requirements.input_limits)
