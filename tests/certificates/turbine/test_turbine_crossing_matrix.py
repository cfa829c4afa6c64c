"""``turbine-crossing``: the Jacobian against the nonlinear loop, and where the loop has none."""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from itertools import islice
from typing import Any, cast

import numpy as np
import pytest
from flint import fmpq, fmpq_mat
from scipy.interpolate import BivariateSpline
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.checker.arithmetic import interval, spline_point
from takagi.certificates.checker.kernel import refusal
from takagi.certificates.checker.turbine.effort_sharing import inputs as plants
from takagi.certificates.checker.turbine.linear_loop import jacobian, pieces, trim
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers
from takagi.certificates.cross_check.turbine.linear import linear_rates
from takagi.certificates.cross_check.turbine.running import machine as second
from takagi.certificates.cross_check.turbine.surface import Outside
from tests.certificates.turbine.crossing_documents import (
    BOTH,
    NEITHER,
    NOMINAL,
    WINDS,
    Data,
    F,
    as_read,
    box_of,
    floats,
    linear_at,
    matrix_of,
    stored_documents,
)
from tests.certificates.turbine.running_documents import sealed, verdicts
from tests.certificates.turbine.schedule_field import SCHEDULE, WIND, Field


@pytest.fixture(scope="module")
def stored() -> list[Data]:
    return stored_documents()


@pytest.fixture
def document(stored: list[Data]) -> Data:
    return deepcopy(stored[0])


# The matrix.


class WithWake(Field):
    """The nonlinear loop with uncertain slopes of the torque, and the wake's answer to wind."""

    def __init__(self, document: Data, mean: float, value: dict[str, float]) -> None:
        document = deepcopy(document)
        document["claims"][0]["functions"] = [{"wind": mean, "P": [[1]]}]
        super().__init__(document)
        self.mean, self.value = mean, value
        ends = [self._trim(mean + step) for step in (-1e-6, 1e-6)]
        self.speed_slope, self.pitch_slope = (np.array(ends[1]) - np.array(ends[0])) / 2e-6
        omega, beta = self._trim(mean)
        steps = ((1e-6, 0, 0), (0, 1e-6, 0), (0, 0, 1e-6))
        self.slopes = [
            (
                self.torque(omega + a, beta + b, mean + c)
                - self.torque(omega - a, beta - b, mean - c)
            )
            / 2e-6
            / self.J
            for a, b, c in steps
        ]

    def _trim(self, wind: float) -> tuple[float, float]:
        return float(self.at("rotor_speed", wind)), float(self.trim_pitch(wind))

    def field(self, y: Any, wake_wind: float) -> Any:
        """Return the rates of ``Field``'s states, and of the wake's wind."""
        speed, pitch, wind = y[0], y[1], y[WIND]
        value = self.value
        a, by_pitch, d = self.slopes
        found = self.rates(
            y,
            self.commands(y)[1],
            value["inertia"],
            value["wake_of_pitch"] * float(self.late(self.mean)),
            value["wake_length"],
            0.0,
        )
        # At the wind U the wake's rate is U / L, as the wake's pitch is at rest there.
        omega, beta = self._trim(wind)
        more = (value["speed_damping"] - 1) * a * (speed - omega)
        more += (value["pitch_effectiveness"] - 1) * by_pitch * (pitch - beta)
        more += value["wake_of_wind"] * d * (wind - wake_wind)
        found[0] += more / value["inertia"]
        return np.append(found, self.mean / value["wake_length"] * (wind - wake_wind))


# Place of the claim's states among those of the field, whose last is the wake's wind.
PLACES = (0, 1, 2, SCHEDULE, 4, 5, 6, 7, 11, WIND, 8, 9)


@pytest.mark.parametrize("wind", WINDS)
def test_the_matrix_is_the_jacobian_of_the_nonlinear_loop(document: Data, wind: str) -> None:
    """Central differences of a loop that shares no code with the checkers; parameters drawn."""
    linear, mean = linear_at(document, wind), float(wind)
    random = np.random.default_rng(7)
    drawn = {name: F(round(random.uniform(0.8, 1.2), 3)) for name in pieces.PARAMETERS}
    drawn |= {"wake_of_wind": F("0.27"), "wake_length": F(51)}
    A = floats(matrix_of(linear, drawn))
    field = WithWake(document, mean, {name: float(x) for name, x in drawn.items()})
    omega, beta = field._trim(mean)
    rest = np.array([omega, beta, 0, mean, omega, omega, mean, beta, omega, omega, mean])
    found = np.zeros((12, 12))
    for i in range(12):
        step = 1e-6
        ahead, behind = (np.append(rest, mean) for _ in range(2))
        ahead[i] += step
        behind[i] -= step
        rates = [field.field(y[:11], y[11]) for y in (ahead, behind)]
        found[:, i] = (rates[0] - rates[1]) / (2 * step)
    # Without r, which the field does not have; y' = r is its wind's rate, 0.
    kept = [i for i in range(jacobian.order(linear.machine)) if i != 10]
    mine = A[np.ix_(kept, kept)]
    theirs = found[np.ix_(PLACES, PLACES)]
    np.testing.assert_allclose(mine, theirs, rtol=2e-6, atol=2e-7)
    assert A[9].tolist() == np.eye(13)[10].tolist()


def test_where_the_law_asks_for_the_least_pitch_the_matrix_has_no_pitch(document: Data) -> None:
    """At 4.1 m/s psi and its slope are 0: pitch from rest stays at rest."""
    linear = linear_at(document, "4.1")
    A = floats(matrix_of(linear, NOMINAL))
    assert np.flatnonzero(A[1]).tolist() == [1]


def test_both_checkers_have_the_same_matrix(document: Data) -> None:
    """Entry by entry, as rational numbers; with the band-stop and without."""
    for wind in WINDS:
        for stop in (True, False):
            linear = linear_at(document, wind, stop=stop)
            read = loads(json.dumps(document))
            claim = read["claims"][0]
            machine = second.Machine(claim, read["model"], read["gains"])
            if not stop:
                machine.stop = None
            rotor = numbers.Rotor(read["model"], read["gains"])
            mean = fmpq(F(wind).numerator, F(wind).denominator)
            other = linear_rates.LinearRates(rotor, machine, claim, mean)
            for values in islice(pieces.corners(box_of(document)), 5, 9):
                A = matrix_of(linear, values)
                B = other.at({k: fmpq(v.numerator, v.denominator) for k, v in values.items()})
                assert fmpq_mat([[fmpq(x, A.below) for x in row] for row in A.rows]) == B


def test_the_matrix_of_an_inner_point_is_a_blend_of_the_corners(document: Data) -> None:
    """Weights are products of shares of 1/inertia, the factors, and 1/wake_length; exactly."""
    linear = linear_at(document, "12")
    box = box_of(document) | {"wake_length": (F(40), F(80))}
    inner = {
        name: low + F(i + 1, 8) * (high - low) for i, (name, (low, high)) in enumerate(box.items())
    }
    total, weights = np.zeros((13, 13), dtype=object), F(0)
    for values in pieces.corners(box):
        weight = F(1)
        for name, (low, high) in box.items():
            inverse = name in ("inertia", "wake_length")
            at, start, stop = (1 / x if inverse else x for x in (inner[name], low, high))
            share = (at - start) / (stop - start)
            weight *= share if values[name] == high else 1 - share
        A = matrix_of(linear, values)
        total = total + weight * np.array([[F(x, A.below) for x in row] for row in A.rows])
        weights += weight
        assert weight >= 0
    A = matrix_of(linear, inner)
    assert weights == 1
    assert (total == np.array([[F(x, A.below) for x in row] for row in A.rows])).all()


def test_the_wind_has_the_deviation_and_the_rate_that_are_stated(document: Data) -> None:
    wind = pieces.Turbulence.read(as_read(document)["claims"][0], "")
    A = np.array([[0, 1], [-float(wind.stiffness), -float(wind.damping)]])
    found = solve_continuous_lyapunov(A, -np.diag([0, float(wind.intensity)]))
    stated = document["claims"][0]["turbulence"]
    expected = [stated["deviation"] ** 2, stated["rate"] ** 2]
    np.testing.assert_allclose(np.diag(found), expected, rtol=1e-9)
    # Two filters one after the other: t_r and t_L have this sum and product of rates.
    t_r = stated["rotor_time"]
    t_l = (stated["deviation"] / stated["rate"]) ** 2 / t_r
    assert float(wind.damping) == pytest.approx(1 / t_r + 1 / t_l, rel=1e-12)


# The spline at a point.


def test_the_spline_at_a_point_is_that_of_scipy_and_of_the_ranges(document: Data) -> None:
    model = as_read(document)["model"]
    surface, ranges = spline_point.ExactSurface.read(model), plants.Plant.read(model).surface
    table = document["model"]["torque_surface"]
    known: Any = cast("Any", BivariateSpline)._from_tck((
        np.array(table["tip_speed_ratio_knots"]), np.array(table["pitch_knots"]),
        np.array(table["coefficients"]).ravel(), 3, 3,
    ))  # fmt: skip
    other = numbers.Rotor(
        loads(json.dumps(document["model"])), loads(json.dumps(document["gains"]))
    )
    x_knots, y_knots = surface.x_knots, surface.y_knots
    inside = [(F("7.55"), F("0.0131")), (F("3.9"), F("0.31")), (x_knots[7], y_knots[9])]
    ends = [(x_knots[0], y_knots[0]), (x_knots[-1], y_knots[-1])]
    for x, y in inside + ends:
        found = surface.at(x, y)
        orders = ((0, 0), (1, 0), (0, 1))
        expected = [float(known.ev(float(x), float(y), dx=i, dy=j)) for i, j in orders]
        np.testing.assert_allclose([float(one) for one in found], expected, rtol=1e-9, atol=1e-12)
        for one, (i, j) in zip(found, orders, strict=True):
            low, high = ranges.bounds(interval.point(x), interval.point(y), i, j)
            assert low <= one * interval.ONE <= high
        again = other.surface.at(*(fmpq(v.numerator, v.denominator) for v in (x, y)))
        assert [F(int(v.p), int(v.q)) for v in again] == list(found)
    for x, y in ((x_knots[0] - 1, F(0)), (F(7), y_knots[-1] + 1)):
        with pytest.raises(refusal.Refused, match="leaves the coefficient table"):
            surface.at(x, y)


# Where there is no linear loop.


def _limits(law: plants.Law) -> Iterator[tuple[plants.Law, str]]:
    count = len(law.wind) - 1
    yield replace(law, rated_torque=F(1)), "torque is at zero"
    yield replace(law, inertia_limit=[F(0)] * count), "feed-forward of the torque is at a limit"
    high = [F(1)] * (count + 1)
    yield replace(law, effort=high, inertia=[F(1)] * count), "feed-forward of the torque"
    still = [F(0)] * count
    yield replace(law, effort=high, inertia=still, pitch_max=law.pitch_min), "pitch is at its upper"


def test_the_loop_has_no_matrix_where_a_limit_is_met(document: Data) -> None:
    linear, read = linear_at(document, "8"), as_read(document)
    law, surface = plants.Law.read(read["gains"]), spline_point.ExactSurface.read(read["model"])
    for other, words in _limits(law):
        with pytest.raises(refusal.Refused, match=words):
            trim.trim_at(linear.plant, other, linear.machine, surface, F(8))
    narrow = replace(linear.machine, wind_limits=(F(8), F(30)))
    with pytest.raises(refusal.Refused, match="limits of the estimate"):
        trim.trim_at(linear.plant, law, narrow, surface, F(8))


def test_both_checkers_refuse_a_matrix_at_the_same_limits(document: Data) -> None:
    """Zero torque, a cut feed-forward, and pitch at its limit, in the file."""
    gains = document["gains"]
    count = len(gains["wind"])
    document.pop("controller")
    for change in (
        {"rated_torque": 1.0},
        {"feedforward_limit": [0.0] * (count - 1)},
        {"trim_effort": [1.0] * count, "inertia_feedforward": [0.1] * (count - 1)},
    ):
        document["gains"] = gains | change
        assert verdicts(document) == NEITHER
    document["gains"] = gains | {"trim_effort": [1.0] * count, "pitch_max": 0.1}
    document["model"] = document["model"] | {"pitch_max": 0.1}
    assert verdicts(document) == NEITHER
    with pytest.raises(CertificateError):
        check_document(document)


def test_the_second_checker_refuses_each_limit_alone(document: Data) -> None:
    """As the first does: a feed-forward at a limit, and pitch at its limit, all else as it is."""
    read = loads(json.dumps(document))
    claim = read["claims"][0]
    machine = second.Machine(claim, read["model"], read["gains"])

    def answer(wind: int, ahead: fmpq, most: fmpq, pitch: fmpq) -> str:
        rotor = numbers.Rotor(read["model"], read["gains"])
        rotor.ahead = [ahead] * len(rotor.ahead)
        rotor.ahead_limit = [most] * len(rotor.ahead)
        rotor.pitch_max = rotor.pitch_min + pitch
        try:
            linear_rates.LinearRates(rotor, machine, claim, fmpq(wind))
        except Outside as reason:
            return str(reason)
        return "a matrix"

    none, some = fmpq(0), fmpq(1, 9)
    assert answer(8, some, fmpq(1), fmpq(1)) == "a matrix"
    assert answer(8, none, none, fmpq(1)) == "a matrix"
    assert answer(12, none, none, fmpq(1)) == "a matrix"
    assert "feed-forward" in answer(8, some, none, fmpq(1))
    # Above rated wind nothing brakes: torque is at its rated value.
    assert "feed-forward" in answer(12, some, fmpq(1), fmpq(1))
    # At 8 m/s pitch is at its lower limit.
    assert answer(8, none, none, fmpq(1, 10**9)) == "a matrix"
    assert "pitch at its upper limit" in answer(8, none, none, none)


def test_torques_that_differ_are_no_trim(document: Data) -> None:
    """At 8 m/s no entry of the matrix depends on the effort's height, which moves the residual.

    The limit is a tenth of the overlap, 0.001 rad/s^2; the residual of the file is 0.000036.
    """
    law, effort = document["gains"], document["gains"]["trim_effort"]
    document.pop("controller")
    own = linear_at(document, "8").trim.residual
    assert abs(own) < F("0.00004")
    for above, expected in (("0.00099", BOTH), ("0.00101", NEITHER)):
        for sign in (-1, 1):
            shift = float(sign * F(above) + own)
            law["trim_effort"] = [x + shift for x in effort]
            assert verdicts(document) == expected
    assert "there is no trim" in check_document(sealed(document)).claims[0].text
