"""Every relaxation bounds the double sum from above, richer ones more closely, none from below."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import combinations, combinations_with_replacement, permutations
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    double_sum_of,
    exact_matrices,
    matrix,
    pdc_condition,
    relaxation_named,
    relaxation_size,
)
from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.sums.relaxations import RELAXATIONS
from takagi.models import Floats, ModelError
from tests.lmi.sums.known import (
    bound,
    combinations_of,
    known_sum,
    largest,
    memberships,
    product_memberships,
    random_theta,
)

SQUARE = ("wang-tanaka-griffin", "tuan", "tanaka-wang", "kim-lee", "liu-zhang")
# The bounds are within this share of the least, by two stages of a solver.
NEAR = 2e-3


@pytest.mark.slow
@given(st.integers(0, 10_000), st.integers(2, 4), st.integers(1, 3))
def test_no_relaxation_promises_too_much(seed: int, rules: int, size: int) -> None:
    theta = random_theta(seed, rules, size)
    reached = largest(theta, memberships(seed, rules))
    found = {name: bound(theta, name) for name in (*SQUARE, "polya-1", "polya-3")}

    assert all(reached <= found[name] + 1e-9 for name in found)
    chain = ("wang-tanaka-griffin", "tanaka-wang", "kim-lee", "liu-zhang")
    chains = (chain, (chain[0], "tuan"), (chain[0], "polya-1", "polya-3"))
    for names in chains:
        for poor, rich in zip(names, names[1:], strict=False):
            assert found[rich] <= found[poor] + NEAR, (poor, rich)


def largest_scalar(theta: Floats) -> float:
    """Return max h' theta h over memberships h, for numbers theta: by its support."""
    symmetric = (theta + theta.T) / 2
    best = float(symmetric.diagonal().max())
    for count in range(2, len(theta) + 1):
        for chosen in combinations(range(len(theta)), count):
            # Inside a face the gradient is the same along all its memberships.
            bordered = np.ones((count + 1, count + 1))
            bordered[:count, :count], bordered[count, count] = symmetric[np.ix_(chosen, chosen)], 0
            h = np.linalg.solve(bordered, np.eye(count + 1)[count])[:count]
            if (h >= 0).all():
                best = max(best, float(h @ symmetric[np.ix_(chosen, chosen)] @ h))
    return best


@settings(max_examples=15)
@given(st.integers(0, 10_000), st.integers(2, 4))
def test_liu_zhang_is_exact_for_numbers_of_four_rules(seed: int, rules: int) -> None:
    """Diananda (1962): up to order 4 a copositive matrix is a definite plus a nonnegative one."""
    theta = random_theta(seed, rules, 1)

    exact = largest_scalar(theta[:, :, 0, 0])
    assert bound(theta, "liu-zhang") == pytest.approx(exact, abs=NEAR)
    assert bound(theta, "kim-lee") == pytest.approx(exact, abs=NEAR)


def test_polya_ends_at_the_largest_value() -> None:
    """-h1^2 - h2^2 + 1.9 h1 h2 < 0: every coefficient of (h1 + h2)^d times it, by convolution."""
    theta = np.array([[-1.0, 0.95], [0.95, -1.0]])[:, :, None, None]
    degrees = range(0, 60)
    form = np.array([-1.0, 1.9, -1.0])
    shows = [
        bool((np.convolve(form, [comb(d, k) for k in range(d + 1)]) < 0).all()) for d in degrees
    ]
    first = shows.index(True)

    assert not any(shows[:first]) and all(shows[first:])
    for degree, holds in ((first - 1, False), (first, True), (first + 7, True)):
        loop = double_sum_of(matrix(theta, r"\Theta", over="ij") << 0, rules=2)
        (lmi,) = relaxation_named(f"polya-{degree}")(loop)[1]
        assert bool((lmi.constants[0].value < 0).all()) is holds


@pytest.mark.slow
@given(st.integers(0, 10_000))
def test_products_of_memberships_are_bounded_and_ordered(seed: int) -> None:
    """All pairs => product => product-1 => product-2; Polya-d => product-d; both together."""
    corners = combinations_of(2, 3)
    theta = random_theta(seed, 6, 1)
    h = product_memberships(corners, [memberships(seed, 2), memberships(seed + 1, 3)])
    reached = largest(theta, h)
    names = ("product", "product-1", "product-2", "product-liu-zhang")
    found = {name: bound(theta, name, corners=corners) for name in names}
    found |= {name: bound(theta, name) for name in ("wang-tanaka-griffin", "polya-1", "liu-zhang")}

    assert all(reached <= found[name] + 1e-9 for name in names)
    for poor, rich in (
        ("wang-tanaka-griffin", "product"),
        ("product", "product-1"),
        ("product-1", "product-2"),
        ("polya-1", "product-1"),
        ("product", "product-liu-zhang"),
        ("liu-zhang", "product-liu-zhang"),
    ):
        assert found[rich] <= found[poor] + NEAR, (poor, rich)


def test_degrees_of_products_close_the_gap() -> None:
    """The gap to what is reached on a fine grid falls like 1 / degree; with a slack it is gone."""
    corners = combinations_of(2, 2)
    theta = random_theta(5, 4, 1)
    grid = np.linspace(0, 1, 201)
    first, second = (part.ravel() for part in np.meshgrid(grid, grid))
    weights = [np.stack([1 - part, part], axis=1) for part in (first, second)]
    reached = largest(theta, product_memberships(corners, weights))
    gaps = [bound(theta, f"product-{d}", corners=corners) - reached for d in (0, 6, 18, 42)]

    assert gaps[0] > 1.5
    assert all(0 < later < earlier for earlier, later in zip(gaps, gaps[1:], strict=False))
    assert gaps[3] < 0.05
    assert bound(theta, "wang-tanaka-griffin") > reached + gaps[0] + 0.2
    assert bound(theta, "liu-zhang") > reached + 0.3
    assert bound(theta, "product-liu-zhang", corners=corners) < reached + NEAR


def test_one_premise_is_one_simplex() -> None:
    theta = random_theta(5, 3, 2)
    corners = np.arange(3)[:, None]

    for degree in (0, 2):
        known = matrix(theta, r"\Theta", over="ij") << 0
        loop = double_sum_of(known, rules=3, corners=corners)
        (first,) = relaxation_named(f"polya-{degree}")(loop)[1]
        (second,) = relaxation_named(f"product-{degree}")(loop)[1]
        np.testing.assert_array_equal(first.constants[0].value, second.constants[0].value)


def test_fractions_are_summed_without_an_error() -> None:
    """Vertices as decimals stay decimals in every relaxation: no weight is rounded."""
    A = fractions(np.array([[["0.1", "0.3"], ["-0.7", "0.2"]]] * 3, dtype=object))
    A[1, 0, 0], A[2, 1, 0] = Fraction(1, 3), Fraction(2, 7)
    B = fractions(np.array([[["0.1"], ["1.1"]]] * 3, dtype=object))
    Q = fractions([[["1", "0.1"], ["0.1", "2"]]])
    M = fractions([[["0.3", "0.7"]], [["-0.9", "0.1"]], [["0.2", "0.4"]]])
    model = Exact(A, B)
    G = [[A[i] @ Q[0] - B[i] @ M[j] for j in range(3)] for i in range(3)]

    condition = pdc_condition(model, relaxation="polya-1")
    (lmi,) = (one for one in condition.lmis if one.name == "product of memberships")
    found = exact_matrices(condition, lmi, {"Q": Q, "M": M, "nu": [[[0]]]})
    for item, chosen in enumerate(combinations_with_replacement(range(3), 3)):
        orders = Counter(order[:2] for order in permutations(chosen))
        total = sum(times * (G[i][j] + G[i][j].T) for (i, j), times in orders.items())
        # Six orderings, and the power of two next to 1 / 6.
        np.testing.assert_array_equal(found[item], -Fraction(6, 6 * 8) * total)
    condition = pdc_condition(model, relaxation="tuan")
    (lmi,) = (one for one in condition.lmis if one.name == "pair")
    found = exact_matrices(condition, lmi, {"Q": Q, "M": M, "nu": [[[0]]]})
    pair = G[0][0] + G[0][1] + G[1][0]
    np.testing.assert_array_equal(found[0], -(pair + pair.T))


class Exact:
    """Vertices as fractions."""

    def __init__(self, A: NDArray[np.object_], B: NDArray[np.object_]) -> None:
        self.A, self.B = A, B


def test_one_gain_takes_pairs_where_the_rest_changes_with_both_rules() -> None:
    theta = np.array([[-1.0, 3.0], [3.0, -1.0]])[:, :, None, None]

    assert bound(theta, "common-gain") == pytest.approx(3.0, abs=NEAR)
    same = np.array([[-1.0, -1.0], [2.0, 2.0]])[:, :, None, None]
    assert bound(same, "common-gain") == pytest.approx(2.0, abs=NEAR)
    assert largest(same, memberships(0, 2)) == pytest.approx(2.0)


def test_names_that_make_no_sense() -> None:
    loop, _ = known_sum(np.zeros((3, 3, 1, 1)))

    for name in ("polya", "polya--1", "product-x", "tanaka"):
        with pytest.raises(ModelError, match="is not known; there are common-gain"):
            relaxation_named(name)
    with pytest.raises(ModelError, match="needs memberships that are products"):
        relaxation_named("product-1")(loop)


@pytest.mark.parametrize(
    "name", [*RELAXATIONS, "polya-0", "polya-3", "product-0", "product-1", "product-3"]
)
def test_sizes_are_known_before_anything_is_built(name: str) -> None:
    corners = combinations_of(2, 3)
    loop, _ = known_sum(random_theta(0, 6, 2), corners=corners)
    slack, lmis = relaxation_named(name)(loop)
    size = relaxation_size(name, 6, corners, size=2)
    if name == "common-gain":
        size = relaxation_size("wang-tanaka-griffin", 6, size=2)

    assert size.slack_variables == sum(unknown.length for unknown in slack)
    assert size.width == max(lmi.size for lmi in lmis)
    assert size.lmis == sum(lmi.count for lmi in lmis)


def test_what_is_too_large_is_refused_with_what_is_not() -> None:
    """A hundred rules with Polya's degree 6 are not begun; the message names what can be."""
    loop, _ = known_sum(np.zeros((100, 100, 4, 4)))

    with pytest.raises(ModelError, match=r"5\d{9} LMIs.*'wang-tanaka-griffin' \(5050 LMIs"):
        relaxation_named("polya-6")(loop)
    with pytest.raises(ModelError, match="'tanaka-wang'"):
        relaxation_named("liu-zhang")(loop)
