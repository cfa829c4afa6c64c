"""The loop of a claim: its groups of pairs, against the double sum itself, and too much work."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import MOST_CLAIMS
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from tests.certificates.kinds.claims import Data, model_data, said_of, sealed, verdicts

ENTRY = st.integers(-9, 9).map(Fraction)
SHARE = st.fractions(0, 1, max_denominator=9)


def rows(draw: Any, height: int, width: int) -> Matrix:
    return Matrix.of([[draw(ENTRY) / 7 for _ in range(width)] for _ in range(height)])


@st.composite
def families(draw: st.DrawFn) -> tuple[PolytopicLoop, list[Fraction], list[Fraction]]:
    corners = tuple(product((0, 1), repeat=draw(st.integers(1, 2))))
    r, one_input = len(corners), draw(st.booleans())
    shared, products = draw(st.booleans()), draw(st.booleans())
    w = [draw(SHARE) for _ in corners[0]]
    h = [Fraction(1)] * r
    for i, row in enumerate(corners):
        for weight, corner in zip(w, row, strict=True):
            h[i] *= weight if corner else 1 - weight
    if not products:
        raw = [draw(SHARE) + Fraction(1, 9) for _ in range(r)]
        h = [share / sum(raw) for share in raw]
    s = draw(st.sampled_from([1, r])) if shared else draw(st.integers(1, 3))
    raw = [draw(SHARE) + Fraction(1, 9) for _ in range(s)]
    g = h if shared and s == r else [share / sum(raw) for share in raw]
    family = PolytopicLoop(
        A=tuple(rows(draw, 2, 2) for _ in range(r)),
        B=tuple(rows(draw, 2, 1) for _ in range(1 if one_input else r)),
        C=tuple(rows(draw, 1, 2) for _ in range(r)),
        D=tuple(rows(draw, 1, 1) for _ in range(1 if one_input else r)),
        E=tuple(rows(draw, 2, 1) for _ in range(r)),
        K=tuple(rows(draw, 1, 2) for _ in range(s)),
        corners=corners if products else None,
        shared_weights=shared,
    )
    return family, h, g


def at(stack: tuple[Matrix, ...], i: int) -> Matrix:
    return stack[i % len(stack)]


@given(families())
def test_blends_make_up_the_double_sum(
    drawn: tuple[PolytopicLoop, list[Fraction], list[Fraction]],
) -> None:
    """sum_ij h_i g_j X_ij = sum of blends with weights >= 0 that sum to one, for A, C, E and K."""
    family, h, g = drawn
    affine = len(family.K) == 1 or (len(family.B) == 1 and family.shared_weights)
    wanted: dict[str, Callable[[int, int], Matrix]] = {
        "A": lambda i, j: at(family.A, i) - at(family.B, i) @ family.K[j],
        "C": lambda i, j: at(family.C, i) - at(family.D, i) @ family.K[j],
        "E": lambda i, j: family.E[i],
        "K": lambda i, j: family.K[j],
    }
    for letter, X in wanted.items():
        total = None
        for (i, a), (j, b) in product(enumerate(h), enumerate(g)):
            part = a * b * X(i, j)
            total = part if total is None else total + part
        found, weights = None, Fraction(0)
        for blend in family.blends():
            # In an affine loop the weights of the pairs (i, i) are h_i themselves.
            if affine:
                weight = h[blend.pairs[0][0]]
            else:
                weight = sum((h[i] * g[j] for i, j in blend.pairs), Fraction(0))
            weights += weight
            part = weight * getattr(blend, letter)
            found = part if found is None else found + part
        assert total is not None
        assert found is not None
        assert weights == 1
        difference = total - found
        assert not any(entry for row in difference.rows for entry in row), letter


@pytest.mark.parametrize(
    ("premises", "pairs", "products"), [(1, 3, 3), (2, 10, 9), (3, 36, 27), (4, 136, 81)]
)
def test_products_of_weights_need_fewer_inequalities(
    premises: int, pairs: int, products: int
) -> None:
    """r (r + 1) / 2 pairs, but 3^p different products of p premises' weights."""
    rules = list(product((0, 1), repeat=premises))
    one = Matrix.identity(1)
    B = tuple(Fraction(i + 1) * one for i in range(len(rules)))
    family = PolytopicLoop(A=B, B=B, K=B)

    assert len(family.blends()) == pairs
    assert len(PolytopicLoop(A=B, B=B, K=B, corners=tuple(rules)).blends()) == products


def test_equal_inputs_or_one_gain_make_the_loop_affine() -> None:
    """Where B is the same in all rules, however often it is written, the rules suffice."""
    model = {
        "kind": "takagi-sugeno",
        "sample_time": None,
        "state_names": ["x"],
        "A": [[["-1"]]] * 3,
        "B": [[["1"]]] * 3,
    }
    gains = {"sample_time": None, "state_names": ["x"], "K": [[["1"]], [["2"]], [["3"]]]}

    read = read_model_loop(numbered(model), numbered(gains))
    assert len(read.blends()) == 3
    model["B"] = [[["1"]], [["2"]], [["3"]]]
    assert len(read_model_loop(numbered(model), numbered(gains)).blends()) == 6
    gains["K"] = [[["1"]]] * 3
    assert len(read_model_loop(numbered(model), numbered(gains)).blends()) == 3


def test_what_would_take_hours_is_refused() -> None:
    """More than two million pairs, or too many inequalities of a large order: at once."""
    many = tuple(Matrix([[k]]) for k in range(1, 2049))
    with pytest.raises(CertificateError, match="pairs"):
        PolytopicLoop(A=many, B=many, K=many).blends()
    large = Matrix.identity(80)
    with pytest.raises(CertificateError, match="too many"):
        PolytopicLoop(A=(large,) * 200).blends()


def test_rules_in_another_order_are_weights_of_their_own() -> None:
    """A law that takes the corners in another order does not have the model's weights."""
    model = {
        "kind": "takagi-sugeno",
        "sample_time": None,
        "state_names": ["x"],
        "A": [[["-1"]], [["-2"]]],
        "B": [[["1"]], [["2"]]],
        "rules": [["0"], ["1"]],
    }
    gains = {"sample_time": None, "state_names": ["x"], "K": [[["1"]], [["2"]]]}

    for rules, shared in (([["0"], ["1"]], True), ([["1"], ["0"]], False)):
        law = numbered(gains | {"rules": rules})
        assert read_model_loop(numbered(model), law).shared_weights is shared
    assert read_model_loop(numbered(model), numbered(gains)).shared_weights


def numbered(data: Any) -> Any:
    from takagi.certificates.checker.kernel.reader import Number

    def entries(value: Any) -> Any:
        return [entries(v) for v in value] if isinstance(value, list) else Number(value)

    return {key: entries(v) if key in ("A", "B", "K", "rules") else v for key, v in data.items()}


ONE = [[1, 0], [0, 1]]
KEPT: Data = {"name": "a", "P": ONE, "level": 1, "multiplier": 1, "disturbance": "inputs"}
KEPT |= {"disturbance_norm": 0.1}


def test_limit_of_work_has_two_sides() -> None:
    bounded(10**4, 10)
    with pytest.raises(CertificateError, match="too many"):
        bounded(10**4 + 1, 10)


def test_more_claims_than_a_chain_has_are_refused() -> None:
    claim = {"name": "a", "kind": "decay", "P": [[1]], "decay_rate": 0}
    model = model_data([[[-1]]])
    assert len(verdicts(sealed(model, None, *[claim] * MOST_CLAIMS))) == MOST_CLAIMS
    with pytest.raises(CertificateError, match="claims"):
        check_document(sealed(model, None, *[claim] * (MOST_CLAIMS + 1)))


def test_polynomial_of_many_terms_is_refused_before_it_is_made() -> None:
    """Two hundred rules, raised eight times: more than 10^15 terms."""
    r = 200
    model = model_data([[[-1]]] * r)
    powers = [[int(i == j) for j in range(r)] for i in range(r)]
    P = [{"powers": [row], "matrix": [[1]]} for row in powers]
    claim = {"name": "a", "kind": "fuzzy-decay", "decay_rate": 0, "degrees": [1], "P": P}

    with pytest.raises(CertificateError, match="terms"):
        said_of(model, None, claim | {"polya": 8, "rates": [[1] * r]})
