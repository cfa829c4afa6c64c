"""Rules as combinations of corners of premises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import (
    DoubleSum,
    ProductRules,
    Unknown,
    double_sum_of,
    pdc,
    product_rules,
    relaxation_named,
    relaxation_size,
)
from takagi.models import Floats, ModelError, Premise, TSModel
from tests.lmi.known_models import blended_rates
from tests.lmi.sums.known import (
    bound,
    combinations_of,
    largest,
    memberships,
    product_memberships,
    random_theta,
)

# Of the random models one with gains by products of corner weights, and none by pairs of rules.
SEED = 31


def weights(seed: int, rules: ProductRules) -> dict[str, Floats]:
    """Return weights of each premise, (count, corners)."""
    return {
        name: memberships(seed + place, corners, 3000)
        for place, (name, corners) in enumerate(rules.sizes.items())
    }


def values(rules: ProductRules, known: dict[str, Floats]) -> Floats:
    """Return the memberships, (count, rules)."""
    count = min(len(weight) for weight in known.values())
    return product_memberships(rules.corners, [known[name][:count] for name in rules.premises])


@settings(max_examples=12)
@given(st.integers(0, 10_000))
def test_sampled_values_stay_below_every_bound(seed: int) -> None:
    rules = ProductRules(combinations_of(2, 2, 2), ("v", "v", "beta"))
    theta = random_theta(seed, rules.rules, 1)
    known = weights(seed, rules)
    reached = largest(theta, values(rules, known))
    found = [bound(theta, name, corners=rules) for name in ("product", "product-1", "product-4")]

    assert all(reached <= value + 1e-9 for value in found)
    pairs = bound(theta, "wang-tanaka-griffin")
    assert found[2] <= found[1] + 2e-3 <= found[0] + 4e-3 <= pairs + 6e-3
    assert relaxation_size("product", 8, rules).lmis == 5 * 3
    assert relaxation_size("product-2", 8, rules).lmis == 7 * 5


def model_of_two_premises(seed: int, spread: float) -> TSModel:
    """Return two states, one input, four rules over two premises."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((2, 2)) + spread * rng.standard_normal((4, 2, 2))
    B = rng.standard_normal((2, 1)) + spread * rng.standard_normal((4, 2, 1))
    return TSModel(A, B, premises=[Premise("z1", 0, 1), Premise("z2", -1, 1)])


def test_products_find_gains_where_pairs_do_not() -> None:
    model = model_of_two_premises(SEED, 0.7)
    z = np.random.default_rng(0).uniform([[0.0], [-1.0]], [[1.0], [1.0]], (2, 4000))
    h = model.memberships(z).T

    assert blended_rates(model, pdc(model, relaxation="product"), h).min() > 0
    for pairs in ("liu-zhang", "wang-tanaka-griffin"):
        assert not pdc(model, relaxation=pairs).found


@pytest.mark.parametrize(
    ("corners", "premises", "message"),
    [
        ([[0, 0], [0, 1], [1, 0]], (), "3 rules, 3 of them different.*for 4 combinations"),
        ([[0], [0]], (), "2 rules, 1 of them different"),
        ([[1], [2]], (), "2 of them different, least index 1, for 3"),
        ([[0.5], [1.0]], (), "integers"),
        ([0, 1], (), r"\(rules, columns\) are needed"),
        ([[0], [1]], ("a", "b"), "2 premises .a, b. for 1 columns"),
    ],
)
def test_corners_that_are_no_combinations(
    corners: list[list[int]], premises: tuple[str, ...], message: str
) -> None:
    """Memberships that would not sum to 1 are refused, with what is missing."""
    with pytest.raises(ModelError, match=message):
        ProductRules(np.array(corners), premises)


def test_rules_of_a_model() -> None:
    model = model_of_two_premises(0, 0.1)
    rules = product_rules(model)

    assert rules.premises == ("z1", "z2") and rules.rules == 4
    np.testing.assert_array_equal(rules.corners, model.rules)
    with pytest.raises(ModelError, match="has no premises"):
        product_rules(TSModel(model.A, model.B))


def test_double_sums_that_do_not_fit() -> None:
    with pytest.raises(ModelError, match="corners: 4 rules, but there are 3"):
        DoubleSum(rules=3, blocks=(1,), parts=(), corners=combinations_of(2, 2))
    corners = ProductRules(combinations_of(2, 3), ("v", "v"))
    loop = DoubleSum(rules=6, blocks=(1,), parts=(), corners=corners)
    with pytest.raises(ModelError, match="premise v has 2 and 3 corners"):
        relaxation_named("product")(loop)
    M = Unknown("M", 1, 1, count=2)
    with pytest.raises(ModelError, match="the part with M is for 1 x 2 rules, but there are 3"):
        double_sum_of(M.over("j") << 0, rules=3)
