"""Bounds of the overshoot: the least of the proved ones, kept by motions, or none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

from takagi.certificates.claims.certification import USEFUL
from takagi.certificates.design.plant.design import certify_plant
from takagi.models import Interval, Plant, Variable
from takagi.reports.loops.plant_claims import overshoots
from takagi.reports.loops.plant_loop import plant_loop
from tests.reports.plant_designs import U, V, X, two_integrators

W = sp.Symbol("w", real=True)


@pytest.mark.parametrize("damping", [0.6, 2.0])
def test_motions_keep_the_bound_and_come_near_it(damping: float) -> None:
    design = two_integrators(1.0, damping)
    found = overshoots(design, plant_loop(design))
    A = np.array([[0.0, 1.0], [-1.0, -damping]])
    peaks = np.abs([expm(A * t) for t in np.linspace(0, 20, 801)]).max(axis=0)

    for k, name in enumerate(("x", "v")):
        assert peaks[k, k] <= found[name] < 1.6 * peaks[k, k]


def test_units_do_not_matter_and_a_useless_claim_is_made_again() -> None:
    """x'' = -1e4 x - 200 v, v up to 100: over the half-widths of the set as of poles at -1."""
    design = two_integrators(1e4, 200.0, side=100.0)
    slow = two_integrators(1.0, 2.0)
    claims = [c for c in design.document["claims"] if c["kind"] == "transient"]

    assert all(float(claim["overshoot"]) <= USEFUL for claim in claims)
    fast = overshoots(design, plant_loop(design))
    for name, most in overshoots(slow, plant_loop(slow)).items():
        assert np.isclose(fast[name], most, rtol=0.2)


def test_no_range_for_one_state_takes_the_set_s_own_width() -> None:
    """Scales of 1 would say 100 times: v gets 100 times as large as x."""
    plant = Plant(
        equations=(V, U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V, "-")),
        inputs=(Variable(U, "-"),),
    )
    design = certify_plant(plant, np.array([[[1e4, 100.0]]]))
    (claim,) = (c for c in design.document["claims"] if c["kind"] == "transient")

    assert "half-widths" in claim["name"] and float(claim["overshoot"]) <= USEFUL
    assert float(claim["scales"][1]) > 10 * float(claim["scales"][0])


def test_nothing_is_said_without_a_proved_set_or_with_a_disturbance() -> None:
    design = two_integrators(1.0, 2.0)
    loop = plant_loop(design)
    pushed = replace(loop.plant, equations=(V, U + W), disturbances=(Variable(W, "-"),))

    assert overshoots(design, replace(loop, level_proved=False)) == {}
    assert overshoots(design, replace(loop, plant=pushed)) == {}
