"""Winds and overlaps of a claim about the paper's laws, in words: none is wider or elsewhere."""

from __future__ import annotations

import re
from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker.turbine.paper_inputs import Overlaps
from takagi.certificates.checker.words import paper as words

DECIMALS = st.integers(1, 10**13).map(lambda k: Fraction(k, 10**12))


@given(st.lists(DECIMALS, min_size=4, max_size=6, unique=True), DECIMALS)
def test_windows_of_one_width_are_not_moved(starts: list[Fraction], width: Fraction) -> None:
    """A rounded lower end would move the window, and its upper end out of what is proved."""
    ordered = sorted(starts)
    said = words._shown([(low, low + width) for low in ordered])
    shown, listed = said.split(" m/s wide from ")

    assert Fraction(shown.removeprefix("in windows ")) <= width
    named = [Fraction(number) for number in re.findall(r"[\d.]+(?:e[+-]?\d+)?", listed)]
    runs = "in steps of" in listed
    assert runs or named == ordered


def test_steps_between_windows_are_not_rounded() -> None:
    step = Fraction("0.1000000001")
    said = words._shown([(3 + k * step, 3 + k * step + Fraction(1, 50)) for k in range(5)])

    assert said == "in windows 0.02 m/s wide from 3 to 3.4000000004 in steps of 0.1000000001"


def test_overlaps_are_named_as_they_are() -> None:
    overlaps = Overlaps(Fraction(1), Fraction("0.1000000001"), Fraction("2000.0004"))

    assert "0.1000000001 rad/s" in words._words(overlaps)
    assert "2000.0004 N m" in words._words(overlaps)
