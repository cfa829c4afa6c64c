r"""Whether a loop keeps the least margins of a design, by eigenvalues alone.

    gain    stable with one command times g and times 1/g, g up to ``LEAST_GAIN``
    phase   stable with one command times e^{j phi}, phi up to ``LEAST_PHASE``
    delay   stable with both commands one sample later

1 + g e^{j phi} L has a zero outside the unit circle exactly where A - B diag(g e^{j phi}, 1) C has
an eigenvalue there, so that no response over frequency is needed: a wind takes a millisecond.  The
conjugate matrix has the conjugate eigenvalues, which is why phi > 0 is enough.

The figures are small on purpose.  They are no design targets (those are given by ``--margins``):
below them a drive or a generator that differs a little from its file, or a controller that sends
one sample later, makes the loop oscillate.

All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.reports.margins.running_loop import RunningLoop

LEAST_GAIN = 1.2
LEAST_PHASE = 10 * pi / 180
COMMANDS = ("torque", "pitch")
# Steps up to the least margin: instability may begin at a factor, and end at a larger one.
STEPS = 4


@dataclass(frozen=True, slots=True)
class SmallMargin:
    """A margin that is below the least one.

    Attributes
    ----------
    kind : "gain", "phase" or "delay".
    command : "torque", "pitch" or, for the delay, "torque and pitch".
    share : of the least margin at which the loop is unstable, in steps; smaller is worse.
    """

    kind: str
    command: str
    share: float


def small_margins(loop: RunningLoop) -> tuple[SmallMargin, ...]:
    """Return the margins of a stable loop that are below the least ones."""
    shares = np.arange(1, STEPS + 1) / STEPS
    found = []
    for place, command in enumerate(COMMANDS):
        for kind in ("gain", "phase"):
            bad = [share for share in shares if not _keeps(loop, place, kind, float(share))]
            if bad:
                found.append(SmallMargin(kind, command, float(bad[0])))
    if not _stable(*_later(loop)):
        found.append(SmallMargin("delay", "torque and pitch", 1.0))
    return tuple(found)


def _keeps(loop: RunningLoop, place: int, kind: str, share: float) -> bool:
    if kind == "phase":
        return _stable_with(loop, place, np.exp(1j * share * LEAST_PHASE))
    factor = LEAST_GAIN**share
    return all(_stable_with(loop, place, one) for one in (factor, 1 / factor))


def _stable_with(loop: RunningLoop, place: int, factor: complex) -> bool:
    factors = np.ones(2, dtype=np.complex128)
    factors[place] = factor
    return _stable(loop.A, loop.B * factors, loop.C)


def _later(loop: RunningLoop) -> tuple[Floats, Floats, Floats]:
    """Return the loop with both commands one sample later: they are two states more."""
    n = len(loop.A)
    A, B, C = np.zeros((n + 2, n + 2)), np.zeros((n + 2, 2)), np.zeros((2, n + 2))
    A[:n, :n], A[:n, n:], B[n:], C[:, :n] = loop.A, loop.B, np.eye(2), loop.C
    return A, B, C


def _stable(A: Floats, B: Floats | Complex, C: Floats) -> bool:
    return float(np.abs(np.linalg.eigvals(A - B @ C)).max()) < 1
