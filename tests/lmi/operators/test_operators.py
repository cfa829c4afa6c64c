"""Conditions written with operators are those written as terms; sums, named numbers, equalities."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    He,
    Parameter,
    Term,
    Unknown,
    added,
    block,
    decide,
    double_sum_of,
    exact_matrices,
    exact_no,
    exact_solution,
    expressed,
    extreme_parameter,
    hinf_norm_condition,
    latex,
    lmi_of,
    log_det,
    matrix,
    objective_below,
    optimise,
    parametrised,
    pose,
    relaxation_named,
    trace,
)
from takagi.lmi.condition.evaluate import lmi_value
from takagi.models import ModelError

A = np.array([[[-1.0, 2.0], [0.0, -1.1]], [[-1.0, 1.1], [0.0, -2.0]]])
B = np.array([[0.0], [1.0]])
C = np.array([[0.1, 1.0]])


def symmetric(name: str = "P", n: int = 2) -> Unknown:
    return Unknown(name, n, n, symmetric=True)


def values_of(condition: Condition, seed: int) -> dict[str, Any]:
    random = np.random.default_rng(seed)
    return {u.name: u.value(random.normal(size=u.length)) for u in condition.unknowns}


def same(one: Condition, other: Condition) -> bool:
    values = values_of(one, 0)
    return all(
        np.all(exact_matrices(one, first, values) == exact_matrices(other, second, values))
        for first, second in zip(one.lmis, other.lmis, strict=True)
    )


def test_the_energy_condition_of_the_guide_is_the_same_by_operators() -> None:
    """The guide's terms and He(P @ A) + I: the same matrices, the same optimum, the same LaTeX."""
    P, one = symmetric(), np.eye(2)[None]
    energy = LMI(
        name="energy",
        blocks=(2,),
        count=2,
        terms=(Term(unknown=P, left=one, right=A, plus_transpose=True, latex=("", "A_i")),),
        constants=(Constant(value=one, latex="I"),),
        sign=-1,
        index=r"i = 1, \dots, 2",
    )
    by_terms = Condition(name="e", unknowns=(P,), lmis=(energy,), objective={"P": one})

    by_hand = pose((He(P @ matrix(A, "A_i")) + np.eye(2) << 0).named("energy"), minimise=trace(P))

    assert same(by_terms, by_hand)
    assert latex(by_hand) == latex(by_terms)
    assert optimise(by_hand).objective == pytest.approx(1.9696, abs=1e-4)


def test_the_bounded_real_lemma_by_blocks_is_the_one_of_the_layer() -> None:
    """Blocks, a scalar times I, None for the mirror image, against ``hinf_norm_condition``."""
    D = np.array([[0.25]])
    P, gamma = symmetric(), Unknown("gamma", 1, 1)

    mine = pose(
        P >> 0,
        block(
            [
                [He(P @ A), P @ B, C.T],
                [None, -gamma * np.eye(1), D.T],
                [None, None, -gamma * np.eye(1)],
            ]
        )
        << 0,
        minimise=gamma,
    )

    theirs = hinf_norm_condition(A, B, C, D)
    assert same(theirs, mine)
    assert mine.objective["gamma"] == 1


def test_members_transposes_and_products_of_unknowns_are_what_they_say() -> None:
    """Y' and Y of a family, A Q + B Y: against the same in numpy, at any values."""
    Q, Y = symmetric("Q"), Unknown("Y", 1, 2, count=2)
    condition = pose(
        (He(A @ Q + B @ Y) - 0.5 * Q << 0), block([[Q, 2 * Y.member(1).T], [None, np.eye(1)]]) >= 0
    )
    values = values_of(condition, 3)
    q, y = values["Q"][0], values["Y"]

    first, second = (exact_matrices(condition, lmi, values) for lmi in condition.lmis)

    for i in range(2):
        M = A[i] @ q + B @ y[i]
        np.testing.assert_allclose(-(M + M.T - 0.5 * q), first[i].astype(float), atol=1e-14)
    whole = np.block([[q, 2 * y[1].T], [2 * y[1], np.eye(1)]])
    np.testing.assert_array_equal(second[0].astype(float), whole)


def test_yalmip_products_are_matrix_products() -> None:
    P, tau = symmetric(), Unknown("tau", 1, 1)

    one = pose(He(P * A[0]) + tau * np.eye(2) * 2.0 << 0)
    other = pose(He(P @ A[0]) << -2 * tau * np.eye(2))

    assert same(one, other)


def test_a_statement_is_neither_true_nor_false() -> None:
    """A chain of comparisons would silently lose its first half."""
    P = symmetric()

    with pytest.raises(ModelError, match="two statements for a chain"):
        bool(P >> 0)
    with pytest.raises(ModelError, match="write << or >>"):
        P < 1  # noqa: B015


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda P: P @ P, "product of two unknowns"),
        (lambda P: Unknown("rho", 1, 1) * P, "product of two unknowns"),
        (lambda P: P * Unknown("rho", 1, 1), "product of two unknowns"),
        (lambda P: P**2, "power"),
        (lambda P: matrix("P", 2), r"Unknown\("),  # type: ignore[arg-type]
        (lambda P: optimise([P >> 0]), "has no objective"),
        (lambda P: decide(np.eye(2)), "a condition is needed"),  # type: ignore[arg-type]
        (lambda P: P @ np.ones((3, 1)), "inner sizes"),
        (lambda P: P + np.eye(3), "shapes must be equal"),
        (lambda P: P + 1.0, "shapes must be equal"),
        (lambda P: pose(P @ A[0] << 0), "is not symmetric"),
        (lambda P: pose(block([[P, P @ A[0]], [P @ A[0], P]]) >> 0), "is not symmetric"),
        (lambda P: block([[P, None], [None, P]]), "so is its mirror image"),
        (lambda P: pose(P @ B << 0), "square matrix"),
        (lambda P: pose(True), "a comparison of expressions"),  # type: ignore[arg-type]
        (lambda P: pose(), "no statement"),
        (lambda P: pose(P >> 0, symmetric("P", 3) >> 0), "two unknowns have the name"),
        (lambda P: pose(P >> 0, minimise=trace(P) + 1.0), "has a constant"),
        (lambda P: P @ [[1.0, np.nan], [0.0, 1.0]], "not finite"),
        (lambda P: P @ [1.0, 0.0], r"a column of n numbers is \(n, 1\)"),
        (lambda P: P.member(1), "counted from 0"),
        (lambda P: P[2, 0], "index 2 of 2 rows"),
        (lambda P: P[0, 0, 0], "3 indices"),
        (lambda P: P[1:1], "picks none"),
        (lambda P: Unknown("X", 2, 2, count=3)[0], "one index for 3 matrices"),
        (lambda P: np.kron(P, P), "product of two unknowns"),
        (lambda P: np.linalg.det(P), "numpy.linalg.det of an unknown.*log_det"),
        (lambda P: pose(P >> 0, minimise=log_det(P)), "maximised only"),
        (lambda P: pose(P >> 0, minimise=trace(P), maximise=trace(P)), "give one"),
        (lambda P: log_det(P @ B), "one square matrix"),
    ],
)
def test_what_cannot_be_meant_is_refused(wrong: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        wrong(symmetric())


def test_a_list_of_statements_is_a_condition() -> None:
    """``decide([...])`` is ``decide(pose(...))``; so are an objective's and the other doors."""
    P = symmetric()
    statements = [P >> 0, np.eye(2) >> P, He(P @ A[0]) << 0]

    assert decide(statements).margin == decide(pose(*statements)).margin
    assert latex(statements) == latex(pose(*statements))
    assert exact_no(statements) is None and exact_no([P >> 0, P << 0]) is not None


def test_two_unknowns_are_compared_as_values_and_numbers_make_an_equation() -> None:
    """``==`` between unknowns stays the comparison that sets and dictionaries use."""
    assert symmetric() == symmetric() and symmetric() != symmetric("Q")
    assert len({symmetric(), symmetric()}) == 1

    fixed = pose(symmetric() == np.eye(2), He(symmetric() @ A) << 0)

    assert len(fixed.equalities) == 1


def test_equalities_are_solved_exactly_and_the_answer_is_checked_over_the_rationals() -> None:
    """P B = C' and trace P = 5/3: a candidate, rounded, satisfies both without any error."""
    P = symmetric()
    third = np.array([[Fraction(5, 3)]], dtype=object)
    condition = pose(P >> 0, He(P @ A[0]) << 0, P @ B == C.T, trace(P) == third)

    outcome = decide(condition)
    exact = exact_solution(condition, outcome.values)

    assert outcome.status == "candidate"
    assert exact is not None and exact.holds
    p = exact.values["P"][0]
    assert p[0, 0] + p[1, 1] == Fraction(5, 3)
    assert (p[0, 1], p[1, 1]) == (Fraction(0.1), 1)


def test_a_broken_solution_is_refused() -> None:
    """One entry moved by 1e-30, and a sign turned: neither is a solution."""
    P = symmetric()
    condition = pose(P >> 0, He(P @ A[0]) << 0, P @ B == C.T)
    exact = exact_solution(condition, decide(condition).values)
    assert exact is not None and exact.holds

    moved = {"P": exact.values["P"].copy()}
    moved["P"][0, 0, 1] += Fraction(1, 10**30)
    moved["P"][0, 1, 0] += Fraction(1, 10**30)
    turned = exact_solution(condition, {"P": -exact.values["P"]})

    assert type(exact)(condition=condition, values=moved).fault().startswith("equality 3")
    assert turned is not None and "not definite" in turned.fault()


def test_equalities_that_contradict_are_a_proved_no() -> None:
    """P = I and trace P = 3, for 2 x 2: elimination over the rationals finds no solution."""
    P = symmetric()
    condition = pose(P >> 0, 1 * P == np.eye(2), trace(P) == 3.0 * np.eye(1))

    outcome = decide(condition)

    assert outcome.status == "infeasible" and "contradict" in outcome.reason
    assert (
        parametrised(condition) is None
        and exact_solution(condition, {"P": np.eye(2)[None]}) is None
    )


def test_equalities_that_leave_nothing_free_are_decided_too() -> None:
    """P = I, stable or not: the margin is that of the one candidate."""
    P = symmetric()

    stable = decide(pose(He(P @ A[1]) << 0, P == np.eye(2)))
    unstable = decide(pose(He(P @ -A[1]) << 0, P == np.eye(2)))

    assert (stable.status, unstable.status) == ("candidate", "infeasible")
    np.testing.assert_array_equal(stable.values["P"], np.eye(2)[None])


def test_a_skew_unknown_is_one_by_an_equality() -> None:
    """S + S' = 0 mixes an unknown and its transpose; |S| <= 1 and S_12 largest: S_12 = 1."""
    S = Unknown("S", 2, 2)
    condition = pose(
        block([[np.eye(2), S], [None, np.eye(2)]]) >= 0,
        S + S.T == 0,
        minimise=np.array([[0.0, 1.0]]) @ S @ np.array([[1.0], [0.0]]),
    )

    outcome = optimise(condition)

    assert outcome.objective == pytest.approx(-1.0, abs=1e-3)
    np.testing.assert_allclose(outcome.values["S"][0], [[0, 1], [-1, 0]], atol=1e-3)


def test_cvxpy_and_exact_multipliers_agree_with_the_elimination() -> None:
    """min trace P with P B = C': cvxpy's value, and an exact lower bound from the other side."""
    P = symmetric()
    condition = pose(P >> 0, He(P @ A[0]) + np.eye(2) << 0, P @ [[1.0], [0.0]] == [[0.7], [0.4]])
    with_trace = pose(
        P >> 0,
        He(P @ A[0]) + np.eye(2) << 0,
        P @ [[1.0], [0.0]] == [[0.7], [0.4]],
        minimise=trace(P),
    )

    outcome = optimise(with_trace)
    by_cvxpy = expressed(with_trace, margin=0.0).problem().solve(solver="CLARABEL")
    above = objective_below(with_trace, outcome.objective * 1.01)
    below = objective_below(with_trace, outcome.objective * 0.99)

    assert outcome.status == "candidate" and outcome.objective == pytest.approx(by_cvxpy, rel=1e-4)
    assert decide(above).status == "candidate"
    free = parametrised(below)
    assert free is not None
    no = exact_no(free.condition)
    assert no is not None and no.holds
    assert r"P" in latex(condition) and "= " in latex(condition)


def test_what_reads_lmis_alone_refuses_equalities() -> None:
    P = symmetric()
    condition = pose(P >> 0, P @ B == C.T)

    with pytest.raises(ModelError, match="parametrised"):
        exact_no(condition)


def value_of(expression: Any, values: dict[str, Any]) -> Any:
    X = expression.flat()
    return np.broadcast_to(sum(piece.value(values, 1) for piece in X.pieces)[0], X.shape)


def test_slices_and_kronecker_products_are_numpys() -> None:
    # The stubs of numpy know arrays alone.
    numpy: Any = np
    P, M = symmetric("P", 3), Unknown("M", 1, 3)
    random = np.random.default_rng(0)
    values = {u.name: u.value(random.normal(size=u.length)) for u in (P, M)}
    p, m, N = values["P"][0], values["M"][0], random.normal(size=(2, 3))

    pairs: list[tuple[Any, Any]] = [
        (P[0, 0], p[:1, :1]),
        (P[1], p[1:2]),
        (P[-1, [0, 2]], p[-1:, [0, 2]]),
        ((P @ N.T)[:2, 1:], (p @ N.T)[:2, 1:]),
        (numpy.kron(N, P), np.kron(N, p)),
        (numpy.kron(P, N), np.kron(p, N)),
        (numpy.kron(2 * matrix(N, "N"), M.T), np.kron(2 * N, m.T)),
        (P[0, 1] * N, p[0, 1] * N),
        (numpy.trace(P), [[np.trace(p)]]),
        (numpy.block([[P, M.T], [M, P[0, 0]]]), np.block([[p, m.T], [m, p[:1, :1]]])),
    ]
    for written, number in pairs:
        assert value_of(written, values) == pytest.approx(np.asarray(number), abs=1e-14)
    exact = matrix(Fraction(1, 3) * np.ones((1, 2), dtype=int), "c")
    posed = pose(numpy.kron(exact.T @ exact, P) >> 0, P >> 0)
    assert exact_matrices(posed, posed.lmis[0], {"P": np.eye(3)[None]})[0, 0, 0] == Fraction(1, 9)


def test_the_largest_determinant_is_found_from_both_sides() -> None:
    """Of P <= diag(1, ..., n) it is n!; log_det alone, by maximise or a minus, in cvxpy too."""
    for n, largest in ((1, 1.0), (3, 6.0), (4, 24.0)):
        P = symmetric("P", n)
        limits = P >> 0, P <= np.diag(np.arange(1.0, n + 1))
        outcome = optimise(pose(*limits, maximise=log_det(P)))

        assert outcome.status == "candidate"
        assert outcome.lower_bound <= -(largest ** (1 / n)) <= outcome.objective + 1e-9
        assert np.linalg.det(outcome.values["P"][0]) == pytest.approx(largest, rel=1e-4)
    tilted = pose(P >> 0, P <= np.eye(4), 4 * P[0, 1] >= 1, minimise=-log_det(P))
    found = optimise(tilted).values["P"][0]
    assert np.linalg.det(found) == pytest.approx(expressed_determinant(tilted), rel=1e-4)


def expressed_determinant(condition: Condition) -> float:
    import cvxpy as cp

    posed = expressed(condition, margin=0.0)
    (P,) = posed.variables["P"]
    constraints = [P << np.eye(4), 4 * P[0, 1] >= 1]
    problem = cp.Problem(cp.Maximize(cp.log_det(P)), constraints)
    problem.solve(solver="CLARABEL")
    return float(np.exp(problem.value))


def test_maximise_is_minimise_with_the_other_sign() -> None:
    P = symmetric()
    outcome = optimise(pose(P >> 0, P <= np.eye(2), He(P @ A[0]) << 0, maximise=P[0, 0]))
    assert outcome.objective == pytest.approx(-1.0, abs=1e-5)


def test_reprs_are_short() -> None:
    P = symmetric("P", 30)
    condition = pose(P >> 0, He(P @ np.ones((30, 30))) << 0, minimise=trace(P))
    for value in (P @ np.ones((30, 30)), P >> 0, P <= P, P == 0, condition, *condition.lmis):
        assert len(repr(value)) < 200 and "\n" not in repr(value)
    assert repr((P[:2] @ np.ones((30, 2))) << 0) == "Inequality(Expression(2 x 2 in P) << 0)"


EACH = np.array([[[1.0], [0.0]], [[0.5], [1.0]]])
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
    A_i, B_i = matrix(A, "A_{i}", over="i"), matrix(EACH, "B_{i}", over="i")
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
        G = A[i] @ X - EACH[i] @ Y[j] + EACH[i] @ gains[j]
        return np.asarray(G + G.T + 0.5 * X)

    assert np.allclose(lmi_value(rule, numbers, rate), [at(0, 0), at(1, 1)])
    assert np.allclose(lmi_value(pair, numbers, rate), [at(0, 1) + at(1, 0)])
    with pytest.raises(ModelError, match="another comparison than <<"):
        double_sum_of(theta >> 0, rules=2)
    with pytest.raises(ModelError, match="give it to double_sum_of"):
        lmi_of(theta << 0)
