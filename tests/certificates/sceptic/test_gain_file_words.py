"""What is said of a gain file that is not the certificate's: which part differs, and how often."""

from __future__ import annotations

import pytest

from takagi.certificates.checker.files.differences import Difference
from takagi.certificates.checker.files.gain_file import MOST_COUNTED, _told
from takagi.certificates.checker.kernel.reader import Number


def differences(count: int, part: str = "law") -> list[Difference]:
    return [Difference((part, k), Number("1"), Number("2")) for k in range(count)]


@pytest.mark.parametrize(
    ("count", "more"),
    [
        (1, ""),
        (3, ""),
        (5, " (and 2 more)"),
        (MOST_COUNTED - 1, " (and 996 more)"),
        # Here counting has ended: there may be more of them.
        (MOST_COUNTED, " (and at least 997 more)"),
    ],
)
def test_differences_that_are_not_told_are_counted(count: int, more: str) -> None:
    told = _told(differences(count))

    last = min(count, 3) - 1
    assert f"law[{last}] is 1 there, 2 in the certificate{more}; give the gain file" in told


def test_the_law_is_named_where_nothing_else_differs() -> None:
    assert _told(differences(2)).startswith("the law is not the certificate's; ")
    for found in (differences(2, "inputs"), differences(1) + differences(1, "inputs")):
        assert _told(found).startswith("the gain file is not the certificate's; ")
