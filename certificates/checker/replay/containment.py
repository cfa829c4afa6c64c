"""Claims about a model are PROVED only if the model is proved to contain its plant."""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Outcome, Verdict
from takagi.certificates.checker.replay.claim_kinds import KINDS

EMBEDDINGS = ("sector-embedding", "secant-embedding")


def of_the_plant(found: Sequence[Outcome], kinds: Sequence[str], where: str) -> list[Outcome]:
    """Return the outcomes; a claim about the loop is PROVED only if the model contains its plant.

    Raises
    ------
    CertificateError : no claim says that it does.
    """
    tied = [one.verdict for one, kind in zip(found, kinds, strict=True) if kind in EMBEDDINGS]
    if not tied:
        raise CertificateError(
            f"{where}: claims about a plant, but none that its model contains it"
        )
    if Verdict.PROVED in tied:
        return list(found)
    return [
        _of_no_plant(one) if kind in KINDS and one.verdict is Verdict.PROVED else one
        for one, kind in zip(found, kinds, strict=True)
    ]


def _of_no_plant(one: Outcome) -> Claim:
    # Imported here: its verdict stands, and its name is looked for.
    from takagi.certificates.checker.words.saying import in_words

    why = "it holds for the model, which is not proved to contain its plant"
    return Claim(in_words(one).name, Verdict.UNDECIDED, why)
