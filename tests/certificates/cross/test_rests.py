"""Rests of the turbine's loop: the second checker's count, forged answers, and enclosures."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from scipy.interpolate import BSpline

from takagi.certificates.audit import cross_checked_document
from takagi.certificates.claims.turbine import published_law_data
from takagi.certificates.cross_check import judge_document, loads
from takagi.certificates.cross_check.turbine import equilibrium as rests
from takagi.certificates.cross_check.turbine import torque_balance as rest_balance
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.surface import NumberRange
from takagi.certificates.cross_check.turbine.torque_balance import Balance, BalanceSign, Looks
from takagi.certificates.document import (
    certificate_document,
    dumps,
    effort_sharing_law_data,
    turbine_data,
)
from tests.certificates.conftest import Built, resealed
from tests.certificates.test_paper_certificate import TURBINE, make_law

Data = dict[str, Any]
# Below rated wind, where pitch takes over, in the stalled range and beyond it (docs/equilibria.md).
CELLS = [
    {"wind": [8.7006, 9.1632], "rests": "one"},
    {"wind": [11.4509, 11.5509], "rests": "one"},
    {"wind": [18.24, 18.26], "rests": "several"},
    {"wind": [22.76, 23.0], "rests": "one"},
]


def claimed(model: Data, gains: Data, cells: list[Data]) -> Data:
    claim = {"name": "rests", "kind": "equilibrium", "cells": cells}
    return certificate_document(
        model=model, gains=gains, claims=[copy.deepcopy(claim)], provenance={}
    )


@pytest.fixture
def document(built: Built) -> Data:
    """A claim about four cells of wind, true, of the two-step law."""
    return claimed(turbine_data(TURBINE, []), effort_sharing_law_data(built.law), CELLS)


def of_interval(document: Data, wind: float) -> int:
    return max(k for k, v in enumerate(document["gains"]["wind"]) if v <= wind)


@pytest.mark.slow
def test_both_count_the_same(document: Data) -> None:
    (row,) = cross_checked_document(document).rows

    assert (row.first, row.second, row.reason) == ("PROVED", "PROVED", "")


def only(document: Data, number: int, **changed: Any) -> None:
    """Leave one cell, changed: what is wrong is in it."""
    document["claims"][0]["cells"] = [CELLS[number] | changed]


def no_reserve(document: Data) -> None:
    """Efforts at trim that the integrator cannot take back: no rest has e = 0."""
    only(document, 1)
    k = of_interval(document, 11.46)
    for i in (k, k + 1):
        document["gains"]["trim_effort"][i] += 1.0


def weak_rotor(document: Data) -> None:
    only(document, 1)
    document["model"]["torque_constant"] *= 0.1


def wide_limit(document: Data) -> None:
    """An integrator limit at which the stalled rest is gone (docs/equilibria.md)."""
    only(document, 2)
    document["gains"]["integral_limit"] = 0.6


FORGED: dict[str, Callable[[Data], None]] = {
    "one for several": lambda d: only(d, 2, rests="one"),
    "several for one": lambda d: only(d, 3, rests="several"),
    "none for one": lambda d: only(d, 0, rests="none"),
    "a continuum": lambda d: only(d, 1, rests="continuum"),
    "the trim, which is not said of this law": lambda d: only(d, 1, rests="one at the trim"),
    "one, in the stalled range": lambda d: only(d, 3, wind=[18.3, 18.31]),
    "over a node": lambda d: only(d, 1, wind=[11.44, 11.46]),
    "no reserve": no_reserve,
    "a weak rotor": weak_rotor,
    "a wide limit": wide_limit,
}


# Of a range with two rests every box is halved to the end: seconds in both checkers.
LONG = "one for several"


@pytest.mark.parametrize(
    "name", [n if n != LONG else pytest.param(n, marks=pytest.mark.slow) for n in FORGED]
)
def test_a_forged_answer_is_proved_by_neither(name: str, document: Data) -> None:
    """With hashes that fit; the second checker says so, and does not abstain."""
    FORGED[name](document)
    (row,) = cross_checked_document(resealed(document)).rows

    assert (row.first, row.second) == ("UNDECIDED", "UNDECIDED"), row.reason


MISSHAPEN: dict[str, Callable[[Data], None]] = {
    "another answer": lambda d: only(d, 0, rests="two"),
    "beyond cut-out": lambda d: only(d, 3, wind=[24.9, 25.1]),
    "winds that fall": lambda d: only(d, 3, wind=[23.0, 22.9]),
    "no cells": lambda d: d["claims"][0].update(cells=[]),
    "other pitch limits": lambda d: d["gains"].update(pitch_max=1.0),
    "no turbine": lambda d: d["model"].update(kind="plant of mine"),
}


@pytest.mark.parametrize("name", MISSHAPEN)
def test_what_does_not_fit_is_refused_by_both(name: str, document: Data) -> None:
    MISSHAPEN[name](document)
    (row,) = cross_checked_document(resealed(document)).rows

    assert (row.first, row.second) == ("REFUSED", "REFUSED")


@pytest.mark.slow
def test_rests_of_a_law_of_the_paper_are_left_open() -> None:
    """Its gains go with averages of slopes, of which the second checker has no reading."""
    cells = [{"wind": [8.0, 8.02], "rests": "one at the trim"}]
    (one,) = judge_document(
        claimed(turbine_data(TURBINE, []), published_law_data(make_law("paper")), cells)
    )

    assert (one.verdict, one.reason) == ("NOT REPLAYED", "rests of a published law")


def test_a_cell_that_is_not_decided_is_left_open(
    document: Data, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Too few halvings, or too few enclosures in all."""
    only(document, 2)
    for name, value in (("HALVED_WINDS", 0), ("MOST_LOOKS", 3)):
        with monkeypatch.context() as patch:
            patch.setattr(rest_balance if name == "MOST_LOOKS" else rests, name, value)
            if name == "HALVED_WINDS":
                patch.setattr(rests, "_changes", lambda *_: 0)
            (one,) = judge_document(resealed(document))
        assert one.verdict == "NOT REPLAYED"


def fraction(value: float) -> fmpq:
    return fmpq(*float(value).as_integer_ratio())


def law_s_balance(document: Data) -> Callable[[float, float, float], float]:
    """Return f of wind, speed error and integral, by floats from the law's formula."""
    gains, model = document["gains"], document["model"]
    table, eps = model["torque_surface"], gains["overlap"]
    J = model["rotor_inertia"] + model["gear_ratio"] ** 2 * model["generator_inertia"]
    along = BSpline(np.array(table["tip_speed_ratio_knots"]), np.array(table["coefficients"]), 3)

    def ramp(s: float) -> float:
        return max(s, 0.0) if abs(s) > eps else (s + eps) ** 2 / (4 * eps)

    def balance(v: float, error: float, x: float) -> float:
        speed, q, gamma, b = (
            float(np.interp(v, gains["wind"], gains[name]))
            for name in ("rotor_speed", "trim_effort", "proportional", "effectiveness")
        )
        effort = q + gamma * (error - x)
        pitch = gains["pitch_min"] + ramp(effort) / b
        ratio = model["rotor_radius"] * (speed + error) / v
        quotient = float(BSpline(np.array(table["pitch_knots"]), along(ratio), 3)(pitch))
        torque = max(gains["rated_torque"] - gains["effort_torque"] * ramp(-effort), 0.0)
        turning = float(model["torque_constant"]) * v**2 * quotient
        return float((turning - model["gear_ratio"] * torque) / J)

    return balance


@pytest.mark.parametrize("wind", [11.46, 21.05, 24.2])
def test_enclosures_hold_the_balance_of_the_law(wind: float, document: Data) -> None:
    """f by floats from the law's formula: no sign, rise or zero is enclosed wrongly.

    Along the curves at a limit as well, whose slopes by wind and tip-speed ratio are in the mean
    value form.
    """
    read = loads(dumps(document))
    rotor, gains, model = Rotor(read["model"], read["gains"]), document["gains"], document["model"]
    winds = (wind, wind + 0.05)
    at = Balance(rotor, of_interval(document, wind), NumberRange(*map(fraction, winds)), Looks())
    limit, balance = gains["integral_limit"], law_s_balance(document)
    rng, seen = random.Random(3), set()
    for _ in range(40):
        a, b = sorted(rng.uniform(-limit, limit) for _ in range(2))
        look = at.inside(NumberRange(fraction(a), fraction(b)))
        v, (x, y) = rng.uniform(*winds), sorted(rng.uniform(a, b) for _ in range(2))
        f, g = balance(v, 0.0, x), balance(v, 0.0, y)
        assert look.sign * f >= 0 <= look.sign * g
        assert not look.rises or f < g
        seen |= {("inside", look.sign), ("rises", look.rises)}
    for _ in range(40):
        low = rng.uniform(2.0, 3.4)
        high = low + rng.choice([0.003, 0.03, 0.3])
        look = at.upper(NumberRange(fraction(low), fraction(high)))
        v, tip = rng.uniform(*winds), rng.uniform(low, high)
        speed = float(np.interp(v, gains["wind"], gains["rotor_speed"]))
        f = balance(v, tip * v / model["rotor_radius"] - speed, limit)
        assert look.sign * f >= 0, (low, high, f)
        seen |= {("upper", look.sign)}
    assert {("inside", 1), ("inside", -1), ("rises", True), ("upper", 1)} <= seen


@pytest.mark.parametrize(("wind", "ratio", "x"), [(21.3, 2.3, 0.1), (12.4, 7.5, -0.1), (9, 8, 0)])
def test_slopes_along_a_limit_are_those_of_the_balance(
    wind: float, ratio: float, x: float, document: Data
) -> None:
    """By wind and by tip-speed ratio, against difference quotients: with torque, pitch and both."""
    read, gains, h = loads(dumps(document)), document["gains"], 1e-5
    v, tip = (NumberRange(fraction(value), fraction(value)) for value in (wind, ratio))
    rotor, k = Rotor(read["model"], read["gains"]), of_interval(document, wind)
    at = Balance(rotor, k, NumberRange(rotor.wind[k], rotor.wind[k + 1]), Looks())
    signal, efforts = at._limited(v, tip, fraction(x))
    state = at._state(v, tip, efforts)
    assert state is not None
    balance, radius = law_s_balance(document), document["model"]["rotor_radius"]

    def f(v: float, tip: float) -> float:
        speed = float(np.interp(v, gains["wind"], gains["rotor_speed"]))
        return balance(v, tip * v / radius - speed, x)

    by_wind, by_ratio = at.slopes(state, v, signal)

    for span, rise in (
        (by_wind, f(wind + h, ratio) - f(wind - h, ratio)),
        (by_ratio, f(wind, ratio + h) - f(wind, ratio - h)),
    ):
        found = [float(end.p) / float(end.q) for end in (span.low, span.high)]
        assert found == pytest.approx([rise / (2 * h)] * 2, rel=1e-5, abs=1e-8)


@pytest.mark.parametrize(
    ("zero", "found"), [(0.3, (1, True)), (-0.3, (1, True)), (2.0, (0, False)), (-2.0, (0, False))]
)
def test_a_curve_that_rises_has_one_zero_with_every_wake_or_none_without(
    zero: float, found: tuple[int, bool]
) -> None:
    """A wake is 0 at x = 0, so that a zero between the ends stays; where there is none, it may add.

    Without a wake there is none then, which is a word against "one".
    """

    def curve(x: NumberRange) -> BalanceSign:
        return BalanceSign((x.low > fraction(zero)) - (x.high < fraction(zero)), rises=True)

    halves = [NumberRange(fmpq(-1), fmpq(0)), NumberRange(fmpq(0), fmpq(1))]
    assert rests._rising_zeros(curve, [(part, curve(part)) for part in halves]) == found


def test_one_change_of_sign_is_not_several() -> None:
    """Where the balance has a sign but its slope is not known, one change says nothing."""

    def at(upper: int) -> Any:
        def inside(x: NumberRange) -> BalanceSign:
            return BalanceSign((x.low > 0) - (x.high < 0))

        def above(ratio: NumberRange) -> BalanceSign:
            return BalanceSign(upper if ratio.high <= 3 else 1 if ratio.low >= 4 else 0)

        table = SimpleNamespace(x=SimpleNamespace(breaks=[fmpq(2), fmpq(9)]))
        rotor = SimpleNamespace(integral_limit=fmpq(1), surface=table)
        ends = NumberRange(fmpq(5), fmpq(6))
        return SimpleNamespace(
            rotor=rotor,
            trim_ratio=ends,
            inside=inside,
            upper=above,
            lower=lambda _: BalanceSign(-1),
        )

    assert rests._rests(at(upper=1)) is None
    assert rests._rests(at(upper=-1)) == "several"
