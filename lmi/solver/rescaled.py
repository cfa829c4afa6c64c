"""Rescaling of a program by its own solution, so that the solution has entries of order one.

A solver equilibrates the data before it knows the solution. If some unknowns are of size 1e5 and
others of size one, or if an LMI's entries differ as much at the solution, the solver meets its
tolerances long before its numbers are right (SDPLIB's hinf5 to hinf11).  Here variables are divided
by the size that they were found with, and every LMI is congruent to one whose diagonal equals that
of its multiplier; powers of two, so nothing is rounded.

Source: Nesterov and Todd (1997), Self-scaled barriers and interior-point methods for convex
programming, Mathematics of Operations Research 22, whose scaling this is, diagonal by diagonal.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.cone.program import ConeProgram, Raw
from takagi.models.arrays import Floats

# The largest ratio of the scales of LMIs, and of those of variables.
FARTHEST = 2.0**40


class Scaling:
    """A program in other units, and the way back from its solutions."""

    def __init__(self, program: ConeProgram, variables: Floats, rows: Floats) -> None:
        self._variables, self._rows = variables, rows
        self._cost = float(nearest_power(np.array([np.abs(program.q * variables).max() or 1.0]))[0])
        A = sp.diags_array(1.0 / rows) @ program.A @ sp.diags_array(variables)
        self.program = replace(
            program, q=program.q * variables / self._cost, A=sp.csc_array(A), b=program.b / rows
        )

    def back(self, raw: Raw) -> Raw:
        """Return a solution of the scaled program as one of the program itself."""
        complete = len(raw.y) == len(self._variables) and len(raw.z) == len(self._rows)
        if not complete:
            return raw
        return replace(raw, y=raw.y * self._variables, z=raw.z * self._cost / self._rows)


def scaling_of(program: ConeProgram, raw: Raw) -> Scaling | None:
    """Return the scaling by a solution, however rough; None without a usable solution."""
    if len(raw.y) != len(program.q) or len(raw.z) != len(program.b):
        return None
    if not (np.isfinite(raw.y).all() and np.isfinite(raw.z).all()):
        return None
    size = np.abs(raw.y)
    # A variable that is zero in the solution has no size of its own; it gets a small one, not zero.
    variables = nearest_power(np.maximum(size, max(float(size.max(initial=0.0)), 1.0) / FARTHEST))
    slack = program.b - program.A @ raw.y
    rows = np.ones(len(program.b))
    linear = slice(0, program.linear)
    rows[linear] = _scales(slack[linear], raw.z[linear])
    for cone in program.cones:
        part = slice(program.linear + cone.rows.start, program.linear + cone.rows.stop)
        column, row = np.tril_indices(cone.size)
        on = np.flatnonzero(column == row)
        # Squares of the congruence's diagonal, (items, size).
        d2 = _scales(
            slack[part].reshape(cone.items, -1)[:, on], raw.z[part].reshape(cone.items, -1)[:, on]
        )
        # d itself is a power of two, so that all products d_i d_j are, and the scaling rounds
        # nothing.
        d = np.exp2(np.round(np.log2(d2) / 2))
        rows[part] = (d[:, row] * d[:, column]).ravel()
    return Scaling(program, variables, rows)


def _scales(slack: Floats, multiplier: Floats) -> Floats:
    """Return the root of slack over multiplier, where both are positive and far from zero."""
    if not slack.size:
        return slack
    found = []
    for values in (slack, multiplier):
        most = max(float(np.abs(values).max()), 1e-200)
        found.append(np.maximum(values, most / FARTHEST))
    return np.asarray(np.sqrt(found[0] / found[1]))
