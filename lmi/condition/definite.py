"""The LMIs of one symmetric unknown: it is positive definite, and at most a multiple of I."""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.term import LMI, Constant, Term
from takagi.lmi.condition.unknown import Unknown


def positive(P: Unknown) -> LMI:
    """Pose P > 0."""
    one = np.eye(P.rows)[None]
    term = Term(unknown=P, left=one, right=one)
    return LMI(name=f"{P.name} positive definite", blocks=(P.rows,), terms=(term,))


def bounded(P: Unknown, largest: float = 1.0, *, latex: str = "") -> LMI:
    """Pose P <= largest I, which fixes the scale of a condition that is homogeneous in P.

    Parameters
    ----------
    latex : the constant; empty for -I, or -I times the number.
    """
    one = np.eye(P.rows)[None]
    told = latex or ("-I" if largest == 1 else f"-{largest:g} I")
    return LMI(
        name=f"scale of {P.name}",
        blocks=(P.rows,),
        terms=(Term(unknown=P, left=one, right=one),),
        constants=(Constant(value=-largest * one, latex=told),),
        sign=-1,
        strict=False,
    )
