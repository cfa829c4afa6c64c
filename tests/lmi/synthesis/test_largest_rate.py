"""The largest decay rate by gains that are bounded: closed forms, both sides, what it shows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import pdc
from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.models import TSModel
from tests.lmi.known_models import pendulum


def random_model(seed: int, step: float | None) -> TSModel:
    rng = np.random.default_rng(seed)
    A = 0.7 * rng.standard_normal((3, 3)) + 0.2 * rng.standard_normal((2, 3, 3))
    B = rng.standard_normal((3, 2)) + 0.2 * rng.standard_normal((2, 3, 2))
    return TSModel(A, B, sample_time=step)


@pytest.mark.parametrize(("a", "b", "bound"), [(1.0, 2.0, 5.0), (-3.0, 0.5, 1.0), (0.0, 1.0, 0.1)])
def test_a_scalar_reaches_what_its_largest_gain_gives(a: float, b: float, bound: float) -> None:
    """x' = a x + b u with |K| <= g: the largest rate is b g - a."""
    design = pdc(TSModel([[[a]]], [[[b]]]), decay_rate="max", gain_bound=bound)

    assert design.decay_rate == pytest.approx(b * bound - a, rel=2e-4)
    assert design.decay_rate < b * bound - a <= design.answer.bound * (1 + 1e-6)


def test_an_input_limit_bounds_the_gain_where_the_box_begins() -> None:
    """x' = x + 2 u, |u| <= 6 from |x| <= 3: the gain is 2 at most, the rate 3."""
    design = pdc(
        TSModel([[[1.0]]], [[[2.0]]]), decay_rate="max", input_limit=[6.0], initial_box=[3.0]
    )

    assert design.decay_rate == pytest.approx(3.0, rel=1e-3)
    assert design.decay_rate < 3.0


@pytest.mark.parametrize("relaxation", ["common-gain", "wang-tanaka-griffin", "liu-zhang"])
def test_the_largest_rate_has_gains_below_and_none_above(relaxation: str) -> None:
    found = pdc(pendulum(), decay_rate="max", gain_bound=300.0, relaxation=relaxation)
    alpha = found.decay_rate

    for share, exists in ((0.999, True), (1.001, False)):
        design = pdc(pendulum(), decay_rate=share * alpha, gain_bound=300.0, relaxation=relaxation)
        assert design.found is exists
    assert alpha < found.answer.bound < alpha * 1.001


@pytest.mark.slow
@settings(max_examples=10)
@given(st.integers(0, 10_000), st.sampled_from([None, 0.2]))
def test_gains_of_the_largest_rate_keep_bound_and_rate(seed: int, step: float | None) -> None:
    """At 50 random blends V decays as fast as said, and no gain is larger than allowed."""
    model = random_model(seed, step)
    design = pdc(model, decay_rate="max", gain_bound=3.0)
    if not design.found:
        return
    K, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(2), 50)
    A, B, gain = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    L = np.linalg.cholesky(P)
    moved = np.linalg.solve(L, (A - B @ gain).transpose(0, 2, 1) @ L)
    if step is None:
        rates = -np.linalg.eigvalsh(moved + moved.transpose(0, 2, 1))[:, -1] / 2
    else:
        rates = -np.log(np.linalg.norm(moved, 2, axis=(1, 2))) / step

    assert np.linalg.norm(K, 2, axis=(1, 2)).max() <= 3.0
    assert rates.min() >= design.decay_rate - 1e-9


def test_gains_too_small_to_stabilise_are_a_no() -> None:
    """At |K| <= 50 the pendulum falls: no gains at decay rate 0, so no largest rate."""
    design = pdc(pendulum(), decay_rate="max", gain_bound=50.0)

    assert design.status == "infeasible" and design.gains is None
    assert "raise gain_bound" in design.answer.diagnosis


@pytest.mark.parametrize("step", [None, 0.2])
@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "kim-lee", "polya-2"])
def test_the_rate_shown_is_where_an_inequality_becomes_singular(
    step: float | None, relaxation: str
) -> None:
    design = pdc(random_model(1, step), relaxation=relaxation)
    answer = design.answer
    assert answer.condition is not None and answer.decay_rate is not None
    least = []
    for share in (0.999, 1.0, 1.001):
        alpha = share * answer.decay_rate
        number = {"alpha": alpha} if step is None else {"contraction": np.exp(-2 * alpha * step)}
        condition = answer.condition.with_parameters(**number)
        eigenvalues = [
            smallest_eigenvalues(condition, lmi, answer.values).min()
            for lmi in condition.lmis
            if any(term.parameter is not None for term in lmi.terms)
        ]
        least.append(min(eigenvalues))

    assert least[0] > 1e-8 and least[2] < -1e-8
    assert abs(least[1]) < 1e-3 * min(least[0], -least[2])
