"""What the checker computes of a conic problem, against numbers by hand and another program."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq, fmpq_mat
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.problem.conic_problem import Block, corrected, triangle
from tests.certificates.kinds.claims import said_of

ENTRY = st.fractions(-4, 4, max_denominator=5)


@given(st.integers(1, 5).flatmap(lambda n: st.lists(st.lists(ENTRY, min_size=n + 2, max_size=n + 2),
                                                    min_size=n, max_size=n)))  # fmt: skip
def test_equations_are_solved_as_flint_solves_them(rows: list[list[Fraction]]) -> None:
    """M v + b = r in the first places of v; the last one, which is no basis, stays."""
    n = len(rows)
    sparse = [{k: a for k, a in enumerate(row[: n + 1]) if a} for row in rows]
    start, right = [Fraction(1)] * (n + 1), [row[-1] for row in rows]
    M = fmpq_mat(n, n, [fmpq(a.numerator, a.denominator) for row in rows for a in row[:n]])

    if M.det() == 0:
        with pytest.raises(Refused):
            corrected(sparse, right, start, range(n))
        return

    rest = [r - row[n] for r, row in zip(right, rows, strict=True)]
    solution = M.solve(fmpq_mat(n, 1, [fmpq(a.numerator, a.denominator) for a in rest]))
    solved = corrected(sparse, right, start, range(n))
    assert solved[n] == 1
    assert solved[:n] == [Fraction(int(x.p), int(x.q)) for x in solution.entries()]


def test_equations_that_are_left_over_must_hold() -> None:
    """x = 2 twice, and x = 2 beside x = 3."""
    rows = [{0: Fraction(1)}, {0: Fraction(2)}]
    assert corrected(rows, [Fraction(2), Fraction(4)], [Fraction(0)], [0]) == [2]
    with pytest.raises(Refused, match="contradict"):
        corrected(rows, [Fraction(2), Fraction(6)], [Fraction(0)], [0])


def test_the_weights_of_a_large_triangle() -> None:
    """Once on the diagonal and twice beside it; once everywhere where values are scaled."""
    plain = Block("semidefinite", 12, False, {}, {})
    scaled = Block("semidefinite", 12, True, {}, {})
    for i, j, position in triangle(12):
        assert plain.weight(position) == (1 if i == j else 2)
        assert scaled.weight(position) == 1


def bound_within(sense: str, **members: Any) -> Any:
    """Return what is proved of: x_1 + 3 x_2 + 5 with x_1 >= 1 and x_2 >= 2, y = (0.9, 3.02)."""
    entries = [[0, 0, -1], [0, 1, -2], [1, 0, 1], [2, 1, 1]]
    model = {
        "kind": "conic-problem",
        "name": "two bounds",
        "objective": [1, 3],
        "offset": 5,
        "sense": sense,
        "blocks": [{"cone": "nonnegative", "size": 2, "entries": entries}],
    }
    claim = {"name": "b", "kind": "optimum-bound", "point": [0.9, 3.02], "basis": []} | members
    return said_of(model, None, claim)


@pytest.mark.parametrize(("sense", "sign"), [("minimise", 1), ("maximise", -1)])
def test_a_bound_within_a_box_by_hand(sense: str, sign: int) -> None:
    """5 + 0.9 + 2 * 3.02 - 10 (0.1 + 0.02) = 10.74; the optimum is 12, or -12 of the opposite."""
    claim = bound_within(sense, radius=10)

    bound, size = claim.figures
    assert claim.verdict.name == "PROVED"
    assert bound.value == sign * Fraction("10.74") and bound.larger == (sign == 1)
    assert size.value == 10 and size.larger


def test_a_bound_of_all_solutions_by_hand() -> None:
    """With y = (1, 3) it is the optimum itself, 12: the equations are solved in both places."""
    claim = bound_within("minimise", basis=[0, 1])

    (bound,) = claim.figures
    assert claim.verdict.name == "PROVED" and bound.value == 12


def test_more_variables_than_are_read() -> None:
    model = {"kind": "conic-problem", "name": "n", "objective": [1] * 2001, "offset": 0}
    model |= {"sense": "minimise", "blocks": [{"cone": "zero", "size": 1, "entries": []}]}
    claim = {"name": "p", "kind": "feasible-point", "point": [0] * 2001, "basis": []}
    with pytest.raises(CertificateError, match="variables"):
        said_of(model, None, claim)
