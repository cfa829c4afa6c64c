"""Laws that run every T seconds: exact thresholds, and the plants simulated."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.checker import check_document
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import embedding_claim, law_members, plant_data
from takagi.certificates.requests import SampledLoop
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import Floats, ModelError, TSModel
from tests.certificates.kinds.claims import (
    Data,
    law_data,
    model_data,
    said_of,
    sealed,
    verdict_of,
)
from tests.certificates.weights.cells import cubic
from tests.reports.plant_designs import design_of

PLANTS = (
    "cart_pole",
    "duffing",
    "mass_spring_damper",
    "ball_and_beam",
    "tora",
    "flexible_joint",
    "quarter_car",
)


def integrator(T: Any, rate: Any = 0) -> tuple[Data, Data, Data]:
    """Return x' = u, u = -x(t_k), whose x(t_k+1) is (1 - T) x(t_k); and a claim of V = x^2.

    Q(s) = [1, T (1 - s)]'[1, T (1 - s)] does not change while u is held.
    """
    nodes = [[[1, T], [T, T * T]], [[1, T / 2], [T / 2, 0]], [[1, 0], [0, 0]]]
    claim = {"name": "held", "kind": "sampled-loop", "sample_time": T, "P": [[1]], "level": 1}
    claim |= {"decay_rate": rate, "functions": nodes}
    return model_data([[[0]]], B=[[[1]]]), law_data([[[1]]]), claim


def frozen(A: Floats, B: Floats, K: Floats, T: float) -> float:
    n, m = B.shape
    M = np.zeros((n + m, n + m))
    M[:n] = np.hstack([A, B])
    flow = expm(T * M)
    return float(np.abs(np.linalg.eigvals(flow[:n, :n] - flow[:n, n:] @ K)).max())


def loop_of(model: TSModel, K: Any) -> ClaimedLoop:
    return ClaimedLoop.of(model, np.array(K, dtype=float))


def test_exact_threshold_of_the_integrator() -> None:
    """(1 - T)^2 < 1 up to T = 2, and (1 - T)^2 < e^(-2 alpha T) up to alpha = ln 2 at T = 1/2."""
    assert verdict_of(*integrator(1.9999999)) == "PROVED"
    assert verdict_of(*integrator(2)) == "UNDECIDED"
    assert verdict_of(*integrator(0.5, 1.38629436)) == "PROVED"
    assert verdict_of(*integrator(0.5, 1.38629437)) == "UNDECIDED"


def test_sentence_names_what_is_assumed() -> None:
    model, gains, claim = integrator(0.5, 0.25)
    told = said_of(model | {"input_names": ["motor [V]"]}, gains, claim).text

    for words in ("every 0.5 s", "motor [V]", "held until the next", "computed in no time"):
        assert words in told
    assert "from anywhere, V = x'Px falls as exp(-0.5 t) from sample to sample" in told


@pytest.mark.parametrize(("a", "k"), [(1.0, 3.0), (-1.0, 3.0), (0.0, 1.0), (4.0, 6.0)])
def test_largest_time_of_one_state(a: float, k: float) -> None:
    """x' = a x - k x(t_k) is stable up to e^(a T) = (k + a)/(k - a), T = 2/k for a = 0."""
    exact = 2 / k if a == 0 else np.log((k + a) / (k - a)) / a
    loop = loop_of(TSModel([[[a]]], [[[1.0]]]), [[[k]]])

    largest = SampledLoop().attempt(loop)
    assert largest.proved
    assert 0.97 * exact < largest.claim["sample_time"] < exact
    assert SampledLoop(0.95 * exact).attempt(loop).proved
    assert not SampledLoop(1.0001 * exact).attempt(loop).proved


def test_largest_time_of_two_states() -> None:
    """A double integrator with a fast gain: where the exact discretisation is stable."""
    A, B, K = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), np.array([[4.0, 3.0]])
    largest = SampledLoop().attempt(loop_of(TSModel(A[None], B[None]), K[None]))
    T = largest.claim["sample_time"]

    assert largest.proved
    assert frozen(A, B, K, T) < 1 < frozen(A, B, K, 1.1 * T)


def test_weights_that_move_within_an_interval() -> None:
    """Each rule with its own gain is stable at T = 1, but rule 2 with the gain of rule 1 is not."""
    A, B = np.zeros((2, 1, 1)), np.array([[[1.0]], [[4.0]]])
    K = [[[1.5]], [[0.4]]]
    loop = loop_of(TSModel(A, B), K)

    for i in range(2):
        alone = loop_of(TSModel(A[i : i + 1], B[i : i + 1]), K[i : i + 1])
        found = SampledLoop(1.0).attempt(alone)
        assert found.proved
        # What shows one rule is no evidence for both.
        assert loop.replay(found.claim).verdict is Verdict.UNDECIDED
    assert not SampledLoop(1.0).attempt(loop).proved
    # The command of gain 1 on rule 2: 4 * 1.5 T < 2, at T = 1/3.
    largest = SampledLoop().attempt(loop)
    assert 0.85 / 3 < largest.claim["sample_time"] < 1 / 3


@pytest.mark.parametrize("form", ["sector", "secants"])
def test_embeddings(form: str) -> None:
    """x' = -x - x^3 + u + w on |x| <= 1, as a sector model and by secants from rest."""
    found = certify(cubic(form), [[1.0]], claims=[SampledLoop(0.05)])

    assert found.verdict is Verdict.PROVED
    assert "between samples too the plant stays in the model's box" in found.checked.claims[1].text


def test_state_must_stay_in_the_box_between_samples() -> None:
    """x' = 3 x - 6 x(t_k), so that |x| is largest between samples only if the box is too small."""
    model = model_data([[[0, 1], [0, 0]]], B=[[[0], [1]]], box={"x1 [-]": [-1, 1]})
    gains = law_data([[[4, 3]]])
    loop = loop_of(TSModel([[[0.0, 1.0], [0.0, 0.0]]], [[[0.0], [1.0]]]), [[[4.0, 3.0]]])
    claim = dict(SampledLoop(0.2).attempt(loop).claim)
    P, Q = np.array(claim["P"]), np.array(claim["functions"])
    at_samples = 1 / np.linalg.inv(P)[0, 0]
    between = min(1 / np.linalg.inv(one)[0, 0] for one in Q)

    assert between < 0.99 * at_samples
    verdicts = [
        verdict_of(model, gains, claim | {"level": float(level)})
        for level in (0.999 * between, 1.001 * between, 0.999 * at_samples)
    ]
    assert verdicts == [
        "PROVED",
        *["UNDECIDED"] * 2,
    ]
    assert "between samples" in said_of(model, gains, claim | {"level": 1.001 * between}).text


def test_sentence_of_a_range_of_one_state_has_its_set() -> None:
    """x1 has a range and x2 has none: the claim is about an ellipsoid, and not about any start."""
    model = model_data([[[0, 1], [0, 0]]], B=[[[0], [1]]], box={"x1 [-]": [-1, 1]})
    loop = loop_of(TSModel([[[0.0, 1.0], [0.0, 0.0]]], [[[0.0], [1.0]]]), [[[4.0, 3.0]]])
    claim = dict(SampledLoop(0.2).attempt(loop).claim) | {"level": 1e-3}

    told = said_of(model, law_data([[[4, 3]]]), claim)

    assert told.verdict is Verdict.PROVED
    assert "from {x'Px <= 0.001}, V = x'Px" in told.text and "anywhere" not in told.text
    assert "between samples too the plant stays in the model's box" in told.text


def test_sentence_assumes_the_range_of_a_signal_that_schedules_alone() -> None:
    """A disturbance is taken as zero, so its range is not assumed besides."""
    _, gains, claim = integrator(0.5)
    texts = []
    for E in (1, 0):
        signal = {"E": [[[E]]], "disturbance_names": ["w"], "box": {"w": [-0.5, 2]}}
        told = said_of(model_data([[[0]]], B=[[[1]]], **signal), gains, claim)
        assert told.verdict is Verdict.PROVED and "without disturbance" in told.text
        texts.append(told.text)

    assert "while" not in texts[0] and "while w stays in the model's box" in texts[1]


def test_loops_that_have_no_such_claim() -> None:
    model, gains, claim = integrator(1)
    with pytest.raises(CertificateError, match="continuous time"):
        said_of(
            model_data([[[0]]], B=[[[1]]], sample_time=1), law_data([[[1]]], sample_time=1), claim
        )
    with pytest.raises(CertificateError, match="gains"):
        said_of(model, None, claim)
    with pytest.raises(ModelError, match="discrete time"):
        SampledLoop(0.1).attempt(loop_of(TSModel([[[0.5]]], [[[1.0]]], sample_time=1.0), [[[0.1]]]))


def test_switched_and_blended_at_will() -> None:
    """The theorem is about any motion of both weights: tried with a hundred random ones."""
    rng = np.random.default_rng(3)
    A = np.array([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [3.0, -0.5]]])
    B = np.array([[[0.0], [1.0]], [[0.0], [1.3]]])
    K = np.array([[[5.0, 3.0]], [[6.0, 3.0]]])
    found = SampledLoop(0.1).attempt(loop_of(TSModel(A, B), K))
    assert found.proved
    P, share = np.array(found.claim["P"]), np.exp(-2 * found.claim["decay_rate"] * 0.1)

    for _ in range(100):
        x = rng.standard_normal(2)
        u = -np.tensordot(rng.dirichlet([0.3, 0.3]), K, axes=1) @ x
        z = np.concatenate([x, u])
        for part in rng.dirichlet(np.ones(5)) * 0.1:
            h = rng.dirichlet([0.3, 0.3])
            M = np.zeros((3, 3))
            M[:2] = np.hstack([np.tensordot(h, A, axes=1), np.tensordot(h, B, axes=1)])
            z = expm(part * M) @ z
        assert z[:2] @ P @ z[:2] <= share * (x @ P @ x)


def proved(name: str, T: float) -> Data:
    design = design_of(name)
    assert design.gains is not None
    data = plant_data(design.model)
    law = pdc_law_data(design.model, design.gains) | law_members(data)
    loop = ClaimedLoop.of(design.model, design.gains, model_data=data, law=law)
    claim = dict(SampledLoop(T).attempt(loop).claim)
    claims = [embedding_claim(design.model), claim]
    return sealed(data, law, *claims)


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("T", [0.005, 0.02])
def test_plants_are_proved(name: str, T: float) -> None:
    if (name, T) != ("cart_pole", 0.02):
        assert check_document(proved(name, T)).verdict is Verdict.PROVED
