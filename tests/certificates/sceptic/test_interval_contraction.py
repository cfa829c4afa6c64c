"""The inequality of a published law's cell: true of every matrix and disturbance, and its edges."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.published.interval_matrices import contraction

DECAY, INVARIANCE, OUTSIDE = "decay", "invariance", "not inside its box"


def failure(
    A: tuple[str, str], *, P: str = "1.21", d: str = "0", rate: str = "1", alpha: str = "1"
) -> str:
    """Return what fails of y' = a y + e with a in a range and |e| <= d, V = P y^2."""
    low, high = ([[Fraction(end)]] for end in A)
    return first_failure(
        contraction(
            [[Fraction(P)]], [(low, high)], [Fraction(d)], Fraction(rate), Fraction(alpha), "here"
        )
    )


@pytest.mark.parametrize(
    ("changed", "fails"),
    [
        ({}, ""),
        # V <= 1 reaches |y| = 1 / sqrt(P).
        ({"P": "1.0000001"}, ""),
        ({"P": "1"}, OUTSIDE),
        # The rate of y' = -2 y is 2.
        ({"rate": "1.9999999"}, ""),
        ({"rate": "2"}, DECAY),
        # (2 * 2 - alpha) alpha > P d^2: 3 > 1.21 d^2, and 3.9999 * 0.0001 is too little for it.
        ({"d": "1.5745916"}, ""),
        ({"d": "1.5745917"}, INVARIANCE),
        ({"d": "0.1", "alpha": "3.9999"}, INVARIANCE),
        ({"d": "0.1", "alpha": "3.9"}, ""),
    ],
)
def test_one_state_at_its_thresholds(changed: dict[str, str], fails: str) -> None:
    found = failure(("-2", "-2"), **changed)

    assert fails in found and bool(fails) == bool(found)


@pytest.mark.parametrize(("rate", "fails"), [("0.99", ""), ("1", DECAY)])
def test_the_slowest_matrix_of_the_range_counts(rate: str, fails: str) -> None:
    """a in [-3, -1] with V = y^2, nearly: the rate is that of a = -1, whichever end is which."""
    found = failure(("-3", "-1"), P="1.0001", rate=rate, alpha="0.5")

    assert fails in found and bool(fails) == bool(found)


def test_every_corner_counts_and_eight_decimals_are_refused() -> None:
    fast, slow = ([[Fraction(a)]] for a in (-2, 1))
    for corners in ([(fast, fast), (slow, slow)], [(slow, slow), (fast, fast)]):
        found = first_failure(
            contraction([[Fraction(2)]], corners, [Fraction(0)], Fraction(1), Fraction(1), "here")
        )
        assert DECAY in found
    with pytest.raises(CertificateError, match="here: .*seven decimals"):
        failure(("-2.00000001", "-2"))


def _fractions(values: Any) -> Any:
    return np.vectorize(lambda x: Fraction(round(x * 10**7), 10**7), otypes=[object])(values)


def sampled(n: int, rng: np.random.Generator) -> bool:
    root = np.eye(n) * 1.1 + 0.15 * rng.normal(size=(n, n))
    P = _fractions(root @ root.T + 0.1 * np.eye(n))
    P = (P + P.T) / 2
    centre = -np.eye(n) * rng.uniform(0.5, 2) + 0.4 * rng.normal(size=(n, n))
    size = rng.uniform(0, 0.2) * rng.random((n, n))
    low, high = _fractions(centre - size), _fractions(centre + size)
    bound = _fractions(rng.uniform(0, 0.3, n))
    rate, alpha = (Fraction(round(x * 1000), 1000) for x in rng.uniform(0.05, 0.8, 2))
    if first_failure(
        contraction(
            P.tolist(), [(low.tolist(), high.tolist())], bound.tolist(), rate, alpha, "here"
        )
    ):
        return False
    p, least, most, d = (M.astype(float) for M in (P, low, high, bound))
    assert np.linalg.inv(p).diagonal().max() <= 1
    shape = np.linalg.inv(np.linalg.cholesky(p)).T
    for _ in range(20):
        A = np.where(rng.random((n, n)) < 0.5, least, most)
        decays = p @ A + A.T @ p + 2 * float(rate) * p
        assert np.linalg.eigvalsh(decays).max() < 1e-9
        v = rng.normal(size=n)
        y = shape @ v / np.linalg.norm(v)
        for signs in product((1, -1), repeat=n):
            assert 2 * y @ p @ (A @ y + np.array(signs) * d) < 1e-9
    return True


@pytest.mark.parametrize("n", [2, 3, 4])
def test_what_is_proved_holds_of_sampled_matrices_and_disturbances(n: int) -> None:
    """V' <= -2 rho V without disturbance, and V' < 0 on V = 1 with the worst one, in floats."""
    rng = np.random.default_rng(n)

    proved = [sampled(n, rng) for _ in range(60)]

    assert 5 < sum(proved) < 55, sum(proved)
