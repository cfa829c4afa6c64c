"""sdpa, called on the cone data themselves; used where the package ``sdpa-python`` is installed.

In SeDuMi's form its dual is ours: maximise b' y with c - A' y in the cones, b = -q.  Cones are
whole matrices there, linear rows first.

Source: Yamashita, Fujisawa, Fukuda, Kobayashi, Nakata and Nakata (2012), Latest developments in
the SDPA family for solving large-scale SDPs, Handbook on Semidefinite, Conic and Polynomial
Optimization.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sp

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.assemble import Cone
from takagi.lmi.cone.program import ConeProgram, Raw
from takagi.lmi.solver.incidence import incidence, sdpa_iteration
from takagi.lmi.solver.time_limit import remaining, stopped
from takagi.models.arrays import Floats, Indices

Entries: TypeAlias = tuple[Indices, Indices, Floats]

# The starting points: multiples of the identity, which must be larger than the solution. If one is
# too small, sdpa stops at once without a step; then it is called again with a larger one.
BEGINNINGS = (10.0, 1e4)
SMALLEST_BEGINNING = 1e2
STUCK = 3
# The default number of iterations of sdpa.
MOST_ITERATIONS = 100


def sdpa_is_installed() -> bool:
    """Return whether sdpa can be imported; it is not imported yet."""
    return find_spec("sdpap") is not None


def with_sdpa(program: ConeProgram) -> Raw:
    """Solve the program; y and z as clarabel's."""
    started = time.perf_counter()
    expansion, sizes = _whole(program)
    # The one entry point that takes SeDuMi's form as it is; the documented one converts first.
    solve = import_module("sdpap.sdpacall.sdpacall").solve_sdpa
    cone = import_module("sdpap.symcone").SymCone(l=program.linear + sizes.count(1), s=_wide(sizes))
    A = sp.csc_matrix((expansion @ program.A).T)
    b, c = sp.csc_matrix(-program.q[:, None]), sp.csc_matrix((expansion @ program.b)[:, None])
    largest = max(SMALLEST_BEGINNING, float(np.abs(program.b).max(initial=0.0)))
    for times in BEGINNINGS:
        options = _options(times * largest) | _iterations(program)
        with _quiet():
            x, y, _, info = solve(A, b, c, cone, options)
        if "maxIteration" in options and info["iteration"] >= options["maxIteration"]:
            stopped()
        if info["iteration"] >= STUCK:
            break
    return Raw(
        "sdpa",
        str(info["phasevalue"]),
        np.asarray(y.toarray(), dtype=np.float64).ravel(),
        expansion.T @ np.asarray(x.toarray(), dtype=np.float64).ravel(),
        int(info["iteration"]),
        time.perf_counter() - started,
    )


def _options(beginning: float) -> dict[str, Any]:
    param = import_module("sdpap.param").param
    options: dict[str, Any] = param({"print": "no", "lambdaStar": beginning})
    return options


def _iterations(program: ConeProgram) -> dict[str, Any]:
    """Return how many iterations fit the time limit, by a model: sdpa has no time limit."""
    seconds_left = remaining()
    if seconds_left is None:
        return {}
    fit = max(1, int(seconds_left / sdpa_iteration(incidence(program))))
    return {"maxIteration": fit} if fit < MOST_ITERATIONS else {}


def _wide(sizes: list[int]) -> tuple[int, ...]:
    return tuple(size for size in sizes if size > 1)


def _whole(program: ConeProgram) -> tuple[sp.csr_array, list[int]]:
    """Return S with S (packed rows) = linear rows, then whole matrices; and the cones' sizes.

    Entries off the diagonal are divided by sqrt(2) and appear twice, so that S' maps whole
    multipliers back to packed ones.
    """
    sizes = [size for cone in program.cones for size in [cone.size] * cone.items]
    linear = np.arange(program.linear)
    blocks: list[Entries] = [(linear, linear, np.ones(program.linear))]
    alone, wide = program.linear, program.linear + sizes.count(1)
    for cone in program.cones:
        position = alone if cone.size == 1 else wide
        blocks.append(_squares(cone, program, position))
        alone += cone.items if cone.size == 1 else 0
        wide += cone.items * cone.size**2 if cone.size > 1 else 0
    row, source, value = (np.concatenate(values) for values in zip(*blocks, strict=True))
    return sp.csr_array((value, (row, source)), shape=(wide, len(program.b))), sizes


def _squares(cone: Cone, program: ConeProgram, position: int) -> Entries:
    """Return row, source and value of the entries of a group of cones."""
    n = cone.size
    high, low = np.tril_indices(n)
    off = high != low
    entry = np.concatenate([low + n * high, (high + n * low)[off]])
    packed = np.concatenate([np.arange(triangle(n)), np.flatnonzero(off)])
    scale = np.where(np.concatenate([off, off[off]]), np.sqrt(0.5), 1.0)
    item = np.arange(cone.items)[:, None]
    return (
        (position + item * n * n + entry).ravel(),
        (program.linear + cone.start + item * triangle(n) + packed).ravel(),
        np.tile(scale, cone.items),
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress sdpa's messages, which it writes directly to the standard output.

    Anything that other threads write there in the meantime is lost too.
    """
    sys.stdout.flush()
    try:
        original = os.dup(1)
    except OSError:
        # There is no standard output, so there is nothing to keep clean.
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(original, 1)
        os.close(original)
        os.close(nowhere)
