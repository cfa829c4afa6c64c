"""What an exact no reads: entries that are not numbers, wide integers, conditions of nothing."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from takagi.lmi import LMI, Condition, Constant, Term, Unknown, exact_no
from takagi.lmi.refutation.exact_algebra import over_one_denominator
from takagi.models import ModelError


def scalar(factor: object, value: object) -> Condition:
    """Return factor * g + value > 0 and g >= 0, which may be touched."""
    g = Unknown("g", 1, 1)
    return Condition(
        name="a number",
        unknowns=(g,),
        lmis=(
            LMI(
                name="sum",
                blocks=(1,),
                terms=(Term(unknown=g, left=np.array([[[factor]]])),),
                constants=(Constant(value=np.array([[[value]]])),),
            ),
            LMI(
                name="sign",
                blocks=(1,),
                terms=(Term(unknown=g, left=np.ones((1, 1, 1))),),
                strict=False,
            ),
        ),
    )


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_refused(bad: float) -> None:
    with pytest.raises(ModelError, match="finite"):
        exact_no(scalar(-1.0, bad))
    with pytest.raises(ModelError, match="finite"):
        exact_no(scalar(bad, 0.0))


@pytest.mark.parametrize("value", [2**53 + 1, -(2**62) - 1, 2**63 - 1])
def test_integers_wider_than_a_mantissa_are_kept(value: int) -> None:
    numerators, denominator = over_one_denominator(np.array([value, 1]))
    assert Fraction(int(numerators[0]), denominator) == value


def test_a_constant_of_wide_integers_is_not_rounded_to_a_contradiction() -> None:
    """2^53 + 1 - 2^53 is 1 > 0, and 0 where it is rounded."""
    whole = 2**53
    plain = LMI(
        name="difference",
        blocks=(1,),
        terms=(),
        constants=(
            Constant(value=np.array([[[whole + 1]]])),
            Constant(value=np.array([[[-whole]]])),
        ),
    )
    assert exact_no(Condition(name="one", unknowns=(), lmis=(plain,))) is None
    zero = Constant(value=np.zeros((1, 1, 1)))
    touched = LMI(name="zero", blocks=(1,), terms=(), constants=(zero,))
    assert exact_no(Condition(name="zero", unknowns=(), lmis=(touched,))) is not None


def test_nothing_is_contradicted_by_nothing() -> None:
    assert exact_no(Condition(name="nothing", unknowns=(), lmis=())) is None
