r"""Two forms of the same decrease: with products of P(h) and A(h), or held apart by slacks.

    continuous   [ He(F A(h)) + dP/dt + 2 alpha P(h)   kappa (P(h) - F) + A(h)' G' ]
                 [ .                                   -kappa (G + G')             ]  < 0

    discrete     [ rho^2 P(h)    A(h)' G'        ]
                 [ .             G + G' - P(h+)  ]  > 0

The slacks F and G are the same for all h: with [x; x' / kappa] for x' = A x, or [x; -x+] for x+ =
A x, on both sides they vanish, and V' < -2 alpha V, or V(x+) < rho^2 V(x), is left.  Linear in P(h)
and in A(h), so that one LMI a vertex is enough where P is linear in h.  F = P and small G, or G = P
in discrete time, shows whatever a common P shows.  The number kappa, about the size of A, only
balances the blocks.

Source: Peaucelle, Arzelier, Bachelier and Bernussou (2000), Systems and Control Letters 40, for
continuous time; de Oliveira, Bernussou and Geromel (1999), Systems and Control Letters 37, for
discrete time.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.condition.term import LMI, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.polynomials.simplex_polynomials import Basis
from takagi.lmi.polynomials.unknown_polynomial import UnknownPolynomial
from takagi.lmi.varying.parameter_condition import (
    SoughtPolynomial,
    decay_term,
    direct_lmi,
    polynomial_lmis,
)
from takagi.lmi.varying.parameter_terms import TermCoefficients
from takagi.models.errors import ModelError

Form: TypeAlias = Literal["direct", "dilated"]
SOURCES = {
    "direct": "Oliveira and Peres (2007); Daafouz and Bernussou (2001)",
    "dilated": "Peaucelle et al. (2000); de Oliveira, Bernussou and Geromel (1999)",
}


def check_form(form: object) -> None:
    """Raise ModelError for a form that there is not."""
    if form not in SOURCES:
        raise ModelError(f"form {form!r} is not known; there are {', '.join(SOURCES)}")


def form_lmis(sought: SoughtPolynomial, form: Form) -> tuple[tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return the slacks of a form, and P(h) > 0, its scale and the decrease."""
    if form == "direct":
        return (), (*polynomial_lmis(sought), direct_lmi(sought))
    slack, decrease = dilated_lmi(sought)
    return slack, (*polynomial_lmis(sought), decrease)


def dilated_lmi(sought: SoughtPolynomial) -> tuple[tuple[Unknown, ...], LMI]:
    """Pose the module's dilated form; the slacks come with it."""
    n = sought.P.rows
    at = sought.coefficients(sought.matrix.basis.degrees)
    pose = _dilated_discrete if sought.discrete else _dilated_continuous
    unknowns, terms = pose(sought, at)
    return unknowns, LMI(
        name="decrease",
        blocks=(n, n),
        terms=terms,
        sign=1 if sought.discrete else -1,
        count=at.count,
        weight=sought.weight,
        labels=at.labels(),
        index=at.index,
    )


def _dilated_discrete(
    sought: SoughtPolynomial, at: TermCoefficients
) -> tuple[tuple[Unknown, ...], tuple[Term, ...]]:
    P, n = sought.P, sought.P.rows
    G = Unknown("G", n, n)
    one = at.one
    return (G,), (
        at.term(P, sought.now, parameter="contraction", latex=(r"\rho^2", ""), symbol="P(h)"),
        at.term(G, _same(sought), sought.matrix, at=(1, 0), latex=("", "A(h)")),
        Term(unknown=G, left=one, right=one, at=(1, 1), plus_transpose=True),
        at.term(P, sought.then, at=(1, 1), factor=-1, latex=("-", ""), symbol="P(h^+)"),
    )


def _dilated_continuous(
    sought: SoughtPolynomial, at: TermCoefficients
) -> tuple[tuple[Unknown, ...], tuple[Term, ...]]:
    P, n, A = sought.P, sought.P.rows, sought.matrix
    F, G = Unknown("F", n, n), Unknown("G", n, n)
    one = at.one
    # A power of two: no digit is touched.
    kappa = 2.0 ** round(np.log2(sought.weight / 2))
    scale = one * (type(one[0, 0, 0])(kappa))
    first = Term(unknown=F, left=-scale, right=one, at=(0, 1), latex=(r"-\kappa", ""))
    return (F, G), (
        at.term(F, _same(sought), A, plus_transpose=True, latex=("", "A(h)")),
        *at.rate_terms(P, sought.now, r"\dot P(h)"),
        decay_term(sought, at),
        at.term(P, sought.now, factor=kappa, at=(0, 1), latex=(r"\kappa", ""), symbol="P(h)"),
        first,
        at.term(G, _same(sought), A, at=(1, 0), latex=("", "A(h)")),
        Term(
            unknown=G,
            left=-scale,
            right=one,
            at=(1, 1),
            plus_transpose=True,
            latex=(r"-\kappa", ""),
        ),
    )


def _same(sought: SoughtPolynomial) -> UnknownPolynomial:
    """Return an unknown that does not change with h, as a polynomial of degree 0."""
    return UnknownPolynomial.of(Basis(sought.motion.sizes, (0,) * len(sought.motion.sizes)))
