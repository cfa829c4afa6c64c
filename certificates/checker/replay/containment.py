"""Which claims may be made of a plant and its law, and which are PROVED.

Claims about a model are PROVED only if the model is proved to contain its plant.

A model with a blend contains it only if the blend is proved to be the plant's two actuators.  An
observer whose weights are taken at its estimate needs the plant's slopes as well.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.replay.claim_kinds import KINDS

EMBEDDINGS, BLEND = ("sector-embedding", "secant-embedding"), "effort-blend"
SLOPES, OBSERVED, TRACKING = "slope-embedding", "observed-loop", "tracking"
SAMPLED, BUMPLESS = "sampled-loop", "bumpless"
# Claims about model and law that hold for the plant only with an embedding.
ABOUT_LOOPS = frozenset({*KINDS, "attraction-region"})
# Kinds that earlier versions read, and the last commit that reads them all.
NO_LONGER_READ = frozenset(
    {
        "box-enlargement",
        "crossing-probability",
        "equilibrium",
        "no-common-quadratic",
        "quadratic-decay",
        "running-rate",
        "schedule-rate",
        "turbine-crossing",
        "turbulence-speed",
    }
)
LAST_READER = "1e325e61"


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
    loop_kinds = ABOUT_LOOPS if is_plant else ABOUT_LOOPS | {TRACKING, BUMPLESS}
    return _left_open(pairs, loop_kinds, "the model, which is not proved to contain its plant")


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
    return _left_open(pairs, {OBSERVED}, "slopes that are not proved to be the plant's")


def _left_open(
    pairs: Sequence[tuple[Outcome, str]], kinds: Collection[str], subject: str
) -> list[Outcome]:
    """Return the outcomes; those of these kinds that are proved hold for another subject alone."""
    failure = f"it holds for {subject}"
    return [
        replace(outcome, failure=failure)
        if kind in kinds and outcome.verdict is Verdict.PROVED
        else outcome
        for outcome, kind in pairs
    ]


def require_whole_law(model: Any, gains: Mapping[str, Any], kinds: Sequence[str]) -> None:
    """Refuse claims about u = -K x where the law has more than gains, and runs otherwise.

    With an observer it runs as u = -K xhat.  With a blend it commands two actuators, and only the
    claim ``effort-blend`` says that these are the model's input.  An effort, and the integrals of
    references, are states of the model that move between samples, while a law that runs every T
    seconds changes them at its samples: xi + T (h - r).  The integrators of a controller are
    states of the model under inputs that are held, so that x_c + T v is what they do.
    """
    if "integrators" in gains:
        # Imported here: few laws have states of their own.
        from takagi.certificates.checker.plant.integrators import require_integrators

        require_integrators(model, gains)
    about_loops = {kind for kind in kinds if kind in ABOUT_LOOPS | {TRACKING, BUMPLESS}}
    extras = [key for key in ("blending", "references") if key in gains]
    if extras and SAMPLED in kinds:
        raise CertificateError(
            f"gains.{extras[0]}: the law has a state of its own, which it changes at its samples; "
            f"{SAMPLED} would be about one that moves between them; leave the sample time out"
        )
    if "blending" in gains and about_loops and BLEND not in kinds:
        raise CertificateError(
            "gains.blending: the law commands two actuators, and no claim effort-blend says that "
            "they are the model's input; make it again with 'takagi certify'"
        )
    if "observer" not in gains:
        return
    of_outputs = TRACKING if "references" in gains else OBSERVED
    if other_claims := sorted((about_loops | ({BLEND} & {*kinds})) - {of_outputs}):
        raise CertificateError(
            f"gains.observer: the law has no states but outputs, and {', '.join(other_claims)} "
            f"would be about another law; claim {of_outputs}"
        )
    if "blending" in gains:
        raise CertificateError("gains.blending: a law with an observer has none")


def refuse_removed_kinds(kinds: Sequence[str]) -> None:
    """Refuse a file with a claim of a kind that is no longer read.

    Parameters
    ----------
    kinds : of the file's claims, in their order.

    Raises
    ------
    CertificateError : there is such a claim; the sentence names the last commit that reads it.
    """
    for i, kind in enumerate(kinds):
        if kind in NO_LONGER_READ:
            raise CertificateError(
                f"claims[{i}].kind: claims of kind {kind!r} are no longer read; check this file "
                f"with takagi at commit {LAST_READER}, the last that reads them, or make the "
                f"certificate again with 'takagi certify'"
            )
