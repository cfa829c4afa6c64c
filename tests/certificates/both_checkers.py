"""The verdicts of the checker, and of its second readers, on all claims of a document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.replay.claim_kinds import KINDS
from takagi.certificates.checker.replay.containment import BLEND, EMBEDDINGS, SLOPES
from takagi.certificates.cross_check.flint_decider import FlintDecider
from tests.certificates.oracle.reading import Refusal
from tests.certificates.oracle.verdicts import LOOPS, judge_document

# The claims that a model is its plant, and the kinds that are proved only with one of them.
TIES = (({*EMBEDDINGS}, {*KINDS}), ({BLEND}, {*KINDS}), ({SLOPES}, {"observed-loop"}))


def verdicts(document: Mapping[str, Any]) -> list[str]:
    """Return the checker's verdict on each claim; REFUSED alone where it refuses the file."""
    try:
        return [claim.verdict.name for claim in check_document(document).claims]
    except CertificateError:
        return ["REFUSED"]


def second(document: Mapping[str, Any]) -> list[str]:
    """Return the oracle's verdict on claims whose formula it has, and FLINT's on all others."""
    try:
        opinions = judge_document(document)
        answers = [opinion.verdict for opinion in opinions]
        kinds = [opinion.kind for opinion in opinions]
        if {*kinds} <= LOOPS.keys():
            return answers
        checked = check_document(document, lambda place: FlintDecider())
    except (CertificateError, Refusal):
        return ["REFUSED"]
    for place, claim in enumerate(checked.claims):
        if kinds[place] not in LOOPS:
            answers[place] = claim.verdict.name
    for ties, tied in TIES:
        proved = {answers[place] for place, kind in enumerate(kinds) if kind in ties}
        if proved and "PROVED" not in proved:
            answers = [
                "UNDECIDED" if kind in tied and answer == "PROVED" else answer
                for kind, answer in zip(kinds, answers, strict=True)
            ]
    return answers
