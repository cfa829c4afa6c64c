r"""Replays a claim about the effort-sharing loop: embedding, LMIs, bounds, consequences.

State (e, zeta, x): speed error, the effort by which pitch lags, the law's integral.  For schedule
winds v_s in a cell, |v - v_s| <= wind_error and |v_s'| <= wind_rate, the loop's matrix and
disturbance lie in the hull of the corners of

    A = [ a - G           S          G     ]      d = ( w,  f w + z, 0 )
        [ f (a - G + nu)  f S - T    f G   ]      w = kappa (r + g wind_error) + o wind_rate
        [ -nu             0          0     ]      (w and z each of both signs)

with T - (b'/b) v_s' in the place of T while v_s moves.  Its eleven coefficients are enclosed here
from the tables of the law and the plant's surface (``loop``, ``moving_schedule``), and
compared with those the certificate states.  A cell also states its conditions: its winds, and the
limit of pitch effectiveness (``effectiveness_limit``, the frozen wake's).  Then,
exactly, at every corner

    -[[A'P + PA + alpha P, P d], [d'P, -alpha]] > 0    so  {V <= 1} is invariant, V = xi' P xi,
    -(A'P + PA + 2 rho P) > 0     so  V(xi - xi*) decays as exp(-2 rho t), v = v_s constant,
    -(A'R + RA + 2 r R) > 0       so  (xi - xi*)' R (xi - xi*) does with one rate r for all winds,

and P > h h' / peak^2 bounds each state on {V <= 1}, which must lie inside the enclosed box.  The
secants between two points of the set lie in the same ranges as those from the trim. Therefore the
decay is towards the equilibrium xi* = (0, 0, x*), which is shifted by the residual of the tables.

v_s' is the rate that the law feeds forward, since its schedule wind is the output of its filter.

Not promised: anything outside {V <= 1}; pitch that starts below its lower limit; a wake with
states of its own (pitch effectiveness is a static map, the same at all times where decay is
claimed, equal to the surface in the trim); a torque that lags its command; sampling.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.definite import is_positive_definite
from takagi.certificates.checker.kernel.reader import listed, matrix, member, number
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.turbine.effort_sharing.corners import Corners, Stated, bounds_row
from takagi.certificates.checker.turbine.effort_sharing.inputs import Settling, Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop

Rows = list[list[Fraction]]
# The wind cell, or None for all, and what is not proved.
Failure = tuple[int | None, str]


def check_effort_sharing(claim: Any, model: Any, gains: Any, where: str) -> Found:
    """Return the verdict on one claim of kind ``coherent-loop``, with what fails and where.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    subject = Subject.read(claim, model, gains, where)
    law = subject.law
    P = matrix(claim, "P", where)
    if len(P) != 3 or len(P[0]) != 3:
        raise CertificateError(f"{where}.P: 3 rows of 3 numbers are needed")
    count = len(law.wind) - 1
    cells = listed(claim, "cells", where, count, count)
    said = {"claim": claim, "law": law, "uncertainty": subject.uncertainty}
    if not is_positive_definite(P):
        why = "P is not symmetric positive definite"
        return Found(Verdict.UNDECIDED, "effort_sharing", said | {"why": why})
    failures: list[Failure] = [(None, why) for why in _set_failures(P, claim, subject, where)]
    settling = Settling.read(claim, where)
    if not is_positive_definite(settling.P):
        failures.append((None, "the matrix of the common decay rate is not positive definite"))
    for k, cell in enumerate(cells):
        stated = Stated.read(cell, f"{where}.cells[{k}]")
        if reason := _cell_failure(subject, k, stated, P, settling):
            failures.append((k, reason))
    if failures:
        return Found(Verdict.UNDECIDED, "effort_sharing", said | {"failures": failures})
    proved = {"plant": subject.plant, "settling": settling, "where": where}
    return Found(Verdict.PROVED, "effort_sharing", said | proved)


def _set_failures(P: Rows, claim: Any, subject: Subject, where: str) -> Iterator[str]:
    """Check that the stated peaks bound h xi on {V <= 1}, and that they lie inside the box."""
    peaks = member(claim, "peaks", where)
    for name, limit, h in (
        ("speed_error", subject.box.speed_error, (1, 0, 0)),
        ("effort_lag", subject.box.effort_lag, (0, 1, 0)),
        ("speed_signal", subject.box.speed_signal, (1, 0, -1)),
        ("integral", subject.law.integral_limit, (0, 0, 1)),
    ):
        peak = number(peaks, name, f"{where}.peaks")
        if not 0 < peak <= limit or not bounds_row(P, h, peak):
            yield f"the set is not inside its stated bound on {name}"


def _cell_failure(subject: Subject, k: int, stated: Stated, P: Rows, settling: Settling) -> str:
    """Return what is not proved about one cell, or nothing."""
    law, sizes = subject.law, stated.sizes
    if stated.ranges["wind"] != law.wind[k : k + 2]:
        raise CertificateError(f"{stated.where}.wind: must be the law's interval {k}")
    if sizes["integral_rate"] != law.nu[k]:
        raise CertificateError(f"{stated.where}.integral_rate: differs from the law's")
    if stated.ranges["effectiveness_limit"] != sorted(law.limit[k : k + 2]):
        raise CertificateError(f"{stated.where}.effectiveness_limit: differs from the gains'")
    if sizes["wind_rate"] < 0:
        return "a negative wind rate"
    loop = Loop(subject, k, sizes["wind_rate"])
    try:
        if wrong := loop.range_failure(stated.ranges):
            return f"the loop's {wrong} leaves the stated range"
        if wrong := loop.size_failure(sizes):
            return f"the loop's {wrong} exceeds the stated bound"
    except Refused as reason:
        return str(reason)
    if limit := loop.limits_failure():
        return limit
    if not 0 <= sizes["wind_error"] <= subject.box.wind_share * law.wind[k]:
        return "the wind class is outside the enclosed one"
    if sizes["multiplier"] <= 0 or sizes["decay_rate"] < 0:
        return "multiplier or decay rate has the wrong sign"
    corners = Corners(stated)
    if wrong := corners.failure(P):
        return wrong
    fails = "the common decay inequality fails at a corner"
    return "" if corners.settles(settling.P, settling.decay_rate) else fails
