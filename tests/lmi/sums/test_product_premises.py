"""Rules as combinations of corners of premises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import (
    DoubleSum,
    Unknown,
    double_sum_of,
    pdc,
    pdc_condition,
    relaxation_named,
    relaxation_size,
    rigorous_no,
)
from takagi.lmi.condition.evaluate import lmi_value
from takagi.lmi.gains.decay.condition import decay_request
from takagi.lmi.gains.decay.design import decided
from takagi.lmi.gains.requirements.limits import GivenLimits
from takagi.lmi.sums.membership_shape import at_points, number_of_points, points_of
from takagi.models import ModelError, Premise, TSModel
from tests.lmi.known_models import blended_rates, three_rules
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


@settings(max_examples=12)
@given(st.integers(0, 10_000))
def test_sampled_values_stay_below_every_bound(seed: int) -> None:
    """Rules over two premises: higher degrees bound closer, pairs worst."""
    corners = combinations_of(2, 3)
    theta = random_theta(seed, 6, 1)
    weights = [memberships(seed + place, side, 3000) for place, side in enumerate((2, 3))]
    count = min(map(len, weights))
    reached = largest(theta, product_memberships(corners, [known[:count] for known in weights]))
    found = [bound(theta, name, corners=corners) for name in ("product", "product-1", "product-4")]

    assert all(reached <= value + 1e-9 for value in found)
    pairs = bound(theta, "wang-tanaka-griffin")
    assert found[2] <= found[1] + 2e-3 <= found[0] + 4e-3 <= pairs + 6e-3
    assert relaxation_size("product", 6, corners).lmis == 3 * 6
    assert relaxation_size("product-2", 6, corners).lmis == 5 * 15


def model_of_two_premises(seed: int, spread: float) -> TSModel:
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
    ("corners", "message"),
    [
        ([[0, 0], [0, 1], [1, 0]], "3 rules, 3 of them different.*for 4 combinations"),
        ([[0], [0]], "2 rules, 1 of them different"),
        ([[1], [2]], "2 of them different, least index 1, for 3"),
        ([[0.5], [1.0]], "integers"),
        ([0, 1], r"\(rules, premises\) are needed"),
    ],
)
def test_corners_that_are_no_combinations(corners: list[list[int]], message: str) -> None:
    """Memberships that would not sum to 1 are refused, with what is missing."""
    with pytest.raises(ModelError, match=message):
        DoubleSum(rules=len(corners), blocks=(1,), parts=(), corners=np.array(corners))


def test_double_sums_that_do_not_fit() -> None:
    """Corners for another number of rules, products of what is none, members."""
    with pytest.raises(ModelError, match="corners: 4 rules, but there are 3"):
        DoubleSum(rules=3, blocks=(1,), parts=(), corners=combinations_of(2, 2))
    with pytest.raises(ModelError, match="knows of none; give the model premises"):
        relaxation_named("product")(DoubleSum(rules=6, blocks=(1,), parts=()))
    M = Unknown("M", 1, 1, count=2)
    with pytest.raises(ModelError, match="the part with M is for 1 x 2 rules, but there are 3"):
        double_sum_of(M.over("j") << 0, rules=3)


def status_at_blends(model: TSModel, parts: int) -> str:
    task = decay_request(model, GivenLimits(), decay_rate=0.0)
    return decided(task, 0.0, at_points(parts)).outcome.status


@pytest.mark.parametrize(
    ("parts", "limit"), [(6, 6.7682), pytest.param(12, 6.6758, marks=pytest.mark.slow)]
)
def test_what_no_relaxation_exceeds_from_both_sides(parts: int, limit: float) -> None:
    """Kim and Lee (2000): beyond this b blends in steps of 1/parts have no common V.  Our number.

    Polya's of degree 24 reaches b = 5.3676, so the truth lies between.  Just beyond, every
    contradiction is singular with irrational directions: none is shown, and no gains are found.
    """
    assert status_at_blends(three_rules(limit - 5e-3), parts) == "candidate"
    assert status_at_blends(three_rules(limit + 5e-3), parts) != "candidate"
    assert pdc(three_rules(5.36), relaxation="polya-24").found


def test_finer_blends_rule_out_more() -> None:
    """The blends of 1/3 are among those of 1/6; at b = 7 only the latter rule gains out."""
    coarse, fine = points_of(3, None, 3), points_of(3, None, 6)
    among = (np.abs(coarse[:, None] - fine[None]).max(axis=2) < 1e-12).any(axis=1)

    assert among.all()
    assert status_at_blends(three_rules(7.0), 2) == "candidate"
    assert status_at_blends(three_rules(7.0), 6) == "infeasible"


def test_of_two_premises_only_products_are_asked_for() -> None:
    """The mean of opposite corners is not a product: (1/2, 0, 0, 1/2) is not among the blends."""
    rng = np.random.default_rng(0)
    A, B = rng.standard_normal((4, 2, 2)), rng.standard_normal((4, 2, 1))
    plain = pdc_condition(TSModel(A, B), relaxation=at_points(2))
    product = pdc_condition(
        TSModel(A, B, premises=[Premise("z1", 0, 1), Premise("z2", 0, 1)]), relaxation=at_points(2)
    )
    counts = [
        next(lmi.count for lmi in condition.lmis if lmi.name == "blend")
        for condition in (plain, product)
    ]

    assert counts == [10, 9]


@pytest.mark.parametrize(("rules", "parts"), [(2, 6), (3, 4), (5, 2)])
def test_the_number_of_blends_is_known_before_they_are_listed(rules: int, parts: int) -> None:
    """Multisets: (r + parts - 1 choose parts)."""
    assert number_of_points(rules, None, parts) == len(points_of(rules, None, parts))


def test_a_no_of_every_relaxation_is_proved() -> None:
    """At b = 8 exact multipliers at the blends rule out every V = x' P x, whatever the gains."""
    proof = rigorous_no(pdc(three_rules(8.0), relaxation="auto"))

    assert proof is not None and proof.holds and "blend" in proof.multipliers
    assert rigorous_no(pdc(three_rules(2.0), relaxation="auto")) is None


def test_blends_are_memberships_and_products_where_premises_are_known() -> None:
    """All rows sum to 1; of two premises a blend is the product of the weights' shares."""
    free = points_of(3, None, 4)
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    product = points_of(4, corners, 2)

    assert free.shape == (15, 3) and product.shape == (9, 4)
    for h in (free, product):
        np.testing.assert_allclose(h.sum(axis=1), 1.0)
        assert h.min() >= 0 and len(np.unique(h, axis=0)) == len(h)
    np.testing.assert_allclose(product[:, 0] * product[:, 3], product[:, 1] * product[:, 2])


def test_the_condition_at_blends_is_the_blended_one() -> None:
    """9/8 He((A(h) - B(h) K(h)) Q) by hand: nine is three parts squared, eight a power of two."""
    model, rng = three_rules(1.0), np.random.default_rng(0)
    condition = pdc_condition(model, relaxation=at_points(3))
    root = rng.standard_normal((2, 2))
    values = {"Q": (root @ root.T)[None], "M": rng.standard_normal((3, 1, 2))}
    lmi = next(lmi for lmi in condition.lmis if lmi.name == "blend")
    found = lmi_value(lmi, {**values, "nu": np.ones((1, 1, 1))}, condition.parameters)
    h = points_of(3, None, 3)
    A, B, M = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, values["M"]))
    closed = A @ values["Q"] - B @ M

    np.testing.assert_allclose(8 / 9 * found, closed + closed.transpose(0, 2, 1), atol=1e-12)
