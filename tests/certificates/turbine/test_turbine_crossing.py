"""``turbine-crossing``: the Jacobian against the nonlinear loop, Rice's formula, forged files.

The certificates are the first two lines of ``recorded/turbine-crossing.jsonl``: the default law of
the NREL 5-MW turbine at 8 m/s with one covariance, and at 13 m/s on three pieces.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from flint import fmpq, fmpq_mat
from scipy.interpolate import BivariateSpline
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates import CertificateError, DesignSettings
from takagi.certificates.checker import Verdict, check_document
from takagi.certificates.checker.arithmetic import interval, spline_point
from takagi.certificates.checker.files import gain_file
from takagi.certificates.checker.kernel import matrices, reader, refusal
from takagi.certificates.checker.turbine.effort_sharing import inputs as plants
from takagi.certificates.checker.turbine.linear_loop import (
    crossing_claim as verdict,
)
from takagi.certificates.checker.turbine.linear_loop import jacobian, pieces, trim
from takagi.certificates.checker.turbine.running_loop import inputs as machines
from takagi.certificates.claims.turbine import (
    MEAN_WINDS,
    CrossingAsked,
    crossing_claim,
    crossing_claims,
)
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers
from takagi.certificates.cross_check.turbine.linear import linear_rates
from takagi.certificates.cross_check.turbine.running import machine as second
from takagi.certificates.design import claim_summary
from takagi.certificates.requests.loop import exact_floats
from takagi.cli.main import main
from takagi.cli.terminal import turbine_summary
from takagi.models import ModelError
from takagi.models.turbine import RotorWind
from takagi.reports.sections.turbine import verdict as report_verdict
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdicts
from tests.certificates.turbine.schedule_field import SCHEDULE, WIND, Field

floats, as_read = exact_floats.floats, exact_floats.as_read
F = Fraction
Data = dict[str, Any]
BOTH, NEITHER, REFUSED = ("PROVED",) * 2, ("UNDECIDED",) * 2, ("refused",) * 2
NOMINAL = dict(zip(pieces.PARAMETERS, map(F, (1, 1, 1, 1, 0, 63)), strict=True))
KIND = "turbine-crossing"
# Below the ramp of the effort, on it twice, and above it; each between two nodes of the tables.
WINDS = ("4.1", "8", "11.4", "12", "15", "22.2")


@pytest.fixture(scope="module")
def stored() -> list[Data]:
    return [dict(json.loads(text)) for _, text in islice(recorded("turbine-crossing"), 2)]


@pytest.fixture
def document(stored: list[Data]) -> Data:
    return deepcopy(stored[0])


@pytest.fixture
def in_pieces(stored: list[Data]) -> Data:
    return deepcopy(stored[1])


def linear_at(document: Data, wind: str, *, stop: bool = True) -> verdict.LinearLoop:
    """Return the loop of a document at a wind, as the first checker computes it."""
    read = as_read(document)
    claim = read["claims"][0]
    plant, law = plants.Plant.read(read["model"]), plants.Law.read(read["gains"])
    machine = machines.Machine.read(claim, read["model"], read["gains"], "claim")
    machine = machine if stop else replace(machine, stop=None)
    surface = spline_point.ExactSurface.read(read["model"])
    at = trim.trim_at(plant, law, machine, surface, F(wind))
    return verdict.LinearLoop(plant, machine, pieces.Turbulence.read(claim, "claim"), at, F(1))


def matrix_of(linear: verdict.LinearLoop, values: dict[str, Fraction]) -> matrices.Matrix:
    return jacobian.loop_matrix(linear.trim, linear.plant, linear.machine, linear.wind, values)


def box_of(document: Data) -> pieces.Box:
    return pieces.parameter_box(as_read(document)["claims"][0], "")


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


# Verdicts.


def rice(document: Data, C: Any, box: Any, wind: str) -> float:
    """Return the bound of one piece in floating point."""
    claim, linear = document["claims"][0], linear_at(document, wind)
    b = claim["overspeed"] * document["model"]["rated_rotor_speed"]
    h = np.zeros(13)
    h[0], h[9] = 1, -float(linear.trim.speed_slope)
    m2 = max(float(h @ A @ C @ A.T @ h) for A in map(floats, linear.at(box)))
    s2 = float(h @ C @ h)
    xi = b**2 / (2 * s2)
    crossings = claim["horizon"] * np.sqrt(m2 / s2) / np.pi
    return float(np.exp(-xi) * (1 / np.sqrt(np.pi * xi) + crossings))


def test_both_checkers_prove_them(document: Data, in_pieces: Data) -> None:
    for one in (document, in_pieces):
        assert verdicts(one) == BOTH


def test_the_probability_from_both_sides(document: Data, in_pieces: Data) -> None:
    for one, wind in ((document, "8"), (in_pieces, "13")):
        claim = one["claims"][0]
        read = as_read(claim)
        parts = pieces.cut_boxes(read, pieces.parameter_box(read, ""), "")
        found = max(
            rice(one, np.array(C), part, wind) for C, part in zip(claim["C"], parts, strict=True)
        )
        for factor, expected in ((1 + 1e-7, BOTH), (1 - 1e-7, NEITHER)):
            claim["probability"] = found * factor
            assert verdicts(one) == expected


def test_no_vertex_has_more_than_the_bound(in_pieces: Data) -> None:
    """Rice's formula with the stationary covariance, at all corners of the whole box."""
    claim, linear = in_pieces["claims"][0], linear_at(in_pieces, "13")
    S = np.zeros((13, 13))
    S[10, 10] = float(linear.wind.intensity)
    b = claim["overspeed"] * in_pieces["model"]["rated_rotor_speed"]
    worst = 0.0
    for A in map(floats, linear.at(box_of(in_pieces))):
        X = solve_continuous_lyapunov(A, -S)
        xi = b**2 / (2 * X[0, 0])
        rate = np.sqrt((A @ X @ A.T)[0, 0] / X[0, 0])
        worst = max(worst, np.exp(-xi) * (1 / np.sqrt(np.pi * xi) + 600 / np.pi * rate))
    assert 1e-10 < worst < claim["probability"] < 1e4 * worst


def test_the_sentence_says_what_is_proved_and_what_is_not(document: Data) -> None:
    said = check_document(sealed(document)).claims[0]
    for phrase in (
        "linearised at its trim at a mean wind of 8 m/s",
        "within 600 s the rotor's speed departs from its reference at the present wind by 20 % of "
        "rated speed (0.2535 rad/s)",
        "a deviation of 1.09 m/s and an rms rate of 0.09 m/s^2",
        "inertia 0.9 to 1.1 of nominal",
        "its excess in wind 0.2 to 0.3 of the torque's slope in wind",
        "The reference is a line in the wind here, without its stop at rated speed",
        "Nothing is said of the nonlinear loop, its limits, or another mean wind",
    ):
        assert phrase in said.text
    assert "loop linearised at the trim of one mean wind, without its limits" in said.assumes
    assert "rigid shaft, tower and blades" in said.assumes


Change = Callable[[Any], None]


def entry(*path: Any, factor: float = 1.0, value: Any = None) -> Change:
    """Return a change of one number of the document, or of the numbers it is given."""

    def change(document: Any) -> None:
        at = document
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = at[path[-1]] * factor if value is None else value

    return change


def column(name: str, factor: float) -> Change:
    """Return a change of a table of the law."""

    def change(document: Any) -> None:
        document["gains"][name] = [factor * x for x in document["gains"][name]]

    return change


def scaled(factor: float) -> Change:
    def change(document: Any) -> None:
        C = document["claims"][0]["C"][0]
        document["claims"][0]["C"][0] = [[factor * x for x in row] for row in C]

    return change


def uncertain(name: str, low: float, high: float) -> Change:
    return entry("claims", 0, "uncertainty", name, value=[low, high])


CLAIM = ("claims", 0)
FALSE = {
    "a smaller probability": entry(*CLAIM, "probability", factor=0.9),
    "a longer time": entry(*CLAIM, "horizon", factor=1.2),
    "a smaller overspeed": entry(*CLAIM, "overspeed", factor=0.97),
    "a limit below the deviation": entry(*CLAIM, "overspeed", value=0.01),
    "another wind": entry(*CLAIM, "wind", value=9.9),
    "a stronger wind": entry(*CLAIM, "turbulence", "deviation", factor=1.1),
    "a faster wind": entry(*CLAIM, "turbulence", "rate", factor=1.1),
    "a slower average": entry(*CLAIM, "turbulence", "rotor_time", factor=0.5),
    "lighter rotors": uncertain("inertia", 0.5, 1.1),
    "heavier rotors": uncertain("inertia", 0.9, 2.0),
    "less damping": uncertain("speed_damping", 0.2, 1.2),
    "more of the wake's wind": uncertain("wake_of_wind", 0.2, 0.8),
    "a shorter wake": uncertain("wake_length", 20.0, 63.0),
    "one entry of C": entry(*CLAIM, "C", 0, 0, 1, factor=1.001),
    "a smaller covariance": scaled(0.97),
    "a larger covariance": scaled(1.1),
    "a negative covariance": scaled(-1.0),
    "a wind at a node of the tables": entry(*CLAIM, "wind", value=7.7755),
    "a wind below the tables": entry(*CLAIM, "wind", value=2.9),
    "a wind above the tables": entry(*CLAIM, "wind", value=25.5),
    "another turbine": entry("model", "torque_constant", factor=1.2),
    "a heavier turbine": entry("model", "rotor_inertia", factor=0.7),
    "another surface": entry("model", "torque_surface", "coefficients", 12, 6, factor=0.5),
    "lower gains": column("proportional", 0.8),
    "a slower integral": column("integral_rate", 4.0),
    "another reference": column("rotor_speed", 1.05),
    "a reference at the mean wind": column("trim_effort", 0.9),
}


@pytest.mark.parametrize("name", FALSE)
def test_what_is_not_shown_is_undecided(document: Data, name: str) -> None:
    FALSE[name](document)
    # Laws and turbines that were changed: the gain file is no matter here.
    document.pop("controller")
    assert verdicts(document) == NEITHER


@pytest.mark.parametrize("name", ["pitch_effectiveness", "wake_of_pitch"])
def test_wider_ranges_of_pitch_are_not_shown(in_pieces: Data, name: str) -> None:
    uncertain(name, 0.5, 3.0)(in_pieces)
    assert verdicts(in_pieces) == NEITHER


UNREADABLE = {
    "no probability": entry(*CLAIM, "probability", value=0.0),
    "a certain probability": entry(*CLAIM, "probability", value=1.0),
    "no time": entry(*CLAIM, "horizon", value=0.0),
    "no overspeed": entry(*CLAIM, "overspeed", value=-0.2),
    "no wind": entry(*CLAIM, "wind", value=0.0),
    "no turbulence": entry(*CLAIM, "turbulence", "deviation", value=0.0),
    "a negative rate": entry(*CLAIM, "turbulence", "rate", value=-0.1),
    "no average": entry(*CLAIM, "turbulence", "rotor_time", value=0.0),
    "an empty range": uncertain("speed_damping", 1.2, 0.8),
    "a negative damping": uncertain("speed_damping", -0.1, 1.2),
    "a massless rotor": uncertain("inertia", 0.0, 1.1),
    "a negative wake": uncertain("wake_of_wind", -0.1, 0.3),
    "no wake's length": uncertain("wake_length", 0.0, 63.0),
    "another observer": entry(*CLAIM, "observer", "l2", factor=1.01),
    "another filter": entry(*CLAIM, "measurement", "speed_filter", factor=2.0),
    "another band-stop": entry(*CLAIM, "measurement", "torsion_filter", "passed", value=0.3),
    "a covariance of another order": entry(*CLAIM, "C", value=[[[1.0]]]),
    "no covariance": entry(*CLAIM, "C", value=[]),
    "a piece without its halves": entry(*CLAIM, "cuts", value=["inertia"]),
    "half a tree": entry(*CLAIM, "cuts", value=["inertia", ""]),
    "two trees": entry(*CLAIM, "cuts", value=["", ""]),
    "no tree": entry(*CLAIM, "cuts", value=[]),
    "no parameter": entry(*CLAIM, "cuts", value=["mass", "", ""]),
    "a number": entry(*CLAIM, "cuts", value=[0, "", ""]),
    "a parameter with one value": entry(*CLAIM, "cuts", value=["wake_length", "", ""]),
    "another law": entry("gains", "name", value="paper"),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_makes_no_claim_is_refused(document: Data, name: str) -> None:
    UNREADABLE[name](document)
    assert verdicts(document) == REFUSED


def test_the_covariances_belong_to_their_pieces(in_pieces: Data) -> None:
    """The lower half comes first, in both checkers; no piece may be left out."""
    claim = in_pieces["claims"][0]
    claim["C"] = claim["C"][::-1]
    assert verdicts(in_pieces) == NEITHER
    claim["C"] = claim["C"][:-1]
    assert verdicts(in_pieces) == REFUSED
    claim["cuts"] = claim["cuts"][:-1]
    assert verdicts(in_pieces) == REFUSED


def test_a_narrower_family_keeps_the_claim(document: Data) -> None:
    """A sub-box has its matrices in the same hull, and parameters with one value no corners."""
    box = document["claims"][0]["uncertainty"]
    for name in ("inertia", "speed_damping", "wake_of_wind"):
        box[name] = [sum(box[name]) / 2] * 2
    assert verdicts(document) == BOTH


def test_terminal_and_report_say_what_is_proved(document: Data, in_pieces: Data) -> None:
    document["claims"] += in_pieces["claims"]
    checked = check_document(sealed(document))
    design: Any = SimpleNamespace(document=document, checked=checked)
    probability = document["claims"][0]["probability"]
    found = claim_summary.turbulence_summary(design)
    assert found[0] == claim_summary.RareOverspeed(8.0, 0.2, probability, 600.0)
    assert turbine_summary._turbulence(design).endswith(
        "within 600 s, by a share of rated speed, with probability at most, at "
        "8 m/s: 20 % with 0.00076; 13 m/s: 20 % with 1.5e-6"
    )
    row = report_verdict._in_turbulence(design)[1]
    assert row[:2] == ("Turbulence at 13 m/s", "\u2264 1.5e-6")
    undecided = replace(checked.claims[0], verdict=Verdict.UNDECIDED)
    design.checked = replace(checked, claims=[undecided, undecided])
    assert turbine_summary._turbulence(design) == ""
    assert report_verdict._in_turbulence(design) == []


def test_a_file_that_would_take_minutes_is_refused(document: Data) -> None:
    """Five parameters have ranges: 109 pieces of 32 corners are below 10^8/13^4, 110 are above.

    The first piece of each file fails, so that no more is tested.
    """
    claim = document["claims"][0]
    claim["probability"] /= 2
    for count, expected in ((109, NEITHER), (110, REFUSED)):
        claim["C"] = claim["C"][:1] * count
        claim["cuts"] = ["inertia", ""] * (count - 1) + [""]
        assert verdicts(document) == expected


def test_a_gain_file_without_what_the_claim_is_about_is_another(
    document: Data, tmp_path: Path
) -> None:
    """Other members may be left out, which is told; observer and filters may not."""
    data, path = as_read(sealed(document)), tmp_path / "gains.json"
    whole = gain_file.expected_file(data)
    for part, message in (("units", "it does not say units"), ("name", "it does not say name")):
        path.write_text(reader.canonical({k: v for k, v in whole.items() if k != part}))
        assert message in gain_file.compare_gains(data, path)
    for part in ("observer", "measurement"):
        path.write_text(reader.canonical({k: v for k, v in whole.items() if k != part}))
        with pytest.raises(refusal.OtherGains, match=f"{part}.* is not the gain file's"):
            gain_file.compare_gains(data, path)


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


# Candidates.


def _given(document: Data) -> tuple[Data, Data, Data, list[float]]:
    return document["model"], document["gains"], document["controller"], [0.9, 1.1]


def test_a_candidate_is_proved_with_the_least_overspeed(document: Data) -> None:
    """At 9 m/s 20 % has 0.00106, and 25 % 3e-6: the probability asked for is 10^-3."""
    asked = CrossingAsked(9.0, RotorWind.of_class("B", 9.0))
    (claim,), why = crossing_claim(*_given(document), asked)
    assert why == {}
    assert claim["overspeed"] == 0.25
    assert 1e-6 < claim["probability"] < 1e-5
    document["claims"] = [claim]
    assert verdicts(document) == BOTH


@pytest.mark.slow
def test_pieces_are_cut_until_the_probability_is_shown(document: Data) -> None:
    """At 9 m/s and 20 % one covariance shows 0.00106; a few pieces show 0.00095."""
    one = CrossingAsked(9.0, RotorWind.of_class("B", 9.0), 9.5e-4, 0.2)
    claims, why = crossing_claim(*_given(document), one)
    assert claims == []
    assert "no covariance shows 0.00095 for an overspeed of 20 % at 9 m/s" in why[KIND]
    (claim,), _ = crossing_claim(*_given(document), replace(one, pieces=8, least=False))
    assert 1 < len(claim["C"]) <= 8
    assert claim["probability"] == 9.5e-4
    document["claims"] = [claim]
    assert verdicts(document) == BOTH


def test_what_has_no_linear_loop_has_no_claim(document: Data) -> None:
    wind = RotorWind.of_class("B", 5.0)
    claims, why = crossing_claim(*_given(document), CrossingAsked(5.0, wind))
    assert claims == []
    assert why == {KIND: "not claimed: the wind is not between two nodes of the law's tables"}
    document["controller"].pop("measurement")
    _, why = crossing_claim(*_given(document), CrossingAsked(8.0, wind))
    assert "no low-pass on the measured speed" in why[KIND]


def test_the_classes_of_turbulence() -> None:
    """Class B as measured, A and C by the reference intensities 0.16, 0.14 and 0.12 of IEC."""
    assert RotorWind.of_class("B", 8.0) == RotorWind(1.09, 0.09)
    for letter, share in (("A", 0.16 / 0.14), ("C", 0.12 / 0.14)):
        found = RotorWind.of_class(letter, 15.0)
        assert found.deviation == pytest.approx(1.64 * share, rel=1e-3)
        assert found.rate == pytest.approx(0.2 * share, rel=1e-3)
    with pytest.raises(ModelError, match="turbulence class 'D'"):
        RotorWind.of_class("D", 8.0)
    with pytest.raises(ModelError, match="positive numbers"):
        RotorWind(0.0, 0.1)


# The command line.


def test_the_option_belongs_to_the_effort_sharing_law_and_has_three_values(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for options, words in (
        (["--law", "paper", "--turbulence", "B"], "--turbulence belongs to the effort-sharing law"),
        (["--turbulence", "D"], "option --turbulence: 'D' was given; a class of turbulence"),
    ):
        assert main(["design", "nrel5mw", *options, "--out", str(tmp_path)]) == 2
        assert words in " ".join(capsys.readouterr().err.split())
    with pytest.raises(ModelError, match="turbulence class 'D' was given"):
        DesignSettings(turbulence="D")


@pytest.mark.slow
def test_a_law_gets_the_claims_on_request(document: Data) -> None:
    """Ten mean winds, all proved; the words before each wind are told."""
    told: list[str] = []
    claims, why = crossing_claims(*_given(document), "B", told.append)
    assert [claim["wind"] for claim in claims] == list(MEAN_WINDS)
    assert why == {}
    assert told[0] == "linear loop in turbulence, at 5.2 m/s"
    assert len(told) == len(MEAN_WINDS)
    assert max(claim["probability"] for claim in claims) <= 1e-3
    document["claims"] = claims
    assert len(json.dumps(claims)) < 40_000
    assert verdicts(document) == BOTH
