r"""P(h) = sum_i h_i P_i and its derivative dP/dt as parts of a double sum.

Where the memberships are products of those of premises, h_i = prod_k w^k_(c_ik), the rate of P is

    dP/dt = sum_i h_i sum_k sum_c (dw^k_c/dt) P_(i with corner c of premise k),

because P_(i with corner c of premise k) does not depend on rule i's own corner of premise k, and
the weights of the corners of one premise sum to 1.  Without premises dP/dt is sum_k dh_k/dt P_k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.polynomials.simplex_polynomials import Basis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.summands import SumPart
from takagi.models.arrays import Floats, Indices


def rule_table(rules: int, by: str, members: Indices | None = None) -> Indices:
    """Return the table (r, r) of members for a part that has the member of rule i, or of rule j.

    Parameters
    ----------
    by : "vertex" for i, "gain" for j.
    members : (r,) the member of each rule; None for the rules' own order.
    """
    rule_members = np.arange(rules) if members is None else members
    table = np.broadcast_to(rule_members[:, None], (rules, rules))
    return np.asarray(table if by == "vertex" else table.T)


def swapped_rules(corners: Indices, premise: int, corner: int) -> Indices:
    """Return (r,): the rule with this corner of the premise, and else the corners of rule i."""
    sizes = tuple(int(size) for size in corners.max(axis=0) + 1)
    number = Basis(sizes, (1,) * len(sizes)).corners
    rule = np.argsort(number(corners))
    changed = corners.copy()
    changed[:, premise] = corner
    return np.asarray(rule[number(changed)])


def rate_parts(
    P: Unknown, corners: Indices, velocity: Sequence[Floats], *, members: Indices | None = None
) -> tuple[SumPart, ...]:
    """Return dP/dt at one velocity of the memberships, as parts of block (0, 0).

    Parameters
    ----------
    corners : (r, K), the corner of each simplex that rule i takes.
    velocity : dw^k/dt, one array for each simplex.
    members : (r,), the member of P for each rule; None for the rules' own order.
    """
    eye = np.eye(P.rows)[None]
    rule_members = np.arange(len(corners)) if members is None else members
    rate_terms = []
    for k, rates in enumerate(velocity):
        for corner in np.flatnonzero(rates):
            rules = rule_members[swapped_rules(corners, k, int(corner))]
            # Rule i where premise k is at this corner, or, without premises, the rule itself.
            index = f"{k + 1},{corner + 1}" if len(velocity) > 1 else f"{corner + 1}"
            rate = rf"\dot w_{{{index}}}" if len(velocity) > 1 else rf"\dot h_{{{index}}}"
            at = f"{{i}}|{index}" if len(velocity) > 1 else index
            symbol = f"{P.symbol}_{{{at}}}"
            rate_terms.append(
                SumPart(
                    unknown=P,
                    left=rates[corner] * eye,
                    right=eye,
                    member=rule_table(len(corners), "vertex", rules),
                    latex=(rate, ""),
                    symbol=symbol,
                )
            )
    return tuple(rate_terms)


def double_sums(
    plain: DoubleSum, additions: Sequence[Sequence[SumPart]], name: str = "rates"
) -> tuple[DoubleSum, ...]:
    """Return for each entry of ``additions`` the double sum with these parts and a new name."""
    count = len(additions)
    return tuple(
        replace(
            plain, parts=(*plain.parts, *added), name=f"{name} {k + 1}" if count > 1 else plain.name
        )
        for k, added in enumerate(additions)
    )
