"""The loop that runs at many winds, and whether it keeps the least margins, by eigenvalues.

    gain    stable with one command times g and times 1/g, g up to ``LEAST_GAIN``
    phase   stable with one command times e^{j phi}, phi up to ``LEAST_PHASE``
    delay   stable with both commands one sample later

1 + g e^{j phi} L has a zero outside the unit circle exactly where A - B diag(g e^{j phi}, 1) C has
an eigenvalue there, so that no response over frequency is needed: a wind takes a millisecond.  The
conjugate matrix has the conjugate eigenvalues, which is why phi > 0 is enough.

The figures are small on purpose.  They are no targets (``takagi check --margins`` has those):
below them a drive or a generator that differs a little from its file, or a controller that sends
one sample later, makes the loop oscillate.

All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.reports.margins.running_loop import (
    NOMINAL,
    NoEquilibrium,
    PlantChoice,
    RunningLoop,
    RunningLoops,
)
from takagi.reports.margins.running_over_wind import FINE, winds_between

LEAST_GAIN = 1.2
LEAST_PHASE = 10 * pi / 180
COMMANDS = ("torque", "pitch")
# Steps up to the least margin: instability may begin at a factor, and end at a larger one.
STEPS = 4


@dataclass(frozen=True, slots=True)
class SmallMargin:
    """A margin that is below the least one.

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


# A loop counts as unstable where it grows faster than this [1/s]; less is the noise of differences.
GROWTH = 1e-4
# Where it decays slower than this [1/s], the nodes of the law's tables around are looked at, too.
CLOSE = 0.03


def loop_at(
    loops: RunningLoops, wind: float, plant: PlantChoice = NOMINAL, side: int | None = None
) -> RunningLoop | None:
    """Return the loop at a wind [m/s]; None where it has no equilibrium."""
    try:
        return loops.at(wind, plant, side)
    except NoEquilibrium:
        return None


def growths(
    loops: RunningLoops, winds: Sequence[float], plant: PlantChoice = NOMINAL
) -> dict[float, float]:
    """Return wind -> largest real part of the loop's poles [1/s], where it has a rest.

    At a node of the law's tables it is the larger one of both sides.
    """
    nodes, found = _nodes(loops), {}
    for wind in winds:
        sides = loops.sides(wind) if wind in nodes else loops.sides(wind)[:1]
        at_wind = [loop_at(loops, wind, plant, side) for side in sides]
        rates = [float(loop.poles.real.max()) for loop in at_wind if loop is not None]
        if rates:
            found[wind] = max(rates)
    return found


def growths_over_wind(loops: RunningLoops) -> dict[float, float]:
    """Return wind -> growth [1/s] from cut-in to cut-out, for the plant of the file.

    Every ``FINE`` m/s, and where the loop is close to growing at the nodes of the law's tables,
    too: between the winds it may grow faster.
    """
    turbine = loops.plant.turbine
    found = growths(loops, fine_winds(loops))
    close = [wind for wind, rate in found.items() if rate > -CLOSE]
    nodes = [w for w in _nodes(loops) if turbine.cut_in <= w <= turbine.cut_out]
    return found | growths(loops, [n for n in nodes if any(abs(n - w) < FINE for w in close)])


def unstable(loops: RunningLoops, winds: Sequence[float], plant: PlantChoice = NOMINAL) -> bool:
    """Return whether the loop grows at one of the winds."""
    return any(rate > GROWTH for rate in growths(loops, winds, plant).values())


def fine_winds(loops: RunningLoops) -> tuple[float, ...]:
    """Return the winds from cut-in to cut-out, every ``FINE`` m/s."""
    turbine = loops.plant.turbine
    return winds_between(turbine.cut_in, turbine.cut_out, FINE)


def decisive_winds(loops: RunningLoops) -> tuple[float, ...]:
    """Return the whole winds, and three where pitch begins to act: the weakest place of it."""
    turbine = loops.plant.turbine
    whole = winds_between(turbine.cut_in, turbine.cut_out, 1.0)
    acting = [wind for wind in fine_winds(loops) if _pitch_acts(loops, wind)]
    return tuple(sorted({*whole, *acting[:3]}))


def _pitch_acts(loops: RunningLoops, wind: float) -> bool:
    try:
        return bool(loops.rest(wind).plant[1] > loops.plant.turbine.pitch_min)
    except NoEquilibrium:
        return False


def _nodes(loops: RunningLoops) -> list[float]:
    law = loops.program.law
    return law.schedule.wind.tolist() if isinstance(law, EffortSharingLaw) else []
