"""From a model or a plant and its gains to a certificate: requests, claims, proof."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.reader import read_json
from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.certificates.checker.replay.certificate import check, check_document
from takagi.certificates.document.certificate_file import (
    certificate_document,
    content_of,
    dumps,
    provenance,
)
from takagi.certificates.document.model_data import rounded_up
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.certificates.requests.attempts import (
    attempted,
    attempts_at_all,
    proved_of,
    requests_for,
)
from takagi.certificates.requests.attraction_region import AttractionRegion
from takagi.certificates.requests.decay import Decay, Poles
from takagi.certificates.requests.exit_probability import ExitProbability
from takagi.certificates.requests.fuzzy_decay import FuzzyDecay
from takagi.certificates.requests.invariant_ellipsoid import InputLimits
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, Request
from takagi.certificates.requests.sampled_loop import SampledLoop
from takagi.certificates.requests.tracking import Tracking, observer_data
from takagi.certificates.requests.transient import Transient
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import PlantSettings

if TYPE_CHECKING:
    from takagi.lmi import EigenvalueRegion
    from takagi.models.equilibrium_line import ConstantObserver
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

LONGEST_VALUE = 60  # the most characters of a given value in a message


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Certificate(ShortRepr):
    """A certificate and the verdicts of the independent checker.

    Attributes
    ----------
    document : the file as plain data.
    checked : verdict per claim.
    tried : what was tried, in words, in order.
    """

    document: Mapping[str, Any]
    checked: Checked
    tried: tuple[str, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """PROVED, DISPROVED or UNDECIDED."""
        return self.checked.verdict

    def save(self, path: Path | str) -> Path:
        """Write a temporary file in the same folder, then rename it; return the path."""
        target = Path(path)
        beside = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            beside.write_text(dumps(self.document), encoding="utf-8")
            os.replace(beside, target)
        finally:
            beside.unlink(missing_ok=True)
        return target


def load_certificate(path: Path | str) -> Certificate:
    """Return a certificate read from a file and checked again.

    Raises
    ------
    CertificateError : the file is refused.
    """
    return Certificate(read_json(Path(path)), check(path))


def certify(
    model: TSModel,
    gains: ArrayLike | None = None,
    *,
    decay_rate: float | None = None,
    claims: Sequence[Request] | Literal["all"] | None = None,
    law: Mapping[str, Any] | None = None,
) -> Certificate:
    """Return a proof attempt for claims about a model, closed by u = -sum_j h_j K_j x.

    The claims are about the decimals of A, B and K as written, along every blend: the weights h may
    vary freely.

    Parameters
    ----------
    model : in continuous or discrete time; A (r, n, n), B (r, n, m).
    gains : K (r, m, n); one for all rules may be given as (m, n); None for the model as it is.
    decay_rate : required alpha [1/s]; None proves slightly less than the largest rate found.
    claims : what is asked for, from ``takagi.certificates.requests``; None asks for the decay rate
        with one quadratic function, ``[Decay(decay_rate)]``; "all" for that and whatever follows
        from it for this loop and can be proved, ``tried`` says what cannot.
    law : the ``law`` member of a gain file to be written in place of K and the names.

    Returns
    -------
    PROVED when every claim is; DISPROVED when one of them is impossible, with exact evidence;
    UNDECIDED otherwise.  ``tried`` says what was tried.

    Raises
    ------
    ModelError : shapes, numbers that are not finite, requests that make no sense for this model, a
        premise whose bounds are sampled.
    TypeError : claims are no list, or an entry of them is no request; names the entry.

    Source: Tanaka and Wang (2001), chapter 3; Boyd et al. (1994), section 5.1.
    """
    refuse_sampled(model)
    if isinstance(claims, str) and claims != "all":
        raise ModelError(f"claims = {claims!r}: give 'all', or requests such as [Decay()]")
    if claims is not None and claims != "all" and decay_rate is not None:
        raise ModelError("decay_rate and claims were given; give claims=[Decay(rate), ...] alone")
    if claims is None:
        claims = [Decay(decay_rate)]
    requests = [] if claims == "all" else _requests(claims)
    if not requests and claims != "all":
        raise ModelError("no claims were asked for; give at least one request, such as Decay()")
    model_data, embedding_claims, notes = plant_and_claim(model)
    loop = ClaimedLoop.of(model, gains, model_data=model_data, law=law)
    unproved: Sequence[str] = ()
    if claims == "all":
        attempts, unproved = attempts_at_all(loop, decay_rate=decay_rate)
    else:
        attempts = [attempted(request, loop) for request in requests]
    return _certificate(loop, embedding_claims, attempts, {}, notes, unproved)


def _certificate(
    loop: ClaimedLoop,
    embedding_claims: Sequence[Mapping[str, Any]],
    attempts: Sequence[Attempt],
    settings: object,
    notes: Sequence[str],
    unproved: Sequence[str],
    *,
    files: Sequence[Path] = (),
) -> Certificate:
    """Return the certificate with the claims in front and those of all attempts, checked."""
    document = certificate_document(
        model=loop.model_data,
        gains=loop.gains_data,
        claims=[*embedding_claims, *(attempt.claim for attempt in attempts)],
        provenance=provenance(
            settings, {str(attempt.claim["kind"]): attempt.solver for attempt in attempts}
        ),
        files=files,
    )
    tried = (*notes, *(words for attempt in attempts for words in attempt.tried), *unproved)
    return Certificate(document, check_document(document), tried)


def _requests(claims: object) -> list[Request]:
    """Return the requests; refuses invalid ones."""
    if not isinstance(claims, Iterable):
        raise TypeError(
            f"claims: {_named(claims)} was given; a list of requests is needed, such as [Decay()]"
        )
    requests = list(claims)
    for k, request in enumerate(requests):
        if isinstance(request, type) or not callable(getattr(request, "attempt", None)):
            raise TypeError(
                f"claims[{k}]: {_named(request)} was given; a request is needed, such as Decay() "
                "of takagi.certificates.requests"
            )
    return requests


def _named(value: object) -> str:
    if isinstance(value, type):
        return f"the class {value.__name__}"
    text = repr(value)
    return text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]}..."


def refuse_sampled(model: TSModel) -> None:
    """Raise ModelError for a model with a premise whose bounds come from samples.

    Its vertices need not contain the plant: between the samples a premise may leave its bounds.
    """
    if model.sampled:
        names = ", ".join(model.sampled)
        raise ModelError(
            f"model {model.name!r}: the bounds of {names} are sampled, which is no proof, so "
            "nothing can be proved of the plant; let sector_model enclose them, or give bounds "
            "that it can confirm"
        )


# Each claim other than decay needs a few solver runs; with more blends they take minutes.
MOST_BLENDS = 2500
# A function of the weights has a matrix for each rule, and its proof grows with their products.
MOST_SCHEDULED = 8
# Of the slowest mode of the rules, the decay rates that it is asked for where none is asked.
SCHEDULED_SHARES = (0.5, 0.1, 0.0)


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
    shape : P of the set on which the inputs keep their limits; None for the best that is found.
    polynomial_region : whether a region of attraction of a polynomial is asked for.
    premise_rates : bounds of the premises' rates, for a function that depends on the weights, where
        no common one is found; None for none.
    norm : the request of a norm of at most a number, or of the least for None; None for no norm.
    norm_below : the norm that is asked for; None for whatever can be proved.
    """

    decay_rate: float | None = None
    input_limits: Floats | None = None
    region: EigenvalueRegion | None = None
    sample_time: float | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    horizon: float | None = None
    shape: Floats | None = None
    norm: Callable[[float | None], Request] | None = None
    norm_below: float | None = None
    polynomial_region: bool = False
    premise_rates: Callable[[], Mapping[str, float] | None] | None = None


def plant_certificate(
    model: TSModel,
    gains: Floats | None,
    settings: PlantSettings,
    requirements: ClaimRequirements,
    *,
    files: Sequence[Path] = (),
    law: Mapping[str, Any] | None = None,
    observer: ConstantObserver | None = None,
) -> Certificate:
    """Return the certificate: embedding, decay, requested claims, and further proved claims.

    Requested claims are included even if they cannot be proved. Further claims are included only if
    they are proved; ``tried`` lists the others.

    Parameters
    ----------
    files : the data files of the plant; the certificate records their content.
    law : a law with its own weights and these gains, as it is written to the file; None for a law
        with the weights of the model.
    observer : of a law with references and measured outputs. Of it, and of a plant whose rest is
        rounded, the claims are those about references alone.

    Raises
    ------
    ModelError : a premise whose bounds are sampled.
    """
    refuse_sampled(model)
    model_data, embedding_claims, notes = plant_and_claim(model)
    if model_data is not None and files:
        model_data |= content_of(files)
    loop = ClaimedLoop.of(model, gains, model_data=model_data, law=law)
    plant = _referred(loop)
    if plant is not None and (observer is not None or not plant.rests_exactly):
        loop = replace(loop, gains_data={**(loop.gains_data or {}), **observer_data(observer)})
        attempts, embedding_claims = list(_tracking(loop, observer)), []
        tried: list[str] = []
    else:
        attempts, tried = _attempts(loop, requirements)
    return _certificate(loop, embedding_claims, attempts, settings, notes, tried, files=files)


def _referred(loop: ClaimedLoop) -> Plant | None:
    """Return the plant of a loop with references; None for another loop."""
    form = None if loop.model.derivation is None else loop.model.derivation.form
    plant = None if form is None or loop.gains is None else form.plant
    return plant if plant is not None and plant.references else None


def _attempts(
    loop: ClaimedLoop, requirements: ClaimRequirements
) -> tuple[list[Attempt], list[str]]:
    decay = attempted(Decay(), loop)
    rate = requirements.decay_rate
    if rate is not None and not (decay.proved and decay.claim["decay_rate"] >= rate):
        decay = attempted(Decay(rate), loop)
    if not decay.proved:
        decay = _scheduled(loop, requirements) or decay
    required = [decay, *(attempted(request, loop) for request in _demanded(loop, requirements))]
    required += [*_sampled(loop, requirements.sample_time), *_under_noise(loop, requirements)]
    required += [*_tracking(loop), *_with_norm(loop, requirements)]
    if requirements.polynomial_region:
        required.append(AttractionRegion().attempt(loop))
    if not decay.proved or decay.claim["kind"] == "fuzzy-decay":
        return required, ["without decay by a common function nothing else was tried"]
    if len(loop.exact.groups()) > MOST_BLENDS:
        note = f"more than {MOST_BLENDS} blends: nothing beside what was asked was tried"
        return required, [note]
    limited = InputLimits if requirements.input_limits is not None else ()
    if requirements.norm is not None:
        limited = (*((InputLimits,) if limited else ()), type(requirements.norm(None)))
    further = (r for r in requests_for(loop) if not isinstance(r, limited))
    proved, notes = proved_of(further, loop)
    useful, overshoot_notes = useful_overshoot(loop, proved)
    return [*required, *useful], [*notes, *overshoot_notes]


def _scheduled(loop: ClaimedLoop, requirements: ClaimRequirements) -> Attempt | None:
    """Return the claim of decay by a function that depends on the weights, if it is proved.

    Limits and regions of poles are proved by a common function alone, so it is not tried with them.
    """
    others = (requirements.input_limits, requirements.region, requirements.norm)
    weighted = loop.exact.corners is not None and len(loop.exact.corners[0]) > 0
    if any(wish is not None for wish in others) or loop.gains is None or not loop.is_double_sum:
        return None
    find = requirements.premise_rates
    rates = None if find is None or not weighted or loop.exact.rules > MOST_SCHEDULED else find()
    if rates is None and loop.sample_time is None:
        return None
    asked = requirements.decay_rate
    slowest = _slowest_mode(loop)
    for alpha in (asked,) if asked is not None else (share * slowest for share in SCHEDULED_SHARES):
        request = FuzzyDecay(np.inf if rates is None else rates, float(f"{max(alpha, 0.0):.3g}"))
        # A common function, which ``attempted`` would try too, is known not to prove it.
        attempt = request.attempt(loop)
        if attempt.proved and (asked is None or attempt.claim["decay_rate"] >= asked):
            return attempt
    return None


def _slowest_mode(loop: ClaimedLoop) -> float:
    """Return the least decay rate [1/s] of the rules with their own gains."""
    K = np.asarray(loop.gains)
    modes = np.linalg.eigvals(loop.model.A - loop.model.B @ K)
    if loop.sample_time is None:
        return float(-modes.real.max())
    return float(-np.log(max(np.abs(modes).max(), 1e-300)) / loop.sample_time)


def _with_weaker(required: Attempt, weaker: Callable[[], Attempt]) -> Iterator[Attempt]:
    """Yield what is required; where it is not proved, also what is less and is."""
    yield required
    if not required.proved and (attempt := weaker()).proved:
        yield attempt


def _with_norm(loop: ClaimedLoop, requirements: ClaimRequirements) -> Iterator[Attempt]:
    """Yield the claim about the norm that is asked for; if it is not proved, also one that is."""
    if requirements.norm is None:
        return
    best, below = attempted(requirements.norm(None), loop), requirements.norm_below
    if below is None or (best.proved and best.claim.get("gain", best.claim.get("norm")) <= below):
        yield best
        return
    yield from _with_weaker(attempted(requirements.norm(below), loop), lambda: best)


def _sampled(loop: ClaimedLoop, step: float | None) -> Iterator[Attempt]:
    """Yield the claim at a sample time; if it is not proved, the claim at the largest one below."""
    if step is None:
        return
    required = SampledLoop(step).attempt(loop)
    yield from _with_weaker(required, lambda: SampledLoop(below=step).attempt(loop))


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
    half_widths = [float(min(-box[k][0], box[k][1])) if k in box else 0.0 for k in names]
    # A signal that only schedules pushes no state.
    bounds = np.where(loop.model.E.any(axis=(0, 1)), half_widths, 0.0).tolist()
    request = ExitProbability(noise, requirements.horizon, disturbance="disturbances")
    if any(bounds):
        bounded = attempted(replace(request, disturbance_bounds=bounds), loop)
        if bounded.proved:
            yield bounded
            return
    yield attempted(request, loop)


def _tracking(loop: ClaimedLoop, observer: ConstantObserver | None = None) -> Iterator[Attempt]:
    """Yield the claims about references; where a rate is not proved, also one that is."""
    plant = _referred(loop)
    if plant is None:
        return
    yield Tracking("jumps", observer=observer).attempt(loop)
    if any(reference.rate is not None for reference in plant.references):
        slower = Tracking("rate", slower=True, observer=observer)
        required = Tracking("rate", observer=observer).attempt(loop)
        yield from _with_weaker(required, lambda: slower.attempt(loop))


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
        yield InputLimits(limits=requirements.input_limits, P=requirements.shape)


# A motion from the invariant set stays in the box anyway.  A bound of k times says more only to
# starts within 1/k of the box, and a set that reaches a tenth of the box is called little of it.
USEFUL = 10.0
SETS = ("invariant-ellipsoid", "input-limits")
NAME = "overshoot and settling time, states over their half-widths of the invariant set"


def useful_overshoot(loop: ClaimedLoop, attempts: list[Attempt]) -> tuple[list[Attempt], list[str]]:
    """Return the proved attempts with a useful bound of the overshoot or none, and notes.

    A bound above 10 is asked for again with the states over their half-widths of the proved set:
    a state without a range has no other natural size.  If that is above 10 too, none is claimed,
    and the note says so.
    """
    useful, notes = [], []
    for attempt in attempts:
        if attempt.claim["kind"] != "transient" or _overshoot(attempt) <= USEFUL:
            useful.append(attempt)
            continue
        scales = _half_widths(attempts)
        proved = [attempt]
        if scales is not None:
            rescaled = attempted(Transient(scales=scales, name=NAME), loop)
            proved += [rescaled] if rescaled.proved else []
        best = min(proved, key=_overshoot)
        if _overshoot(best) <= USEFUL:
            useful.append(best)
        else:
            notes.append(
                f"Transient: an overshoot of at most {_overshoot(best):.4g} times is proved, which "
                "says nothing beside the invariant set, and is not claimed"
            )
    return useful, notes


def _overshoot(attempt: Attempt) -> float:
    return float(Fraction(str(attempt.claim["overshoot"])))


def _half_widths(attempts: list[Attempt]) -> Floats | None:
    """Return (n,) of the first proved set, to two digits; None without one."""
    claim = next((attempt.claim for attempt in attempts if attempt.claim["kind"] in SETS), None)
    if claim is None:
        return None
    P = np.array([[float(Fraction(str(entry))) for entry in row] for row in claim["P"]])
    reach = np.sqrt(float(Fraction(str(claim["level"]))) * np.diag(np.linalg.inv(P)))
    return np.array([rounded_up(float(size), 2) for size in reach])
