"""Functions of control.nlsys, called with symbols: the same values, or a refusal."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import control
import numpy as np
import pytest

from takagi.models import (
    ModelError,
    Plant,
    from_control,
    nonlinear_system,
    sector_model,
)

Floats = Any
Update = Callable[[Any, Any, Any, Mapping[str, Any]], Any]


def pendulum(t: Any, x: Any, u: Any, params: Mapping[str, Any]) -> Any:
    damped = np.array([[0, 1.0], [0, -0.1]]) @ x
    return damped + np.array([0, params["g"] * np.sin(x[0]) + u[0] / params.get("m", 2)])


def many(t: Any, x: Any, u: Any, params: Mapping[str, Any]) -> Any:
    drag = np.abs(x[1]) * x[1] / np.sqrt(1 + np.square(x[0]))
    return [
        x[1],
        -drag + np.exp(-x[0]) - 1 + np.tanh(x[0]) * u[0] ** 3 + 2 ** x[0] * x[1] - np.arctan(x[1]),
    ]


def system_of(update: Update, **options: Any) -> control.NonlinearIOSystem:
    names = {"states": ["q", "w"], "inputs": ["u"], "outputs": ["q", "w"], "name": "given"}
    return control.nlsys(update, None, **(names | options))


@pytest.mark.parametrize("update", [pendulum, many])
def test_the_plant_has_the_function_s_values(update: Update) -> None:
    system = system_of(update, params={"g": 9.81})
    again = nonlinear_system(from_control(system, {"q": (-1, 1), "w": (-2, 2), "u": (-1, 1)}))
    for point in np.random.default_rng(0).uniform(-1, 1, (20, 3)):
        true = np.array(update(0.0, point[:2], point[2:], {"g": 9.81}), dtype=float)
        assert np.allclose(again.updfcn(0.0, point[:2], point[2:], {}), true, rtol=1e-12)


def test_parameters_keep_their_names() -> None:
    plant = from_control(system_of(pendulum, params={"g": 9.81, "m": 2.0}), {"q": (-1, 1)})

    assert {p.symbol.name: float(p.value) for p in plant.parameters} == {"g": 9.81, "m": 2.0}
    assert plant.name == "given" and len(sector_model(plant).rules) == 2


def test_a_parameter_that_is_called_as_a_state_is_its_number() -> None:
    def update(t: Any, x: Any, u: Any, params: Any) -> Any:
        return [x[1], params["q"] * x[0] + params["_b"] * u[0]]

    plant = from_control(system_of(update, params={"q": 3.0, "_b": 0.5}))

    assert str(plant.equations[1]) == "3*q + u/2" and plant.parameters == ()


def test_outputs_and_the_sample_time_are_kept() -> None:
    def height(t: Any, x: Any, u: Any, params: Any) -> Any:
        return [np.cos(x[0])]

    system = control.nlsys(pendulum, height, states=2, inputs=1, outputs=1, dt=0.1, params={"g": 1})
    plant = from_control(system, {"x_0": (-1, 1)})

    assert plant.sample_time == 0.1
    assert str(plant.outputs[0].expression) == "cos(x_0)"


def test_a_disturbance_is_named() -> None:
    system = system_of(pendulum, params={"g": 1.0})

    assert from_control(system, disturbances=["u"]).inputs == ()
    with pytest.raises(ModelError, match="disturbances: d was given; inputs are u"):
        from_control(system, disturbances=["d"])


def branching(t: Any, x: Any, u: Any, params: Any) -> Any:
    return [x[1], u[0]] if x[0] > 0 else [x[1], -u[0]]


def equal(t: Any, x: Any, u: Any, params: Any) -> Any:
    return [x[1], u[0] if x[0] == 0 else -u[0]]


def filling(t: Any, x: Any, u: Any, params: Any) -> Any:
    rate = np.zeros(2)
    rate[0] = x[1]
    return rate


def hiding(t: Any, x: Any, u: Any, params: Any) -> Any:
    """A branch on the type, which no comparison shows."""
    return [x[1], u[0] if isinstance(x[0], float) else -u[0]]


@pytest.mark.parametrize(
    ("update", "told"),
    [
        (branching, "it compares q"),
        (equal, "it compares q"),
        (filling, "needs its number"),
        (hiding, "is another function of symbols than of numbers"),
        (lambda t, x, u, p: [x[1], math.sin(x[0])], "needs its number"),
        (lambda t, x, u, p: [x[1], np.maximum(x[0], 0)], "it compares q"),
        (lambda t, x, u, p: [x[1], np.where(x[0] > 0, 1, 2)], "it compares q"),
        (lambda t, x, u, p: [x[1], np.arctan2(x[0], 1)], "it calls arctan2 of q"),
        (lambda t, x, u, p: [x[1], np.sin(t)], "depends on time"),
        (lambda t, x, u, p: [x[1], p["missing"]], "KeyError"),
        (lambda t, x, u, p: [x[1]], "f has 1 rows, and 2 states"),
    ],
)
def test_a_function_that_is_no_expression_is_refused(update: Update, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        from_control(system_of(update), {"q": (-1, 1)})


@pytest.mark.parametrize(
    ("system", "told"),
    [
        (control.tf([1], [1, 1]), "a system of control.ss or control.nlsys with states"),
        (control.ss([], [], [], [[1.0]]), "with no states was given"),
        (control.ss([[1.0]], [[1.0]], [[1.0]], [[0.0]], True), "without a sample time"),
    ],
)
def test_a_system_of_another_kind_is_refused(system: Any, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        from_control(system)


def test_a_linear_system_may_have_units_and_be_measured() -> None:
    system = control.ss([[0, 1], [2, 0]], [[0], [3]], [[1, 0]], [[0]], states=["q", "w"])
    plant = from_control(system, {"q": (-60, 60)}, units={"q": "deg", "w": "rad/s"}, measured=["q"])

    assert plant.measured == ("q",) and plant.units == "checked"
    assert plant.states[0].range is not None and float(plant.states[0].range.upper) < 1.05


def test_a_plant_from_a_function_is_one_from_sympy() -> None:
    assert isinstance(from_control(system_of(many)), Plant)


@pytest.mark.parametrize(
    ("C", "names", "told"),
    [
        ([[0, 1], [1, 0]], ["q", "w"], "outputs: q is w, and a state has this name"),
        ([[2, 0], [0, 1]], ["q", "w"], r"outputs: q is 2\*q, and a state has this name"),
        ([[2, 0], [0, 3]], ["y[0]", "y_0"], "outputs: y_0 is the name of two"),
    ],
)
def test_an_output_under_the_name_of_another_is_refused(
    C: Any, names: list[str], told: str
) -> None:
    """``measured`` would be about the state, and of two outputs one would be lost."""
    system = control.ss(
        [[0, 1], [2, 0]], [[0], [3]], C, [[0], [0]], states=["q", "w"], outputs=names
    )
    with pytest.raises(ModelError, match=told):
        from_control(system)


def test_an_output_that_looks_at_types_is_refused() -> None:
    def output(t: Any, x: Any, u: Any, params: Mapping[str, Any]) -> Any:
        return [x[0], (3 if isinstance(x[0], float) else 2) * x[1]]

    names = {"states": ["q", "w"], "inputs": ["u"], "outputs": ["q", "y"]}
    system = control.nlsys(lambda t, x, u, params: [x[1], u[0] - x[0]], output, **names)
    with pytest.raises(ModelError, match="the output function gives"):
        from_control(system)
