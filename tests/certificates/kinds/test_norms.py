"""Energy gain, variance and peak: exact thresholds, and other ways to the same numbers.

x' = -2 x + w1/5 + 3 w2, y = x: from one disturbance with the entry e the energy gain and the peak
are e/2, and the variance of y under white noise is e^2/4; from both, e is their Euclidean norm.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from takagi.certificates import Verdict
from takagi.certificates.requests import H2Norm, L2Gain, Peak
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import hinf_norm
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, model_data, verdict_of

NAMES = ["w1 [N]", "w2 [m/s]"]
GAIN = {"kind": "l2-gain"}
NOISE = {"kind": "h2-norm"}
PEAK = {"kind": "peak", "disturbance_norm": 1, "multiplier": 2}
BASE = {"name": "norm", "disturbance": "disturbances"}
LESS, MORE = 1 - 1e-12, 1 + 1e-12


def plant(**others: Any) -> Data:
    return model_data([[[-2]]], E=[[[0.2, 3]]], C=[[[1]]], disturbance_names=NAMES, **others)


def claims(entry: float, **members: Any) -> list[Data]:
    """Return the three norms for an entry e, each 1e-9 above its true value at most."""
    norm = entry / 2 * (1 + 1e-9)
    return [
        BASE | members | GAIN | {"gain": norm, "P": [[1 / entry]]},
        BASE | members | NOISE | {"norm": norm, "P": [[0.2500000001]]},
        BASE | members | PEAK | {"gain": norm, "level": entry**2 / 4 * (1 + 1e-9), "P": [[1]]},
    ]


@pytest.mark.parametrize("number", range(3))
def test_each_disturbance_alone_from_both_sides(number: int) -> None:
    """The norm of a named disturbance is proved, and is none of the other, nor of both."""
    for name, entry in zip(NAMES, (0.2, 3.0), strict=True):
        claim = claims(entry, entering=[name])[number]

        assert verdict_of(plant(), None, claim) == "PROVED"
        less = {k: 0.999 * claim[k] for k in ("gain", "norm") if k in claim}
        for wrong in (claim | less, {k: v for k, v in claim.items() if k != "entering"}):
            assert verdict_of(plant(), None, wrong) == "UNDECIDED"
    weak = claims(0.2, entering=[NAMES[1]])[number]
    assert verdict_of(plant(), None, weak) == "UNDECIDED"


LAG, SAMPLED = (-2, None), (0.5, 0.1)


@pytest.mark.parametrize(
    ("system", "claim", "wrong"),
    [
        # 1/a and 1/(1 - a), reached at rest.
        (LAG, GAIN | {"gain": 0.500000001, "P": [[1]]}, [{"gain": 0.5}]),
        (SAMPLED, GAIN | {"gain": 2.00000001, "P": [[1]]}, [{"gain": 2}, {"gain": 2 - 1e-9}]),
        # 1/sqrt(2 a) and 1/sqrt(1 - a^2).
        (LAG, NOISE | {"norm": 0.500000001, "P": [[0.2500000001]]},
         [{"norm": 0.5, "P": [[0.25 + k * 1e-9]]} for k in (-1, 0, 1)]),
        ((0.6, 0.1), NOISE | {"norm": 1.250000001, "P": [[1.5625000001]]},
         [{"norm": 1.25, "P": [[1.5625 + k * 1e-9]]} for k in (-1, 0, 1)]),
        # The peak is reached by w = 1 at last, so it is proved itself, and nothing less is.
        (LAG, PEAK | {"gain": 0.5, "P": [[1]], "level": 0.25},
         [{"gain": 0.5 * LESS}, {"level": 0.25 * LESS}, {"disturbance_norm": MORE}]),
        (SAMPLED, PEAK | {"gain": 2, "P": [[1]], "level": 4, "multiplier": 0.5},
         [{"gain": 2 * LESS}, {"level": 4 * LESS}, {"disturbance_norm": MORE}]),
    ],
)  # fmt: skip
def test_from_both_sides_of_the_exact_value(system: Any, claim: Data, wrong: list[Data]) -> None:
    model = model_data([[[system[0]]]], E=[[[1]]], C=[[[1]]], sample_time=system[1])

    assert verdict_of(model, None, BASE | claim) == "PROVED"
    for change in wrong:
        assert verdict_of(model, None, BASE | claim | change) == "UNDECIDED"


@pytest.mark.parametrize(("gain", "verdict"), [(2, "PROVED"), (1.9999, "UNDECIDED")])
def test_a_disturbance_that_reaches_the_output_directly(gain: float, verdict: str) -> None:
    """x' = -x + w with |w| <= 1 keeps |x| <= 1, so that y = x + w reaches 2."""
    claim = BASE | PEAK | {"P": [[1]], "level": 1, "multiplier": 1, "share": 0.5, "gain": gain}
    claim |= {"output": {"C": [[[1]]], "F": [[[1]]]}}
    assert verdict_of(model_data([[[-1]]], E=[[[1]]]), None, claim) == verdict


def test_two_disturbances_and_one_output() -> None:
    """y = x + [1, 0] w of x' = -2 x + [1, 1] w: [3/2, 1/2] at rest, sqrt(10) / 2 = 1.5811388..."""
    model = model_data([[[-2]]], E=[[[1, 1]]], C=[[[1]]])
    claim = BASE | GAIN | {"output": {"C": [[[1]]], "F": [[[1, 0]]]}}

    # By hand, P is at its best where gamma P = 1 at the limit.
    tried = [{"P": [[p / 100]]} for p in range(40, 90)]
    found = [
        {verdict_of(model, None, claim | {"gain": g} | P) for P in tried} for g in (1.6, 1.58113)
    ]
    assert "PROVED" in found[0] and found[1] == {"UNDECIDED"}


K = np.array([[[1.0, 2.0]], [[0.5, 1.5]]])


def loop() -> TSModel:
    return TSModel(
        [[[0.0, 1.0], [-1.0, -0.4]], [[0.0, 1.0], [-3.0, -0.2]]],
        [[[0.0], [1.0]], [[0.0], [1.5]]],
        C=[[[1.0, 0.0]], [[0.8, 0.1]]],
        D=[[[0.1]], [[0.2]]],
        E=[[[0.0], [1.0]], [[0.2], [1.0]]],
    )


def test_found_and_asked_gains_are_near_the_solvers() -> None:
    """The claim, exact, against the candidate of ``hinf_norm`` for the blends as arrays."""
    made = ClaimedLoop.of(loop(), K)
    least = hinf_norm(made.A, made.E, made.C).gain
    assert least is not None
    attempt = L2Gain().attempt(made)

    assert attempt.proved
    assert least < attempt.claim["gain"] <= least * 1.002
    assert L2Gain(least * (1 + 1e-5)).attempt(made).proved
    assert not L2Gain(least * (1 - 1e-4)).attempt(made).proved


def test_disturbance_added_to_the_input() -> None:
    """E = B says the same as "inputs", for a model without direct feed-through."""
    model = loop()
    same = TSModel(model.A, model.B, C=model.C, E=model.B)
    without = TSModel(model.A, model.B, C=model.C)

    ways = [L2Gain().attempt(ClaimedLoop.of(m, K)).claim for m in (same, without)]

    assert [claim["disturbance"] for claim in ways] == ["disturbances", "inputs"]
    assert ways[0]["gain"] == pytest.approx(ways[1]["gain"], rel=1e-6)


def test_unstable_loop_is_not_claimed() -> None:
    attempt = L2Gain().attempt(ClaimedLoop.of(TSModel([[[0.1]]], C=[[[1.0]]], E=[[[1.0]]])))

    assert attempt.checked.verdict is Verdict.UNDECIDED
    assert "not stable" in attempt.tried[0]


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
matrices = st.lists(numbers, min_size=4, max_size=4).map(lambda v: np.reshape(v, (2, 2)))


@settings(max_examples=10, deadline=None)
@given(matrices, st.booleans())
def test_one_vertex_has_the_norms_of_its_gramian_and_response(A: Any, discrete: bool) -> None:
    """sqrt(tr B'PB) by scipy's Gramian; sampled frequencies never exceed the proved gain."""
    A = A * 0.45 if discrete else A - 2.5 * np.eye(2)
    B, C = np.array([[1.0], [0.5]]), np.array([[1.0, 0.2]])
    solve = solve_discrete_lyapunov if discrete else solve_continuous_lyapunov
    P = solve(A.T, C.T @ C if discrete else -C.T @ C)
    truth = float(np.sqrt((B.T @ P @ B)[0, 0]))
    s = np.exp(1j * np.linspace(0, np.pi, 60)) if discrete else 1j * np.geomspace(1e-3, 1e2, 60)
    response = max(abs((C @ np.linalg.solve(x * np.eye(2) - A, B))[0, 0]) for x in s)
    loop = ClaimedLoop.of(TSModel([A], C=[C], E=[B], sample_time=0.5 if discrete else None))

    noise, gain = H2Norm().attempt(loop), L2Gain().attempt(loop)

    assert noise.proved and gain.proved
    assert truth < noise.claim["norm"] < truth * (1 + 3e-4)
    assert not H2Norm(truth * (1 - 1e-4)).attempt(loop).proved
    assert gain.claim["gain"] >= response * (1 - 1e-9)


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(matrices, matrices, st.booleans())
def test_proved_peak_holds_in_simulation(first: Any, second: Any, discrete: bool) -> None:
    """Blends that jump and a disturbance of full size that switches never exceed the bound."""
    step = 0.01
    A = np.array([M * 0.4 if discrete else M - 2.5 * np.eye(2) for M in (first, second)])
    model = TSModel(
        A,
        C=[[[1.0, 0.3]], [[0.7, -0.2]]],
        E=[[[1.0], [0.5]], [[0.8], [-0.5]]],
        sample_time=0.1 if discrete else None,
    )
    attempt = Peak().attempt(ClaimedLoop.of(model))
    assert attempt.proved

    draw = np.random.default_rng(1)
    x, most = np.zeros(2), 0.0
    for _ in range(1000):
        h = draw.dirichlet([0.3, 0.3])
        w = draw.choice([-1.0, 1.0]) * attempt.claim["disturbance_norm"]
        moved = np.einsum("i,ijk,k->j", h, model.A, x) + h @ model.E[:, :, 0] * w
        x = moved if discrete else x + step * moved
        most = max(most, abs(float(h @ model.C[:, 0] @ x)))
    assert most <= attempt.claim["gain"] * attempt.claim["disturbance_norm"] * 1.01
