"""Gradients of norm and slowest mode, against differences; and the bilinear transform."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi.gains.descent import GainLoops, response

Floats = NDArray[np.float64]


def loops(seed: int, *, discrete: bool) -> GainLoops:
    """Two random systems, stable without control, with a gain each, one entry of it fixed at 0."""
    rng = np.random.default_rng(seed)
    n, q, m, z, k = 4, 2, 2, 3, 2
    A = rng.standard_normal((2, n, n))
    values = np.linalg.eigvals(A)
    if discrete:
        A *= 0.7 / np.abs(values).max(axis=1)[:, None, None]
    else:
        A -= (values.real.max(axis=1) + 0.5)[:, None, None] * np.eye(n)

    def drawn(rows: int, columns: int) -> Floats:
        return rng.standard_normal((2, rows, columns))

    return GainLoops(
        A=A,
        B1=drawn(n, q),
        B2=drawn(n, m),
        C1=drawn(z, n),
        C2=drawn(k, n),
        D11=drawn(z, q),
        D12=drawn(z, m),
        D21=drawn(k, q),
        pattern=np.array([[True, False], [True, True]]),
        group=np.arange(2),
        discrete=discrete,
    )


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize("what", ["norm", "slowest"])
def test_the_gradient_is_that_of_differences(what: str, discrete: bool) -> None:
    for seed in range(5):
        system = loops(seed, discrete=discrete)
        function = getattr(system, what)
        x = 0.02 * np.random.default_rng(seed).standard_normal(system.count)

        _, gradient = function(x)

        step = 1e-6
        differences = [
            (function(x + step * e)[0] - function(x - step * e)[0]) / (2 * step)
            for e in np.eye(system.count)
        ]
        assert np.abs(gradient).max() > 0
        assert gradient == pytest.approx(np.array(differences), rel=1e-4, abs=1e-5)


def test_entries_off_the_pattern_stay_zero() -> None:
    system = loops(0, discrete=False)
    x = np.arange(1.0, 7.0)

    F = system.gains(x)

    assert F.shape == (2, 2, 2) and (F[:, 0, 1] == 0).all()
    assert (system.entries(F) == x).all()


def test_the_norm_in_discrete_time_is_that_on_the_unit_circle() -> None:
    system = loops(1, discrete=True)
    x = np.zeros(system.count)
    angles = np.exp(1j * np.linspace(0, np.pi, 20001))
    A, B, C, D = system.closed(system.gains(x))
    responses = [response(A[i], B[i], C[i], D[i], angles) for i in range(2)]
    seen = max(float(np.linalg.norm(one, 2, axis=(1, 2)).max()) for one in responses)

    assert seen <= np.exp(system.norm(x)[0]) * (1 + 1e-9) <= seen * (1 + 1e-6)


def test_an_unstable_loop_and_a_forbidden_gain_are_walls() -> None:
    system = loops(0, discrete=False)
    far = 1e3 * np.ones(system.count)
    narrow = replace(system, allowed=lambda F: bool(np.abs(F).max() < 1.0))

    assert system.norm(far)[0] == np.inf
    assert np.isfinite(narrow.slowest(0.5 * np.ones(6))[0])
    assert narrow.slowest(2.0 * np.ones(6))[0] == np.inf
