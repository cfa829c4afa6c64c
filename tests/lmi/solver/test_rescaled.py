"""A program in the units of its own solution: the same program, with sharper multipliers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.lmi.cone import ConeProgram, cone_program, least_objective_bound
from takagi.lmi.cone.assemble import assemble
from takagi.lmi.solver import Session
from takagi.lmi.solver.rescaled import scaling_of
from takagi.lmi.solver.solve import rescaled
from tests.lmi.solver.control import OPTIMUM, control1


def least() -> ConeProgram:
    """Return SDPLIB's control1: minimise with no margin."""
    data = assemble(control1())
    return cone_program(data, data.objective, (), margin=0.0)


def test_a_scaled_program_is_the_program() -> None:
    """Its feasible points, objective and multipliers map to those of the program, to the bit."""
    program = least()
    raw = Session().solve(program)
    scaling = scaling_of(program, raw)
    assert scaling is not None
    there = replace(raw, y=np.ones_like(raw.y), z=np.ones_like(raw.z))
    back, inside = scaling.back(there), scaling.program

    # b - A y times z row by row, the objective, and the bound's part: all by the same factor.
    factor = program.q @ back.y / (inside.q @ there.y)
    assert np.allclose(
        (program.b - program.A @ back.y) * back.z, factor * (inside.b - inside.A @ there.y)
    )
    assert program.b @ back.z == pytest.approx(factor * (inside.b @ there.z))


def test_odd_units_do_not_hide_the_optimum() -> None:
    """control1 with variables in units from 1e-3 to 1e3: solved again, the bound is sharp."""
    program = least()
    units = np.geomspace(1e-3, 1e3, len(program.q))
    odd = replace(program, q=program.q * units, A=(program.A * units).tocsc())
    first = Session().solve(odd)
    found = first
    for _ in range(2):
        again = rescaled(odd, found)
        assert again is not None
        found = again

    assert odd.q @ found.y == pytest.approx(OPTIMUM, rel=1e-5)
    gap = odd.q @ found.y - least_objective_bound(odd, found)
    assert 0 <= gap + 1e-6 < 1e-3 * OPTIMUM
    assert gap <= abs(odd.q @ first.y - least_objective_bound(odd, first)) + 1e-6


def test_without_a_solution_there_is_no_scale() -> None:
    """No numbers, or not all of them finite: nothing to go by."""
    program = least()
    raw = Session().solve(program)

    assert rescaled(program, replace(raw, y=np.zeros(0))) is None
    assert rescaled(program, replace(raw, z=np.full_like(raw.z, np.nan))) is None
