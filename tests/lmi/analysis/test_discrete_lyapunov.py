"""Common quadratic functions in discrete time: published pairs, eigenvalues, the fast limit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.lmi import common_lyapunov, max_decay_rate
from takagi.models import Floats, ModelError, TSModel
from tests.lmi.known_models import TRUCK_GAINS, book_pair, rolmip_pair, truck_trailer


def printed_loops() -> Floats:
    """Tanaka and Sano (1994), gains printed to four decimals: G11, G22, (G12 + G21) / 2."""
    model = truck_trailer()
    G = model.A[:, None] + model.B[:, None] @ TRUCK_GAINS[None]
    return np.array([G[0, 0], G[1, 1], (G[0, 1] + G[1, 0]) / 2])


def sampled_fast(step: float) -> tuple[Floats, Floats]:
    """Return eight vertices of continuous time, and those of Euler's method."""
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
def test_one_matrix_against_its_eigenvalues(seed: int, step: float) -> None:
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
