"""Wider premises: scalar models whose limit is known, and back to the box itself."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kinds.box_enlargement import enlarged
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.requests import BoxEnlargement
from takagi.models import Premise, TSModel
from tests.certificates.kinds.claims import law_data, model_data, said_of

Data = dict[str, Any]
CORNERS = [[0, 0], [0, 1], [1, 0], [1, 1]]
RANGES = [{"name": name, "lower": -1, "upper": 1} for name in ("a", "b")]


def claim(theta: float, **others: Any) -> Data:
    base = {"name": "x", "kind": "box-enlargement", "decay_rate": 0, "P": [[1]]}
    return base | {"enlargement": theta} | others


def test_one_premise() -> None:
    """x' = (-2 + z) x, |z| <= theta, is stable for all z iff theta < 2."""
    model = model_data([[[-3]], [[-1]]])

    for theta in (0, 1, 1.999999999):
        assert said_of(model, None, claim(theta)).verdict is Verdict.PROVED
    for theta in (2, 2.1, -1):
        assert said_of(model, None, claim(theta)).verdict is Verdict.UNDECIDED


def test_a_product_of_premises_grows_with_the_square() -> None:
    """x' = (-3 + a b) x is stable iff theta^2 < 3; along A_0 + theta (A_i - A_0) it would be 3."""
    A = [[[-2]], [[-4]], [[-4]], [[-2]]]
    model = model_data(A, premises=RANGES, rules=CORNERS)

    assert said_of(model, None, claim(1.7320508)).verdict is Verdict.PROVED
    assert said_of(model, None, claim(1.7320509)).verdict is Verdict.UNDECIDED
    assert said_of(model_data(A), None, claim(1.7320509)).verdict is Verdict.PROVED


def test_what_holds_of_a_part_alone_is_named_so() -> None:
    """x' = [0 1; -1 + 2 z, -1] x: not stable at z = 1, but for |z| < 1/2; and 3/2 + z is."""
    A = np.array([[[0.0, 1.0], [-3.0, -1.0]], [[0.0, 1.0], [1.0, -1.0]]])
    part = certify(TSModel(A, premises=[Premise("z", "-1", "1")]), claims=[BoxEnlargement()])
    claim = part.document["claims"][0]

    assert part.verdict is Verdict.PROVED and 0.4 < claim["enlargement"] < 0.5
    assert claim["name"] == "part of the box of the model"
    assert "less than the model's own" in part.checked.claims[0].text
    assert any(words.startswith("ranges shrunk to 0.4") for words in part.tried)
    assert not any("enlargement" in words for words in (*part.tried, claim["name"]))


@pytest.mark.parametrize(("theta", "less"), [(0.4, True), (1, False), (1.2, False)])
def test_a_part_of_the_box_is_not_called_more(theta: float, less: bool) -> None:
    """Below 1 the ranges shrink: the sentence says that it is about less than the model."""
    A = [[[-2]], [[-4]], [[-4]], [[-2]]]
    model = model_data(A, premises=RANGES, rules=CORNERS)

    for found in (said_of(model, None, claim(theta)), said_of(model_data(A), None, claim(theta))):
        assert found.verdict is Verdict.PROVED
        assert (f"times {theta}, less than the model's own: V =" in found.text) is less


def test_the_middle_alone_is_never_claimed() -> None:
    """x' = (-1 + z/2) x decays at 1 1/s where z = 0 and in no range; a given claim says so."""
    A = [[[-1.5]], [[-0.5]]]
    found = certify(TSModel(A, premises=[Premise("z", -1, 1)]), claims=[BoxEnlargement(1.0)])

    assert found.verdict is Verdict.UNDECIDED and found.document["claims"][0]["enlargement"] > 0
    given = said_of(model_data(A), None, claim(0))
    assert given.verdict is Verdict.PROVED and "nothing of the model" in given.text


def test_every_corner_is_asked_for_before_any_kind() -> None:
    """So the vertices of a claim are there, of a premise without a range too."""
    A, flat = [[[-2]], [[-4]]], [{"name": "a", "lower": 1, "upper": 1}, RANGES[1]]
    model = model_data(A, premises=flat, rules=[[0, 0], [0, 1]])

    assert said_of(model, None, claim(1.5)).verdict is Verdict.PROVED
    for rules in ([[0, 0], [1, 1]], [[0, 1], [1, 0]]):
        with pytest.raises(CertificateError, match="not the corners"):
            said_of(model | {"rules": rules}, None, claim(1.5))


def test_gains_blend_as_they_like() -> None:
    """x' = z x + u on |z| <= theta with gains 2 and 3: the weaker gain has to do, theta < 2."""
    model = model_data([[[-1]], [[1]]], B=[[[1]]])
    gains = law_data([[[2]], [[3]]])

    assert said_of(model, gains, claim(1.999999999)).verdict is Verdict.PROVED
    assert said_of(model, gains, claim(2)).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("change", [{"enlargement": None}, {"P": [[1, 0]]}, {"enlargement": "1"}])
def test_what_does_not_fit_is_refused(change: Data) -> None:
    """Types and shapes raise CertificateError; so do rules that leave out a corner."""
    with pytest.raises(CertificateError):
        said_of(model_data([[[-3]], [[-1]]]), None, claim(1) | change)
    holes = model_data([[[-3]], [[-2]], [[-1]]], premises=RANGES, rules=CORNERS[:3])
    with pytest.raises(CertificateError, match="not the corners"):
        said_of(holes, None, claim(1))


@given(st.fractions(0, 3, max_denominator=20), st.lists(st.integers(-9, 9), min_size=4, max_size=4))
def test_the_enlarged_vertices_are_those_of_the_multiaffine_function(
    theta: Fraction, c: list[int]
) -> None:
    """c0 + c1 a + c2 b + c3 a b at a, b = +-theta, from its values at +-1."""

    def value(a: Fraction, b: Fraction) -> Fraction:
        return c[0] + c[1] * a + c[2] * b + c[3] * a * b

    ends = [(2 * i - 1, 2 * j - 1) for i, j in CORNERS]
    stack = tuple(Matrix.of([[value(Fraction(a), Fraction(b))]]) for a, b in ends)
    family = PolytopicLoop(A=stack, corners=tuple((i, j) for i, j in CORNERS))

    found = [one[0, 0] for one in enlarged(stack, family, theta)]

    assert found == [value(theta * a, theta * b) for a, b in ends]


def test_the_largest_enlargement_is_proved() -> None:
    """x' = [0 1; -2 + z, -1] x over |z| <= theta: found, a little less proved, beyond it not."""
    A = np.array([[[0.0, 1.0], [-3.0, -1.0]], [[0.0, 1.0], [-1.0, -1.0]]])
    model = TSModel(A, premises=[Premise("z", "-1", "1")])

    found = certify(model, claims=[BoxEnlargement()])

    assert found.verdict is Verdict.PROVED
    claim = found.document["claims"][0]
    theta = claim["enlargement"]
    assert theta > 1
    wider = said_of(
        dict(found.document["model"]), None, {**claim, "enlargement": round(1.01 * theta, 6)}
    )
    assert wider.verdict is Verdict.UNDECIDED
    assert certify(model, claims=[BoxEnlargement(decay_rate=9.0)]).verdict is Verdict.UNDECIDED
