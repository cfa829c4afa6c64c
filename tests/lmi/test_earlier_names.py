"""Names of earlier versions, which packages still hand out."""

from __future__ import annotations

import pytest

import takagi.lmi


@pytest.mark.parametrize(
    ("earlier", "name"),
    [
        ("Fixed", "KnownBlock"),
        ("LyapunovFamily", "PolynomialLyapunov"),
        ("Part", "SumPart"),
        ("Region", "EigenvalueRegion"),
        ("Rung", "RelaxationResult"),
    ],
)
def test_an_earlier_name_is_the_same_class(earlier: str, name: str) -> None:
    assert earlier in dir(takagi.lmi)
    assert getattr(takagi.lmi, earlier) is getattr(takagi.lmi, name)
