"""What a claim about a law of the paper asks beside its cells, and its words."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.turbine.published.inputs import Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.loop import Ends
from takagi.certificates.checker.words import published as words
from tests.certificates.recorded.inputs import read_law

DECIMALS = st.integers(1, 10**13).map(lambda k: Fraction(k, 10**12))


@given(st.lists(DECIMALS, min_size=4, max_size=6, unique=True), DECIMALS)
def test_windows_of_one_width_are_not_moved(starts: list[Fraction], width: Fraction) -> None:
    """A rounded lower end would move the window, and its upper end out of what is proved."""
    ordered = sorted(starts)
    said = words.winds_words([(low, low + width) for low in ordered])
    shown, listed = said.split(" m/s wide from ")

    assert Fraction(shown.removeprefix("in windows ")) <= width
    named = [Fraction(number) for number in re.findall(r"[\d.]+(?:e[+-]?\d+)?", listed)]
    runs = "in steps of" in listed
    assert runs or named == ordered


def test_steps_between_windows_are_not_rounded() -> None:
    step = Fraction("0.1000000001")
    said = words.winds_words([(3 + k * step, 3 + k * step + Fraction(1, 50)) for k in range(5)])

    assert said == "in windows 0.02 m/s wide from 3 to 3.4000000004 in steps of 0.1000000001"


def test_overlaps_are_named_as_they_are() -> None:
    overlaps = Overlaps(Fraction(1), Fraction("0.1000000001"), Fraction("2000.0004"))

    assert "0.1000000001 rad/s" in words._words(overlaps)
    assert "2000.0004 N m" in words._words(overlaps)


def test_winds_that_are_left_out_are_told() -> None:
    data = read_law("paper")
    claim = {**data["claims"][0], "cells": [], "winds": [[Number("5"), Number("6")]]}

    def said(unproved: list[dict[str, list[Number]]]) -> str:
        stated = {**claim, "unproved": unproved}
        return replay(stated, data, None, [], "here").in_words().text

    ends = "not proved: 5 to 6 m/s, where no stated cell holds"
    assert said([]).endswith(ends)
    unproved = [{"wind": [Number("3"), Number("4")]}]
    assert said(unproved).endswith(f"{ends}; looked at but not claimed: 3 to 4 m/s")


@pytest.mark.parametrize("side", [1, -1])
def test_the_width_of_the_set_is_added_to_how_far_its_centre_is(side: int) -> None:
    """Pitch of the tables is zero here: 1.5 degrees off and 0.4 wide is near, 0.6 wide is not."""
    law = PublishedLaw.read(read_law("paper")["gains"])
    partial, full = (
        replace(region, pitch=[Fraction(0)] * len(region.pitch))
        for region in (law.partial, law.full)
    )
    flat, degree = replace(law, partial=partial, full=full), Fraction(1745, 100000)

    def near(width: Fraction) -> bool:
        z = [Fraction(1), side * degree * Fraction(3, 2), Fraction(0)]
        ends = Ends((Fraction(8), Fraction(9)), (z, z), [Fraction(0), width, Fraction(0)])
        return words._near_trim_pitch(flat, ends)

    assert near(degree * Fraction(2, 5))
    assert not near(degree * Fraction(3, 5))
