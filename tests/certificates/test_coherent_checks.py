"""Each single check of the coherent claim, by itself: a dropped line of the checker shows here."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.corners import (
    BOUNDS,
    RANGES,
    Corners,
    Stated,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.lmi.analysis.invariant_ellipsoid import largest_scale
from takagi.models.laws.effort_sharing.law import loop_vertices
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import rotor_torque
from tests.certificates.kinds.claims import as_read


def subject(document: dict[str, Any]) -> Subject:
    read = as_read(document)
    return Subject.read(read["claims"][0], read["model"], read["gains"], "claim")


def loop(document: dict[str, Any], k: int, rate: str | None = None, **changes: Any) -> Loop:
    known = subject(document)
    stated = document["claims"][0]["cells"][k]["wind_rate"] if rate is None else rate
    law = replace(
        known.law, **{name: changes[name] for name in changes if hasattr(known.law, name)}
    )
    box = replace(
        known.box, **{name: changes[name] for name in changes if hasattr(known.box, name)}
    )
    return Loop(replace(known, law=law, box=box), k, Fraction(str(stated)))


def decided(cell: dict[str, Any], P: Any, error: float, rate: float, alpha: float) -> str:
    exact = {name: [Fraction(str(v)) for v in cell[name]] for name in RANGES}
    sizes = {name: Fraction(str(cell[name])) for name in BOUNDS}
    names = ("wind_error", "wind_rate", "multiplier", "decay_rate")
    for name, value in zip(names, (error, rate, alpha, 0), strict=True):
        sizes[name] = Fraction(str(round(value, 6)))
    sizes["integral_rate"] = Fraction(str(cell["integral_rate"]))
    matrix = Matrix.of([[Fraction(str(entry)) for entry in row] for row in P])
    return first_failure(Corners(Stated(exact, sizes, "cell")).obligations(matrix))


@pytest.mark.parametrize(("binding", "coupling"), [(0, 0.0), (1, -500.0)])
def test_both_signs_of_the_lag_disturbance_are_checked(
    built: Any, binding: int, coupling: float
) -> None:
    """A wind error that one sign of w_zeta allows and the other does not is refused.

    A larger w_zeta is stated; which sign is the worse one depends on how P couples speed and lag.
    """
    P, found = built.candidate.P.copy(), 0
    P[0, 1] = P[1, 0] = coupling
    for k, given in enumerate(built.candidate.cells):
        cell = replace(given, lag_disturbance=Fraction("0.003"))
        v = loop_vertices(cell)
        scales = [
            largest_scale(P, v.A[s::2], v.fixed[s::2], v.per_wind_error[s::2], limit=50)
            for s in (0, 1)
        ]
        (tight, _), (loose, alpha) = scales[binding], scales[1 - binding]
        if tight == 0 or loose < 1.02 * tight:
            continue
        found += 1
        stated = built.document["claims"][0]["cells"][k] | {"lag_disturbance": 0.003}
        error, rate = (tight + loose) / 2, stated["wind_rate"]
        assert "invariance" in decided(stated, P.tolist(), error, rate, alpha)
        if found == 3:
            break
    assert found


@pytest.mark.parametrize("wrong", [0, 0.02], ids=["table's c_P", "c_P 2 % off"])
def test_the_residual_bound_covers_the_torque_that_the_tables_leave(
    built: Any, wrong: float
) -> None:
    """Sampled between the nodes of every cell, by the float model of the plant."""
    power = (1 - Fraction(str(wrong)), 1 + Fraction(str(wrong)))
    known = subject(built.document)
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
        rotor = rotor_torque(turbine, speed, pitch, v)
        left = [float(s) * rotor - turbine.gear_ratio * torque for s in power]
        sampled = float(np.abs(left).max() / turbine.inertia)
        bound = Loop(known, k, Fraction(0)).residual(power) / ONE
        assert sampled <= bound
        close += sampled > 0.2 * bound
    # A bound five times too small would have been noticed in these cells.
    assert close > 20


def test_a_set_that_may_demand_negative_torque_is_refused(built: Any) -> None:
    """A wider speed signal reaches below zero torque where little is in reserve: at low wind."""
    box = subject(built.document).box
    wide = 2 * box.speed_signal

    assert not first_failure(loop(built.document, 0).limits())
    assert "negative torque" in first_failure(loop(built.document, 0, speed_signal=wide).limits())
