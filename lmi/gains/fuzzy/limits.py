"""What keeps the unknowns of a fuzzy design finite: their scale, and the input effort."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from takagi.lmi.condition.term import LMI, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.fuzzy.sums import SoughtGains
from takagi.lmi.gains.requirements.closed_loop import gain_symbol

LARGEST_SLACK = 16.0


def effort_lmi(sought: SoughtGains, nu: Unknown, *, discrete: bool) -> LMI:
    """Pose [[P_i, M_j'], [M_j, nu I]] >= 0: |u|^2 <= nu V; G_j + G_j' - S_i in discrete time."""
    r, n, m = sought.rules, sought.P.rows, sought.M.rows
    i, j = (index.ravel() for index in np.indices((r, r)))
    one = np.eye(n)[None]
    own = sought.members[i]
    gains = j if sought.M.count > 1 else np.zeros_like(j)
    slacks = j if sought.G.count > 1 else np.zeros_like(j)
    first: tuple[Term, ...] = (
        Term(unknown=sought.P, left=one, right=one, members=own, symbol=f"{sought.P.symbol}_i"),
    )
    if discrete:
        first = (
            Term(
                unknown=sought.P,
                left=-one,
                right=one,
                members=own,
                latex=("-", ""),
                symbol=f"{sought.P.symbol}_i",
            ),
            Term(
                unknown=sought.G,
                left=one,
                right=one,
                members=slacks,
                plus_transpose=True,
                symbol=sought.slack_symbol,
            ),
        )
    inputs = np.eye(m)[None]
    return LMI(
        name="input effort",
        blocks=(n, m),
        terms=(
            *first,
            Term(
                unknown=sought.M,
                left=inputs,
                right=one,
                at=(1, 0),
                members=gains,
                symbol=gain_symbol(sought.M),
            ),
            Term(unknown=nu, left=inputs, at=(1, 1), latex=("", "I")),
        ),
        count=r * r,
        strict=False,
        index=rf"i, j = 1, \dots, {r}",
    )


def scale_lmis(sought: SoughtGains) -> tuple[LMI, ...]:
    """Pose 0 < P_i <= I, and |G| <= 16, which only keeps the slack finite."""
    P, G = sought.P, sought.G
    one = np.eye(P.rows)[None]
    every, each = np.arange(P.count), np.arange(G.count)
    own = Term(unknown=P, left=one, right=one, members=every, symbol=f"{P.symbol}_i")
    bound = Constant(value=LARGEST_SLACK * one, latex=f"{LARGEST_SLACK:g} I")
    return (
        LMI(
            name=f"{P.symbol} positive definite",
            blocks=(P.rows,),
            terms=(own,),
            count=P.count,
            index=rf"i = 1, \dots, {P.count}",
        ),
        LMI(
            name=f"scale of {P.symbol}",
            blocks=(P.rows,),
            terms=(own,),
            constants=(Constant(value=-one, latex="-I"),),
            sign=-1,
            count=P.count,
            strict=False,
            index=rf"i = 1, \dots, {P.count}",
        ),
        LMI(
            name="scale of G",
            blocks=(P.rows, P.rows),
            terms=(Term(unknown=G, left=one, right=one, at=(0, 1), members=each),),
            constants=(bound, replace(bound, at=(1, 1))),
            count=G.count,
            strict=False,
        ),
    )
