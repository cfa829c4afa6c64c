"""What a claim about a law of the paper asks beside its cells, and its words."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.kernel.result import Claim
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.turbine.published.inputs import Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.loop import Ends
from takagi.certificates.checker.words import published as words
from tests.certificates.kinds.claims import as_read
from tests.certificates.recorded.inputs import document, read_law

Data = dict[str, Any]


def recorded(*cells: Data) -> tuple[Data, Data, Data]:
    """Return claim, model and gains, with one recorded cell as often, each with other parts."""
    data = document("paper")
    claim, gains = data["claims"][0], data["gains"]
    own = claim["cells"][4]
    claim |= {"cells": [{**own, **changed} for changed in cells], "winds": [own["wind"]]}
    return claim, data["model"], gains


def answer(claim: Data, model: Data, gains: Data) -> Claim:
    data = as_read({"claims": [claim], "model": model, "gains": gains})
    return replay(data["claims"][0], data, None, [], "here").in_words()


@pytest.mark.parametrize(("top", "refused"), [(44000, False), (43999.9, True), (44001, False)])
def test_the_rounded_corner_ends_at_the_top_torque_at_the_latest(top: float, refused: bool) -> None:
    """The corner at 43000 N m is 2000 N m wide; a claim without cells is read all the same."""
    claim, model, gains = recorded()
    claim["torque_overlap"], gains["rated_torque"] = 2000, 43000
    gains["coupling"]["top_torque"] = top

    if refused:
        with pytest.raises(CertificateError, match="the rounded corner goes beyond it"):
            answer(claim, model, gains)
    else:
        assert answer(claim, model, gains).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("limit", ["pitch_min", "pitch_max"])
def test_law_and_turbine_have_the_same_pitch_limits(limit: str) -> None:
    claim, model, gains = recorded()
    gains[limit] += 0.1 if limit == "pitch_max" else -0.1

    with pytest.raises(CertificateError, match="pitch limits differ from the model's"):
        answer(claim, model, gains)


CORNER: Data = document("paper")["claims"][0]["cells"][4]["corners"][0]
# Part of the ranges of the loop's matrix alone.
NARROW = {"low": CORNER["low"], "high": CORNER["low"]}
LEAVES = "the loop's matrix leaves the stated ranges"
EXCEEDS = "the field at the centre exceeds the stated bound"


@pytest.mark.parametrize(
    ("cells", "failures"),
    [
        ([{}], []),
        ([{"corners": [NARROW, CORNER]}], []),
        ([{"corners": [NARROW]}], [LEAVES]),
        ([{"disturbance": [0.0038, 0.002, 0.000002]}], [EXCEEDS]),
        # The first one covers its winds; that the other was stated in vain is said all the same.
        ([{}, {"corners": [NARROW]}], [LEAVES]),
    ],
)
def test_each_cell_has_to_hold(cells: list[Data], failures: list[str]) -> None:
    found = answer(*recorded(*cells))

    assert found.verdict is (Verdict.UNDECIDED if failures else Verdict.PROVED)
    proved = len(cells) - len(failures)
    assert [why for why in (LEAVES, EXCEEDS) if why in found.text] == failures
    assert (f"{proved} cells)" in found.text) == bool(proved)
    assert ("no stated cell holds" in found.text) == (not proved)


WIND = document("paper")["claims"][0]["cells"][4]["wind"]
STATES = len(CORNER["low"])


@pytest.mark.parametrize(
    "wrong",
    [
        {"wind": WIND[::-1]},
        {"box": [0.01] * (STATES - 1) + [0]},
        {"box": [0.01] * (STATES + 1)},
        {"centre": [[1.2, 0.1, -4][:STATES], [1.2, -0.1, -4][:STATES]]},
        {"centre": [[1.2, 0.1, -4][:STATES]]},
        {"P": [[2, 0], [0, 2]]},
        {"P": [[2, 0, 0.5], [0, 2, 0], [0, 0, 2]]},
        {"corners": []},
        {"corners": [{**CORNER, "low": CORNER["low"][:-1]}]},
        {"corners": [CORNER] * 9},
        {"decay_rate": 0},
        {"multiplier": -1},
        {"disturbance": [-1e-4] * STATES},
    ],
    ids=str,
)
def test_a_cell_that_cannot_be_is_refused(wrong: Data) -> None:
    claim, model, gains = recorded({}, wrong)
    with pytest.raises(CertificateError, match="cells"):
        answer(claim, model, gains)


def test_every_pair_of_winds_increases() -> None:
    claim, model, gains = recorded({})
    for winds in ([WIND, WIND[::-1]], [[0, 1], WIND], [[*WIND, 20]]):
        with pytest.raises(CertificateError, match=r"winds: pairs of increasing winds"):
            answer({**claim, "winds": winds}, model, gains)


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
