"""Each single check of the coherent claim, by itself: a dropped line of the checker shows here."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.coherent_corners import BOUNDS, RANGES, Corners
from takagi.certificates.checker.coherent_inputs import Box, Law, Plant, Uncertainty
from takagi.certificates.checker.coherent_loop import Loop
from takagi.certificates.checker.coherent_residual import residual
from takagi.certificates.checker.fixed import ONE
from takagi.certificates.checker.reader import read_text
from takagi.lmi.analysis.invariant_ellipsoid import largest_scale
from takagi.models.embedding.vertices import loop_vertices
from takagi.models.law.effort import effort_ramp
from takagi.models.turbine.aerodynamics import rotor_torque


def as_read(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document as the reader sees it."""
    return read_text(json.dumps(document), "document")


def parts(document: dict[str, Any]) -> tuple[Plant, Law, Box, Uncertainty]:
    """Return what the checker reads."""
    read = as_read(document)
    claim = read["claims"][0]
    return (
        Plant.read(read["model"]),
        Law.read(read["gains"]),
        Box.read(claim, "claim"),
        Uncertainty.read(claim, "claim"),
    )


def decided(cell: dict[str, Any], P: Any, error: float, rate: float, alpha: float) -> str:
    """Return what the corners of one stated cell say about a wind class, with decay 0."""
    exact = {name: [Fraction(str(v)) for v in cell[name]] for name in RANGES}
    sizes = {name: Fraction(str(cell[name])) for name in BOUNDS}
    corners = Corners(exact, sizes, Fraction(str(cell["integral_rate"])), "cell")
    matrix = [[Fraction(str(entry)) for entry in row] for row in P]
    e, r, a = (Fraction(str(round(value, 6))) for value in (error, rate, alpha))
    return corners.failure(matrix, e, r, a, Fraction(0))


@pytest.mark.parametrize("binding", [0, 1])
def test_both_signs_of_the_lag_disturbance_are_checked(built: Any, binding: int) -> None:
    """A wind rate that one sign of w_zeta allows and the other does not is refused."""
    P, cells = built.candidate.P, built.candidate.cells
    found = 0
    for k, cell in enumerate(cells):
        v = loop_vertices(cell)
        scales = [
            largest_scale(P, v.A[s::2], v.residual[s::2], v.per_wind_rate[s::2], limit=50)
            for s in (0, 1)
        ]
        (tight, _), (loose, alpha) = scales[binding], scales[1 - binding]
        if tight == 0 or loose < 1.02 * tight:
            continue
        found += 1
        stated = built.document["claims"][0]["cells"][k]
        rate = (tight + loose) / 2
        assert "invariance" in decided(stated, P.tolist(), 0.0, rate, alpha)
        if found == 3:
            break
    assert found


def test_an_equilibrium_outside_the_set_is_refused(built: Any) -> None:
    """P_33 (kappa r / Gamma)^2 >= 1: the tables' residual would move the rest out of the set."""
    claim = built.document["claims"][0]
    cell = claim["cells"][-1] | {"residual": 0.05}

    assert "equilibrium" in decided(cell, claim["P"], 0.0, 0.0, 0.05)
    assert "equilibrium" not in decided(claim["cells"][-1], claim["P"], 0.0, 0.0, 0.05)


def test_the_residual_bound_covers_the_torque_that_the_tables_leave(built: Any) -> None:
    """Sampled between the nodes of every cell, by the float model of the plant."""
    plant, law, _, _ = parts(built.document)
    turbine, table = built.turbine, built.law.schedule
    close = 0
    for k in range(len(table.wind) - 1):
        v = np.linspace(table.wind[k], table.wind[k + 1], 41)
        speed, q, b = (
            np.interp(v, table.wind, column)
            for column in (table.rotor_speed, table.trim_effort, table.effectiveness)
        )
        pitch = turbine.pitch_min + effort_ramp(q, table.overlap) / b
        torque = built.law.rated_torque - built.law.effort_torque * effort_ramp(-q, table.overlap)
        left = rotor_torque(turbine, speed, pitch, v) - turbine.gear_ratio * torque
        sampled = float(np.abs(left).max() / turbine.inertia)
        bound = residual(plant, law, k) / ONE
        assert sampled <= bound
        close += sampled > 0.2 * bound
    # A bound five times too small would have been noticed in these cells.
    assert close > 20


def test_a_set_that_may_demand_negative_torque_is_refused(built: Any) -> None:
    """A wider speed signal reaches below zero torque where little is in reserve: at low wind."""
    plant, law, box, uncertainty = parts(built.document)
    wide = replace(box, speed_signal=2 * box.speed_signal)

    assert not Loop(plant, law, box, uncertainty, 0).limits_failure()
    assert "negative torque" in Loop(plant, law, wide, uncertainty, 0).limits_failure()


def test_a_set_that_may_demand_too_much_pitch_is_refused(built: Any) -> None:
    """The pitch band of the last cell against a limit just inside it."""
    plant, law, box, uncertainty = parts(built.document)
    last = len(law.wind) - 2
    low = replace(law, pitch_max=Fraction("0.4"))

    assert not Loop(plant, law, box, uncertainty, last).limits_failure()
    assert "pitch" in Loop(plant, low, box, uncertainty, last).limits_failure()
