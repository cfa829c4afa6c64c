"""Designs of plants that several tests read, made once."""

from __future__ import annotations

from functools import cache

import numpy as np
import sympy as sp

from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, Plant, Variable, load_model

X, V, U = sp.symbols("x v u", real=True)


@cache
def design_of(name: str) -> PlantDesign:
    plant = load_model(name)
    assert isinstance(plant, Plant)
    found = design_plant(plant)
    assert isinstance(found, PlantDesign)
    return found


@cache
def two_integrators(
    k: float, d: float, *, side: float = 1, room: int | None = None, step: float | None = None
) -> PlantDesign:
    """x' = v, v' = u, or one step of it, u = -k x - d v; |x| <= 1, |v| <= side, |u| <= room."""
    plant = Plant(
        equations=(V, U) if step is None else (X + step * V, V + step * U),
        states=(Variable(X, "m", Interval.of(-1, 1)), Variable(V, "m/s", Interval.of(-side, side))),
        inputs=(Variable(U, "m/s^2", None if room is None else Interval.of(-room, room)),),
        sample_time=step,
    )
    return certify_plant(plant, np.array([[[k, d]]]))
