"""The oracle's verdicts on the claims of a certificate about loops.

It reads the formulas of these claims in another way than the checker, from the loop that the
checker reads.  Files, hashes and all other claims are the checker's.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import CertificateError
from tests.certificates.oracle import decay, disturbed, limits
from tests.certificates.oracle.exact import Definite, Obligations
from tests.certificates.oracle.loop import VertexLoop, read_loop
from tests.certificates.oracle.reading import Refusal

NOT_REPLAYED = "NOT REPLAYED"
LOOPS: dict[str, Callable[[Any, VertexLoop], Obligations]] = {
    "decay": decay.decay,
    "no-common-decay": decay.no_common_decay,
    "region": decay.region,
    "transient": decay.transient,
    "gain-rounding": decay.gain_rounding,
    "l2-gain": disturbed.l2_gain,
    "h2-norm": disturbed.h2_norm,
    "peak": disturbed.peak,
    "exit-probability": disturbed.exit_probability,
    "invariant-ellipsoid": disturbed.invariant_ellipsoid,
    "input-limits": limits.input_limits,
}
# A claim that something does not exist: where its conditions hold, the verdict is DISPROVED.
AGAINST = "no-common-decay"


@dataclass(frozen=True, slots=True)
class Opinion:
    """The verdict on one claim; ``reason`` is the first condition that failed, else empty."""

    kind: str
    verdict: str
    reason: str = ""


def judge_document(document: Mapping[str, Any]) -> list[Opinion]:
    """Return the opinion on every claim; NOT REPLAYED where the oracle has no formula.

    Raises
    ------
    Refusal : model, gains or a claim about their loop do not fit.
    """
    try:
        data = read_text(json.dumps(document), "certificate")
        claims = data["claims"]
        loop = read_loop(data["model"], data["gains"]) if _is_about_loop(claims) else None
    except CertificateError as error:
        raise Refusal(str(error)) from error
    return [opinion(claim, loop) for claim in claims]


def _is_about_loop(claims: Any) -> bool:
    if not isinstance(claims, list) or not claims:
        raise Refusal("there are no claims")
    if not all(isinstance(claim, dict) and isinstance(claim.get("kind"), str) for claim in claims):
        raise Refusal("a claim has no kind")
    return any(claim["kind"] in LOOPS for claim in claims)


def opinion(claim: Any, loop: VertexLoop | None) -> Opinion:
    """Return the opinion on one claim; see ``judge_document``."""
    kind = claim["kind"]
    if kind not in LOOPS or loop is None or (loop.extremes and kind == AGAINST):
        return Opinion(kind, NOT_REPLAYED)
    # The constant has one value between its ends; a condition that is affine in the matrices, or
    # concave, holds there where it holds at the ends.
    for condition in chain.from_iterable(
        LOOPS[kind](claim, at_end) for at_end in (loop, *loop.extremes)
    ):
        if not condition.holds:
            failure = "is not definite" if isinstance(condition, Definite) else "does not hold"
            return Opinion(kind, "UNDECIDED", f"{condition.label} {failure}")
    return Opinion(kind, "DISPROVED" if kind == AGAINST else "PROVED")
