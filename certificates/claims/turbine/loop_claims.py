"""The claims about a turbine's effort-sharing loop, and the claims that depend on it.

A dependent claim is kept only if the checker proves it, assuming the claim about the loop. So a
consequence that a design does not have cannot make the file UNDECIDED. The reason why a claim was
left out is recorded in the file's provenance.  The claim about the loop with its observer is by
itself: of it those winds are claimed at which a function was found.

The bounds of a claim ``bumpless`` are the checker's, rounded up; B is computed here in floating
point.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.claim_kind import ClaimKind, Outcome
from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kernel.reader import number, read_text
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.turbine.effort_sharing.bumpless import (
    NAME,
    CellRates,
    cell_rates,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.published.bumpless import NAME as PUBLISHED_NAME
from takagi.certificates.checker.turbine.published.bumpless import RATES, command_rates
from takagi.certificates.checker.turbine.published.loop_claim import PublishedLoop
from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_claim
from takagi.certificates.claims.turbine.largest_wind_error import EffortSharingCandidate
from takagi.certificates.claims.turbine.wind_rate_claim import wind_rate_claim
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    provenance,
    turbine_data,
)
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.turbine.data import Turbine

ClaimMaker = Callable[[], "dict[str, Any] | None"]


def loop_document(
    turbine: Turbine,
    law: EffortSharingLaw,
    candidate: EffortSharingCandidate,
    configuration: object,
    *,
    files: Sequence[Path] = (),
    controller: Mapping[str, Any] | None = None,
    tell: Callable[[str], None] | None = None,
) -> dict[str, Any]:
    """Return the certificate of an effort-sharing loop, with every claim that holds.

    Parameters
    ----------
    asked : the configuration, as recorded in the provenance.
    controller : the gain file's observer and filters; None makes no claim about the loop with them.
    tell : called with a word before the search for each of these claims.
    files : the turbine's data files; the certificate records what they say.

    Raises
    ------
    ModelError : the candidate has no P.
    """
    model, gains = turbine_data(turbine, files), effort_sharing_law_data(law)
    claims, left_out = loop_claims(model, gains, effort_sharing_claim(candidate))
    if law.setpoints is not None:
        if tell is not None:
            tell("loop at constant set-points")
        # Imported here: it loads a solver.  The user asked for set-points, so that a claim that is
        # not proved stays in the file.
        from takagi.certificates.claims.turbine.set_points_claim import set_points_claim

        claims.append(set_points_claim(turbine, law, model, gains))
    if controller is not None:
        if tell is not None:
            tell("loop with its observer, at constant winds")
        inertia = claims[0]["uncertainty"]["inertia"]
        running, reasons = running_claim(model, gains, controller, inertia)
        claims += running
        left_out |= reasons
    return certificate_document(
        model=model,
        gains=gains,
        claims=claims,
        provenance=provenance(configuration, {"joint analysis": candidate.words, **left_out}),
        files=files,
    )


def loop_claims(
    model: Mapping[str, Any], gains: Mapping[str, Any], loop: Mapping[str, Any]
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the claims in the file's order, and by kind why one was left out.

    Parameters
    ----------
    model, gains : as the certificate states them.
    loop : the claim ``effort_sharing_claim`` states.
    """
    claims, left_out = [dict(loop)], {}

    makers: dict[str, ClaimMaker] = {
        "wind-rate": lambda: wind_rate_claim(loop, float(gains["wind_filter"])),
        "bumpless": lambda: bumpless_claim(model, gains, loop),
    }
    for kind, make in makers.items():
        try:
            claim = make()
        except Refused as reason:
            # Without a proof of the loop nothing can follow; the loop's verdict gives the reason.
            claim, why = None, str(reason)
        else:
            why = "nothing to claim" if claim is None else _open(claim, model, gains, claims)
        if claim is None or why:
            left_out[kind] = f"not claimed: {why}"
        else:
            claims.append(claim)
    return claims, left_out


def running_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    controller: Mapping[str, Any],
    inertia: Sequence[float],
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the claim about the loop with its observer, or by its kind why there is none.

    ``controller``, ``inertia`` : as ``running_loop_claim`` takes them.
    """
    # Imported here: it loads a solver.
    from takagi.certificates.claims.turbine.running_loop_claim import (
        running_loop_claim,
    )

    try:
        claim = running_loop_claim(model, gains, controller, inertia)
        why = _open(claim, model, gains, [])
    except Refused as reason:
        why = str(reason)
    return ([], {"running-loop": f"not claimed: {why}"}) if why else ([claim], {})


def _open(
    claim: Mapping[str, Any],
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    earlier: Sequence[Mapping[str, Any]],
) -> str:
    """Return why the checker would not prove a claim of the loop, or nothing."""
    members = {"model": model, "gains": gains, "claims": [*earlier, claim]}
    data, index = read_text(json.dumps(members), "candidate"), len(earlier)
    below = [Outcome(_TakenAsProved()) for _ in earlier]
    return replay(data["claims"][index], data, None, below, f"claims[{index}]").failure


class _TakenAsProved(ClaimKind):
    name = "taken as proved"

    def obligations(self) -> Obligations:
        return iter(())

    def sentence(self) -> str:
        return self.name


# Factor on B, which is found in floating point.
RESERVE = 1 + 1e-6
DIGITS = 7


def bumpless_claim(
    model: Mapping[str, Any], gains: Mapping[str, Any], loop: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the claim as plain data; a cell's rates are the least bounds that hold.

    Parameters
    ----------
    model, gains : as the certificate states them.
    loop : its claim of kind ``coherent-loop``, the first of the file.
    """
    members = {"model": dict(model), "gains": dict(gains), "loop": dict(loop)}
    data = read_text(json.dumps(members), "candidate")
    subject = Subject.read(data["loop"], data["model"], data["gains"], "loop")
    P = np.linalg.inv(np.array(loop["P"], dtype=np.float64))
    pitch_limit = number(data["model"], "pitch_rate_limit", "model")
    cells = []
    for bound in cell_rates(subject, data["loop"], "loop"):
        signal = _signal_rate(bound, P)
        cells.append(
            {
                "pitch_rate": float(min(pitch_limit, _up(bound.pitch))),
                "signal_rate": float(signal),
                "torque_rate": float(_up(bound.torque_rate(signal))),
            }
        )
    return {"name": NAME, "kind": "bumpless", "loop": 0, "cells": cells}


def published_bumpless_claim(
    model: Mapping[str, Any], gains: Mapping[str, Any], loop: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the same claim for Schulte's law.

    ``loop`` : the claim of kind ``paper-loop``, the first of the file.
    """
    members = {"model": dict(model), "gains": dict(gains), "claims": [dict(loop)]}
    data = read_text(json.dumps(members), "candidate")
    stated = PublishedLoop.read(data["claims"][0], data, (), "claims[0]")
    cells = [
        {name: float(_up(rate)) for name, rate in zip(RATES, command_rates(stated, c), strict=True)}
        for c in stated.cells
    ]
    return {"name": PUBLISHED_NAME, "kind": "bumpless", "loop": 0, "cells": cells}


def _signal_rate(bound: CellRates, inverse: Any) -> Fraction:
    """Return max sqrt(h P^-1 h') over the corners, rounded up."""
    rows = np.array([[float(entry) for entry in h] for h in bound.corners])
    largest = float(np.sqrt(np.einsum("ci,ij,cj->c", rows, inverse, rows).max()))
    return _up(Fraction(largest * RESERVE))


def _up(value: Fraction) -> Fraction:
    return Fraction(math.ceil(value * 10**DIGITS), 10**DIGITS)
