"""Plants of the package: equations written once more from the literature, and models."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from takagi.models import Floats, Plant, TSModel, Variable, load_model, sector_model
from takagi.models.blending.substitution import blended_model


def cart_pole(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Tanaka and Wang (2001), section 2.2: m = 2, M = 8, 2 l = 1, g = 9.8."""
    s, c, s2 = np.sin(x[0]), np.cos(x[0]), np.sin(2 * x[0])
    rise = 9.8 * s - 0.1 * 2.0 * 0.5 * x[1] ** 2 * s2 / 2 - 0.1 * c * u[0]
    return [x[1], rise / (4 * 0.5 / 3 - 0.1 * 2.0 * 0.5 * c**2)]


def cart_pole_2rules(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Wang, Tanaka and Griffin (1996): two local models and triangular weights."""
    beta, share = np.cos(np.deg2rad(88)), 2 * abs(x[0]) / np.pi
    first = (9.8 * x[0] - 0.1 * u[0]) / (2 / 3 - 0.1)
    second = (2 / np.pi * 9.8 * x[0] - 0.1 * beta * u[0]) / (2 / 3 - 0.1 * beta**2)
    return [x[1], (1 - share) * first + share * second]


def tora(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Bupp, Bernstein and Coppola (1998), solved for the accelerations."""
    e, s, c = 0.1, np.sin(x[2]), np.cos(x[2])
    pull, scale = e * x[3] ** 2 * s - x[0], 1 - e**2 * c**2
    return [x[1], (pull - e * c * u[0]) / scale, x[3], (u[0] - e * c * pull) / scale]


def truck_trailer(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Tanaka and Sano (1994) in their x1, x2, x3, before and after the change of coordinates."""
    turn, x1, x2 = -1.0 * 2.0 / 5.5, x[0], x[1] - (-1.0 * 2.0) / (2 * 5.5) * x[0]
    ahead = [(1 - turn) * x1 - 2.0 / 2.8 * u[0], x2 + turn * x1, x[2] - 2.0 * np.sin(x[1])]
    return [ahead[0], ahead[1] + turn / 2 * ahead[0], ahead[2]]


def quarter_car(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Newton's law for body and wheel."""
    force = u[0] - 16e3 * x[0] - 1e6 * x[0] ** 3 - 1500 * 0.8 * np.tanh(x[1] / 0.8)
    body, wheel = force / 300, (-force - 19e4 * x[2]) / 40
    return [x[1], body - wheel, x[3] - w[0], wheel]


def between(
    first: list[list[float]], second: list[list[float]]
) -> Callable[[Floats, Floats, Floats], Floats]:
    def field(x: Floats, u: Floats, w: Floats) -> Floats:
        blended: Floats = ((1 - w[0]) * np.array(first) + w[0] * np.array(second)) @ x
        return blended

    return field


# Equations written down again from the literature, figures in place, beside the number of rules.
FIELDS: dict[str, tuple[int, Callable[[Floats, Floats, Floats], object]]] = {
    "ball_and_beam": (
        4,
        lambda x, u, w: [x[1], 5 / 7 * (x[0] * x[3] ** 2 - 9.81 * np.sin(x[2])), x[3], u[0]],
    ),
    "cart_pole": (16, cart_pole),
    "cart_pole_2rules": (2, cart_pole_2rules),
    "dayawansa_martin": (2, between([[-1, -1], [1, -1]], [[-1, -5.8], [1 / 5.8, -1]])),
    "duffing": (2, lambda x, u, w: [x[1], -0.1 * x[1] - x[0] ** 3 + 12 * w[0] + u[0]]),
    "flexible_joint": (
        2,
        lambda x, u, w: [
            x[1],
            -9.81 * np.sin(x[0]) - 100 * (x[0] - x[2]),
            x[3],
            100 * (x[0] - x[2]) + u[0],
        ],
    ),
    "flexible_link": (
        2,
        lambda x, u, w: [
            x[1],
            48.6 * (x[2] - x[0]) - 1.25 * x[1] + 21.6 * u[0],
            x[3],
            -19.5 * (x[2] - x[0]) - 3.33 * np.sin(x[2]),
        ],
    ),
    # About x = 0.6, y = 0.18, u = -0.076, where it rests.
    "henon": (
        2,
        lambda x, u, w: [
            1 - 1.4 * (0.6 + x[0]) ** 2 + (0.18 + x[1]) + (u[0] - 0.076) - 0.6,
            0.3 * (0.6 + x[0]) - 0.18,
        ],
    ),
    "lorenz": (
        2,
        lambda x, u, w: [
            10 * (x[1] - x[0]) + u[0],
            28 * x[0] - x[0] * x[2] - x[1],
            x[0] * x[1] - 8 / 3 * x[2],
        ],
    ),
    "mass_spring_damper": (
        4,
        lambda x, u, w: [x[1], -0.1 * x[1] ** 3 - 0.02 * x[0] - 0.67 * x[0] ** 3 + u[0]],
    ),
    "quarter_car": (4, quarter_car),
    "shorten_narendra": (2, between([[-2, 4], [-1, -2]], [[-2, 4], [-10.6, -2]])),
    "tora": (16, tora),
    "truck_trailer": (2, truck_trailer),
}


@lru_cache
def plant_of(name: str) -> Plant:
    plant = load_model(name)
    assert isinstance(plant, Plant)
    return plant


@lru_cache
def model_of(name: str) -> TSModel:
    return sector_model(plant_of(name))


@lru_cache
def library_model(name: str) -> TSModel:
    """The model that a design takes: of two actuators behind a blend it has the effort."""
    plant = plant_of(name)
    return model_of(name) if plant.blending is None else blended_model(plant)


def named(plant: Plant, x: Floats, u: Floats, w: Floats) -> dict[str, float]:
    values = map(float, np.concatenate([x, u, w]))
    return dict(zip(map(model_name, plant.variables), values, strict=True))


def model_name(variable: Variable) -> str:
    return variable.name if variable.rest == 0 else f"delta_{variable.name}"


def blended(name: str, x: Floats, u: Floats, w: Floats) -> Floats:
    model = model_of(name)
    now = model.blend(model.premise_values(**named(plant_of(name), x, u, w)))
    moved: Floats = now.A @ x + now.B @ u + now.E @ w
    return moved
