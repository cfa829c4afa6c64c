"""Plants from sympy: the same plant as from a file, and what is refused."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import ModelError, Plant, from_sympy, load_model, plant_text, sector_model
from tests.plant_files import filed_plant

x, v, u, m, k = sp.symbols("x v u m k")


def cubic(**changes: Any) -> Plant:
    given: dict[str, Any] = {
        "f": [v, (u - k * x**3) / m],
        "states": [x, v],
        "inputs": [u],
        "ranges": {x: (-1.5, 1.5), "v": (-2, 2), u: (-3, 3)},
        "parameters": {m: 1.1, k: 0.67},
    }
    return from_sympy(**(given | changes))


def test_the_plant_is_that_of_a_file(tmp_path: Path) -> None:
    text = """
format = 1
kind = "plant"
name = "pendulum"
[states]
theta = { unit = "deg", range = [-60, 60] }
omega = { unit = "rad/s", range = [-4, 4] }
[inputs]
tau = { unit = "N m", range = [-20, 20] }
[parameters]
m = { value = 2.0, unit = "kg" }
l = { value = 500, unit = "mm" }
g = { value = 9.81, unit = "m/s^2" }
[equations]
theta = "omega"
omega = "(m*g*l*sin(theta) + tau) / (m*l^2)"
[outputs]
height = { expression = "l*cos(theta)", unit = "m" }
"""
    theta, omega, tau, length, g = sp.symbols("theta omega tau l g")
    plant = from_sympy(
        {omega: (m * g * length * sp.sin(theta) + tau) / (m * length**2), theta: omega},
        [theta, omega],
        [tau],
        {theta: (-60, 60), omega: (-4, 4), tau: (-20, 20)},
        parameters={m: 2.0, length: 500, g: 9.81},
        units={
            theta: "deg", omega: "rad/s", tau: "N m", m: "kg", length: "mm", g: "m/s^2",
        },
        outputs={"height": length * sp.cos(theta)},
        name="pendulum",
    )  # fmt: skip

    assert plant == filed_plant(tmp_path, text)
    assert filed_plant(tmp_path, plant_text(plant), "again.toml") == plant
    assert 'unit = "deg", range = [-60, 60]' in plant_text(plant)


def test_a_plant_from_sympy_is_designed_and_proved() -> None:
    design = design_plant(cubic())

    assert isinstance(design, PlantDesign) and design.proved


def test_functions_of_time_are_states() -> None:
    q, w = dynamicsymbols("q w")
    plant = from_sympy([w, 17 * sp.sin(q) + u], [q, w], [u], {q: (-1, 1)}, measured=[q])

    assert plant.equations[1] == 17 * sp.sin(sp.Symbol("q", real=True)) + sp.Symbol("u", real=True)
    assert plant.measured == ("q",)
    assert len(sector_model(plant).rules) == 2


def test_floats_are_the_decimals_that_they_print_as() -> None:
    plant = from_sympy([-0.1 * x + 0.3 * u], [x], [u])

    assert plant.equations[0].coeff(plant.states[0].symbol) == sp.Rational(-1, 10)
    assert cubic().parameters[0].value == Fraction(11, 10)


def test_a_rest_may_be_found() -> None:
    plant = from_sympy([u - x**2], [x], [u], {x: (1, 3), u: (0, 9)}, rest={x: 2, u: None})

    assert [float(w.rest) for w in plant.variables] == [2.0, 4.0]


def test_signals_that_schedule_move_the_matrices() -> None:
    w = sp.Symbol("w")
    plant = from_sympy([-(1 + w) * x + u], [x], [u], {w: (0, 1)}, scheduling=[w])

    assert sorted(sector_model(plant).A.ravel()) == [-2.0, -1.0]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"f": [v]}, r"f has 1 rows, and 2 states were given \(x, v\)"),
        ({"f": {x: v}}, "f has no row for v; every state needs one"),
        ({"parameters": {m: 1}}, "k is neither a variable nor a parameter"),
        ({"ranges": {"w": (0, 1)}}, r"ranges of w was given.*there are x, v, u, m, k"),
        ({"ranges": {x: (1, -1)}}, "the smaller end first"),
        ({"states": [sp.Symbol(r"\theta"), v]}, "use another symbol"),
        ({"f": [v, sp.atan2(x, v)]}, r"atan2\(x, v\) was given; its rigorous range is not known"),
        ({"f": [v, sp.Piecewise((x, x > 0), (0, True))]}, "its rigorous range is not known"),
        ({"f": ["v", "u"]}, "'v' is a text; a sympy expression is needed"),
        ({"f": [v, sp.I * x]}, "real finite numbers are needed"),
        ({"units": {x: "Nm"}}, "unit 'Nm' is not known; write 'N m'"),
        ({"units": {x: "m"}}, "has the unit"),
        ({"measured": ["y"]}, "measured"),
    ],
)
def test_what_does_not_fit_is_told(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ModelError, match=told):
        cubic(**changes)


def test_the_library_s_plants_survive_their_text(tmp_path: Path) -> None:
    for name in ("cart_pole", "tora", "henon", "two_mass_spring", "flexible_link", "lorenz"):
        plant = load_model(name)
        assert isinstance(plant, Plant)
        assert filed_plant(tmp_path, plant_text(plant), f"{name}.toml") == plant
    for name in ("van_de_vusse", "magnetic_levitation"):
        plant = load_model(Path(__file__).parents[2] / "gallery" / "plants" / f"{name}.toml")
        assert isinstance(plant, Plant)
        assert filed_plant(tmp_path, plant_text(plant), f"{name}.toml") == plant


@pytest.mark.parametrize("name", ["split_range", "dc_servo"])
def test_a_plant_with_more_than_a_plant_s_file_is_refused(name: str) -> None:
    plant = load_model(name)
    assert isinstance(plant, Plant)

    with pytest.raises(ModelError, match="copy its file"):
        plant_text(plant)


@pytest.mark.parametrize("time", ["t - 1", "0", "2*t"])
def test_a_state_at_another_time_is_not_the_state(time: str) -> None:
    """A delay, or an initial value, would become the present value."""
    (q,) = dynamicsymbols("q,")
    other = q.subs(sp.Symbol("t"), sp.sympify(time))
    with pytest.raises(ModelError, match="knows q at the present time alone"):
        from_sympy([-other], [q])
    assert from_sympy([-q], [q]).equations == (-sp.Symbol("q", real=True),)
