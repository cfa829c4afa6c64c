"""Loops through an observer: limits by hand, both kinds of weights, and what is claimed."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.observer_law import states_at_start
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import (
    law_members,
    observer_member,
    plant_data,
    slope_claim,
    slopes_data,
)
from takagi.certificates.requests import ObservedLoop
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import Interval, ModelError, Output, Plant, TSModel, Variable, sector_model
from tests.certificates.kinds.claims import Data, law_data, model_data, sealed


@pytest.mark.parametrize(
    ("changed", "proved"),
    [
        ({}, True),
        ({"P": [[1, 0], [0, 0.375]]}, False),
        ({"level": 1.0001}, False),
        ({"decay_rate": 0.01}, False),
        ({"P": [[1, 0], [0, -1]]}, False),
        ({"P": [[1, 0.1], [0, 1]]}, False),
        # u = -3 (x - e): 9 (1 + 8/3) = 33, so that 5.75^2 > 33 is kept and 5.74^2 is not.
        ({"input_limits": [5.75]}, True),
        ({"input_limits": [5.74]}, False),
        ({"input_limits": [-6]}, False),
        # With a term of x and e: 9 c (1 + 1 + 0.4) / 0.96 = 21.6 for c = 0.96, 4.647...^2.
        ({"P": [[1, 0.2], [0.2, 1]], "level": 0.96, "input_limits": [4.65]}, True),
        ({"P": [[1, 0.2], [0.2, 1]], "level": 0.96, "input_limits": [4.64]}, False),
    ],
)
def test_limits_of_a_linear_plant_from_both_sides(changed: Data, proved: bool) -> None:
    verdict, text = outcome(*line(**changed))

    assert (verdict == "PROVED") is proved, text


def test_the_sentence_says_where_it_may_start() -> None:
    """xhat starts at the measured x: e = 0, so that V = x^2 and |x| <= 1 may start."""
    text = outcome(*line())[1]
    assert "a state alone may start up to 1 in x1" in text
    assert "exact outputs" in text


@pytest.mark.parametrize(
    ("changed", "proved"),
    [
        ({}, True),
        ({"P": [[1, 0], [0, 0.66]], "level": 0.3}, False),
        ({"level": 0.4118}, False),
        ({"input_limits": [1.93]}, True),
        ({"input_limits": [1.92]}, False),
    ],
)
def test_limits_with_weights_at_the_estimate(changed: Data, proved: bool) -> None:
    verdict, text = outcome(*of_cubic(**changed))

    assert (verdict == "PROVED") is proved, text
    assert not proved or "weights at the estimate" in text


def test_the_motion_of_the_plant_stays_in_the_proved_set() -> None:
    """x and xhat of the nonlinear plant, integrated by themselves from the set's boundary."""
    from scipy.integrate import solve_ivp

    s, c = 0.7, 0.4117

    def rate(_: float, both: Any) -> list[float]:
        plant, estimate = both
        command = -3 * estimate
        gap = 4 * (plant - estimate)
        return [plant - plant**3 + command, estimate - estimate**3 + command + gap]

    for angle in np.linspace(0, 2 * np.pi, 16, endpoint=False):
        z = np.sqrt(c) * np.array([np.cos(angle), np.sin(angle) / np.sqrt(s)])
        found = solve_ivp(rate, (0, 10), [z[0] + z[1], z[0]], rtol=1e-9, atol=1e-12)
        value = found.y[1] ** 2 + s * (found.y[0] - found.y[1]) ** 2
        assert np.all(np.diff(value) <= 1e-9)
        assert np.abs(found.y).max() <= 1 and value[-1] < 1e-8


@pytest.mark.parametrize(
    ("C", "D", "seen"),
    [
        ([[[1, 0]]], [], [True, False]),
        ([[[0, 1], [1, 0]]], [], [True, True]),
        ([[[2, 0]]], [], [False, False]),
        ([[[1, 1]]], [], [False, False]),
        ([[[0, 0]]], [], [False, False]),
        ([[[1, 0]], [[1.01, 0]]], [], [False, False]),
        ([[[1, 0]]], [[[0]], [[1]]], [False, False]),
        ([[[1, 0]]], [[[0, 1]]], [False, False]),
        ([[[1, 0], [0, 1]]], [[[0], [1]]], [True, False]),
        ([], [], [False, False]),
    ],
)
def test_an_estimate_starts_at_states_that_are_outputs(C: Any, D: Any, seen: list[bool]) -> None:
    """A factor of 1 in all rules, one state, and no input that is added."""
    matrices = [[Matrix.of([[Fraction(str(e)) for e in r] for r in M]) for M in S] for S in (C, D)]
    assert states_at_start(matrices[0], matrices[1], 2) == seen


def test_the_sentence_says_what_is_assumed_and_kept() -> None:
    model, gains, claim = line()
    assert "which its measured outputs tell" in outcome(model, gains, claim)[1]
    text = outcome({k: v for k, v in model.items() if k != "box"}, gains, claim)[1]
    assert "in the model's box" not in text
    assert "in which x stays in the model's box" in outcome(model, gains, claim)[1]
    only = model | {"box": {"u [-]": [-9, 9]}}
    assert "in the model's box" in outcome(only, gains, claim)[1]
    assert "in which x and xhat stay in the model's box" in outcome(*of_cubic())[1]
    # An output that is not a state: the estimate starts at rest, e = x, V = x'(1 + s) x.
    twice = model | {"C": [[[2]]], "A": [[[1]]]}
    text = outcome(twice, gains, claim | {"P": [[1, 0], [0, 1]], "level": 0.5})[1]
    assert "where the estimate starts at rest, a state alone may start up to 0.5 in x1" in text


def test_the_request_finds_the_set() -> None:
    """The loop of ``line``: no start beyond 1 stays, and nearly all up to 1 do (e starts at 0)."""
    model, gains, _ = line()
    plant = TSModel(
        [[[1.0]]], [[[1.0]]], C=[[[1.0]]], states=["x1 [-]"], inputs=["u [-]"], outputs=["y"],
        box={"x1 [-]": (-1, 1)},
    )  # fmt: skip
    loop = ClaimedLoop.of(plant, [[[3.0]]], model_data=model, law=gains)

    found = ObservedLoop().attempt(loop)

    assert found.proved
    P, level = np.array(found.claim["P"]), found.claim["level"]
    assert 0.99 < np.sqrt(level / P[0, 0]) <= 1
    assert not ObservedLoop(2.01).attempt(loop).proved
    with pytest.raises(ModelError, match="positive numbers"):
        ObservedLoop(input_limits=[-1.0]).attempt(loop)


def test_a_model_without_an_observer_is_refused_by_the_request() -> None:
    model = sector_model(
        Plant(
            equations=(x - x**3 + u,),
            states=(Variable(x, "-", Interval.of(-1, 1)),),
            inputs=(Variable(u, "-"),),
        )
    )
    with pytest.raises(ModelError, match="needs gains.observer"):
        ObservedLoop().attempt(ClaimedLoop.of(model, np.full((2, 1, 1), 3.0)))


x, v, u = sp.symbols("x v u", real=True)


SEEN = {"weights": "measured", "measured": ["y"]}


def outcome(model: Data, gains: Data, *claims: Data) -> tuple[str, str]:
    checked = check_document(sealed(model, gains, *claims)).claims[-1]
    return checked.verdict.name, checked.text


def line(**changed: Any) -> tuple[Data, Data, Data]:
    """Return x' = x + u, y = x, |x| <= 1, u = -3 xhat, L = 4, and P = diag(1, s).

    z = (x, e): z' = [[-2, 3], [0, -3]] z.  4 * 6 s > 9: s > 3/8; x in its range for c <= 1.
    """
    model = model_data(
        [[[1]]], B=[[[1]]], C=[[[1]]], output_names=["y"], input_names=["u [-]"],
        box={"x1 [-]": [-1, 1]},
    )  # fmt: skip
    gains = law_data([[[3]]], input_names=["u [-]"], observer=SEEN | {"L": [[[4]]]})
    claim = {"name": "line", "kind": "observed-loop", "level": 1, "decay_rate": 0}
    return model, gains, claim | {"P": [[1, 0], [0, 0.375000001]]} | changed


@cache
def cubic() -> tuple[Data, Data]:
    """Return x' = x - x^3 + u, y = x on |x| <= 1, |u| <= 2, and u = -3 xhat, L = 4 by estimate."""
    plant = Plant(
        equations=(x - x**3 + u,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-", Interval.of(-2, 2)),),
        outputs=(Output("y", x, "-"),),
        measured=("y",),
        name="cubic",
    )
    return _by_estimate(plant, [[3.0]], [[4.0]])


@cache
def hidden() -> tuple[Data, Data]:
    """Return x' = v, v' = u - v^3, y = x on |x|, |v| <= 1: its premise is not measured."""
    plant = Plant(
        equations=(v, u - v**3),
        states=(Variable(x, "-", Interval.of(-1, 1)), Variable(v, "-", Interval.of(-1, 1))),
        inputs=(Variable(u, "-"),),
        outputs=(Output("y", x, "-"),),
        measured=("y",),
        name="hidden",
    )
    return _by_estimate(plant, [[1.0, 1.0]], [[3.0], [3.0]])


def _by_estimate(plant: Plant, K: list[list[float]], L: list[list[float]]) -> tuple[Data, Data]:
    model = sector_model(plant)
    data = plant_data(model) | {"slopes": slopes_data(secant_model(plant))}
    own = {"observer": observer_member(np.array([L]), ["y"], at_estimate=True)}
    gains = pdc_law_data(model, np.broadcast_to(np.array(K), (len(model.A), 1, len(L))))
    return data, gains | law_members(data) | own


def of_cubic(data: Data | None = None, **changed: Any) -> tuple[Data, Data, Data, Data, Data]:
    """Return the cubic plant's certificate in parts.

    z = (xhat, e): xhat' = (1 - xhat^2 - 3) xhat + 4 e, e' = (S - 4) e with S in [-2, 1].  With
    P = diag(1, s): 4 * 6 s > 16, s > 2/3.  Of s = 0.7: c (1 + 1/s) <= 1 keeps x in its range,
    c <= 0.41176...; 9 c <= 4 keeps the input.
    """
    model, gains = cubic()
    claim = {"name": "cubic", "kind": "observed-loop", "level": 0.4117, "decay_rate": 0}
    claim |= {"P": [[1, 0], [0, 0.7]]}
    first = {"name": "cubic is its model", "kind": "sector-embedding"}
    return data or model, gains, first, slope_claim("cubic"), claim | changed
