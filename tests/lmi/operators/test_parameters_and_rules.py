"""Named numbers, sums over items, and double sums, written with operators."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import (
    He,
    Parameter,
    Unknown,
    added,
    block,
    double_sum_of,
    extreme_parameter,
    latex,
    lmi_of,
    matrix,
    pose,
    relaxation_named,
)
from takagi.lmi.condition.evaluate import lmi_value
from takagi.models.errors import ModelError

A = np.array([[[-1.0, 2.0], [0.0, -1.5]], [[-2.0, 1.0], [0.5, -3.0]]])
B = np.array([[[1.0], [0.0]], [[0.5], [1.0]]])
P = Unknown("P", 2, 2, symmetric=True)
M = Unknown("M", 1, 2, count=2)
alpha = Parameter("alpha", 0.25, r"\alpha")


def values() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(3)
    X = rng.normal(size=(2, 2))
    return {"P": (X + X.T)[None], "M": rng.normal(size=(2, 1, 2))}


def test_a_named_number_stays_a_parameter_of_the_condition() -> None:
    decay = He(P @ matrix(A[0], "A")) + 2 * alpha * P << 0
    condition = pose(P >> 0, P <= np.eye(2), decay.named("decay", weight=2.0))
    assert dict(condition.parameters) == {"alpha": 0.25}
    assert condition.lmis[-1].weight == 2.0
    assert r"\mathrm{He}\left(P A\right) + 2\alpha P \prec 0" in latex(condition)
    # Both eigenvalues of A are real, and the slower is -1.
    assert extreme_parameter(condition, "alpha").value == pytest.approx(1.0, abs=1e-4)


def test_what_a_named_number_cannot_do_is_refused() -> None:
    other = Parameter("beta", 1.0)
    with pytest.raises(ModelError, match="alpha and beta; one parameter"):
        alpha * other * P
    with pytest.raises(ModelError, match="multiplies a known matrix alone"):
        lmi_of(P + alpha * np.eye(2) >> 0)
    with pytest.raises(ModelError, match="alpha has two values"):
        pose(alpha * P << 0, Parameter("alpha", 0.5) * P - np.eye(2) << 0)
    with pytest.raises(ModelError, match="the objective has the parameter alpha"):
        pose(P >> 0, minimise=alpha * (np.ones((1, 2)) @ P @ np.ones((2, 1))))


def test_a_sum_over_items_is_the_sum_of_its_matrices() -> None:
    total = added(matrix(A, "A_{i}") @ P @ matrix(A, "A_{i}").T, latex=r"\sum_i")
    lmi = lmi_of((total - P << 0).named("sum"))
    assert lmi.count == 1
    X = values()
    expected = sum(a @ X["P"][0] @ a.T for a in A) - X["P"][0]
    assert np.allclose(lmi_value(lmi, X, {})[0], expected)
    with pytest.raises(ModelError, match="a sum of 2 matrices into 1"):
        added(matrix(A, "A_{i}") @ P, [0, 1])


def test_what_is_given_below_the_diagonal_is_solved_and_printed_there() -> None:
    lmi = lmi_of(block([[-P, None], [matrix(A[0], "A") @ P, -P]]) << 0)
    assert [term.at for term in lmi.terms] == [(0, 0), (1, 0), (1, 1)]


def test_a_matrix_on_all_blocks_keeps_the_blocks() -> None:
    E = np.array([[1.0, 0.0, 0.0, 2.0]]).T
    tau = Unknown("tau", 1, 1)
    lmi = lmi_of(block([[-P, None], [matrix(A[0], "A") @ P, -P]]) + tau * (E @ E.T) << 0)
    assert lmi.blocks == (2, 2) and lmi.terms[-1].at is None
    X = values() | {"tau": np.array([[[3.0]]])}
    without = X | {"tau": np.zeros((1, 1, 1))}
    assert np.allclose(lmi_value(lmi, X, {}) - lmi_value(lmi, without, {}), 3 * E @ E.T)


@pytest.mark.parametrize(
    ("side", "text"),
    [("right", r"u E A"), ("both", r"A^\top u E A"), ("turned", r"u A^\top E A")],
)
def test_a_number_times_a_matrix_is_printed_in_the_order_of_its_factors(
    side: str, text: str
) -> None:
    matrix_A, E = matrix(A[0], "A"), matrix(np.diag([1.0, 2.0]), "E")
    scaled = Unknown("u", 1, 1) * E
    both = matrix_A.T @ scaled @ matrix_A
    total = {"right": He(scaled @ matrix_A), "both": both, "turned": both.T}[side]
    condition = pose((total << 0).named("x"))
    assert rf"{text}\right" in latex(condition) or f"& {text} \\prec" in latex(condition)
    value = lmi_value(condition.lmis[0], {"u": np.array([[[3.0]]])}, {})[0]
    product = 3 * np.diag([1.0, 2.0]) @ A[0]
    expected = product + product.T if side == "right" else A[0].T @ product
    assert np.allclose(value, expected)


def test_a_double_sum_is_theta_at_every_pair_of_rules() -> None:
    A_i, B_i = matrix(A, "A_{i}", over="i"), matrix(B, "B_{i}", over="i")
    gains = np.arange(4.0).reshape(2, 1, 2)
    theta = (
        He(A_i @ P - B_i @ M.over("j")) + 2 * alpha * P + He(B_i @ matrix(gains, "K_{j}", over="j"))
    )
    loop = double_sum_of((theta << 0).named("loop", weight=3.0), rules=2)
    assert (loop.name, loop.weight, loop.by_gain) == ("loop", 3.0, True)
    rule, pair = relaxation_named("wang-tanaka-griffin")(loop)[1]
    assert [term.latex[0] for term in rule.terms] == ["A_{i}", "-B_{i}", r"2\alpha"]
    rate, numbers = {"alpha": 0.25}, values()
    X, Y = numbers["P"][0], numbers["M"]

    def at(i: int, j: int) -> np.ndarray:
        G = A[i] @ X - B[i] @ Y[j] + B[i] @ gains[j]
        return np.asarray(G + G.T + 0.5 * X)

    assert np.allclose(lmi_value(rule, numbers, rate), [at(0, 0), at(1, 1)])
    assert np.allclose(lmi_value(pair, numbers, rate), [at(0, 1) + at(1, 0)])
    with pytest.raises(ModelError, match="another comparison than <<"):
        double_sum_of(theta >> 0, rules=2)
    with pytest.raises(ModelError, match="give it to double_sum_of"):
        lmi_of(theta << 0)
