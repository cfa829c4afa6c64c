"""Laws that are more than gains: which claims may be made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.replay.claim_kinds import KINDS

SAMPLED = "sampled-loop"


def require_whole_law(gains: Mapping[str, Any], kinds: Sequence[str]) -> None:
    """Refuse claims about u = -K x where the law has more than gains, and runs otherwise.

    With an observer it runs as u = -K xhat.  With a blend it commands two actuators, and only the
    claim ``effort-blend`` says that these are the model's input.  An effort, and the integrals of
    references, are states of the model that move between samples, while a law that runs every T
    seconds changes them at its samples: xi + T (h - r).
    """
    about_loops = {kind for kind in kinds if kind in KINDS or kind == "tracking"}
    extras = [key for key in ("blending", "references") if key in gains]
    if extras and SAMPLED in kinds:
        raise CertificateError(
            f"gains.{extras[0]}: the law has a state of its own, which it changes at its samples; "
            f"{SAMPLED} would be about one that moves between them; leave the sample time out"
        )
    if "blending" in gains and about_loops and "effort-blend" not in kinds:
        raise CertificateError(
            "gains.blending: the law commands two actuators, and no claim effort-blend says that "
            "they are the model's input; make it again with 'takagi certify'"
        )
    if "observer" not in gains:
        return
    of_outputs = "tracking" if "references" in gains else "observed-loop"
    if other_claims := sorted((about_loops | ({"effort-blend"} & {*kinds})) - {of_outputs}):
        raise CertificateError(
            f"gains.observer: the law has no states but outputs, and {', '.join(other_claims)} "
            f"would be about another law; claim {of_outputs}"
        )
    if "blending" in gains:
        raise CertificateError("gains.blending: a law with an observer has none")
