"""The verdicts of the second checker: the conditions of each claim, and whether they hold.

Nothing here is shared with the first checker, with the models or with the solver. This checker
reads the file with its own code, computes with exact numbers and matrices of FLINT, encloses
functions by FLINT's balls, and decides definiteness by characteristic polynomials.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from takagi.certificates.cross_check.kernel.exact import Definite, Obligation, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    NotReplayed,
    Refusal,
    entry,
    hashes_differ,
    line,
    load,
    loads,
    whole,
)
from takagi.certificates.cross_check.loop import (
    decay,
    disturbed,
    fuzzy,
    limits,
    observing,
    sampled,
)
from takagi.certificates.cross_check.loop.loop import VertexLoop
from takagi.certificates.cross_check.plant.plant import read_loop, with_slopes

NOT_REPLAYED = "NOT REPLAYED"
FORMAT, VERSION = "takagi-certificate", 1
LOOPS: dict[str, Callable[[Any, VertexLoop], Obligations]] = {
    "decay": decay.decay,
    "no-common-decay": decay.no_common_decay,
    "region": decay.region,
    "transient": decay.transient,
    "gain-rounding": decay.gain_rounding,
    "fuzzy-decay": fuzzy.fuzzy_decay,
    "fuzzy-l2-gain": fuzzy.fuzzy_l2_gain,
    "l2-gain": disturbed.l2_gain,
    "h2-norm": disturbed.h2_norm,
    "peak": disturbed.peak,
    "exit-probability": disturbed.exit_probability,
    "invariant-ellipsoid": disturbed.invariant_ellipsoid,
    "input-limits": limits.input_limits,
    "observer": observing.observer,
    "observed-feedback": observing.observed_feedback,
    "observed-loop": observing.observed_loop,
    "sampled-loop": sampled.sampled_loop,
}
# Claims that the model contains the plant, that its effort is the plant's two actuators, and that
# its slopes are the plant's.
CONTAINING, BLEND = {"sector-embedding", "secant-embedding"}, {"effort-blend"}
SLOPES = "slope-embedding"
# Claims that depend on an earlier claim of the same file.
RESTING = ("wind-rate", "actuator-rates")
# The members of such a claim that name the claims on which it depends.
RESTS_ON = ("loop", "wind_rate")
# The claim that also reads the gain file's observer and filters, from the member ``controller``.
WITH_OBSERVER = "running-loop"
# Claims about a turbine's loop whose conditions are implemented here.
OF_TURBINES = ("coherent-loop", *RESTING, WITH_OBSERVER)
# Claims that something does not exist: where their conditions hold the verdict is DISPROVED.
AGAINST = ("no-common-decay",)


@dataclass(frozen=True, slots=True)
class Opinion:
    """What the second checker says of one claim.

    Attributes
    ----------
    kind : the kind of the claim, as the file names it.
    verdict : PROVED, DISPROVED, UNDECIDED, or ``NOT_REPLAYED`` for a claim, or a step of one, that
        this checker does not implement.
    inequalities : the number of matrices whose definiteness was decided.
    reason : the first condition that failed, or the step that is not implemented; else empty.
    """

    kind: str
    verdict: str
    inequalities: int
    reason: str = ""


def judge(path: Path) -> list[Opinion]:
    """Return the opinion on every claim of a file.

    Raises
    ------
    Refusal : the file cannot be read, is no certificate, or is not the one that was hashed.
    """
    return _judged(load(path))


def judge_document(document: Mapping[str, Any]) -> list[Opinion]:
    """Return the opinion on a certificate in memory; see ``judge``."""
    return _judged(loads(json.dumps(document)))


def _judged(document: dict[str, Any]) -> list[Opinion]:
    """Return the opinions; a claim that depends on another is proved only if that one is proved.

    Claims about a plant's loop depend on the claims that the model contains the plant, and that its
    effort is the plant's two actuators.
    """
    found: list[Opinion] = []
    for place, (kind, obliged) in enumerate(claims_of(document)):
        one = _opinion(kind, obliged)
        if kind in RESTING and one.verdict == "PROVED":
            claim = document["claims"][place]
            below = [found[whole(claim, name)] for name in RESTS_ON if name in claim]
            if unproved := [other.verdict for other in below if other.verdict != "PROVED"]:
                reason = f"the claim that it rests on is {unproved[0]}"
                verdict = NOT_REPLAYED if unproved[0] == NOT_REPLAYED else "UNDECIDED"
                one = Opinion(kind, verdict, one.inequalities, reason)
        found.append(one)
    found = _with_its_slopes(found, document)
    # A containing claim that is not implemented here leaves the claims about the loop as they are:
    # the reader sees NOT REPLAYED beside them, and the first checker decides it.
    ties = [{one.verdict for one in found if one.kind in kinds} for kinds in (CONTAINING, BLEND)]
    if all(not tie or tie & {"PROVED", NOT_REPLAYED} for tie in ties):
        return found
    return _undecided(found, LOOPS, "the model is not proved to contain its plant")


def _undecided(found: list[Opinion], kinds: Collection[str], reason: str) -> list[Opinion]:
    """Return the opinions, with those of these kinds that are PROVED made UNDECIDED."""
    return [
        Opinion(one.kind, "UNDECIDED", one.inequalities, reason)
        if one.kind in kinds and one.verdict == "PROVED"
        else one
        for one in found
    ]


def _with_its_slopes(found: list[Opinion], document: Any) -> list[Opinion]:
    """Return the opinions; the loop of an observer at its estimate needs proved slopes."""
    gains = document.get("gains")
    own = gains.get("observer") if isinstance(gains, dict) else None
    if not isinstance(own, dict) or own.get("weights") != "estimated":
        return found
    tied = {one.verdict for one in found if one.kind == SLOPES}
    if tied & {"PROVED", NOT_REPLAYED}:
        return found
    return _undecided(found, ["observed-loop"], "the slopes are not proved to be the plant's")


def claims_of(document: dict[str, Any]) -> Iterator[tuple[str, Obligations | None]]:
    """Yield (kind, obligations) of every claim; None for a kind that is not implemented here."""
    if line(document, "format") != FORMAT or whole(document, "version") != VERSION:
        raise Refusal(f"not a {FORMAT} of version {VERSION}")
    changed = hashes_differ(document)
    if changed:
        raise Refusal(f"the {changed} changed after the hash was made")
    claims = entry(document, "claims")
    if not isinstance(claims, list) or not claims:
        raise Refusal("there are no claims")
    kinds = [entry(claim, "kind") for claim in claims]
    for claim in claims:
        line(claim, "kind"), line(claim, "name")
    model, gains = entry(document, "model"), document.get("gains")
    about_plant = isinstance(model, dict) and model.get("kind") == "plant"
    # References are followed by differences of motions, whose embedding that claim shows itself.
    if about_plant and not CONTAINING & {*map(str, kinds)} and set(kinds) != {"tracking"}:
        raise Refusal("claims about a plant, and none that it is its model")
    _fits_the_law(gains, {*map(str, kinds)})
    loop, unread = None, ""
    try:
        loop = read_loop(model, gains) if any(kind in LOOPS for kind in kinds) else None
    except (NotReplayed, RecursionError) as reason:
        unread = str(reason)
    for claim, kind in zip(claims, kinds, strict=True):
        if kind in OF_TURBINES:
            from takagi.certificates.cross_check.turbine.members import (
                no_other_members,
                nothing_unread,
            )

            no_other_members(claim, str(kind))
            nothing_unread(document)
        if unread:
            yield str(kind), _abstained(unread)
        elif kind == WITH_OBSERVER:
            from takagi.certificates.cross_check.turbine.running_loop import running_loop

            yield str(kind), running_loop(claim, document)
        elif kind in RESTING:
            yield str(kind), _resting(claim, str(kind), document)
        else:
            yield str(kind), obligations(claim, str(kind), loop, model, gains)


def _fits_the_law(gains: Any, kinds: set[str]) -> None:
    """Refuse claims about u = -K x of a law that is run otherwise."""
    if not isinstance(gains, dict):
        return
    loops = kinds & {*LOOPS, "tracking"}
    # An effort or an integral that the law computes is held between its samples, in the model not.
    if "sampled-loop" in kinds and {"blending", "references"} & set(gains):
        raise Refusal("a sampled law with a state of its own, which the model moves all the time")
    if "blending" in gains and loops and "effort-blend" not in kinds:
        raise Refusal("the law has two actuators, and no claim says what they are to the model")
    if "observer" in gains:
        fitting = {"tracking"} if "references" in gains else {"observed-loop"}
        of_states = (loops | kinds & {"effort-blend"}) - fitting
        if of_states:
            raise Refusal(
                f"the law has outputs, and {', '.join(sorted(of_states))} is of one of states"
            )
        if "blending" in gains:
            raise Refusal("a law with outputs has no blend")


def _resting(claim: Any, kind: str, document: Any) -> Obligations:
    """Return the conditions that a claim adds to the claim it depends on."""
    if kind == "wind-rate":
        from takagi.certificates.cross_check.turbine.rates import wind_rate

        return wind_rate(claim, document)
    from takagi.certificates.cross_check.turbine.rates import actuator_rates

    return actuator_rates(claim, document)


def _abstained(reason: str) -> Obligations:
    """Return obligations that raise ``NotReplayed`` before the first of them."""
    yield from ()
    raise NotReplayed(reason)


def _slopes(model: Any, gains: Any) -> Obligations:
    """Yield what shows that the slopes of the plant lie in the ranges that the model states."""
    from takagi.certificates.cross_check.plant.secant import lies_in_secants

    yield from lies_in_secants(with_slopes(model), gains)


def obligations(
    claim: Any, kind: str, loop: VertexLoop | None, model: Any, gains: Any
) -> Obligations | None:
    """Return the conditions of one claim; None for a kind that is not implemented here."""
    if kind in LOOPS and loop is not None:
        if loop.extremes and kind in AGAINST:
            return _abstained("what does not exist at the ends of a constant's bounds")
        # The constant has one value between its ends; a condition that is affine in the matrices,
        # or concave, holds there where it holds at the ends.
        return chain.from_iterable(LOOPS[kind](claim, one) for one in (loop, *loop.extremes))
    if kind == "sector-embedding":
        from takagi.certificates.cross_check.plant.embedding import embedded

        return embedded(model, gains)
    if kind == "secant-embedding":
        from takagi.certificates.cross_check.plant.secant import lies_in_secants

        return lies_in_secants(model, gains)
    if kind == "tracking":
        from takagi.certificates.cross_check.plant.tracking import tracking

        return tracking(claim, model, gains)
    if kind == "slope-embedding":
        return _slopes(model, gains)
    if kind == "effort-blend":
        from takagi.certificates.cross_check.plant.blend import effort_blend_obligations

        return effort_blend_obligations(model, gains)
    if kind == "coherent-loop":
        from takagi.certificates.cross_check.turbine.loop_claim import effort_sharing_loop

        return effort_sharing_loop(claim, model, gains)
    return None


def _opinion(kind: str, found: Obligations | None) -> Opinion:
    if found is None:
        return Opinion(kind, NOT_REPLAYED, 0, "no reading of this kind of claim")
    count = 0
    try:
        for one in found:
            count += isinstance(one, Definite)
            if not one.holds:
                return Opinion(kind, "UNDECIDED", count, _failed(one))
    except (NotReplayed, RecursionError) as reason:
        return Opinion(kind, NOT_REPLAYED, count, str(reason))
    return Opinion(kind, "DISPROVED" if kind in AGAINST else "PROVED", count)


def _failed(one: Obligation) -> str:
    what = "does not hold" if not isinstance(one, Definite) else "is not definite"
    return f"{one.label} {what}"
