"""Intervals of the bootstrap and a year's wind, each two independent ways."""

from __future__ import annotations

from itertools import product
from math import exp, gamma, pi

import numpy as np
import pytest
from scipy.stats import bootstrap

from takagi.models.errors import ModelError
from takagi.reports.study.controllers_files import (
    Weibull,
    lifetime_load,
    lifetime_mean,
    mean_interval,
    resampled_seeds,
)

VALUES = np.array([1.2, 0.7, 1.9, 1.1, 0.4, 1.6])


def test_an_interval_is_that_of_all_draws_and_of_scipy() -> None:
    """All 6^6 draws of six seeds can be counted; scipy draws its own."""
    every = np.array([np.mean(draw) for draw in product(VALUES, repeat=6)])
    exact = np.percentile(every, [2.5, 97.5])
    drawn = bootstrap((VALUES,), np.mean, method="percentile", rng=7).confidence_interval

    ours = mean_interval(VALUES)

    assert ours.value == pytest.approx(VALUES.mean())
    assert (ours.low, ours.high) == pytest.approx(tuple(exact), abs=0.02)
    assert (ours.low, ours.high) == pytest.approx((drawn.low, drawn.high), abs=0.04)


def test_intervals_contain_the_true_mean_about_as_often_as_they_say() -> None:
    """Of 300 samples of 30 numbers; with six seeds fewer, which the tables say."""
    samples = np.random.default_rng(3).normal(2.0, 1.0, (300, 30))
    inside = [x.low <= 2.0 <= x.high for x in map(mean_interval, samples)]
    few = [x.low <= 2.0 <= x.high for x in (mean_interval(row[:6]) for row in samples)]

    assert 0.90 <= np.mean(inside) <= 0.97
    assert np.mean(few) < np.mean(inside)


def test_shares_are_those_of_the_closed_form() -> None:
    """They add up to F(25) - F(3); with shape 2 F is Rayleigh's; the mean is the one given."""
    means = [float(v) for v in range(4, 25, 2)]
    shares = Weibull(8.5, 2.0).shares(means, 3.0, 25.0)

    def rayleigh(v: float) -> float:
        return 1 - exp(-pi / 4 * (v / 8.5) ** 2)

    assert shares.sum() == pytest.approx(rayleigh(25) - rayleigh(3))
    assert shares[2] == pytest.approx(rayleigh(9) - rayleigh(7))
    # By quadrature over the density: the mean that was given, whatever the shape.
    fine = np.linspace(0, 80, 40_001)
    below = np.array([Weibull(10.0, 1.6).below(v) for v in fine])
    assert np.trapezoid(1 - below, fine) == pytest.approx(10.0, rel=1e-5)
    assert Weibull(10.0, 1.6).below(10 / gamma(1 + 1 / 1.6)) == pytest.approx(1 - exp(-1))


def test_a_year_by_hand() -> None:
    """Loads by their damage, energy by the time, 0 while the turbine stands; draws are shared."""
    loads, shares = np.array([[1.0, 3.0], [2.0, 2.0]]), np.array([0.5, 0.25])

    assert lifetime_load(loads, shares, 4.0).value == pytest.approx((0.5 * 41 + 0.25 * 16) ** 0.25)
    assert lifetime_mean(loads, shares).value == pytest.approx(0.5 * 2 + 0.25 * 2)
    extremes = lifetime_mean(loads, shares)
    assert (extremes.low, extremes.high) == pytest.approx((1.0, 2.0))
    assert np.array_equal(resampled_seeds(6), resampled_seeds(6))


@pytest.mark.parametrize("text", ["8.5", "8.5:x", "0:2", "8.5:-1", "nan:2"])
def test_a_wind_that_is_none(text: str) -> None:
    with pytest.raises(ModelError, match=r"8\.5:2"):
        Weibull.read(text)
