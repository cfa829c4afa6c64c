"""The recorded certificates of ``turbine-crossing``, and what the first checker reads in them.

The default law of the NREL 5-MW turbine, at 8 m/s with one covariance and at 13 m/s on three
pieces.
"""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from typing import Any

from takagi.certificates.checker.arithmetic import spline_point
from takagi.certificates.checker.kernel import matrices
from takagi.certificates.checker.turbine.effort_sharing import inputs as plants
from takagi.certificates.checker.turbine.linear_loop import (
    crossing_claim as verdict,
)
from takagi.certificates.checker.turbine.linear_loop import jacobian, pieces, trim
from takagi.certificates.checker.turbine.running_loop import inputs as machines
from takagi.certificates.requests.loop import exact_floats
from tests.certificates.recorded.answers import recorded

floats, as_read = exact_floats.floats, exact_floats.as_read
F = Fraction
Data = dict[str, Any]
BOTH, NEITHER, REFUSED = ("PROVED",) * 2, ("UNDECIDED",) * 2, ("refused",) * 2
NOMINAL = dict(zip(pieces.PARAMETERS, map(F, (1, 1, 1, 1, 0, 63)), strict=True))
# Below the ramp of the effort, on it twice, and above it; each between two nodes of the tables.
WINDS = ("4.1", "8", "11.4", "12", "15", "22.2")


def stored_documents() -> list[Data]:
    """Return both documents anew."""
    return [dict(json.loads(text)) for _, text in islice(recorded("turbine-crossing"), 2)]


def linear_at(document: Data, wind: str, *, stop: bool = True) -> verdict.LinearLoop:
    """Return the loop of a document at a wind, as the first checker computes it."""
    read = as_read(document)
    claim = read["claims"][0]
    plant, law = plants.Plant.read(read["model"]), plants.Law.read(read["gains"])
    machine = machines.Machine.read(claim, read["model"], read["gains"], "claim")
    machine = machine if stop else replace(machine, stop=None)
    surface = spline_point.ExactSurface.read(read["model"])
    at = trim.trim_at(plant, law, machine, surface, F(wind))
    return verdict.LinearLoop(plant, machine, pieces.Turbulence.read(claim, "claim"), at, F(1))


def matrix_of(linear: verdict.LinearLoop, values: dict[str, Fraction]) -> matrices.Matrix:
    return jacobian.loop_matrix(linear.trim, linear.plant, linear.machine, linear.wind, values)


def box_of(document: Data) -> pieces.Box:
    return pieces.parameter_box(as_read(document)["claims"][0], "")
