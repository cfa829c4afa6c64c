"""Rule reduction: the proved error holds everywhere, and nothing is lost for nothing."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import prod

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import (
    Domain,
    Interval,
    ModelError,
    Plant,
    Premise,
    ReducedModel,
    TSModel,
    load_model,
    mode_spectrum,
    reduce_rules,
    sector_model,
)
from takagi.models.intervals import exact
from takagi.models.reduction.reduced_model import bounded_reduction
from takagi.models.reduction.rule_tensor import rule_tensor


def plant(name: str) -> Plant:
    """Return a built-in plant."""
    found = load_model(name)
    assert isinstance(found, Plant)
    return found


def blended(model: TSModel, h: np.ndarray) -> np.ndarray:
    """Return [A B E; C D 0] at memberships h (r, points), (points, n + p, n + m + q)."""
    q = model.E.shape[2]
    corner = np.zeros((len(model.A), model.C.shape[1], q))
    stacks = np.concatenate(
        (
            np.concatenate((model.A, model.B, model.E), axis=2),
            np.concatenate((model.C, model.D, corner), axis=2),
        ),
        axis=1,
    )
    return np.tensordot(h.T, stacks, axes=1)


def random_model(seed: int, premises: int) -> TSModel:
    """Return a model whose entries are multi-affine in the premises, of mixed importance."""
    chance = np.random.default_rng(seed)
    z = np.array(list(product((-1.0, 1.0), repeat=premises)))
    terms = np.concatenate([np.ones((len(z), 1)), z, z[:, :1] * z[:, -1:]], axis=1)
    size = 10.0 ** chance.integers(-3, 1, size=(terms.shape[1], 1))

    def stack(rows: int, columns: int) -> np.ndarray:
        entries = terms @ (size * chance.normal(size=(terms.shape[1], rows * columns)))
        return np.round(entries, 5).reshape(-1, rows, columns)

    return TSModel(
        stack(2, 2),
        stack(2, 1),
        C=stack(1, 2),
        E=stack(2, 1),
        premises=[Premise(f"z{k}", -1, 1) for k in range(premises)],
    )


def exact_error(reduced: ReducedModel) -> Fraction:
    """Return the largest squared Frobenius error at a vertex, once more and in Fractions alone."""
    original, model = reduced.original, reduced.model
    shares = [
        [
            prod(exact(float(f[c, j])) for f, c, j in zip(reduced.factors, at, rule, strict=True))
            for rule in product(*(range(f.shape[1]) for f in reduced.factors))
        ]
        for at in reduced.corners
    ]
    worst = Fraction(0)
    for i, weights in enumerate(shares):
        assert sum(weights) == 1
        squared = Fraction(0)
        for letter in "ABCDE":
            whole, few = getattr(original, letter), getattr(model, letter)
            for row, column in np.ndindex(whole.shape[1:]):
                near = sum(
                    (
                        w * exact(float(r))
                        for w, r in zip(weights, few[:, row, column], strict=True)
                    ),
                    Fraction(0),
                )
                squared += (exact(float(whole[i, row, column])) - near) ** 2
        worst = max(worst, squared)
    return worst


@given(
    seed=st.integers(0, 10**6),
    premises=st.integers(1, 4),
    digits=st.integers(-3, 1),
    joint=st.booleans(),
)
def test_the_reduced_model_and_its_error_contain_the_original(
    seed: int, premises: int, digits: int, joint: bool
) -> None:
    """At random points of the box |S(h) - S_reduced(g)| <= error <= tolerance, g convex."""
    model = random_model(seed, premises)
    names = [premise.name for premise in model.premises]
    reduced = reduce_rules(model, Fraction(10) ** digits, together=[names] if joint else ())
    z = np.random.default_rng(seed).uniform(-1, 1, size=(premises, 40))

    h, g = model.memberships(z), reduced.memberships(z)
    gaps = np.linalg.norm(blended(model, h) - blended(reduced.model, g), axis=(1, 2))

    assert np.all(g >= 0)
    assert np.allclose(g.sum(axis=0), 1)
    assert gaps.max() <= float(reduced.error.size) + 1e-9
    assert reduced.error.size <= Fraction(10) ** digits
    assert len(reduced.model.rules) <= len(model.rules)


@given(seed=st.integers(0, 10**4), joint=st.booleans())
def test_the_error_is_that_of_fractions_computed_another_way(seed: int, joint: bool) -> None:
    model = random_model(seed, 2)
    reduced = reduce_rules(model, 1, together=[("z0", "z1")] if joint else ())

    squared = exact_error(reduced)

    assert squared <= reduced.error.size**2
    assert float(reduced.error.size) == pytest.approx(float(squared) ** 0.5, rel=1e-12)


def test_the_error_is_at_most_the_root_of_the_discarded_singular_values() -> None:
    """De Lathauwer, De Moor, Vandewalle (2000), property 10: |T - T'|^2 <= sum of discarded s^2."""
    model = random_model(5, 3)
    tensor = rule_tensor(model)
    reduced = reduce_rules(model, 1)
    discarded = [
        tensor.directions(axis)[1]
        for axis, factor in enumerate(reduced.factors)
        if factor.shape[1] == 1
    ]

    assert discarded
    bound = np.sqrt(sum(float((s**2).sum()) for s in discarded))
    assert float(reduced.error.size) <= bound


def test_the_spectrum_tells_what_a_mode_weighs() -> None:
    """Half the difference 2 and half the difference 0.6, on two corners and two of the other."""
    A = np.array([[[-5 - z1 - 0.3 * z2]] for z1 in (-1, 1) for z2 in (-1, 1)])
    model = TSModel(A, premises=[Premise("z1", -1, 1), Premise("z2", -1, 1)])

    alone, joint = mode_spectrum(model), mode_spectrum(model, [("z1", "z2")])

    assert alone[("z1",)] == pytest.approx([2])
    assert alone[("z2",)] == pytest.approx([0.6])
    assert joint[("z1", "z2")] == pytest.approx([(4 + 0.36) ** 0.5])


def test_a_premise_of_no_effect_costs_nothing() -> None:
    """z2 does nothing: four rules become two, with error 0 at tolerance 0."""
    A = np.array([[[-1.25 - z]] for z in (0.1, 0.7) for _ in range(2)])
    model = TSModel(A, premises=[Premise("z1", "0.1", "0.7"), Premise("z2", 0, 1)])

    reduced = reduce_rules(model, 0)

    assert reduced.error.size == 0
    assert [premise.name for premise in reduced.model.premises] == ["z1"]
    assert np.array_equal(reduced.model.A[:, 0, 0], [-1.35, -1.95])
    assert reduced.error.blocks() == reduced.error.blocks("whole") == ()


def test_two_premises_that_act_as_one_need_two_rules() -> None:
    """Only z1 + 2 z2 matters: together they are one direction, each by itself is not."""
    A = np.array([[[-5 - z1 - 2 * z2]] for z1 in (0.0, 1.0) for z2 in (0.0, 1.0)])
    model = TSModel(A, premises=[Premise("z1", 0, 1), Premise("z2", 0, 1)])

    alone, joint = reduce_rules(model, "0.1"), reduce_rules(model, "0.1", together=[("z1", "z2")])

    assert len(alone.model.rules) == 4
    assert sorted(joint.model.A[:, 0, 0]) == pytest.approx([-8, -5])
    assert joint.error.size < Fraction(1, 10**10)
    assert [premise.name for premise in joint.model.premises] == ["share1"]


def test_premises_that_enter_affinely_need_one_rule_more_than_their_number() -> None:
    """mass_spring_damper: 3 rules in the place of 4, without error, around the rectangle."""
    model = sector_model(plant("mass_spring_damper"))

    reduced = reduce_rules(model, 0, together=[("z1", "z2")])

    assert (len(model.rules), len(reduced.model.rules)) == (4, 3)
    assert reduced.error.size == 0
    assert reduced.model.premises == ()


def test_the_pendulum_on_a_cart_needs_four_of_its_sixteen_rules() -> None:
    """Three entries vary, so four vertices surround all sixteen."""
    model = sector_model(plant("cart_pole"))
    names = [premise.name for premise in model.premises]

    reduced = reduce_rules(model, "1e-9", together=[names])

    assert (len(model.rules), len(reduced.model.rules)) == (16, 4)
    assert 0 < reduced.error.size < Fraction(1, 10**9)


def test_a_shared_premise_is_evaluated_at_operating_points() -> None:
    """g of the reduced model's own premise is shares @ h of the original."""
    model = sector_model(plant("cart_pole"))
    names = [premise.name for premise in model.premises]
    reduced = reduce_rules(model, 1, together=[names])
    point = {"angle": 0.8, "rate": -1.5}

    own = reduced.model.memberships(reduced.model.premise_values(**point))

    assert len(reduced.model.rules) == 2
    assert own == pytest.approx(reduced.memberships(model.premise_values(**point)), abs=1e-12)


def test_a_model_without_premises_is_one_mode() -> None:
    """Six vertices on a line: two rules, the ends."""
    A = np.array([[[-1.0 - t, 0.5 * t], [0.0, -1.0]] for t in (0, 0.25, 0.5, 0.6, 0.9, 1)])

    reduced = reduce_rules(TSModel(A), "1e-9")

    assert sorted(reduced.model.A[:, 0, 0]) == pytest.approx([-2, -1])
    assert reduced.shares.shape == (2, 6)


def test_rules_in_another_order_and_a_constant_premise() -> None:
    premises = [Premise("z1", 0, 1), Premise("c", 3, 3), Premise("z2", 0, "0.001")]
    rules = [(1, 0, 1), (0, 0, 0), (1, 0, 0), (0, 0, 1)]
    A = np.array([[[-1.0 - z1 - (0.0, 0.001)[z2]]] for z1, _, z2 in rules])
    model = TSModel(A, premises=premises, rules=rules)

    reduced = reduce_rules(model, "0.0005")

    assert reduced.error.size == Fraction(1, 2000)
    h = model.memberships(z1=0.3, c=3, z2=0.0002)
    blend = float(reduced.shares @ h @ reduced.model.A[:, 0, 0])
    assert blend == pytest.approx(-1.3005)


def test_a_flipped_sign_in_the_core_is_in_the_error() -> None:
    """The error is about what is handed out, whoever made it."""
    model = random_model(1, 2)
    tensor = rule_tensor(model)
    core = tensor.values.copy()
    core[0, 1, 0] *= -1

    broken = bounded_reduction(model, tensor, [np.eye(2), np.eye(2)], core)

    assert float(broken.error.size) == pytest.approx(2 * abs(tensor.values[0, 1, 0]))


def test_weights_that_are_not_convex_are_refused() -> None:
    model = random_model(1, 1)
    tensor = rule_tensor(model)

    with pytest.raises(ModelError, match="not convex sums"):
        bounded_reduction(model, tensor, [np.array([[1.1, -0.1], [0, 1]])], tensor.values)


def test_what_is_said_of_the_model_is_kept() -> None:
    """Names, box and sample time; a box that holds in part only is not claimed as a whole."""
    part = Domain.of_box({sp.Symbol("x1"): Interval.of(0, 1)})
    A = [[[-0.5]], [[-0.501]]]

    def reduced(domain: Domain | None) -> TSModel:
        premise = Premise("z", 0, 1, domain=domain)
        box = {"x1 [-]": (0, 2)}
        model = TSModel(A, premises=[premise], box=box, sample_time=0.1, name="m", source="s")
        return reduce_rules(model, 1).model

    assert (reduced(None).sample_time, reduced(None).name) == (0.1, "m")
    assert reduced(None).source == "s; 1 rules in the place of 2, Frobenius error 0.0005"
    assert dict(reduced(None).box) == {"x1 [-]": (Fraction(0), Fraction(2))}
    assert dict(reduced(part).box) == {}


def test_sampled_bounds_are_refused() -> None:
    """A model without that premise could not say that nothing is proved with it."""
    model = TSModel([[[-1.0]], [[-2.0]]], premises=[Premise("z", 0, 1, sampled=True)])

    with pytest.raises(ModelError, match="z has sampled bounds"):
        reduce_rules(model, 1)


@pytest.mark.parametrize(
    ("together", "message"),
    [([("z0", "z9")], "names z9"), ([("z0",), ("z0", "z1")], "names z0")],
)
def test_premises_that_are_unknown_or_named_twice_are_refused(
    together: list[tuple[str, ...]], message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        reduce_rules(random_model(1, 2), 1, together=together)


def test_a_negative_tolerance_and_gains_of_another_model_are_refused() -> None:
    model = random_model(1, 2)

    with pytest.raises(ModelError, match="at least 0"):
        reduce_rules(model, -1)
    with pytest.raises(ModelError, match="one for each rule"):
        reduce_rules(model, 0).expanded(np.zeros((3, 1, 2)))
