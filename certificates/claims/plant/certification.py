"""From a Takagi-Sugeno model and its gains to a certificate: candidate, then proof."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.reader import read_json
from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.certificates.checker.replay.certificate import check, check_document
from takagi.certificates.document.certificate_file import certificate_document, dumps
from takagi.certificates.document.plant_embedding import plant_and_claim
from takagi.certificates.document.provenance import provenance
from takagi.certificates.requests.all_claims import attempts_at_all
from takagi.certificates.requests.decay import Decay
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.on_pieces import attempted
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.requests.request import Request
    from takagi.models.ts.model import TSModel

LONGEST = 60  # the most characters of a given value in a message


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
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
    asked = [Decay(decay_rate)] if claims is None else [] if claims == "all" else _requests(claims)
    if not asked and claims != "all":
        raise ModelError("no claims were asked for; give at least one request, such as Decay()")
    model_data, claims_before, notes = plant_and_claim(model)
    loop = ClaimedLoop.of(model, gains, model_data=model_data, law=law)
    unproved: Sequence[str] = ()
    if claims == "all":
        attempts, unproved = attempts_at_all(loop, decay_rate=decay_rate)
    else:
        attempts = [attempted(request, loop) for request in asked]
    document = certificate_document(
        model=loop.model_data,
        gains=loop.gains_data,
        claims=[*claims_before, *(attempt.claim for attempt in attempts)],
        provenance=provenance(
            {}, {str(attempt.claim["kind"]): attempt.solver for attempt in attempts}
        ),
    )
    tried = (*notes, *(words for attempt in attempts for words in attempt.tried), *unproved)
    return Certificate(document, check_document(document), tried)


def _requests(claims: object) -> list[Request]:
    """Return the requests; refuses invalid ones."""
    if not isinstance(claims, Iterable):
        raise TypeError(
            f"claims: {_named(claims)} was given; a list of requests is needed, such as [Decay()]"
        )
    found = list(claims)
    for k, one in enumerate(found):
        if isinstance(one, type) or not callable(getattr(one, "attempt", None)):
            raise TypeError(
                f"claims[{k}]: {_named(one)} was given; a request is needed, such as Decay() of "
                "takagi.certificates.requests"
            )
    return found


def _named(given: object) -> str:
    if isinstance(given, type):
        return f"the class {given.__name__}"
    text = repr(given)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


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
