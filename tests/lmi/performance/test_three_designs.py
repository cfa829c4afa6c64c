"""What designs for the variance, the energy gain and the peak gain have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    Condition,
    Design,
    EigenvalueRegion,
    expressed,
    h2_pdc,
    h2_pdc_condition,
    hinf_pdc,
    hinf_pdc_condition,
    peak_pdc,
    peak_pdc_condition,
    rigorous_no,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant, plant_of
from takagi.models import TSModel
from tests.lmi import known_models
from tests.lmi.norms import (
    frequency_norm,
    gramian_norm,
    hamiltonian_norm,
    sampled_gramian_norm,
)
from tests.lmi.performance.disturbed import blends, gain_of, loop, three_rules, two_rules

pytestmark = pytest.mark.numeric

DESIGNS: dict[str, Callable[..., Design]] = {"h2": h2_pdc, "hinf": hinf_pdc, "peak": peak_pdc}
# The unknown that is minimised, and whether it is the gain or its square.
LEAST = {"h2": ("nu", 2), "hinf": ("gamma", 1), "peak": ("kappa", 2)}


def condition_of(kind: str, model: TSModel, design: Design) -> Condition:
    if kind == "peak":
        return peak_pdc_condition(model, decay_rate=design.decay_rate)
    return h2_pdc_condition(model) if kind == "h2" else hinf_pdc_condition(model)


@pytest.mark.parametrize("sample_time", [None, 0.1])
@pytest.mark.parametrize("kind", DESIGNS)
def test_the_condition_itself_in_cvxpy(kind: str, sample_time: float | None) -> None:
    """The condition as data, read by cvxpy, has the same least gain as the design."""
    model = two_rules(sample_time)
    design = DESIGNS[kind](model)
    other = expressed(condition_of(kind, model, design), margin=0.0)
    other.problem().solve(solver="CLARABEL")

    name, power = LEAST[kind]
    least = float(other.values()[name][0, 0, 0])
    accuracy = 1e-4 if kind == "h2" else 1e-3
    assert gain_of(design) == pytest.approx(least ** (1 / power), rel=accuracy)


@pytest.mark.parametrize("sample_time", [None, 0.1])
@pytest.mark.parametrize("kind", DESIGNS)
def test_the_gains_hold_in_the_models_own_coordinates(kind: str, sample_time: float | None) -> None:
    """One per cent above the least, P, K and gain satisfy the LMIs; reversed gains do not."""
    model = two_rules(sample_time)
    design = DESIGNS[kind](model, tolerance=0.01)
    K, P = design.require()
    assert design.margin > 1e-6 or kind != "hinf"
    condition, Q = condition_of(kind, model, design), np.linalg.inv(P)
    name, power = LEAST[kind]
    least = np.array([[[gain_of(design) ** power * (1 + 1e-6)]]])
    values: dict[str, Any] = {"Q": Q[None], "M": K @ Q, name: least}
    if kind == "h2":
        W = model.E.transpose(0, 2, 1) @ P @ model.E
        values["W"] = W + (least - W.max()) / 2

    assert margin(condition, values) > 0
    assert margin(condition, {**values, "M": -values["M"]}) < 0
    assert margin(condition, {**values, name: 0.9 * least}) < 0


@pytest.mark.parametrize("sample_time", [None, 0.1])
@pytest.mark.parametrize("kind", ["h2", "hinf"])
def test_no_blend_of_the_loop_has_a_larger_norm(kind: str, sample_time: float | None) -> None:
    """Frozen memberships are among what the bound covers: the loop by Gramians or frequencies."""
    model, zero = three_rules(sample_time), np.zeros((2, 2))
    design = DESIGNS[kind](model, tolerance=0.02)
    norm: Callable[..., float] = {
        "h2": (lambda A, B, C, _: gramian_norm(A, B, C), sampled_gramian_norm),
        "hinf": (hamiltonian_norm, frequency_norm),
    }[kind][sample_time is not None]
    worst = max(norm(*loop(model, design.require()[0], h), zero) for h in blends(3, 12))

    assert 0.3 * gain_of(design) < worst <= gain_of(design)


@pytest.mark.parametrize("kind", DESIGNS)
def test_units_change_the_gain_by_their_ratio(kind: str) -> None:
    """By d / c for w = d what, y = c yhat; time counts for a variance, by its own root."""
    model = two_rules()
    s, tau, d, c, rate = np.array([1e3, 1e-2]), 1e4, 1e-3, 10.0, 50.0
    other = TSModel(
        rate * model.A * s / s[:, None],
        rate * tau * model.B / s[:, None],
        E=rate * d * model.E / s[:, None],
        C=model.C * s / c,
        D=model.D * tau / c,
    )
    given: dict[str, tuple[dict[str, float], dict[str, float]]] = {
        "h2": ({}, {}),
        "hinf": ({"tolerance": 0.01}, {"tolerance": 0.01}),
        "peak": ({"decay_rate": 2.0}, {"decay_rate": 2.0 * rate, "disturbance_peak": 1 / d}),
    }
    plain, scaled = (
        DESIGNS[kind](one, **options)
        for one, options in zip((model, other), given[kind], strict=True)
    )

    expected = gain_of(plain) * d / c * (np.sqrt(rate) if kind == "h2" else 1.0)
    assert gain_of(scaled) == pytest.approx(expected, rel=1e-3 if kind == "hinf" else 1e-4)
    if kind == "hinf":
        for h in blends(2, 5):
            closed = loop(other, scaled.require()[0], h)
            assert hamiltonian_norm(*closed, np.zeros((2, 1))) <= gain_of(scaled)


@pytest.mark.parametrize("kind", DESIGNS)
def test_without_gains_the_answer_says_why(kind: str) -> None:
    """Two rules whose inputs push in opposite directions: the no is that of plain compensation."""
    opposed = TSModel([[[1.0]], [[1.0]]], [[[1.0]], [[-1.0]]], E=[[1.0]], C=[[1.0]])
    design = DESIGNS[kind](opposed)

    assert design.status == "infeasible"
    assert design.gains is None and design.gain is None and design.P is None
    assert "no gains by wang-tanaka-griffin" in design.answer.diagnosis


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "relaxation", "limit"),
    [
        ("h2", "tuan", -0.67),
        ("h2", "kim-lee", 1.2593),
        ("peak", "tuan", -0.67),
        ("peak", "kim-lee", 1.2593),
        ("peak", "liu-zhang", 2.7252),
    ],
)
def test_rules_that_can_hardly_be_stabilised_have_a_gain(
    kind: str, relaxation: str, limit: float
) -> None:
    """Kim and Lee (2000), a = 2, five per cent of b inside the limit of each relaxation.

    No V falls faster than about 1e-3 1/s there: no rate of the mean vertex's regulator will do.
    """
    b = limit - 0.05 * abs(limit)
    A = [[[1.59, -7.29], [0.01, 0]], [[0.02, -4.64], [0.35, 0.21]], [[-2.0, -4.33], [0, 0.05]]]
    B = [[[1.0], [0.0]], [[8.0], [0.0]], [[6.0 - b], [-1.0]]]
    C, D = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]], [[0.0], [0.0], [1.0]]
    design = DESIGNS[kind](TSModel(A, B, E=[[1.0], [1.0]], C=C, D=D), relaxation=relaxation)

    assert design.status == "candidate", design.answer.diagnosis
    assert kind == "h2" or design.decay_rate < 5e-3


@pytest.mark.parametrize("kind", ["h2", "hinf"])
def test_a_no_is_that_of_gains_of_whatever_norm(kind: str) -> None:
    """Kim and Lee's three rules have no gains by all pairs, so none with a norm: two questions."""
    gains_alone = known_models.three_rules(2.0)
    model = TSModel(gains_alone.A, gains_alone.B, E=[[1], [0]], C=np.eye(2), D=[[0], [1]])

    design = DESIGNS[kind](model)

    assert design.status == "infeasible"
    assert "of gains with whatever norm" in design.answer.diagnosis
    assert len(design.answer.tries) <= 4
    no = rigorous_no(design)
    assert no is not None
    assert no.holds
    assert no.condition.name.startswith("parallel distributed compensation")


def test_a_margin_that_costs_too_much_is_made_smaller_once() -> None:
    rng = np.random.default_rng(1)
    A, B = rng.normal(size=(4, 4)), rng.normal(size=(4, 2))
    A = A + 0.2 * rng.normal(size=(4, 4, 4))
    B = B + 0.2 * rng.normal(size=(4, 4, 2))
    C, D = np.vstack([np.eye(4), np.zeros((2, 4))]), np.vstack([np.zeros((4, 2)), np.eye(2)])
    design = h2_pdc(TSModel(A, B, E=rng.normal(size=(4, 1)), C=C, D=D))

    assert gain_of(design) == pytest.approx(18.6905, rel=2e-4)
    assert [attempt.solver for attempt in design.answer.tries] == ["clarabel", "clarabel"]
    assert design.margin > 1e-4


# Damping of at least 0.98, and no pole faster than 30/s.
REGION = EigenvalueRegion.sector(float(np.arccos(0.98))) & EigenvalueRegion.disc(30.0)


def plant(seconds: float) -> DisturbedPlant:
    """Return two rules of an oscillator with z = (x, u), in another unit of time."""
    A = np.array([[[0.0, 1.0], [-4.0, -0.1]], [[0.0, 1.0], [-9.0, -0.1]]])
    B, E = np.array([[[0.0], [1.0]]] * 2), np.array([[[0.0], [1.0]]] * 2)
    model = TSModel(A * seconds, B * seconds, E=E * seconds)
    return plant_of(model, ([[1.0, 0.0], [0.0, 0.0]], [[0.0], [0.1]]))


@pytest.mark.parametrize("function", [hinf_pdc, h2_pdc, peak_pdc])
def test_poles_lie_in_the_region_and_the_norm_is_larger(function: Any) -> None:
    free = function(plant(1.0))
    held = function(replace(plant(1.0), region=REGION))

    def poles(design: Any) -> Any:
        p = plant(1.0)
        return np.linalg.eigvals(p.A - p.B @ design.gains)

    assert REGION.excess(poles(held)).max() < 0 < REGION.excess(poles(free)).max()
    assert held.gain > free.gain


def test_the_unit_of_time_does_not_matter() -> None:
    """In ms the plant is a thousand times slower, and so is the region: the same energy gain."""
    in_seconds = hinf_pdc(replace(plant(1.0), region=REGION))
    in_milliseconds = hinf_pdc(replace(plant(1e-3), region=REGION.slowed(1e3)))

    assert in_milliseconds.gain == pytest.approx(in_seconds.gain, rel=1e-3)
