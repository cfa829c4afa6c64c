"""Replays a claim about the equilibria of a turbine's loop at constant winds, cell by cell.

A cell has winds [v_1, v_2] and the number of equilibria at every one of them:

    one                 exactly one equilibrium (coherent: with e = 0, for any wake)
    one at the trim     exactly one, at the reference speed with smallest pitch or rated torque
    one off the trim    exactly one, and it is not the trim
    none                no equilibrium
    several             at least two
    continuum           an interval of pitches, each an equilibrium with e = 0

Every answer is computed again here from model and gains (``coherent_rest``, ``paper_rest``) and
compared. All answers are about states with tip-speed ratio and pitch inside the coefficient table;
there are no other equilibria there; v_hat = v. Stability is not claimed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from takagi.certificates.checker.kernel.reader import member, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.equilibria.effort_sharing import (
    EffortSharingEquilibria,
    effort_sharing_equilibria,
)
from takagi.certificates.checker.turbine.equilibria.published import bends, published_equilibria
from takagi.certificates.checker.turbine.equilibria.zero_count import Span
from takagi.certificates.checker.turbine.published.inputs import LAWS, PublishedLaw

ANSWERS = ("one", "one at the trim", "one off the trim", "none", "several", "continuum")
MOST_CELLS = 2000
# Winds -> the answer at each of them; raises Refused if it is not known.
RestReader = Callable[[Span], str]


def equilibrium_reader(model: Any, gains: Any) -> tuple[str, Span, RestReader]:
    """Return the law's name, its wind range, and the function that gives a cell's answer.

    Raises
    ------
    CertificateError : model or gains are not those of a turbine's loop.
    """
    plant, name = Plant.read(model), text(gains, "name", "gains")
    if name in LAWS:
        paper = PublishedLaw.read(gains)
        if (plant.pitch_min, plant.pitch_max) != (paper.pitch_min, paper.pitch_max):
            raise CertificateError("gains: pitch limits differ from the model's")
        if paper.rated_torque + paper.overlaps.torque / 2 > paper.top_torque:
            raise CertificateError("gains.coupling.top_torque: the rounded corner goes beyond it")
        return name, (paper.cut_in, paper.cut_out), lambda winds: _published(plant, paper, winds)
    law = Law.read(gains)
    if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
        raise CertificateError("gains: pitch limits differ from the model's")
    return name, (law.wind[0], law.wind[-1]), lambda winds: _effort_sharing(plant, law, winds)


def check_equilibrium(claim: Any, model: Any, gains: Any, where: str) -> Found:
    """Return the verdict on a claim of kind ``equilibrium``.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    name, known, answer = equilibrium_reader(model, gains)
    cells = member(claim, "cells", where)
    if not isinstance(cells, list) or not 0 < len(cells) <= MOST_CELLS:
        raise CertificateError(f"{where}.cells: 1 to {MOST_CELLS} are needed")
    proved: list[tuple[Span, str]] = []
    failures: list[tuple[Span, str, str]] = []
    for k, cell in enumerate(cells):
        place = f"{where}.cells[{k}]"
        low, high = numbers(cell, "wind", place, 2)
        stated = text(cell, "rests", place)
        if stated not in ANSWERS or not known[0] <= low < high <= known[1]:
            raise CertificateError(f"{place}: winds of the law and one of {', '.join(ANSWERS)}")
        try:
            found = answer((low, high))
        except Refused as reason:
            found = str(reason)
        if found == stated:
            proved.append(((low, high), stated))
        else:
            failures.append(((low, high), stated, found))
    said = {"law": name, "known": known, "proved": proved, "failures": failures}
    return Found(Verdict.UNDECIDED if failures else Verdict.PROVED, "equilibrium", said)


def _effort_sharing(plant: Plant, law: Law, winds: Span) -> str:
    rests = effort_sharing_equilibria(plant, law, winds)
    inside, upper, lower = rests.inside, rests.upper, rests.lower
    held = (upper, 1), (lower, -1)
    away = all(not c.blocks and {c.start, c.end} <= {sign, 0} for c, sign in held)
    # The balance rises with x, so that any admitted wake only increases its slope.
    if (inside.exact, inside.start, inside.end) == (1, -1, 1) and away:
        return "one"
    if _least(rests) > 1 and _least(effort_sharing_equilibria(plant, law, winds, common=True)) > 1:
        return "several"
    raise Refused("the number of rests is not known")


def _least(rests: EffortSharingEquilibria) -> int:
    return rests.inside.least + rests.upper.least + rests.lower.least


def _published(plant: Plant, law: PublishedLaw, winds: Span) -> str:
    cuts = [winds[0], *sorted(v for v in bends(plant, law) if winds[0] < v < winds[1]), winds[1]]
    found = {
        _published_piece(plant, law, (low, high)) for low, high in zip(cuts, cuts[1:], strict=False)
    }
    if len(found) > 1:
        raise Refused("the rests differ on both sides of a bend of the reference speed")
    return found.pop()


def _published_piece(plant: Plant, law: PublishedLaw, winds: Span) -> str:
    rests = published_equilibria(plant, law, winds)
    if rests.continuum is not None:
        return "continuum"
    if rests.count.exact == 1:
        if rests.at_trim is None:
            return "one"
        return "one at the trim" if rests.at_trim else "one off the trim"
    if rests.count.exact == 0:
        return "none"
    if rests.count.least > 1:
        return "several"
    raise Refused("the number of rests is not known")
