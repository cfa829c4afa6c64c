r"""Multipliers that show that no common P exists.

    continuous   find 0 <= Z_i <= I with  sum_i (A_i Z_i + Z_i A_i' + 2 alpha Z_i) >= t I,  t > 0,
    discrete     find 0 <= Z_i <= I with  sum_i (A_i Z_i A_i' - e^(-2 alpha T) Z_i) >= t I,  t > 0.

If such Z_i exist, there is no P > 0 with A_i'P + PA_i + 2 alpha P < 0, or A_i'P A_i < e^(-2 alpha
T) P, at all vertices. The trace of P times the sum would be negative by these inequalities, and
positive by those on Z_i.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2.3 (theorems of alternatives).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import vertex_stack
from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide
from takagi.models.arrays import Floats


def impossibility_condition(
    A: Floats, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> Condition:
    """Pose the alternative to a common quadratic function; Z_i <= I fixes the scale.

    Parameters
    ----------
    A : (N, n, n).
    decay_rate : alpha [1/s].
    sample_time : T in s of x+ = A x; None for x' = A x.
    """
    count, n = A.shape[:2]
    Z = Unknown("Z", n, n, symmetric=True, count=count)
    eye = np.eye(n)[None]
    every = np.arange(count)
    positive = LMI(
        name="multiplier",
        blocks=(n,),
        terms=(Term(unknown=Z, left=eye, right=eye, items=every, members=every),),
        count=count,
        strict=False,
    )
    bounded = LMI(
        name="scale of the multiplier",
        blocks=(n,),
        terms=(Term(unknown=Z, left=eye, right=eye, items=every, members=every),),
        constants=(Constant(value=-eye, latex="-I"),),
        sign=-1,
        count=count,
        strict=False,
    )
    alternative = LMI(name="alternative", blocks=(n,), terms=_sum(A, Z, decay_rate, sample_time))
    return Condition(
        name="no common quadratic function",
        unknowns=(Z,),
        lmis=(positive, bounded, alternative),
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2.3",
    )


def _sum(A: Floats, Z: Unknown, rate: float, step: float | None) -> tuple[Term, ...]:
    count, n = A.shape[:2]
    eye, every, first = np.eye(n)[None], np.arange(count), np.zeros(count, dtype=np.intp)
    if step is None:
        shifted = A + rate * np.eye(n)
        motion_term = Term(
            unknown=Z,
            left=shifted,
            right=eye,
            plus_transpose=True,
            items=first,
            members=every,
            latex=("A_{i}", ""),
        )
        return (motion_term,)
    ahead = A.transpose(0, 2, 1)
    decay = -np.exp(-2.0 * rate * step) * eye
    return (
        Term(
            unknown=Z,
            left=A,
            right=ahead,
            items=first,
            members=every,
            latex=("A_{i}", r"A_{i}^\top"),
        ),
        Term(unknown=Z, left=decay, right=eye, items=first, members=every, latex=(r"-\rho^2", "")),
    )


def impossibility_multipliers(
    A: ArrayLike, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> Floats | None:
    """Return (N, n, n) multipliers Z_i in floating point, or None when none were found."""
    condition = impossibility_condition(
        vertex_stack(A), decay_rate=decay_rate, sample_time=sample_time
    )
    outcome = decide(condition)
    return outcome.values["Z"] if outcome.status == "candidate" else None
