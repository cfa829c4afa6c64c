"""Claims about a model are PROVED only if the model is proved to contain its plant.

A model with a blend contains it only if the blend is proved to be the plant's two actuators.  An
observer whose weights are taken at its estimate needs the plant's slopes as well.
"""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.replay.claim_kinds import KINDS

EMBEDDINGS, BLEND = ("sector-embedding", "secant-embedding"), "effort-blend"
SLOPES, OBSERVED, TRACKING = "slope-embedding", "observed-loop", "tracking"


def of_the_plant(outcomes: Sequence[Outcome], kinds: Sequence[str], where: str) -> list[Outcome]:
    """Return the outcomes; a claim about the loop is PROVED only if the model contains its plant.

    Raises
    ------
    CertificateError : no claim says that it does.
    """
    pairs = list(zip(outcomes, kinds, strict=True))
    tied = [outcome.verdict for outcome, kind in pairs if kind in EMBEDDINGS]
    if set(kinds) == {TRACKING}:
        # It proves its own embedding, of differences, and needs no equilibrium at the rest.
        return list(outcomes)
    if not tied:
        raise CertificateError(
            f"{where}: claims about a plant, but none that its model contains it"
        )
    blended = [outcome.verdict for outcome, kind in pairs if kind == BLEND]
    is_plant = not blended or Verdict.PROVED in blended
    if Verdict.PROVED in tied and is_plant:
        return list(outcomes)
    # A claim about references proves its embedding itself, but not that a blend is the plant.
    loop_kinds = {*KINDS} if is_plant else {*KINDS, TRACKING}
    return [
        _of_no_plant(outcome)
        if kind in loop_kinds and outcome.verdict is Verdict.PROVED
        else outcome
        for outcome, kind in pairs
    ]


def of_its_slopes(
    outcomes: Sequence[Outcome], kinds: Sequence[str], loop: PolytopicLoop | None, where: str
) -> list[Outcome]:
    """Return the outcomes; of an observer at its estimate PROVED only with the plant's slopes.

    Raises
    ------
    CertificateError : no claim says that the slopes are the plant's.
    """
    law = None if loop is None else loop.observer
    if law is None or not law.at_estimate or OBSERVED not in kinds:
        return list(outcomes)
    pairs = list(zip(outcomes, kinds, strict=True))
    tied = [outcome.verdict for outcome, kind in pairs if kind == SLOPES]
    if not tied:
        raise CertificateError(
            f"{where}: an observer with weights at its estimate, but no claim about the slopes"
        )
    if Verdict.PROVED in tied:
        return list(outcomes)
    why = "it holds for slopes that are not proved to be the plant's"
    return [
        _of_no_plant(outcome, why)
        if kind == OBSERVED and outcome.verdict is Verdict.PROVED
        else outcome
        for outcome, kind in pairs
    ]


def _of_no_plant(
    outcome: Outcome, why: str = "it holds for the model, which is not proved to contain its plant"
) -> Claim:
    # Imported here: its verdict stands, and its name is looked for.
    from takagi.certificates.checker.words.saying import in_words

    return Claim(in_words(outcome).name, Verdict.UNDECIDED, why)
