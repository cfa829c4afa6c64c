"""Corners of wind cells and interval matrices: bounds and signs that one place decides."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.corners import (
    BOUNDS,
    RANGES,
    Corners,
    Stated,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range, filter_keeps_up
from takagi.certificates.checker.turbine.published.interval_matrices import contraction

# A cell without a residual whose one free coefficient is the lag's rate T.  P was searched for:
# it decreases along the loop for T from 0.5 to 1 1/s, and not for T = 1.5 1/s.
COEFFICIENTS = {"stiffness": "-0.2", "loop_gain": "0.5", "lag_gain": "0.1", "share_gain": "-0.6"}
INTEGRAL_RATE = Fraction("0.2")
ROWS = (("4.25", "3.6", "-1.59"), ("3.6", "3.96", "-0.89"), ("-1.59", "-0.89", "5.81"))
P = Matrix.of([[Fraction(entry) for entry in row] for row in ROWS])
ALPHA = Fraction("0.01")


def corners(lag_rate: tuple[str, str], **sizes: str) -> Stated:
    """Return the cell with a range of T [1/s] and the sizes that are not zero."""
    stated = {name: [Fraction(value)] * 2 for name, value in COEFFICIENTS.items()}
    stated["lag_rate"] = [Fraction(value) for value in lag_rate]
    bounds = {name: Fraction(sizes.get(name, "0")) for name in BOUNDS}
    bounds |= {"integral_rate": INTEGRAL_RATE, "multiplier": ALPHA, "decay_rate": Fraction(0)}
    return Stated(stated, bounds, "cell")


def decided(cell: Stated, error: Any = 0, rate: Any = 0) -> str:
    class_ = {"wind_error": Fraction(error), "wind_rate": Fraction(rate)}
    return first_failure(Corners(replace(cell, sizes=cell.sizes | class_)).obligations(P))


@pytest.mark.parametrize(
    ("lags", "slope", "rate", "fails"),
    [
        (("0.5", "1"), "0", 1, ""),
        (("1", "1"), "0.5", 0, ""),
        # T - (b'/b) v_s' has both signs: its upper end, 1.5 1/s, is not in the decreasing set.
        (("1", "1"), "0.5", 1, "invariance"),
        (("0.75", "0.75"), "0.5", "1.5", "invariance"),
        # From 0.6 - 0.5 to 1 + 0.5 1/s; taken inward it would be 0.5 to 1.1 1/s, where V falls.
        (("0.6", "1"), "0", 1, ""),
        (("0.6", "1"), "0.5", 1, "invariance"),
        # 0.3 - 0.4 < 0 makes the lag unstable; 0.3 + 0.4 1/s would be in the set.
        (("0.3", "0.3"), "0.4", "0.05", ""),
        (("0.3", "0.3"), "0.4", 1, "invariance"),
    ],
)
def test_a_moving_schedule_widens_the_lags_rate(
    lags: tuple[str, str], slope: str, rate: Any, fails: str
) -> None:
    found = decided(corners(lags, effectiveness_slope=slope), rate=rate)
    assert fails in found and bool(fails) == bool(found)


@pytest.mark.parametrize("part", ["wind error", "wind rate", "turning", "lag disturbance"])
def test_disturbances_are_rounded_up(part: str) -> None:
    """Half a unit of the seventh decimal beyond the largest that the set withstands.

    So is (b'/b) v_s', by which a moving schedule turns the lag.
    """

    def failing(units: Fraction) -> str:
        size = units / 10**7
        if part == "wind error":
            found = corners(("1", "1"), inertia_gain="1", wind_gain="1")
            return decided(found, error=size)
        if part == "wind rate":
            found = corners(("1", "1"), reference_slope="1")
            return decided(found, rate=size)
        if part == "turning":
            return decided(corners(("1", "1"), effectiveness_slope="1"), rate=size)
        return decided(corners(("1", "1"), lag_disturbance=str(size)))

    low, high = 0, 10**7
    assert failing(Fraction(low)) == "" and failing(Fraction(high))
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if failing(Fraction(middle)) else (middle, high)

    assert failing(Fraction(low)) == ""
    assert "invariance" in failing(low + Fraction(1, 1000))
    assert "invariance" in failing(low + Fraction(1, 2))


def test_the_rest_is_rounded_outward() -> None:
    P33, unit = P[2, 2], Fraction(1, 10**7)
    r = Fraction(0)
    step = Fraction(1)
    while step >= unit:
        while P33 * (r + step) ** 2 < Fraction(COEFFICIENTS["loop_gain"]) ** 2:
            r += step
        step /= 10

    def failing(residual: Fraction) -> str:
        return decided(corners(("1", "1"), inertia_gain="1", residual=str(residual)))

    assert "equilibrium" not in failing(r)
    assert "equilibrium" in failing(r + unit / 2)


def last_cell(document: dict[str, Any], rate: str, pitch_max: Fraction | None = None) -> Loop:
    read = read_text(json.dumps(document), "document")
    subject = Subject.read(read["claims"][0], read["model"], read["gains"], "claim")
    if pitch_max is not None:
        subject = replace(subject, law=replace(subject.law, pitch_max=pitch_max))
    return Loop(subject, len(subject.law.wind) - 2, Fraction(rate))


def test_pitch_beyond_the_limit_is_refused(short: Any) -> None:
    """The limit is compared with the pitch that the set reaches, which no command exceeds."""
    reached = Fraction(last_cell(short, "0").reached.high, ONE)
    hair = Fraction(1, ONE)

    assert first_failure(last_cell(short, "0", reached).limits()) == ""
    assert "pitch beyond its limit" in first_failure(last_cell(short, "0", reached - hair).limits())


@pytest.mark.parametrize(
    ("k", "b"), [(0, "0"), (2, "0.5"), (4, "-0.2")], ids=["torque alone", "ramp", "pitch"]
)
def test_the_moving_schedule_disturbs_by_its_largest_slope(short: Any, k: int, b: str) -> None:
    """rho |N| is not below the slope of psi(U) - b beta_ref in v_s at any point of a fine grid."""
    read = read_text(json.dumps(short), "document")
    subject = Subject.read(read["claims"][0], read["model"], read["gains"], "claim")
    law, rate = subject.law, Fraction("0.3")
    # Another effectiveness at the cell's upper end: with the emitted one its slope hardly counts.
    bent = [*law.effectiveness]
    bent[k + 1] = bent[k] * (1 + Fraction(b))
    law = replace(law, effectiveness=bent)
    found = Loop(replace(subject, law=law), k, rate)
    eps, (low, high) = float(law.overlap), (float(end) for end in found.winds)
    share_of, signal = np.linspace(0, 1, 101), float(found.box.speed_signal)
    y = signal * np.linspace(-1, 1, 41)[:, None]

    def along(column: Any) -> tuple[Any, float]:
        first, last = float(column[k]), float(column[k + 1])
        return first + share_of * (last - first), (last - first) / (high - low)

    (q, dq), (gamma, dgamma), (b_of, db) = (
        along(column) for column in (law.effort, law.gamma, law.effectiveness)
    )
    U = q + gamma * y
    F = np.clip((U + eps) / (2 * eps), 0, 1)
    psi = np.where(U >= eps, U, np.where(U <= -eps, 0, (U + eps) ** 2 / (4 * eps)))
    N = F * (dq + dgamma * y) - psi * db / b_of
    largest = float(rate) * float(np.abs(N).max())

    bound = float(found.lag_disturbance())
    assert largest <= bound * (1 + 1e-12)
    assert bound <= 4 * largest + 1e-12


F = Fraction
WIND, FILTER, PHI = [F(8), F(9), F(10)], F(1), F(1, 5)


@pytest.mark.parametrize(
    "node",
    [
        pytest.param(0, id="the estimate is at the range's first wind"),
        pytest.param(1, id="the estimate is at a node, the schedule wind between two"),
        pytest.param(2, id="the estimate is at the range's last wind"),
    ],
)
def test_an_estimate_that_outruns_the_schedule_wind_at_one_place(node: int) -> None:
    """Where phi is constant, the schedule wind keeps behind the estimate as long as r <= phi.

    The estimate is fastest at one node, by 1/1000 m/s^2 more than the schedule wind may be; there
    the schedule wind is 1/5 m/s beside that node, which is no node of its own.
    """
    for excess, refused in ((F(1, 1000), True), (F(0), False)):
        estimate = [F(1, 10)] * 3
        estimate[node] = PHI + excess
        one = Range(WIND, estimate, [PHI] * 3, F(0))
        found = first_failure(filter_keeps_up(one, FILTER))
        assert bool(found) == refused
        if found:
            s = F(found.removeprefix("the rates do not fit at ").partition(" ")[0])
            assert abs(s - WIND[node]) == FILTER * PHI
            assert s not in WIND


def test_the_worst_signs_are_found_for_each_pair_of_states() -> None:
    """x' = -x + d, |d_i| <= delta: with P = [[2, s], [s, 2]] the rests of the worse signs have
    V = 6 delta^2, and the inequality with alpha = 1 allows delta < 1/sqrt(6) = 0.408.
    """
    for sign, delta in product((1, -1), (F(41, 100), F(2, 5))):
        P = [[F(2), F(0), F(sign)], [F(0), F(2), F(0)], [F(sign), F(0), F(2)]]
        A = [[F(-int(i == j)) for j in range(3)] for i in range(3)]
        bounds = [delta, F(0), delta]
        said = first_failure(contraction(P, [(A, A)], bounds, F(1, 2), F(1), "here"))
        assert bool(said) == (6 * delta**2 > 1)


# Two units of the last decimal, for two roundings of one.
STEP = Fraction(2, 10**7)
SHARES = (0, 8, 20, 30, 35, 38, 41, 44, 50, 65, 80, 99)
Inputs = tuple[Subject, list[Any]]


@pytest.fixture(scope="session")
def inputs(built: Any) -> Inputs:
    read = read_text(json.dumps(built.document), "document")
    claim = read["claims"][0]
    return Subject.read(claim, read["model"], read["gains"], "claim"), claim["cells"]


def outside(loop: Loop, ranges: Any, sizes: dict[str, Fraction]) -> str:
    return first_failure(loop.enclosed(Stated(ranges, sizes, "cell")))


@pytest.mark.parametrize("share", SHARES)
def test_what_a_cell_states_is_enclosed_and_no_more(inputs: Inputs, share: int) -> None:
    subject, cells = inputs
    k = share * (len(cells) - 1) // 99
    cell = cells[k]
    loop = Loop(subject, k, Fraction(cell["wind_rate"]))
    ranges = {name: [Fraction(end) for end in cell[name]] for name in RANGES}
    sizes = {name: Fraction(cell[name]) for name in BOUNDS}

    assert outside(loop, ranges, sizes) == ""
    assert first_failure(loop.limits()) == ""

    found = {name: [Fraction(end, ONE) for end in bracket] for name, bracket in loop.ranges()}
    largest = dict(loop.sizes())
    assert found.keys() == set(RANGES)
    assert largest.keys() == set(BOUNDS)
    for name, (low, high) in found.items():
        assert low - STEP <= ranges[name][0] <= low, name
        assert high <= ranges[name][1] <= high + STEP, name
    # The residual is bounded in two ways: over a whole cell here, over pieces of it there.
    residual = largest.pop("residual")
    assert residual <= sizes["residual"] <= 2 * residual
    for name, size in largest.items():
        assert size <= sizes[name] <= size + STEP, name


@pytest.mark.parametrize("name", (*RANGES, *BOUNDS))
def test_each_stated_number_is_compared(inputs: Inputs, name: str) -> None:
    """One that is too small by two units of the last decimal is named, at either end."""
    subject, cells = inputs
    k = next(k for k, cell in enumerate(cells) if Fraction(cell["reference_slope"]) > 0)
    cell = cells[k]
    loop = Loop(subject, k, Fraction(cell["wind_rate"]))
    ranges = {one: [Fraction(end) for end in cell[one]] for one in RANGES}
    sizes = {one: Fraction(cell[one]) for one in BOUNDS}

    if name in RANGES:
        low, high = ranges[name]
        assert f"loop's {name} leaves" in outside(loop, ranges | {name: [low + STEP, high]}, sizes)
        assert f"loop's {name} leaves" in outside(loop, ranges | {name: [low, high - STEP]}, sizes)
        assert outside(loop, ranges | {name: [low - STEP, high + STEP]}, sizes) == ""
    else:
        less = sizes[name] / 2 if name == "residual" else sizes[name] - STEP
        assert f"loop's {name} exceeds" in outside(loop, ranges, sizes | {name: less})
        assert outside(loop, ranges, sizes | {name: sizes[name] + STEP}) == ""


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
