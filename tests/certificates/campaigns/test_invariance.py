"""Verdicts do not depend on the units of the states, nor on the size of P, in powers of two.

Both are exact in floats and in decimals: the inequalities are scaled and nothing else.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.models import TSModel
from tests.certificates.kinds.claims import law_data, model_data, said_of, verdict_of

Floats = NDArray[np.float64]
Rows = list[list[float]]
EIGHTHS = st.integers(-24, 24).map(lambda k: k / 8)
POWERS = st.integers(-12, 12)
PAIRS = st.lists(st.lists(EIGHTHS, min_size=4, max_size=4), min_size=2, max_size=2)


def vertices(pairs: list[list[float]]) -> Floats:
    return np.array(pairs).reshape(2, 2, 2) - 2 * np.eye(2)


def claims(P: Rows) -> list[dict[str, Any]]:
    named = {"name": "claim", "P": P}
    return [
        {**named, "kind": "decay", "decay_rate": 0.25},
        {**named, "kind": "region", "parts": [{"L": [[0.25]], "M": [[1]]}]},
        {**named, "kind": "observer", "L": [[[1], [0.5]]], "decay_rate": 0.0},
    ]


@settings(max_examples=60)
@given(PAIRS, st.tuples(EIGHTHS, EIGHTHS, EIGHTHS), POWERS, st.tuples(POWERS, POWERS))
def test_claims_keep_their_verdicts(
    pairs: list[list[float]], entries: tuple[float, float, float], k: int, sizes: tuple[int, int]
) -> None:
    """P -> 2^k P; and x -> S x: A -> S A S^-1, B -> S B, C -> C S^-1, K -> K S^-1, P likewise."""
    A, s = vertices(pairs), np.exp2(np.array(sizes, dtype=float))
    B, C, K = np.array([[1.0], [0.5]]), np.array([[1.0, 0.25]]), np.array([[0.5, 0.25]])
    p, q, r = entries
    P = np.array([[4 + p, r], [r, 4 + q]])
    moved = np.outer(1 / s, 1 / s) * P

    def verdicts(X: Floats, Y: Floats, Z: Floats, L: Floats, F: Floats, size: Floats) -> Any:
        model = model_data(X.tolist(), B=[Y.tolist()], C=[Z.tolist()])
        law = law_data([L.tolist()])
        listed = claims(F.tolist())
        listed[2]["L"] = [(np.array([[1.0], [0.5]]) * size[:, None]).tolist()]
        return [said_of(model, law, claim).verdict for claim in listed]

    one = np.ones(2)
    before = verdicts(A, B, C, K, P, one)

    assert verdicts(A, B, C, K, P * 2.0**k, one) == before
    assert verdicts(A * s[:, None] / s, B * s[:, None], C / s, K / s, moved, s) == before


@settings(max_examples=40)
@given(PAIRS, st.tuples(EIGHTHS, EIGHTHS, EIGHTHS), POWERS, st.tuples(POWERS, POWERS))
def test_sets_keep_their_verdicts(
    pairs: list[list[float]], entries: tuple[float, float, float], k: int, sizes: tuple[int, int]
) -> None:
    """{x'Px <= c} is {x'(2^k P)x <= 2^k c}; the box is scaled with the states."""
    A, s = vertices(pairs), np.exp2(np.array(sizes, dtype=float))
    p, q, r = entries
    P = np.array([[4 + p, r], [r, 4 + q]])

    def verdict(X: Floats, F: Floats, level: float, size: Floats) -> Verdict:
        sides = {f"x{i + 1} [-]": [-size[i], size[i]] for i in range(2)}
        claim = {"name": "set", "kind": "invariant-ellipsoid", "P": F.tolist(), "level": level}
        return said_of(
            model_data(X.tolist(), box=sides), None, claim | {"multiplier": 0.25}
        ).verdict

    before = verdict(A, P, 3.0, np.ones(2))

    assert verdict(A, P * 2.0**k, 3.0 * 2.0**k, np.ones(2)) == before
    assert verdict(A * s[:, None] / s, np.outer(1 / s, 1 / s) * P, 3.0, s) == before


@settings(max_examples=15, deadline=None)
@given(PAIRS, st.tuples(POWERS, POWERS))
def test_certify_keeps_its_verdict(pairs: list[list[float]], sizes: tuple[int, int]) -> None:
    """Away from the edge, where the candidate's last digits do not decide."""
    A, s = vertices(pairs), np.exp2(np.array(sizes, dtype=float))
    for M in (A[0], A[1], A[0] @ A[1], A[0] @ np.linalg.inv(A[1] + 1e-9 * np.eye(2))):
        values = np.linalg.eigvals(M)
        if np.abs(values.real).min() < 0.05 or np.abs(np.linalg.det(M)) < 0.05:
            return

    found = [certify(TSModel(X), decay_rate=0).verdict for X in (A, A * s[:, None] / s)]

    assert {Verdict.PROVED, Verdict.DISPROVED} >= set(found) or found[0] is found[1]
    if Verdict.UNDECIDED not in found:
        assert found[0] is found[1]


def test_the_scaling_of_a_false_claim_is_seen() -> None:
    """Scaled wrongly, the claim is another one: the laws above would fail for a wrong formula."""
    model = model_data([[[-1.0, 0.0], [0.0, -1.0]]])
    claim = {"name": "c", "kind": "decay", "decay_rate": float(Fraction(1, 2))}

    assert verdict_of(model, None, claim | {"P": [[1, 0], [0, 1]]}) == "PROVED"
    assert verdict_of(model, None, claim | {"P": [[1, 4], [4, 1]]}) == "UNDECIDED"


def test_half_width_of_a_strip_is_said() -> None:
    """|Im z| < 3 is [[-6, z - conj(z)], [conj(z) - z, -6]] < 0; poles at -1 +- 2i."""
    model = model_data([[[-1, 2], [-2, -1]]])
    part = {"L": [[-6, 0], [0, -6]], "M": [[0, 1], [-1, 0]]}
    claim = {"name": "strip", "kind": "region", "P": [[1, 0], [0, 1]], "parts": [part]}

    found = said_of(model, None, claim)

    assert found.verdict is Verdict.PROVED
    assert "|Im z| < 3" in found.text


def test_steps_of_one_entry_are_said() -> None:
    """x' = -3 x - (k x_1 + l x_2) in each state: only the first gain may be off."""
    model = model_data([[[-3, 0], [0, -3]]], B=[[[1], [1]]])
    claim: dict[str, Any] = {"name": "steps", "kind": "gain-rounding", "P": [[1, 0], [0, 1]]}
    claim |= {"decay_rate": 0, "relative": 0, "absolute": [[0.1, 0]], "tau": [0.1]}

    found = said_of(model, law_data([[[0, 0]]]), claim)

    assert found.verdict is Verdict.PROVED
    assert "the stated absolute steps" in found.text
