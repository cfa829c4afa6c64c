"""Knowledge of the memberships: bounds on products, rules that act together, quadratic forms."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray

from takagi.lmi import (
    ProductRules,
    pdc,
    product_bounds,
    relaxation_named,
    relaxation_size,
    with_overlap,
    with_shape,
)
from takagi.models import ModelError
from tests.lmi.known_models import three_rules
from tests.lmi.sums.known import (
    bound,
    combinations_of,
    known_sum,
    largest,
    least,
    memberships,
    product_memberships,
    random_theta,
)

Floats = NDArray[np.float64]
NEAR = 2e-3


def shaped(theta: Floats, relaxation: str, bounds: ArrayLike, **known: object) -> float:
    """Return the relaxation's upper bound where h_i h_j <= bounds."""
    loop, s = known_sum(theta, **known)
    changed, unknowns, lmis = with_overlap(loop, bounds)
    return least(changed, s, relaxation, unknowns, lmis)


@pytest.mark.parametrize("b", [0.25, 0.1, 0.02])
@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "tuan", "liu-zhang", "polya-1"])
def test_two_numbers_from_both_sides(b: float, relaxation: str) -> None:
    """-h1^2 - h2^2 + 2 c h1 h2 = -1 + 2 (1 + c) h1 h2 is at most 0 where h1 h2 <= b iff c is <= c*.

    c* = 1 / (2 b) - 1, and the multiplier loses nothing: N = 1 / b.
    """
    limit = 1 / (2 * b) - 1
    bounds = np.array([[np.inf, b], [b, np.inf]])
    for c, negative in ((0.98 * limit, True), (1.02 * limit, False)):
        theta = np.array([[-1.0, c], [c, -1.0]])[:, :, None, None]
        assert (shaped(theta, relaxation, bounds) < 0) is negative
        # Without the knowledge only c < 1 will do.
        assert (bound(theta, "liu-zhang") < 0) is (c < 1)


def kept(h: Floats, bounds: Floats) -> Floats:
    """Return the memberships that keep the bounds."""
    return h[(h[:, :, None] * h[:, None, :] <= bounds).all(axis=(1, 2))]


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.integers(2, 4), st.integers(1, 2))
@pytest.mark.slow
def test_bounds_hold_for_memberships_that_keep_them(seed: int, rules: int, size: int) -> None:
    """Sampled memberships within the bounds stay below; knowing more is never worse."""
    rng = np.random.default_rng(seed)
    theta = random_theta(seed, rules, size)
    tight = rng.uniform(0.02, 0.3, (rules, rules))
    tight = np.triu(tight, 1) + np.triu(tight, 1).T + np.diag(rng.uniform(0.6, 1.1, rules))
    loose = 1.5 * tight
    h = memberships(seed, rules, 20_000)
    relaxations = ("wang-tanaka-griffin", "tanaka-wang", "liu-zhang", "polya-1")
    for name in relaxations:
        found = [shaped(theta, name, tight), shaped(theta, name, loose), bound(theta, name)]
        for value, bounds in zip(found, (tight, loose, np.ones((rules, rules))), strict=True):
            inside = kept(h, bounds)
            assert len(inside) > 10
            assert largest(theta, inside) <= value + 1e-9
        assert found[0] <= found[1] + NEAR <= found[2] + 2 * NEAR, name


def test_diagonal_bounds_keep_a_rule_from_acting_alone() -> None:
    """h_1^2 <= 1/4 with r = 2: 0.9 h1^2 - h2^2 is negative, though Theta_11 is positive."""
    theta = np.array([[0.9, 0.0], [0.0, -1.0]])[:, :, None, None]
    bounds = np.array([[Fraction(1, 4), np.inf], [np.inf, 1]], dtype=object)

    # At h = (1/2, 1/2) the value is -0.025.
    assert -0.025 - 1e-9 <= shaped(theta, "liu-zhang", bounds) < 0
    assert bound(theta, "liu-zhang") > 0.89


def test_rules_that_never_act_together_need_no_inequality() -> None:
    """A bound 0 drops the pair: as many LMIs fewer, whatever stands in its Theta."""
    theta = random_theta(0, 4, 1)
    theta[0, 3] = theta[3, 0] = 1e6
    bounds = np.full((4, 4), np.inf)
    bounds[0, 3] = bounds[3, 0] = 0
    loop, s = known_sum(theta)
    changed, unknowns, lmis = with_overlap(loop, bounds)

    assert unknowns == () and lmis == ()
    h = memberships(0, 4)
    h = h[h[:, 0] * h[:, 3] == 0]
    faces = memberships(1, 3)
    h = np.concatenate([h, np.insert(faces, 3, 0, axis=1), np.insert(faces, 0, 0, axis=1)])
    for name in ("wang-tanaka-griffin", "tuan", "tanaka-wang", "kim-lee", "liu-zhang", "polya-2"):
        found = least(changed, s, name)
        assert largest(theta, h) <= found + 1e-9
        assert found < 100 < bound(theta, name)
        count = sum(lmi.count for lmi in relaxation_named(name)(changed)[1])
        assert count < relaxation_size(name, 4).lmis
        assert count <= relaxation_size(name, 4, active=bounds > 0).lmis


@pytest.mark.slow
@settings(max_examples=25)
@given(st.integers(0, 10_000))
def test_few_rules_act_at_a_time(seed: int) -> None:
    """With two of four rules active: sound on every edge, and never worse than without."""
    theta = random_theta(seed, 4, 2)
    loop, s = known_sum(theta)
    changed, _, _ = with_overlap(loop, active_rules=2)
    edges = np.zeros((0, 4))
    for first, second in zip(*np.triu_indices(4, 1), strict=True):
        edge = np.zeros((500, 4))
        edge[:, first] = np.linspace(0, 1, 500)
        edge[:, second] = 1 - edge[:, first]
        edges = np.concatenate([edges, edge])
    reached = largest(theta, edges)
    for name in ("tuan", "tanaka-wang", "polya-1", "polya-4"):
        found = least(changed, s, name)
        assert reached <= found + 1e-9
        assert found <= bound(theta, name) + NEAR


def test_three_active_rules_break_what_is_promised_of_two() -> None:
    """The knowledge is used: where it is wrong, the sum exceeds the bound."""
    theta = (1.8 * np.ones((3, 3)) - 2.8 * np.eye(3))[:, :, None, None]
    loop, s = known_sum(theta)
    third = np.full((1, 3), 1 / 3)

    for name in ("tanaka-wang", "tuan"):
        told = least(with_overlap(loop, active_rules=2)[0], s, name)
        assert told < largest(theta, third) - 0.1
        assert bound(theta, name) > largest(theta, third) - 1e-6
    assert least(with_overlap(loop, active_rules=1)[0], s, "polya-2") == pytest.approx(-1, abs=NEAR)


def test_bounds_of_product_memberships_are_reached() -> None:
    """A quarter for each premise that differs; exact, and attained by weights one half."""
    rules = ProductRules(combinations_of(2, 3))
    b = product_bounds(rules)
    half = [np.array([[0.5, 0.5]]), np.array([[0.5, 0.5, 0.0]])]
    h = product_memberships(rules.corners, half)[0]

    assert b[0, 0] == 1 and b[0, 1] == Fraction(1, 4) and b[0, 4] == Fraction(1, 16)
    assert all(type(entry) is Fraction for entry in b.flat)
    assert h[0] * h[4] == b[0, 4]
    weights = [memberships(0, 2), memberships(1, 3)]
    products = product_memberships(rules.corners, weights)
    largest_products = (products[:, :, None] * products[:, None, :]).max(axis=0)
    assert (largest_products <= b.astype(float) + 1e-15).all()


def test_bounds_of_a_premise_that_is_a_factor_twice() -> None:
    """h_i = w_a w_b of one premise: w_1^3 w_2 is at most 27 / 256, at w = (3/4, 1/4)."""
    rules = ProductRules(combinations_of(2, 2), ("omega", "omega"))
    b = product_bounds(rules)

    assert b[0, 1] == Fraction(27, 256) and b[0, 3] == b[1, 1] == Fraction(1, 16)


@settings(max_examples=15)
@given(st.integers(0, 10_000))
def test_forms_of_memberships(seed: int) -> None:
    """h_1 >= 2 h_2 as forms h_l (h_1 - 2 h_2) >= 0: sound where it holds, never worse."""
    theta = random_theta(seed, 3, 1)
    a = np.array([1.0, -2.0, 0.0])
    forms = np.stack([(np.outer(a, e) + np.outer(e, a)) / 2 for e in np.eye(3)])
    loop, s = known_sum(theta)
    changed, unknowns, lmis = with_shape(loop, forms)
    h = memberships(seed, 3)
    h = np.concatenate([h[h @ a >= 0], [[2 / 3, 1 / 3, 0], [1, 0, 0], [0, 0, 1]]])
    for name in ("wang-tanaka-griffin", "liu-zhang"):
        found = least(changed, s, name, unknowns, lmis)
        assert largest(theta, h) <= found + 1e-9
        assert found <= bound(theta, name) + NEAR
    theta = -np.eye(3)[:, :, None, None]
    theta[1, 1] = 3.0
    loop, s = known_sum(theta)
    # At h = (2, 1, 0) / 3 the value is -1/9.
    changed, unknowns, lmis = with_shape(loop, forms)
    assert -1 / 9 - 1e-9 <= least(changed, s, "liu-zhang", unknowns, lmis) < 0


@pytest.mark.parametrize(
    ("relaxation", "b", "known"),
    [
        ("wang-tanaka-griffin", 0.0, {"overlap": 0.1}),
        ("tanaka-wang", 0.0, {"active_rules": 2}),
        ("liu-zhang", 3.0, {"overlap": 0.1}),
        ("polya-1", 8.0, {"overlap": 0.02}),
    ],
)
def test_gains_for_memberships_that_overlap_little(
    relaxation: str, b: float, known: dict[str, float]
) -> None:
    """There are gains for such memberships where there are none for all; they decay for them."""
    model, bounds, h = three_rules(b), np.full((3, 3), np.inf), memberships(0, 3, 40_000)
    if "overlap" in known:
        bounds[~np.eye(3, dtype=bool)] = known["overlap"]
        K, P = pdc(model, relaxation=relaxation, overlap=bounds).require()
        h = kept(h, bounds)
    else:
        K, P = pdc(model, relaxation=relaxation, active_rules=2).require()
        h = np.concatenate([np.insert(memberships(1, 2), k, 0, axis=1) for k in range(3)])
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    V = P @ (A - B @ K)

    assert len(h) > 100
    assert np.linalg.eigvalsh(V + V.transpose(0, 2, 1)).max() < 0
    assert not pdc(model, relaxation=relaxation).found


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ([[1.0, 0.1]], r"shape \(1, 2\); \(2, 2\) is needed"),
        ([[1.0, -0.1], [-0.1, 1.0]], r"bounds\[0, 1\] is -0.1; 0 or more"),
        ([[1.0, np.nan], [0.1, 1.0]], r"bounds\[0, 1\] is nan"),
        ([[1.0, 0.2], [0.1, 1.0]], r"not symmetric: \[0, 1\] is 0.2, \[1, 0\] is 0.1"),
        ([[0.2, 0.1], [0.1, 0.2]], "sum to 0.6, but the products h_i h_j to 1"),
        ([[0.0, 0.25], [0.25, 1.0]], "rule 1 never acts; leave it out"),
        ([["a", "b"], ["c", "d"]], "cannot be read as a matrix of numbers"),
    ],
)
def test_bounds_that_make_no_sense(bounds: list[list[float]], message: str) -> None:
    """What was given, what is needed."""
    loop, _ = known_sum(random_theta(0, 2, 1))

    with pytest.raises(ModelError, match=message):
        with_overlap(loop, bounds)


def test_other_knowledge_that_makes_no_sense() -> None:
    """Numbers of rules, and forms."""
    loop, _ = known_sum(random_theta(0, 2, 1))
    with pytest.raises(ModelError, match="active_rules is 3; 1 ... 2 rules"):
        with_overlap(loop, active_rules=3)
    with pytest.raises(ModelError, match="forms are not symmetric"):
        with_shape(loop, [[[0.0, 1.0], [0.0, 0.0]]])
    with pytest.raises(ModelError, match=r"forms have shape \(2, 2\)"):
        with_shape(loop, np.eye(2))
    with pytest.raises(ModelError, match="symmetric, with every rule active by itself"):
        replace(loop, active=np.array([[True, False], [True, True]]))
