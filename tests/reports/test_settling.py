"""Half-widths and settling time of the proved set, against closed forms and motions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from sympy import Symbol

from takagi.certificates.design.plant.design import certify_plant
from takagi.models import Interval, Plant, Variable
from takagi.reports.loops.plant_claims import half_widths, settling_time
from takagi.reports.loops.plant_loop import plant_loop
from tests.reports.plant_designs import U, X, two_integrators


@pytest.mark.parametrize("disturbed", [False, True])
def test_one_state_settles_as_its_pole_says(*, disturbed: bool) -> None:
    """x' = u = -2 x: the set is all of |x| <= 1, and 2 % are reached after ln(50) / 2.

    So it is with a disturbance that stays at rest.
    """
    W = Symbol("W", real=True)
    plant = Plant(
        equations=(U + W if disturbed else U,),
        states=(Variable(X, "-", Interval.of(-1, 1)),),
        inputs=(Variable(U, "-", Interval.of(-3, 3)),),
        disturbances=(Variable(W, "-", Interval.of(-0.1, 0.1)),) if disturbed else (),
    )
    loop = plant_loop(certify_plant(plant, np.array([[[2.0]]])))
    reach, time = half_widths(loop), settling_time(loop)

    assert reach is not None and np.isclose(reach[0], 1.0, rtol=1e-3)
    # The proved rate is a little below the pole.
    assert time is not None and np.log(50) / 2 <= time <= 1.05 * np.log(50) / 2


def test_motions_from_the_set_s_edge_keep_both_bounds() -> None:
    """Two poles at -1; exp(A t) moves sixty starts on the edge of {x' P x <= c}."""
    loop = plant_loop(two_integrators(1, 2, room=3))
    reach, time = half_widths(loop), settling_time(loop)
    assert reach is not None and time is not None
    P, level = loop.ellipsoid
    angle = np.linspace(0, np.pi, 60)
    edge = np.linalg.solve(
        np.linalg.cholesky(P).T, np.sqrt(level) * np.array([np.cos(angle), np.sin(angle)])
    )
    A = np.array([[0.0, 1.0], [-1.0, -2.0]])

    for t in np.linspace(0, 2 * time, 41):
        part = np.abs(expm(A * t) @ edge).max(axis=1) / reach
        assert np.all(part <= (0.02 if t >= time else 1.0) * (1 + 1e-9))
    assert np.isclose((np.abs(edge).max(axis=1) / reach).max(), 1.0, rtol=1e-2)
