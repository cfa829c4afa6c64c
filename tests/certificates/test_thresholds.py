"""Published problems whose thresholds are algebraic: decided on both sides, within 1e-6 of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import Decay, Poles
from takagi.lmi import EigenvalueRegion
from takagi.models import TSModel
from tests.lmi.known_models import TRUCK_GAINS, truck_trailer

Floats = NDArray[np.float64]
PROVED, DISPROVED = Verdict.PROVED, Verdict.DISPROVED


def planar_pair(a: float) -> TSModel:
    """Return Dayawansa and Martin's pair, whose blends are all stable."""
    return TSModel([[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -a], [1 / a, -1.0]]])


def grown_pair(lam: float) -> TSModel:
    """Return two vertices of which the second has a stronger coupling, by lam."""
    return TSModel([[[-2.0, 4.0], [-1.0, -2.0]], [[-2.0, 4.0], [-(1 + lam), -2.0]]])


def placed_loop(b: float) -> tuple[TSModel, Floats]:
    """Return Tanaka, Ikeda and Wang's two rules, each gain placing its own poles at -2, -2."""
    A = np.array([[[2.0, -10.0], [1.0, 0.0]], [[2.5, -10.0], [1.0, 0.0]]])
    B = np.array([[[1.0], [0.0]], [[b], [0.0]]])
    K = np.array([[[6.0, -6.0]], [[6.5 / b, -6.0 / b]]])
    return TSModel(A, B), K


def companion(*poles: float) -> TSModel:
    coefficients: Sequence[float] = np.poly(poles)[1:].tolist()
    n = len(poles)
    return TSModel(np.vstack([-np.array(coefficients), np.eye(n)[:-1]])[None])


@pytest.mark.parametrize(
    ("a", "verdict"),
    [
        (5.828427, PROVED),
        (5.828428, DISPROVED),
        (0.1715729, PROVED),
        (0.1715728, DISPROVED),
        (1.0, PROVED),
        (20.0, DISPROVED),
    ],
)
def test_planar_pair(a: float, verdict: Verdict) -> None:
    """Dayawansa & Martin (1999): one P iff 3 - sqrt(8) = 0.17157288 < a < 5.82842712."""
    assert certify(planar_pair(a), decay_rate=0).verdict is verdict


@pytest.mark.parametrize(("lam", "verdict"), [(9.656854, PROVED), (9.656855, DISPROVED)])
def test_grown_pair(lam: float, verdict: Verdict) -> None:
    """Shorten & Narendra (2002): one P iff lam < 4 + 4 sqrt(2) = 9.65685425."""
    assert certify(grown_pair(lam), decay_rate=0).verdict is verdict


@pytest.mark.parametrize(
    ("b", "verdict"), [(2.999999, PROVED), (4.0, PROVED), (4.441519, DISPROVED)]
)
def test_gains_that_place_poles(b: float, verdict: Verdict) -> None:
    """Tanaka, Ikeda & Wang (1998), data: b + 1/b < 10/3 for the mean of G_12 and G_21, so b < 3.

    Beyond it the mean alone is unstable, which the loop never has alone.  It has h = (1/2, 1/2),
    where det G(h) = 10 - 6 (1 + h_1 h_2 (b + 1/b - 2)) is zero at b = (7 + 2 sqrt(10))/3 = 4.44152.
    """
    assert certify(*placed_loop(b), decay_rate=0).verdict is verdict


@pytest.mark.parametrize(("rate", "verdict"), [(2.499999, PROVED), (2.500001, DISPROVED)])
def test_decay_of_one_matrix(rate: float, verdict: Verdict) -> None:
    """The example of YALMIP's page on decay rates: eigenvalues with real part -5/2."""
    assert certify(TSModel([[[-1.0, 2.0], [-3.0, -4.0]]]), decay_rate=rate).verdict is verdict


@pytest.mark.parametrize(("rate", "verdict"), [(1.999999, PROVED), (2.000001, DISPROVED)])
def test_decay_of_a_companion_matrix(rate: float, verdict: Verdict) -> None:
    """(s + 2)(s + 3)(s + 5) decays at 2 1/s."""
    assert certify(companion(-2, -3, -5), claims=[Decay(rate)]).verdict is verdict


@pytest.mark.parametrize(
    ("inside", "outside"),
    [
        (EigenvalueRegion.half_plane(1.999999), EigenvalueRegion.half_plane(2.000001)),
        (EigenvalueRegion.disc(5.000001), EigenvalueRegion.disc(4.999999)),
        (
            EigenvalueRegion.vertical_strip(0, 5.000001),
            EigenvalueRegion.vertical_strip(0, 4.999999),
        ),
        (EigenvalueRegion.sector(1e-6), EigenvalueRegion.disc(0.5)),
    ],
    ids=str,
)
def test_poles_of_a_companion_matrix(inside: EigenvalueRegion, outside: EigenvalueRegion) -> None:
    """(s + 2)(s + 3)(s + 5): within 1e-6 of the edge, and never beyond it.

    Floating point with a tolerance of 1e-10 accepts the disc of radius 4.983.
    """
    assert certify(companion(-2, -3, -5), claims=[Poles(inside)]).verdict is PROVED
    for region in (outside, EigenvalueRegion.disc(4.983)):
        assert certify(companion(-2, -3, -5), claims=[Poles(region)]).verdict is not PROVED


def test_a_loop_with_printed_gains_is_not_stable_by_its_printed_function() -> None:
    """Tanaka & Sano (1994), gains and P with four digits, recalled: no P is proved with these."""
    assert certify(truck_trailer(), -TRUCK_GAINS, decay_rate=0).verdict is not PROVED
