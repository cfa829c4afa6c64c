"""Common quadratic Lyapunov functions against exact thresholds of the literature."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from takagi.certificates import Verdict, certify
from takagi.lmi import (
    EigenvalueRegion,
    common_lyapunov,
    d_stability,
    exact_solution,
    max_decay_rate,
)
from takagi.lmi.analysis.decay_rate import rate_of, rates_of
from takagi.lmi.analysis.gain_pairs import pairs_of
from takagi.models import Floats, ModelError, TSModel
from tests.lmi.known_models import (
    TRUCK_GAINS,
    book_pair,
    feasp_triple,
    planar_pair,
    rolmip_pair,
    truck_trailer,
)

pytestmark = pytest.mark.numeric


def test_planar_pair_has_a_common_p_exactly_between_its_limits() -> None:
    """Dayawansa and Martin (1999): a common P exists exactly for 3 - sqrt 8 < a < 3 + sqrt 8."""
    for limit, inward in ((3 + np.sqrt(8), -1), (3 - np.sqrt(8), 1)):
        inside = common_lyapunov(planar_pair(limit * (1 + 1e-3 * inward)))
        outside = common_lyapunov(planar_pair(limit * (1 - 1e-3 * inward)))

        assert inside.status == "candidate"
        assert inside.margin > 1e-5
        assert outside.status == "infeasible"
        assert outside.P is None


@pytest.mark.parametrize(
    "vertices",
    [
        [[[-101.0]], [[-1e-8]]],
        [[[-101.0, 0.0], [0.0, -1e-8]]],
        [[[-1.0, 5.0], [0.0, -1e-8]], [[-1e-8, 0.0], [3.0, -400.0]]],
    ],
)
def test_a_slow_mode_beside_fast_ones_leaves_a_function(vertices: ArrayLike) -> None:
    """The margin is 1e-10 of the fast mode and less: exact arithmetic decides, as for a proof."""
    A = np.array(vertices)
    found = common_lyapunov(A)
    P = found.P

    assert found.status == "candidate" and P is not None and found.condition is not None
    solution = exact_solution(found.condition, found.values)
    assert solution is not None and solution.holds
    assert common_lyapunov(-A[-1:]).status == "infeasible"
    beyond = common_lyapunov(A, decay_rate=1.01e-8)
    assert beyond.status != "candidate"


def test_an_unstable_vertex_is_no_false_proof() -> None:
    """A = I with P > 1e-9 I was accepted on a solver's status; here it is a no, with its reason."""
    answer = common_lyapunov(np.eye(2))

    assert answer.status == "infeasible"
    assert "vertex 1 of 1 alone" in answer.diagnosis
    Z = answer.multipliers["vertex"][0]
    assert np.linalg.eigvalsh(Z + Z)[0] > -1e-12


def test_a_no_carries_multipliers_that_show_it() -> None:
    """Z_i >= 0, not all zero, with sum A_i Z_i + Z_i A_i' >= 0 exclude every P."""
    answer = common_lyapunov(planar_pair(8.0))
    assert answer.condition is not None
    A = answer.condition.lmis[2].terms[0].right
    assert A is not None
    Z = answer.multipliers["vertex"]
    flow = (A @ Z).sum(axis=0)

    assert np.trace(Z.sum(axis=0)) > 1e-2
    assert np.linalg.eigvalsh(Z).min() >= -1e-12
    assert np.linalg.eigvalsh(flow + flow.T)[0] > -1e-7
    assert "vertex 1 of 2" in answer.diagnosis and "vertex 2 of 2" in answer.diagnosis


def test_many_vertices_are_all_looked_at() -> None:
    rng = np.random.default_rng(1)
    A = rng.standard_normal((5, 5)) - 4 * np.eye(5) + 0.15 * rng.standard_normal((3000, 5, 5))
    answer = common_lyapunov(A)

    assert answer.P is not None and answer.condition is not None
    assert rates_of(A, answer.P).min() > 0
    assert answer.condition.lmis[2].count < 200

    two = np.concatenate([A[:, :2, :2], planar_pair(8.0)])
    no = common_lyapunov(two)
    assert no.status == "infeasible"
    assert "of 3002" in no.diagnosis


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_the_loop_is_a_blend_of_its_pairs(seed: int, r: int) -> None:
    """X(h) - Y(h) K(h), and X(h), with weights h_i^2 and 2 h_i h_j that sum to one."""
    rng = np.random.default_rng(seed)
    X, Y = rng.standard_normal((r, 2, 3)), rng.standard_normal((r, 2, 2))
    K = rng.standard_normal((r, 2, 3))
    h = rng.dirichlet(np.ones(r))
    i, j = np.triu_indices(r)
    weight = np.where(i == j, 1, 2) * h[i] * h[j]
    x, y, k = (np.tensordot(h, part, 1) for part in (X, Y, K))

    np.testing.assert_allclose(np.tensordot(weight, pairs_of(X, Y, K), 1), x - y @ k, atol=1e-12)


def test_a_mean_that_fails_is_not_said_to_exclude_the_loop() -> None:
    """G(h) = -1 + 3 h_1 h_2 <= -1/4, though (G_12 + G_21)/2 = 1/2: the no is about means."""
    model = TSModel([[[-1.0]], [[5.0]]], [[[1.0]], [[2.0]]])
    gains = [[[0.0]], [[3.0]]]
    answer = d_stability(model, EigenvalueRegion.half_plane(0.0), gains=gains)

    assert not answer.found
    assert "a mean that fails excludes nothing" in answer.diagnosis
    assert "mean" not in d_stability(model, EigenvalueRegion.half_plane(0.0)).diagnosis


def test_three_vertices_of_the_gevp_page() -> None:
    """MathWorks, gevp: V' <= -0.122 V, recomputed by bisection 0.1221308; ours is half of it."""
    A = feasp_triple()
    answer = max_decay_rate(A)

    assert answer.decay_rate == pytest.approx(0.12213081 / 2, rel=1e-6)
    assert answer.P is not None and answer.decay_rate is not None
    assert rate_of(A, answer.P) == pytest.approx(answer.decay_rate, rel=1e-9)
    assert len(answer.tries) < 8


def test_an_unstable_system_has_a_negative_rate() -> None:
    """x' = 0.1 x + rotation grows with 0.1: the rate is -0.1, and it is an answer."""
    answer = max_decay_rate(np.array([[0.1, 2.0], [-2.0, 0.1]]))

    assert answer.found
    assert answer.decay_rate == pytest.approx(-0.1, abs=1e-5)


def test_a_supremum_that_is_not_attained_is_approached_from_below() -> None:
    """A Jordan block at -1 shows every rate below 1 and not 1; P stays usable."""
    answer = max_decay_rate(np.array([[-1.0, 1.0], [0.0, -1.0]]))

    assert answer.decay_rate is not None and answer.P is not None
    assert 0.999 < answer.decay_rate < 1.0 <= answer.bound
    assert np.linalg.cond(answer.P) < 1e10


@settings(max_examples=10)
@given(st.integers(0, 1000))
def test_one_matrix_against_its_eigenvalues(seed: int) -> None:
    """For one diagonalisable matrix the rate is -max Re(eigenvalue)."""
    A = np.random.default_rng(seed).standard_normal((4, 4))
    answer = max_decay_rate(A)
    slowest = -float(np.linalg.eigvals(A).real.max())

    assert answer.decay_rate == pytest.approx(slowest, abs=2e-3)
    assert answer.decay_rate is not None and answer.decay_rate <= slowest + 1e-9


def test_rounds_find_what_all_vertices_at_once_find() -> None:
    rng = np.random.default_rng(3)
    A = rng.standard_normal((3, 3)) - 3 * np.eye(3) + 0.2 * rng.standard_normal((400, 3, 3))
    answer = max_decay_rate(A)
    assert answer.P is not None and answer.decay_rate is not None

    assert rate_of(A, answer.P) == pytest.approx(answer.decay_rate, abs=1e-9)
    # A thousandth, of the rate or of a thousandth of the vertices: what a candidate promises.
    size = float(np.linalg.norm(A, 2, axis=(1, 2)).max())
    near = 1e-3 * max(abs(answer.bound), 2e-3 * size)
    assert answer.decay_rate <= answer.bound <= answer.decay_rate + near
    assert common_lyapunov(A, decay_rate=answer.bound + 10 * near).status == "infeasible"


def printed_loops() -> Floats:
    """Tanaka and Sano (1994), gains printed to four decimals: G11, G22, (G12 + G21) / 2."""
    model = truck_trailer()
    G = model.A[:, None] + model.B[:, None] @ TRUCK_GAINS[None]
    return np.array([G[0, 0], G[1, 1], (G[0, 1] + G[1, 0]) / 2])


def sampled_fast(step: float) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(0)
    A = rng.standard_normal((6, 6)) - 3 * np.eye(6) + 0.3 * rng.standard_normal((8, 6, 6))
    return A, np.eye(6) + step * A


def test_the_rolmip_pair_has_none_and_says_so() -> None:
    """The largest margin is 0, so no candidate; both sides of the largest contraction."""
    answer = common_lyapunov(rolmip_pair(), sample_time=1.0)
    assert answer.status == "infeasible"
    assert answer.P is None and abs(answer.margin) < 1e-7

    rate = max_decay_rate(rolmip_pair(), sample_time=1.0)
    assert rate.decay_rate is not None and rate.decay_rate < 0
    for side, status in ((-1e-3, "candidate"), (1e-3, "infeasible")):
        scaled = rolmip_pair() * np.exp(rate.decay_rate + side)
        assert common_lyapunov(scaled, sample_time=1.0).status == status


def test_printed_gains_of_the_truck_are_not_certified() -> None:
    """Each loop is stable by itself, the slowest by 4.5e-5 only; one P for all is not there."""
    loops = printed_loops()
    sizes = np.abs(np.linalg.eigvals(loops)).max(axis=1)
    answer = common_lyapunov(loops, sample_time=2.0)

    assert sizes.max() == pytest.approx(0.999955, abs=1e-6)
    assert answer.status == "infeasible"
    assert "vertex 2 of 3" in answer.diagnosis
    P = np.array([[113.9, -92.61, 2.540], [-92.61, 110.7, -3.038], [2.540, -3.038, 0.5503]])
    grows = np.linalg.eigvalsh(loops[1].T @ P @ loops[1] - P)[-1]
    assert grows == pytest.approx(0.0104, abs=5e-4)
    rate = max_decay_rate(loops, sample_time=2.0).decay_rate
    assert rate is not None and rate < 0


def test_stable_in_continuous_time_is_not_stable_in_discrete_time() -> None:
    """x+ = -2 x grows though Re(-2) < 0, and x+ = 0.5 x decays though Re(0.5) > 0."""
    grows = common_lyapunov([[-2.0]], sample_time=0.1)
    assert grows.status == "infeasible"
    assert "its eigenvalue -2+0j, of size 2," in grows.diagnosis
    assert common_lyapunov([[0.5]], sample_time=0.1).found
    assert common_lyapunov([[0.5]]).status == "infeasible"
    Z = common_lyapunov([[0.0, 1.2], [-1.2, 0.0]], sample_time=1.0).multipliers["vertex"][0]
    A = np.array([[0.0, 1.2], [-1.2, 0.0]])
    assert np.linalg.eigvalsh(A @ Z @ A.T - Z)[0] > 0.2


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.sampled_from([1e-3, 0.5, 7.0]))
def test_one_sampled_matrix_against_its_eigenvalues(seed: int, step: float) -> None:
    """For one diagonalisable matrix alpha = -ln(largest |z|) / T, 1/s."""
    A = np.random.default_rng(seed).standard_normal((4, 4))
    exact = -float(np.log(np.abs(np.linalg.eigvals(A)).max())) / step
    answer = max_decay_rate(A, sample_time=step)

    assert answer.decay_rate is not None
    assert answer.decay_rate == pytest.approx(exact, abs=2e-3 / step)
    assert answer.decay_rate <= exact + 1e-9 / step
    assert answer.bound >= exact - 1e-7 / step


@pytest.mark.parametrize("step", [1e-2, 1e-4, 1e-6])
def test_sampled_ever_faster_the_rate_is_that_of_continuous_time(step: float) -> None:
    """(1 + T A_i) of Euler's method: the rate in 1/s converges to that of A_i, to order T."""
    continuous, discrete = sampled_fast(step)
    limit = max_decay_rate(continuous).decay_rate
    answer = max_decay_rate(discrete, sample_time=step)

    assert limit is not None and answer.decay_rate is not None
    assert abs(answer.decay_rate - limit) < 2 * step + 2e-6
    assert answer.bound == pytest.approx(answer.decay_rate, rel=3e-6)
    assert len(answer.tries) < 20


def test_dead_beat_has_every_rate() -> None:
    """A = 0 is at the origin after one step: the rate is inf, and P still a candidate."""
    answer = max_decay_rate(np.zeros((2, 2)), sample_time=0.1)

    assert answer.found and answer.P is not None
    assert answer.decay_rate == np.inf and answer.bound == np.inf


def test_a_model_knows_its_sample_time() -> None:
    model = TSModel(book_pair(), sample_time=0.5)

    assert (
        common_lyapunov(model).decay_rate
        == common_lyapunov(book_pair(), sample_time=0.5).decay_rate
    )
    with pytest.raises(ModelError, match="the model's own is 0.5 s"):
        common_lyapunov(model, sample_time=0.1)
    with pytest.raises(ModelError, match="discretise it first"):
        max_decay_rate(TSModel(-book_pair()), sample_time=0.1)
    with pytest.raises(ModelError, match="must be positive"):
        max_decay_rate(book_pair(), sample_time=0.0)


def test_certificates_of_discrete_time_are_about_it() -> None:
    """x+ = A x must not be read as x' = A x: the one pair is proved, the other disproved."""
    proved = certify(TSModel(book_pair(), sample_time=0.5))
    none = certify(TSModel(rolmip_pair(), sample_time=0.5))

    assert proved.verdict is Verdict.PROVED
    assert proved.document["model"]["sample_time"] == 0.5
    assert none.verdict is Verdict.DISPROVED
