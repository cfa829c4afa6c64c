"""The running loop where the reference speed stops following the wind, at 3.4919 m/s.

The certificate is the last line of ``recorded/running-loop.jsonl``: the two cells on both sides of
this wind, from 3.25 to 3.5564 m/s, of the default law of the NREL 5-MW turbine.  In the boxes of
both the slope of the reference speed is 0 to 0.207 rad/s per m/s.
"""

from __future__ import annotations

import json
from copy import deepcopy
from fractions import Fraction
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine import running_loop_claim
from takagi.certificates.claims.turbine import running_loop_claim as candidate
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdict
from tests.certificates.turbine.test_running_loop import first_cell

motion: Any = import_module("turbine_running")
CORNER, STEEP = 3.4919, 0.20714


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(list(recorded("running-loop"))[-1][1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


def test_it_is_proved_in_the_winds_around_the_corner(document: dict[str, Any]) -> None:
    assert document["claims"][0]["winds"] == [[3.25, 3.5564]]
    assert CORNER in document["gains"]["wind"]
    assert verdict(document) == "PROVED"
    # The nonlinear loop, written anew, finds nothing against it.
    rng = np.random.default_rng(1)
    assert motion.why_running_false(document, document["claims"][0], rng) == ""
    text = check_document(sealed(document)).claims[0].text
    assert "NOT at winds 3 to 3.25 m/s, 3.5564 to 25 m/s, which are not covered" in text


@pytest.mark.parametrize("k", [0, 1])
def test_the_slope_has_both_of_its_values(stored: dict[str, Any], k: int) -> None:
    _, spans = first_cell(stored, k)
    low, high = spans["speed slope"]
    assert low == 0 and float(high) == pytest.approx(STEEP, rel=1e-4)


@pytest.mark.numeric
def test_the_search_shortens_the_schedule_side_at_a_corner_only(document: Any) -> None:
    subject = running_loop_claim.loop_subject(
        document["model"], document["gains"], document["claims"][0]
    )
    for winds, usual in ((("3.4844", "3.4919"), False), (("3.65", "3.66"), True)):
        low, high = map(Fraction, winds)
        found, _ = candidate.running_candidate(subject, (low, high), sizes=[Fraction(1, 20)])
        assert found is not None
        shape = candidate.box_of_size(subject, Fraction(1, 20))
        assert (found.sides == shape) is usual
        assert found.sides.schedule == shape.schedule / (1 if usual else 2)
        assert found.sides.estimate == shape.estimate


def test_the_search_says_where_no_box_has_room(document: Any) -> None:
    """A corner so sharp that a quarter of the side is too long, too."""
    law = document["gains"]
    node = law["wind"].index(CORNER)
    law["rotor_speed"][node - 1] = 0.05
    subject = running_loop_claim.loop_subject(document["model"], law, document["claims"][0])
    winds = Fraction("3.4919"), Fraction("3.493")
    found, why = candidate.running_candidate(subject, winds, sizes=[Fraction(1, 100)])
    assert found is None and why == "the ranges are wider than the box"
