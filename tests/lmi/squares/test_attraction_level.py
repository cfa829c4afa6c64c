"""Levels inside the region of attraction: textbook values, rays, simulation, exact identities."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    AttractionLevel,
    ExactSolution,
    StatePolynomial,
    attraction_level,
    attraction_level_condition,
    exact_solution,
)
from takagi.models import ModelError

STATES = ["x1", "x2"]
VAN_DER_POL = ["-x2", "x1 + (x1**2 - 1)*x2"]
KHALIL = "1.5*x1**2 - x1*x2 + x2**2"


def least_on_rays(answer: AttractionLevel, rays: int = 2000) -> float:
    """The least V at which V' is 0, from the roots of V' along rays: above every level there is."""
    slope = answer.function.along(answer.field)
    best = np.inf
    for angle in np.linspace(0, np.pi, rays, endpoint=False):
        direction = np.array([np.cos(angle), np.sin(angle)])
        for sign in (1.0, -1.0):
            powers = np.zeros(slope.degree + 1)
            for a, c in slope.terms.items():
                powers[sum(a)] += float(c) * np.prod((sign * direction) ** np.array(a))
            roots = np.roots(powers[::-1])
            real = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 1e-6)].real
            for r in real:
                best = min(best, float(answer.function(sign * r * direction)))
    return best


@pytest.fixture(scope="module")
def oscillator() -> AttractionLevel:
    """Van der Pol's oscillator in reverse time with the quadratic function of its linearisation."""
    return attraction_level(VAN_DER_POL, KHALIL, states=STATES)


def test_van_der_pols_level_is_the_largest_that_the_function_has(
    oscillator: AttractionLevel,
) -> None:
    """Khalil (2002), example 8.9: c = 2.25 from a plot; along rays V' = 0 from 2.3045 on.

    The level from sums of squares is between them, and proved.
    """
    assert oscillator.found and oscillator.proved and oscillator.fault() == ""
    assert oscillator.level is not None
    assert oscillator.level > 2.25
    assert oscillator.level == pytest.approx(least_on_rays(oscillator), rel=3e-4)
    assert oscillator.level < least_on_rays(oscillator)


def test_a_level_above_the_largest_is_not_shown(oscillator: AttractionLevel) -> None:
    """One per mill above the least V with V' = 0 there is no identity: the bound says so."""
    assert oscillator.bound < 1.001 * least_on_rays(oscillator)


def test_solutions_from_the_level_tend_to_zero_and_outside_they_may_not(
    oscillator: AttractionLevel,
) -> None:
    """Runge-Kutta from 60 points just inside; a point outside the limit cycle leaves."""

    def run(x: Any, steps: int = 4000, dt: float = 0.01) -> Any:
        def f(y: Any) -> Any:
            return np.stack([-y[..., 1], y[..., 0] + (y[..., 0] ** 2 - 1) * y[..., 1]], axis=-1)

        for _ in range(steps):
            a = f(x)
            b = f(x + dt / 2 * a)
            c = f(x + dt / 2 * b)
            d = f(x + dt * c)
            x = np.clip(x + dt / 6 * (a + 2 * b + 2 * c + d), -1e3, 1e3)
        return x

    assert oscillator.level is not None
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    edge = ray * np.sqrt(0.999 * oscillator.level / oscillator.function(ray))[:, None]

    assert np.abs(run(edge)).max() < 1e-3
    assert np.abs(run(np.array([[2.5, 0.0]]), steps=600)).max() > 10


def test_an_analytic_level_from_both_sides() -> None:
    """x' = -x + x^3, V = x^2: the region is |x| < 1, so c = 1 exactly."""
    answer = attraction_level(["-x + x**3"], "x**2", states=["x"])

    assert answer.proved and answer.level is not None
    assert 0.999 < answer.level < 1


def test_a_cubic_system_with_a_function_of_degree_four() -> None:
    """V of degree 4 along a cubic system, held against rays."""
    field = ["-x1 + x2", "-x1 - x2 + x1**3"]
    quartic = "x1**2 + x2**2 + 0.1*x1**4 + 0.1*x2**4"

    answer = attraction_level(field, quartic, states=STATES)

    assert answer.proved and answer.level is not None
    assert 0.5 * least_on_rays(answer) < answer.level < least_on_rays(answer)


def test_the_function_of_the_linearisation_is_taken_where_none_is_given() -> None:
    """Chesi, Tesi and Vicino, system S7: x2' = -2 x1 - 3 x2 + x1^2 + x1 x2 - x2^2."""
    answer = attraction_level(
        ["x2", "-2*x1 - 3*x2 + x1**2 + x1*x2 - x2**2"], states=STATES, multiplier_degree=2
    )

    assert answer.proved and answer.level is not None
    assert 0.99 * least_on_rays(answer) < answer.level < least_on_rays(answer)


def damaged(answer: AttractionLevel, name: str, change: Fraction) -> AttractionLevel:
    """The answer with one entry of a Gram matrix changed, on both sides of the diagonal."""
    assert answer.exact is not None
    values = {key: value.copy() for key, value in answer.exact.values.items()}
    values[name][0, 0, 0] += change
    solution = ExactSolution(condition=answer.exact.condition, values=MappingProxyType(values))
    return replace(answer, exact=solution)


@pytest.mark.parametrize("name", ["S", "Lambda", "W"])
def test_forged_sums_of_squares_are_refused(oscillator: AttractionLevel, name: str) -> None:
    """An entry moved by 1e-40 breaks the identity; the level raised breaks it too."""
    assert damaged(oscillator, name, Fraction(0)).fault() == ""

    assert damaged(oscillator, name, Fraction(1, 10**40)).fault() != ""
    assert oscillator.level is not None
    c = oscillator.level * 1.01
    raised = replace(oscillator, level=c, invariant_level=c)
    assert raised.fault() == "the identity of the polynomials does not hold"
    assert replace(oscillator, level=c).fault() != ""
    assert replace(oscillator, orders={}).fault() != ""


def test_an_indefinite_gram_matrix_that_keeps_the_identity_is_refused() -> None:
    """c far above the limit: exact Gram matrices exist for the identity, but are not definite."""
    condition = attraction_level_condition(["-x + x**3"], "x**2", states=["x"])
    values = {
        u.name: np.zeros((u.count, u.rows, u.cols)) + (100.0 if u.name == "c" else 0.0)
        for u in condition.unknowns
    }

    found = exact_solution(condition, values)

    assert found is not None and "not definite" in found.fault()


@pytest.mark.parametrize(
    ("field", "function", "message"),
    [
        (["x2"], KHALIL, "one polynomial for each"),
        (["x2 + 1", "-x1"], KHALIL, "shift the states"),
        (["sin(x1)", "-x2"], KHALIL, "no polynomial"),
        (["-x1 + y", "-x2"], KHALIL, "no polynomial"),
        (["-x1", "-x2"], "x1**3 + x2**2", "an even degree"),
        (["-x1", "-x2"], "x1 + x2**2", "no term below degree 2"),
        (["-x1", "-x2"], [[1.0]], r"\(2, 2\) is needed"),
        (["x1", "-x2"], None, "is not stable"),
    ],
)
def test_what_is_no_such_question_is_refused(field: Any, function: Any, message: str) -> None:
    """Each misuse says what was given and what was needed."""
    with pytest.raises(ModelError, match=message):
        attraction_level(field, function, states=STATES)


SUM = "x1**2 + x2**2"
DEGENERATE: list[tuple[list[str], Any, float]] = [
    # Strict decrease, though not to first order.
    (["-x1**3"], "x1**2", np.inf),
    (["-1e6*x1**7"], [[1e-9]], np.inf),
    (["-x1**3", "-x2"], SUM, np.inf),
    (["-4*(x1 + x2)**3 - x1 + x2", "-4*(x1 + x2)**3 + x1 - x2"], SUM, np.inf),
    (["-x1**3 - x1**5", "-x2 - x2**3"], "x1**4 + x2**2", np.inf),
    (["4*x1*x2 - 8*x1**3", "2*x1**2 - 2*x2"], "x2**2 - 2*x2*x1**2 + 2*x1**4", np.inf),
    (["-x1**3 + x1**5"], "x1**2", 1.0),
    # V' = 0 on a line on which only 0 stays; the second is Parrilo's, the last Carr's (1981).
    (["x2", "-x1 - x2**3"], SUM, np.inf),
    (["-x1 + (1 + x1)*x2", "-(1 + x1)*x1"], SUM, np.inf),
    (["x2", "-x1**3 - x2"], "x1**4/2 + x2**2", np.inf),
    (["x2", "-x1 - x2**3 + x2**5"], SUM, 1.0),
    (["x1*x2", "-x2 - x1**2"], SUM, np.inf),
    # Textbook: Lorenz below its bifurcation, with every level; Slotine and Li (1991), example 3.13.
    (["10*(x2 - x1)", "0.5*x1 - x2 - x1*x3", "x1*x2 - 8/3*x3"], "x1**2/10+x2**2+x3**2", np.inf),
    (["-x1 - x1**3"], None, np.inf),
    (["x1*(x1**2 + x2**2 - 2) - 4*x1*x2**2", "4*x1**2*x2 + x2*(x1**2 + x2**2 - 2)"], SUM, 2.0),
]


@pytest.mark.parametrize(("field", "function", "level"), DEGENERATE)
def test_levels_where_the_linearisation_is_marginal_or_every_level_holds(
    field: list[str], function: Any, level: float
) -> None:
    """Each level follows from V' by hand; a finite one is reached from below to 1e-5."""
    answer = attraction_level(field, function, states=["x1", "x2", "x3"][: len(field)])

    assert answer.found and answer.proved and answer.largest and answer.fault() == ""
    assert answer.level == answer.invariant_level == pytest.approx(level, rel=1e-5)
    assert answer.level is not None and (answer.level == np.inf or answer.level < level)


@pytest.mark.parametrize(
    ("field", "function"),
    [
        (["x2", "-x1", "-x3"], "x1**2 + x2**2 + x3**2"),  # an undamped oscillation
        (["-x1 + x2*x3", "-2*x1*x3", "x1*x2"], "x1**2 + x2**2 + x3**2"),  # a body may spin
    ],
)
def test_invariance_is_not_called_attraction(field: list[str], function: str) -> None:
    """V never rises, but solutions need not tend to 0."""
    answer = attraction_level(field, function, states=["x1", "x2", "x3"][: len(field)])

    assert (answer.status, answer.level, answer.proved) == ("unknown", None, False)
    assert answer.invariant_level == np.inf and answer.fault() == ""
    assert replace(answer, level=np.inf).fault() != ""


def test_attraction_ends_at_the_next_equilibrium_where_every_level_is_invariant() -> None:
    """Equilibria at x1 = 0.625 and 0.8; V' = -x2^2, and V(0.8, 0) = 0.0768 is the lower one."""
    field = ["x2", "-2*x1 + 5.7*x1**2 - 4*x1**3 - x2"]

    answer = attraction_level(field, "x1**2 - 1.9*x1**3 + x1**4 + x2**2/2", states=STATES)

    assert answer.proved and answer.invariant_level == np.inf and answer.fault() == ""
    assert answer.level is not None and 0.0767 < answer.level < 0.0768
    assert replace(answer, level=0.07679).fault() == replace(answer, level=0.07).fault() == ""
    assert replace(answer, level=0.0769).fault() != ""


def test_a_number_that_may_not_be_the_largest_is_called_a_lower_bound() -> None:
    """With a constant multiplier no solver bounds it; with the usual degree every level holds."""
    field = ["-x1*(1 - x1*x2)**2", "-x2"]

    answer = attraction_level(field, SUM, states=STATES, multiplier_degree=0)

    assert answer.proved and not answer.largest and "lower bound" in answer.diagnosis


@pytest.mark.slow
def test_gram_matrices_that_are_singular_off_the_axes_are_reduced() -> None:
    """V' = -2 (x1 - 2 x2)^4 - 2 (x1 + x2)^6: S has null vectors that are no monomials."""
    field = ["-(x1 - 2*x2)**3 - (x1 + x2)**5", "2*(x1 - 2*x2)**3 - (x1 + x2)**5"]

    answer = attraction_level(field, SUM, states=STATES, multiplier_degree=2)

    assert answer.proved and answer.fault() == ""
    assert max(len(m.terms) for m in answer.bases["S"]) > 1


@pytest.mark.parametrize(
    ("field", "function", "by_ray"),
    [
        (["-x1", "-x2"], "x1**2 - x2**2", True),
        (["x1**3", "-x2"], SUM, True),
        (["-4.5*x1 + 2.25*x2", "2.25*x1 - x2"], SUM, False),  # V' > 0 between the rays looked at
    ],
)
def test_infeasible_has_an_exact_reason(field: list[str], function: str, by_ray: bool) -> None:
    """V <= 0 or V' > 0 along a ray, or exact multipliers that exclude every positive level."""
    answer = attraction_level(field, function, states=STATES)

    assert answer.status == "infeasible" and answer.level is None and not answer.proved
    if by_ray:
        assert answer.ray is not None
        near = np.array([float(entry) for entry in answer.ray]) / 1000
        assert answer.function(near) <= 0 or answer.function.along(answer.field)(near) > 0
    else:
        assert answer.no is not None and answer.no.holds and "c positive" in answer.no.multipliers


def test_a_text_is_read_and_not_executed(tmp_path: Path) -> None:
    """Text of a caller is a polynomial by the grammar of plant files, or refused."""
    file = tmp_path / "made"

    with pytest.raises(ModelError, match="no polynomial"):
        StatePolynomial.of(f"x1*len(str(open({str(file)!r}, 'w')))", STATES)
    assert not file.exists()


def test_decimals_in_texts_are_decimals() -> None:
    """0.1 is one tenth, and a matrix of floats is what it stores."""
    assert StatePolynomial.of("0.1*x1", STATES).terms == {(1, 0): Fraction(1, 10)}
    assert StatePolynomial.quadratic([[0.1, 0.0], [0.0, 1.0]]).terms[(2, 0)] == Fraction(0.1)
