"""``turbine-crossing``: verdicts from both sides, the sentence, and forged files."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates.checker import Verdict, check_document
from takagi.certificates.checker.files import gain_file
from takagi.certificates.checker.kernel import reader, refusal
from takagi.certificates.checker.turbine.linear_loop import pieces
from takagi.certificates.design import claim_summary
from takagi.cli.terminal import turbine_summary
from takagi.reports.sections.turbine import verdict as report_verdict
from tests.certificates.turbine.crossing_documents import (
    BOTH,
    NEITHER,
    REFUSED,
    Data,
    as_read,
    box_of,
    floats,
    linear_at,
    stored_documents,
)
from tests.certificates.turbine.running_documents import Change, entry, sealed, verdicts


@pytest.fixture(scope="module")
def stored() -> list[Data]:
    return stored_documents()


@pytest.fixture
def document(stored: list[Data]) -> Data:
    return deepcopy(stored[0])


@pytest.fixture
def in_pieces(stored: list[Data]) -> Data:
    return deepcopy(stored[1])


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
    "no damping": uncertain("speed_damping", 0.0, 1.2),
    "no effect of pitch": uncertain("pitch_effectiveness", 0.0, 1.2),
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


def test_a_parameter_with_one_value_is_not_halved(document: Data) -> None:
    """Also where there are as many covariances as pieces."""
    claim = document["claims"][0]
    claim["C"] = claim["C"] * 2
    for name, expected in (("wake_length", REFUSED), ("inertia", BOTH)):
        claim["cuts"] = [name, "", ""]
        assert verdicts(document) == expected
    assert "in 2 pieces" in check_document(sealed(document)).claims[0].text


def test_a_wake_may_follow_at_once(document: Data) -> None:
    """Its ranges may begin at zero, which is a wider family here."""
    for name in ("wake_of_pitch", "wake_of_wind"):
        changed = deepcopy(document)
        uncertain(name, 0.0, 0.3)(changed)
        assert verdicts(changed) in (BOTH, NEITHER)


def test_the_wind_is_within_the_limits_of_the_estimate(document: Data) -> None:
    """Strictly: at a limit the observer's equation has no derivative."""
    document.pop("controller")
    for limits, expected in (
        ([8.0, 25.0], NEITHER),
        ([7.999, 25.0], BOTH),
        ([3.0, 8.0], NEITHER),
        ([3.0, 8.001], BOTH),
    ):
        document["claims"][0]["observer"]["wind_limits"] = limits
        assert verdicts(document) == expected


def test_the_limit_is_a_deviation_or_more(document: Data) -> None:
    """In no time the bound at one deviation is 0.484: the probability alone would allow less."""
    claim, linear = document["claims"][0], linear_at(document, "8")
    h = np.zeros(13)
    h[0], h[9] = 1, -float(linear.trim.speed_slope)
    deviation = np.sqrt(h @ np.array(claim["C"][0]) @ h) / document["model"]["rated_rotor_speed"]
    claim["horizon"], claim["probability"] = 1e-6, 0.9
    for factor, expected in ((1 + 1e-9, BOTH), (1 - 1e-9, NEITHER)):
        claim["overspeed"] = float(deviation * factor)
        assert verdicts(document) == expected


def test_an_unstable_loop_has_a_solution_that_is_no_covariance(document: Data) -> None:
    """With an integral 200 times as fast A X + X A' = -Q < -S S' is solved by an indefinite X.

    It fulfils the other conditions: signal and rate have a positive variance, the limit is above.
    """
    document.pop("controller")
    document["gains"]["integral_rate"] = [200 * x for x in document["gains"]["integral_rate"]]
    claim = document["claims"][0]
    for name, (low, high) in claim["uncertainty"].items():
        claim["uncertainty"][name] = [(low + high) / 2] * 2
    linear = linear_at(document, "8")
    (A,) = map(floats, linear.at(box_of(document)))
    assert np.linalg.eigvals(A).real.max() > 0.3
    Q = np.diag([1e-9] * 13)
    Q[10, 10] += float(linear.wind.intensity)
    X = solve_continuous_lyapunov(A, -Q)
    assert np.linalg.eigvalsh(X).min() < -1e-6
    claim["C"] = [((X + X.T) / 2).tolist()]
    assert rice(document, X, box_of(document), "8") < 0.01
    claim["probability"] = 0.5
    assert verdicts(document) == NEITHER
    text = check_document(sealed(document)).claims[0].text
    assert "C is not symmetric positive definite" in text


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
