"""How much a box may grow: closed forms, the determinant test of planar pairs, sampled blends."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    Answer,
    common_lyapunov,
    max_box_enlargement,
    pdc,
)
from takagi.lmi.analysis.loop_growth import Law
from takagi.models import ModelError, Premise, TSModel
from tests.lmi.known_models import oscillators

Floats = NDArray[np.float64]
LAWS: tuple[Law, ...] = get_args(Law)


def two_premises() -> TSModel:
    """An oscillator whose stiffness and damping are premises, affine in both."""
    A = [[[b, 1.0], [a, 0.0]] for a in (-1.0, 2.0) for b in (-0.5, 0.3)]
    premises = [Premise("a", -1, 2), Premise("b", "-0.5", "0.3")]
    return TSModel(A, [[0.0], [1.0]], premises=premises)


def growth(answer: Answer) -> float:
    """Return the enlargement of an answer that must have one."""
    assert answer.found and answer.P is not None, answer.diagnosis
    assert answer.enlargement is not None
    assert answer.enlargement <= answer.bound * (1 + 1e-9)
    return answer.enlargement


def worst_slope(model: TSModel, K: Floats, answer: Answer, law: Law) -> float:
    """Return the largest eigenvalue of He(P (A - B K)), relative, over random points and laws."""
    theta = growth(answer)
    P = np.asarray(answer.P)
    rng = np.random.default_rng(0)
    middle, half = np.array([0.5, -0.1]), np.array([1.5, 0.4])
    worst = -np.inf
    for _ in range(1500):
        s = np.clip(rng.uniform(-1.3, 1.3, 2), -1, 1)
        a, b = middle + theta * s * half
        if law == "clamped":
            g = model.memberships([a, b], clip=True)
        elif law == "stretched":
            g = model.memberships(middle + s * half, clip=True)
        else:
            g = rng.dirichlet(np.full(4, 0.3))
        M = np.array([[b, 1.0], [a, 0.0]]) - np.array([[0.0], [1.0]]) @ np.tensordot(g, K, axes=1)
        worst = max(worst, float(np.linalg.eigvalsh(P @ M + M.T @ P)[-1]))
    return worst / float(np.linalg.norm(P))


def test_one_state_in_closed_form() -> None:
    """-2 +- theta stays below -alpha up to theta = 2 - alpha; about the slower one without end."""
    A = [[[-1.0]], [[-3.0]]]

    assert growth(max_box_enlargement(A)) == pytest.approx(2.0, rel=2e-6)
    assert growth(max_box_enlargement(A, decay_rate=0.5)) == pytest.approx(1.5, rel=2e-6)
    assert growth(max_box_enlargement(A, nominal=[0, 1])) == pytest.approx(1.5, rel=2e-6)
    assert growth(max_box_enlargement(A, nominal=[1, 0])) == np.inf


def test_one_state_in_discrete_time() -> None:
    """|0.4 +- 0.2 theta| < rho: 3 for rho = 1, and (e^(-alpha T) - 0.4) / 0.2 with a rate."""
    A = [[[0.2]], [[0.6]]]
    fast = max_box_enlargement(A, sample_time=0.5, decay_rate=0.8)

    assert growth(max_box_enlargement(A, sample_time=0.5)) == pytest.approx(3.0, rel=2e-6)
    assert growth(fast) == pytest.approx((np.exp(-0.4) - 0.4) / 0.2, rel=2e-6)
    assert fast.decay_rate == pytest.approx(0.8, abs=1e-5)
    flipping = max_box_enlargement([[[0.2]], [[-0.6]]], sample_time=1.0)
    assert growth(flipping) == pytest.approx(2.0, rel=2e-6)


@pytest.mark.parametrize("stiffening", [2.0, 5.0, 20.0])
def test_oscillators_grow_to_four_plus_four_root_two(stiffening: float) -> None:
    """About the first vertex, theta lambda may reach 4 + 4 sqrt 2: below 1 where lambda = 20."""
    answer = max_box_enlargement(oscillators(stiffening), nominal=[1.0, 0.0])

    assert growth(answer) == pytest.approx((4 + 4 * np.sqrt(2)) / stiffening, rel=5e-6)
    assert answer.bound == pytest.approx((4 + 4 * np.sqrt(2)) / stiffening, rel=1e-5)


@settings(max_examples=8)
@given(st.integers(0, 10**6), st.sampled_from([None, 0.1]))
def test_common_lyapunov_agrees_from_both_sides(seed: int, sample_time: float | None) -> None:
    """A thousandth below the enlargement there is a common P with the rate, above there is none."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((3, 3)) - 3 * np.eye(3) + 0.4 * rng.standard_normal((5, 3, 3))
    if sample_time is not None:
        A = np.eye(3) + sample_time * A
    A0 = A.mean(axis=0)
    answer = max_box_enlargement(A, decay_rate=0.1, sample_time=sample_time)
    if not answer.found:
        assert not common_lyapunov(A0, decay_rate=0.1, sample_time=sample_time).found
        return
    theta = growth(answer)
    for side, status in ((1 - 1e-3, "candidate"), (1 + 1e-3, "infeasible")):
        grown = A0 + theta * side * (A - A0)
        found = common_lyapunov(grown, decay_rate=0.1, sample_time=sample_time)
        assert found.status == status


@pytest.mark.parametrize("step", [1e-2, 1e-4])
def test_sampled_ever_faster_it_grows_as_in_continuous_time(step: float) -> None:
    """1 + T A of Euler's method: theta tends to that of A; at T = 0.0001 to two thousandths."""
    limit = (4 + 4 * np.sqrt(2)) / 5
    A = np.eye(2) + step * oscillators(5.0)
    answer = max_box_enlargement(A, nominal=[1.0, 0.0], sample_time=step)

    assert abs(growth(answer) - limit) < 16 * step
    assert answer.bound == pytest.approx(growth(answer), rel=1e-5)


def test_a_thousand_vertices() -> None:
    """Few are given to the solver; P serves all of them enlarged."""
    rng = np.random.default_rng(5)
    A = rng.standard_normal((4, 4)) - 3 * np.eye(4) + 0.3 * rng.standard_normal((1000, 4, 4))
    answer = max_box_enlargement(A)
    theta = growth(answer)
    assert answer.condition is not None and answer.P is not None
    assert answer.condition.lmis[-1].count < 100

    A0 = A.mean(axis=0)
    M = answer.P @ (A0 + theta * (A - A0))
    grown = np.linalg.eigvalsh(M + M.transpose(0, 2, 1))[:, -1]
    assert grown.max() <= 1e-9 * np.abs(M).max()
    assert answer.bound == pytest.approx(theta, rel=1e-4)


def test_one_state_under_laws_in_closed_form() -> None:
    """a in [1, 3], K = 2, 4: the law of its box holds to a = 4; any blend not even at a = 2."""
    model = TSModel([[[1.0]], [[3.0]]], [[1.0]], premises=[Premise("a", 1, 3)])
    K = np.array([[[2.0]], [[4.0]]])

    for law in ("stretched", "clamped"):
        found = max_box_enlargement(model, gains=K, law=law)
        assert growth(found) == pytest.approx(2.0, rel=2e-6)
    no = max_box_enlargement(model, gains=K)
    assert no.status == "infeasible" and no.enlargement is None
    assert "not even the nominal point" in no.diagnosis
    for law in LAWS:
        assert growth(max_box_enlargement(model, gains=[[4.0]], law=law)) == pytest.approx(2.0)


@pytest.mark.parametrize("law", LAWS)
def test_p_serves_all_that_the_law_allows(law: Law) -> None:
    """Random points of the enlarged box, random gains of the law: V falls at every one."""
    model = two_premises()
    K, _ = pdc(model, decay_rate=0.5).require()
    answer = max_box_enlargement(model, gains=K, law=law)

    assert worst_slope(model, K, answer, law) <= 1e-12
    bigger = Answer(
        status="candidate",
        P=answer.P,
        margin=0.0,
        enlargement=1.05 * growth(answer),
        bound=np.inf,
    )
    assert worst_slope(model, K, bigger, law) > 1e-3


def test_any_blend_of_gains_covers_the_clamped_law() -> None:
    """What holds whatever the law does holds for the law that is held at its edge."""
    model = two_premises()
    K, _ = pdc(model, decay_rate=0.5).require()
    theta = {law: growth(max_box_enlargement(model, gains=K, law=law)) for law in LAWS}

    assert 1 < theta["independent"] < theta["clamped"]


def test_a_law_that_fails_in_its_own_box_is_a_no() -> None:
    """Gains with the wrong sign: no enlargement, and the reason names the box."""
    model = two_premises()
    K, _ = pdc(model).require()
    answer = max_box_enlargement(model, gains=-K, law="clamped")

    assert answer.status == "infeasible" and answer.P is None
    assert "not even the law in its own box" in answer.diagnosis


def test_nothing_to_enlarge() -> None:
    """One vertex, or the same three times, stays where it is: the enlargement is inf."""
    A = oscillators(5.0)[:1]

    assert growth(max_box_enlargement(A)) == np.inf
    assert growth(max_box_enlargement(np.repeat(A, 3, axis=0))) == np.inf


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": "clumped"}, r"law 'clumped' is not known.*mean 'clamped'"),
        ({"law": "clamped"}, "give gains, or leave law out"),
        ({"nominal": [0.5, 0.6]}, "sum 1.1; memberships are not negative and sum to 1"),
        ({"nominal": [1.5, -0.5]}, "least entry -0.5"),
        ({"nominal": [1.0]}, r"nominal has shape \(1,\); memberships \(2,\)"),
        ({"nominal": ["a", 0.0]}, "cannot be read as numbers"),
        ({"tolerance": -1.0}, "tolerance is -1.0"),
        ({"sample_time": -1.0}, "must be positive"),
        ({"decay_rate": np.nan}, "decay_rate is nan"),
        ({"gains": [[1.0, 2.0]]}, "no B"),
    ],
)
def test_misuse_is_named(change: dict[str, Any], message: str) -> None:
    """Each is refused where it is given."""
    with pytest.raises(ModelError, match=message):
        max_box_enlargement(oscillators(5.0), **change)


def test_clamped_needs_premises_that_matrices_are_affine_in() -> None:
    """Without premises, or with a product of two, what lies beyond the box is not known."""
    plain = TSModel(oscillators(5.0), [[0.0], [1.0]])
    with pytest.raises(ModelError, match='take law "independent"'):
        max_box_enlargement(plain, gains=[[1.0, 1.0]], law="clamped")
    A = [[[-2.0 - a * b]] for a in (0.0, 1.0) for b in (0.0, 1.0)]
    curved = TSModel(A, [[1.0]], premises=[Premise("a", 0, 1), Premise("b", 0, 1)])
    with pytest.raises(ModelError, match="away from matrices affine in the premises"):
        max_box_enlargement(curved, gains=[[1.0]], law="clamped")
