"""Regions of attraction of polynomials: exact thresholds, van der Pol's oscillator."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from takagi.certificates import certify
from takagi.certificates.checker.words.figure import Figure
from takagi.certificates.coq.coq_export import coq_file
from takagi.certificates.cross_check.comparison import cross_checked
from takagi.certificates.requests import AttractionRegion
from takagi.lmi import StatePolynomial
from takagi.lmi.sums_of_squares.attraction_set import multipliers
from takagi.models import Interval, ModelError, Plant, TSModel, Variable, sector_model
from tests.certificates.kinds.claims import Data, verdicts
from tests.certificates.weights.cells import plant_document

x, y, u, w = sp.symbols("x y u w", real=True)
FILE = Path(__file__).with_name("van_der_pol_region.json")
AMPLITUDE = 2.0086  # of the limit cycle of van der Pol's oscillator, Andersen and Geer (1982)


def one(degree: int, squares: float, multiplier: float, least: int = 0) -> Data:
    """An identity with y of one monomial; S is found from the identity."""
    size = degree + 1 - least
    rows = [[squares if i == j else 0 for j in range(size)] for i in range(size)]
    return {
        "degree": degree,
        "squares": rows,
        "multiplier_degree": least,
        "multiplier": [[multiplier]],
    }


def line(level: float, multiplier: float, **members: Any) -> Data:
    """A claim about V = x^2 of a plant with one state and no inputs."""
    claim = {"kind": "attraction-region", "function": "x^2", "level": level, "box": [[-2, 2]]}
    claim |= {"decrease": [one(2, 1, multiplier, 1)], "states": [one(0, 1, 1)], "inputs": []}
    return claim | members


def unstable_beyond_one(rest: float = 0) -> TSModel:
    """x' = -d + d^3 with d = x - rest."""
    d = x - sp.Rational(str(rest))
    state = Variable(x, "-", Interval.of(rest - 2, rest + 2), rest=Fraction(str(rest)))
    return sector_model(Plant(equations=(sp.expand(-d + d**3),), states=(state,), name="line"))


@pytest.mark.parametrize("rest", [0, 1.5])
def test_the_threshold_is_that_of_the_equation(rest: float) -> None:
    """x' = -x + x^3: |x| < 1 is the region, so V = x^2 has the levels below 1, about any rest."""
    model = unstable_beyond_one(rest)
    name = "x" if rest == 0 else str(model.states[0]).split()[0]

    def at(level: float, multiplier: float) -> str:
        claim = line(level, multiplier, function=f"{name}^2")
        return verdicts(plant_document(model, claim))[-1]

    assert at(0.999, 2.0005) == "PROVED"
    assert all(at(1.001, m) == "UNDECIDED" for m in (0, 1.5, 1.9, 1.998, 1.999, 2, 2.001, 3))


def van_der_pol() -> TSModel:
    sides = (Variable(s, "-", Interval.of(-3, 3)) for s in (x, y))
    return sector_model(Plant(equations=(-y, x + (x**2 - 1) * y), states=tuple(sides)))


def document() -> Data:
    """The oscillator with the region that the search found; no solver is needed."""
    return dict(json.loads(FILE.read_text(encoding="utf-8")))


def function() -> StatePolynomial:
    return StatePolynomial.of(document()["claims"][1]["function"], ["x", "y"])


def border(V: StatePolynomial, level: float = 1.0, count: int = 360) -> Any:
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rays = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    r = np.linspace(0, 4, 1601)[1:]
    first = (V(r[:, None, None] * rays) >= level).argmax(axis=0)
    return r[first, None] * rays


def area(points: Any) -> float:
    a, b = points.T
    return float(abs(np.dot(a, np.roll(b, -1)) - np.dot(b, np.roll(a, -1))) / 2)


def test_the_proved_set_is_most_of_the_region_and_lies_inside_the_limit_cycle() -> None:
    """The cycle has the published amplitude; its area is 13.72, that of Khalil's ellipse 6.4.

    Khalil (2002), example 8.9: V = 1.5 x^2 - x y + y^2 with c = 2.25.
    """
    assert verdicts(document()) == ["PROVED", "PROVED"]
    motion = solve_ivp(
        lambda t, s: [s[1], -s[0] + (1 - s[0] ** 2) * s[1]],
        (0, 25),
        [2, 0],
        rtol=1e-8,
        t_eval=np.linspace(18, 25, 5001),
    )
    cycle = np.asarray(motion.y)
    assert np.abs(cycle[0]).max() == pytest.approx(AMPLITUDE, abs=1e-3)

    points = border(function())
    khalil = border(StatePolynomial.of("1.5*x^2 - x*y + y^2", ["x", "y"]), 2.25)
    turn = np.argsort(np.arctan2(cycle[1], cycle[0]))
    whole = area(cycle[:, turn].T)

    assert area(khalil) == pytest.approx(np.pi * 2.25 / np.sqrt(1.25), rel=1e-2)
    assert whole == pytest.approx(13.72, rel=5e-3)
    assert 1.8 * area(khalil) < area(points) < whole
    at = np.interp(
        np.arctan2(points[:, 1], points[:, 0]), np.arctan2(cycle[1], cycle[0])[turn],
        np.hypot(*cycle)[turn], period=2 * np.pi,
    )  # fmt: skip
    assert np.all(np.hypot(*points.T) < at)


def test_khalils_function_has_multipliers_up_to_its_level() -> None:
    """Khalil (2002), example 8.9: V' = 0 first at 2.3047; 2.30 has squares, 2.31 none."""
    names = ["x", "y"]
    field = [StatePolynomial.of(text, names) for text in ("-y", "x + (x^2 - 1)*y")]

    def at(level: str) -> bool:
        V = StatePolynomial.of(f"(1.5*x^2 - x*y + y^2)/{level}", names)
        return multipliers(field, [], V) is not None

    assert at("2.30") and not at("2.31")


def test_the_second_decider_and_coq_read_the_same_obligations() -> None:
    """Six matrices: S and Lambda of the decrease and of each state."""
    compared = cross_checked(FILE)

    assert compared.agrees and [row.matrices for row in compared.rows][-1] == 6
    assert coq_file(FILE).matrices == {1: 0, 2: 6}


def test_a_set_is_found_and_proved() -> None:
    """x' = -x + x^3: from the request to the verdict, near the whole of |x| < 1."""
    answer = certify(unstable_beyond_one(), claims=[AttractionRegion()])
    (start,) = (f.value for f in answer.checked.claims[1].figures if isinstance(f, Figure))

    assert answer.verdict.name == "PROVED"
    assert start is not None and 0.95 < start < 1


def test_what_has_no_such_set_says_so() -> None:
    sine = Plant(equations=(-sp.sin(x),), states=(Variable(x, "-", Interval.of(-1, 1)),))

    with pytest.raises(ModelError, match="no polynomial in the states"):
        certify(sector_model(sine), claims=[AttractionRegion()])
    unstable = Plant(equations=(x + x**3,), states=(Variable(x, "-", Interval.of(-1, 1)),))
    with pytest.raises(ModelError, match="not stable at rest"):
        certify(sector_model(unstable), claims=[AttractionRegion()])


@pytest.mark.slow
def test_the_search_finds_most_of_van_der_pols_region() -> None:
    """Quartic V: more than 1.7 times Khalil's ellipse of example 8.9, whose area is 6.32."""
    answer = certify(van_der_pol(), claims=[AttractionRegion(4)])
    V = StatePolynomial.of(answer.document["claims"][1]["function"], ["x", "y"])

    assert answer.verdict.name == "PROVED"
    assert area(border(V)) > 1.7 * 6.32


def test_starts_in_the_proved_set_converge_and_starts_outside_of_the_region_do_not() -> None:
    """Runge-Kutta from random points of the set, and from points 30 % outside of its border."""

    def last(starts: Any, time: float) -> Any:
        h, s = 0.01, starts.T
        for _ in range(int(time / h)):

            def f(z: Any) -> Any:
                return np.array([-z[1], z[0] + (z[0] ** 2 - 1) * z[1]])

            k1 = f(s)
            k2 = f(s + h / 2 * k1)
            k3 = f(s + h / 2 * k2)
            s = np.clip(s + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(s + h * k3)), -1e3, 1e3)
        return np.abs(s).max(axis=0)

    points = border(function(), count=200)
    shares = np.sqrt(np.random.default_rng(3).uniform(0, 1, len(points)))[:, None]

    assert np.all(last(np.concatenate([points * 0.995, points * shares]), 60) < 1e-2)
    assert np.all(last(1.5 * points, 20) > 3)
