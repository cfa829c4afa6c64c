"""Rules as combinations of corners: premises of vertices, gains and filters, shared or not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    DoubleSum,
    ProductRules,
    SumPart,
    Term,
    Unknown,
    decide,
    pdc,
    product_rules,
    relaxation_named,
    relaxation_size,
)
from takagi.lmi.condition import lmi_value
from takagi.lmi.gains.requirements.closed_loop import closed_loop
from takagi.models import ModelError, Premise, TSModel
from tests.lmi.sums.known import (
    bound,
    combinations_of,
    largest,
    memberships,
    product_memberships,
    random_theta,
)

Floats = NDArray[np.float64]


def rules_over(**sides: int) -> ProductRules:
    """Return the combinations of the named premises' corners."""
    return ProductRules(combinations_of(*sides.values()), tuple(sides))


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
def test_gains_over_other_premises_than_the_vertices(seed: int) -> None:
    """Vertices over (omega, v), gains over (v, beta): sampled values stay below every bound.

    The shared premise counts once: as two of its own the bound is never smaller.
    """
    vertices, gains = rules_over(omega=2, v=2), rules_over(v=2, beta=3)
    theta = random_theta(seed, vertices.rules, 1, gains.rules)
    known = weights(seed, vertices.crossed(gains))
    reached = largest(theta, values(vertices, known), values(gains, known))
    found = [
        bound(theta, name, corners=vertices, gain_corners=gains)
        for name in ("product", "product-1", "product-4")
    ]
    apart = ProductRules(gains.corners, ("other v", "beta"))
    separate = bound(theta, "product", corners=vertices, gain_corners=apart)
    unknown = bound(theta, "product")

    assert all(reached <= value + 1e-9 for value in found)
    assert found[2] <= found[1] + 2e-3 <= found[0] + 4e-3 <= separate + 6e-3
    assert unknown == pytest.approx(separate, abs=2e-3)
    assert separate == pytest.approx(float(theta.max()), abs=2e-3)


def test_a_premise_of_three_factors_is_of_degree_three() -> None:
    """Plant over (omega, v), filter over (omega, T), gains over (omega, beta, v).

    omega is a factor three times, v twice, T and beta once: 4 * 3 * 2 * 2 coefficients in the
    place of the 4 * 4 * 8 products of three separate sums.
    """
    plant, filtered = rules_over(omega=2, v=2), rules_over(omega=2, T=2)
    gains = rules_over(omega=2, beta=2, v=2)
    vertices = plant.crossed(filtered)
    theta = random_theta(2, vertices.rules, 2, gains.rules)
    known = weights(2, vertices.crossed(gains))
    reached = largest(theta, values(vertices, known), values(gains, known))
    size = relaxation_size("product", 16, vertices, gain_corners=gains)
    largest_alone = float(np.linalg.eigvalsh(theta)[..., -1].max())

    assert size.lmis == 4 * 3 * 2 * 2
    assert relaxation_size("product-2", 16, vertices, gain_corners=gains).lmis == 6 * 5 * 4 * 4
    bounds = [
        bound(theta, f"product-{degree}", corners=vertices, gain_corners=gains)
        for degree in (0, 1, 3)
    ]
    assert reached <= bounds[2] + 1e-9
    assert bounds[2] < bounds[1] < bounds[0] < largest_alone
    np.testing.assert_array_equal(vertices.corners[5], [*plant.corners[1], *filtered.corners[1]])


def test_a_law_over_fewer_premises_rides_on_the_other() -> None:
    """Torque law over v, pitch law over (v, beta): one sum, its gain index the larger set.

    A torque rule's membership is the sum of those pitch rules' that agree with it in v, so its
    member is looked up by the pitch rule.  The coefficients, expanded, give back the triple sum.
    """
    rng = np.random.default_rng(3)
    vertices, gains = rules_over(v=2), rules_over(v=2, beta=2)
    torque, pitch = Unknown("torque", 1, 1, count=2), Unknown("pitch", 1, 1, count=4)
    a, b = rng.standard_normal((2, 2, 1, 1))
    one = np.ones((1, 1, 1))
    parts = (
        SumPart(
            unknown=torque,
            left=a,
            right=one,
            member=np.broadcast_to(gains.corners[:, 0], (2, 4)),
        ),
        SumPart(unknown=pitch, left=b, right=one, member="gain"),
    )
    loop = DoubleSum(rules=2, blocks=(1,), parts=parts, corners=vertices, gain_corners=gains)
    (lmi,) = relaxation_named("product")(loop)[1]
    t, p = rng.standard_normal((2, 1, 1)), rng.standard_normal((4, 1, 1))
    items = lmi_value(lmi, {"torque": t, "pitch": p}, {})[:, 0, 0]
    known = weights(4, gains)
    v, beta = known["v"], known["beta"][: len(known["v"])]
    # (v_1 + v_2)^2 has the orderings 1, 2, 1; beta is of degree one.
    squares = np.stack([v[:, 0] ** 2, 2 * v[:, 0] * v[:, 1], v[:, 1] ** 2], axis=1)
    expanded = np.einsum("ta,tb->tab", squares, beta).reshape(len(v), -1) @ items
    direct = (v @ a[:, 0, 0]) * (v @ t[:, 0, 0])
    direct += (v @ b[:, 0, 0]) * (values(gains, known) @ p[:, 0, 0])

    np.testing.assert_allclose(expanded, direct, atol=1e-12)


def model_of_two_premises(seed: int, spread: float) -> TSModel:
    """Return two states, one input, four rules over two premises."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((2, 2)) + spread * rng.standard_normal((4, 2, 2))
    B = rng.standard_normal((2, 1)) + spread * rng.standard_normal((4, 2, 1))
    return TSModel(A, B, premises=[Premise("z1", 0, 1), Premise("z2", -1, 1)])


def rates(model: TSModel, K: Floats, P: Floats, h: Floats) -> Floats:
    """Return -1/2 lambda_max(P^-1 He(P (A(h) - B(h) K(h))))."""
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    L = np.linalg.cholesky(P)
    inside = np.linalg.solve(L, (A - B @ K).transpose(0, 2, 1) @ L)
    return np.asarray(-np.linalg.eigvalsh(inside + inside.transpose(0, 2, 1))[:, -1] / 2)


def separating_model() -> TSModel:
    """Return a model with gains by products of corner weights, and none by pairs of rules."""
    for seed in range(100):
        model = model_of_two_premises(seed, 0.7)
        if pdc(model, relaxation="product").found and not pdc(model, relaxation="liu-zhang").found:
            return model
    raise AssertionError("no seed separates")


def test_products_find_gains_where_pairs_do_not() -> None:
    """The gains decay at all product memberships; Liu and Zhang's pairs find none."""
    model = separating_model()
    K, P = pdc(model, relaxation="product").require()
    z = np.random.default_rng(0).uniform([[0.0], [-1.0]], [[1.0], [1.0]], (2, 4000))
    h = model.memberships(z).T

    assert rates(model, K, P, h).min() > 0
    assert pdc(model, relaxation="wang-tanaka-griffin").status == "infeasible"


def solved(loop: DoubleSum, Q: Unknown, M: Unknown, relaxation: str) -> tuple[Floats, Floats]:
    """Return the members of K, and P, that the relaxation finds."""
    _, posed = relaxation_named(relaxation)(loop)
    one = np.eye(Q.rows)[None]
    term = Term(unknown=Q, left=one, right=one)
    positive = LMI(name="positive", blocks=(Q.rows,), terms=(term,))
    constant = (Constant(value=-one),)
    scale = LMI(
        name="scale", blocks=(Q.rows,), terms=(term,), constants=constant, sign=-1, strict=False
    )
    condition = Condition(
        name="gains",
        unknowns=(Q, M),
        lmis=(positive, scale, *posed),
        parameters={"alpha": 0.0},
    )
    outcome = decide(condition)
    assert outcome.status == "candidate"
    P = np.linalg.inv(outcome.values["Q"][0])
    return outcome.values["M"] @ P, P


def test_gains_may_follow_one_premise_only() -> None:
    """Gains over z1 alone: closed_loop with gain_corners; decay at all values of both premises."""
    model = model_of_two_premises(4, 0.3)
    vertices = product_rules(model)
    gains = ProductRules(np.arange(2)[:, None], ("z1",))
    Q = Unknown("Q", 2, 2, symmetric=True)
    M = Unknown("M", 1, 2, count=2)
    loop = closed_loop(model.A, model.B, Q, M, weight=1.0, corners=vertices, gain_corners=gains)
    K, P = solved(loop, Q, M, "product-1")

    assert relaxation_named("product-1")(loop)[1][0].count == 4 * 3
    z = np.random.default_rng(1).uniform([[0.0], [-1.0]], [[1.0], [1.0]], (2, 4000))
    h = model.memberships(z).T
    assert rates(model, K[vertices.corners[:, 0]], P, h).min() > 0


def test_a_filter_over_a_shared_premise() -> None:
    """x' = A(z1, z2) x - B(z1, z2) F(z1) K(z1, z2) x: a triple sum, of degree 3 in z1's weights.

    As three sums of their own it has 4 * 2 * 4 inequalities, and asks for more.
    """
    model = model_of_two_premises(4, 0.3)
    plant = product_rules(model)
    F = np.array([1.0, 0.4])
    vertices = plant.crossed(ProductRules(np.arange(2)[:, None], ("z1",)))
    A, B = np.repeat(model.A, 2, axis=0), (model.B[:, None] * F[:, None, None]).reshape(8, 2, 1)
    Q = Unknown("Q", 2, 2, symmetric=True)
    M = Unknown("M", 1, 2, count=4)
    loop = closed_loop(A, B, Q, M, weight=1.0, corners=vertices, gain_corners=plant)
    K, P = solved(loop, Q, M, "product")

    assert relaxation_named("product")(loop)[1][0].count == 4 * 3
    z = np.random.default_rng(1).uniform([[0.0], [-1.0]], [[1.0], [1.0]], (2, 4000))
    h = model.memberships(z).T
    filtered = np.stack([1 - z[0], z[0]], axis=1) @ F
    G = np.tensordot(h, model.A, axes=1)
    G -= (np.tensordot(h, model.B, axes=1) * filtered[:, None, None]) @ np.tensordot(h, K, axes=1)
    V = P @ G
    assert np.linalg.eigvalsh(V + V.transpose(0, 2, 1)).max() < 0


@pytest.mark.parametrize("name", ["wang-tanaka-griffin", "tuan", "tanaka-wang", "kim-lee"])
def test_pairs_of_unlike_rules_are_refused(name: str) -> None:
    """Relaxations by pairs need one set of rules; the message says which to take."""
    loop = DoubleSum(rules=2, blocks=(1,), parts=(), gain_rules=3)

    for refused in (name, "liu-zhang", "polya-1", "product-liu-zhang"):
        with pytest.raises(ModelError, match='there are 2 and 3 .*take "product"'):
            relaxation_named(refused)(loop)


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
    """A model's premises name the columns; a model without any is refused."""
    model = model_of_two_premises(0, 0.1)
    rules = product_rules(model)

    assert rules.premises == ("z1", "z2") and rules.rules == 4
    np.testing.assert_array_equal(rules.corners, model.rules)
    with pytest.raises(ModelError, match="has no premises"):
        product_rules(TSModel(model.A, model.B))


def test_double_sums_that_do_not_fit() -> None:
    """Corners for another number of rules, one premise with two numbers of corners, members."""
    with pytest.raises(ModelError, match="corners of the vertices: 4 rules, but there are 3"):
        DoubleSum(rules=3, blocks=(1,), parts=(), corners=combinations_of(2, 2))
    loop = DoubleSum(
        rules=2,
        blocks=(1,),
        parts=(),
        corners=rules_over(v=2),
        gain_corners=rules_over(v=3),
    )
    with pytest.raises(ModelError, match="premise v has 2 and 3 corners"):
        relaxation_named("product")(loop)
    M = Unknown("M", 1, 1, count=2)
    one = np.ones((1, 1, 1))
    part = SumPart(unknown=M, left=one, right=one, member="gain")
    with pytest.raises(ModelError, match="M has 2 members for 3 rules"):
        DoubleSum(rules=3, blocks=(1,), parts=(part,))
