"""The ranges of the running loop's factors over the box of one cell.

Every factor is a secant between a state of the set and the rest, so it lies in the range of the
derivative over the box; if a limit may cut a term, the range is extended to 0.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.arithmetic.interval import ONE, enclose, point
from takagi.certificates.checker.turbine.running_loop.cell import (
    FULL,
    NIL,
    Cell,
    down,
    size,
    span,
    up,
)
from takagi.certificates.checker.turbine.running_loop.inputs import Span


def factors(cell: Cell) -> dict[str, Span]:
    """Return each factor's range by the names of ``equations``, without the share of pitch."""
    law, machine, sides = cell.law, cell.machine, cell.sides
    b0 = point(cell.b0)
    # gamma(v_s) (signal - x_rest) + gamma(v) x_rest: the second part depends on v_s - v.
    steep = size(cell.secants(law.gamma)) * cell.rest_integral
    q = cell.secants(law.effort)
    b, b_law = enclose(*cell.b), enclose(*cell.b_reach)
    bend = enclose(*cell.secants(law.effectiveness))
    shed_rest = enclose(*(psi(U, law.overlap) for U in cell.efforts_at_rest))
    sigma = cell.pitch_gain(cell.ratio(NIL), cell.pitches)
    limit = cell.over(law.limit, cell.winds)[1]
    late = max(limit / cell.b0 - Fraction(sigma.low, ONE), NIL)
    observed, length = machine.observer_inertia, machine.wake_length
    return {
        "speed slope": cell.secants(law.speed),
        "effort slope": (down(q[0] - steep), up(q[1] + steep)),
        "gamma": _outward(cell.over(law.gamma, cell.reach)),
        "held estimate": (FULL if cell.estimate_is_free else NIL, FULL),
        "feed-forward": cell.feed_forward,
        "pitch per effort": span(b0 / b_law),
        "pitch by schedule": span(shed_rest * bend * b0 / (b_law * b)),
        "lead": cell.lead,
        "integral rate": cell.steps(law.nu),
        "stiffness": span(cell.speed_gain(sides.speed)),
        "pitch gain": span(sigma),
        "late pitch gain": (NIL, up(late)),
        "inertia": _outward((1 / machine.inertia[1], 1 / machine.inertia[0])),
        "observed stiffness": span(cell.speed_gain(max(sides.speed, sides.measured))),
        "wind gain": span(cell.wind_gain()),
        "observer inertia": _outward((observed, observed)),
        "wake rate": _outward((cell.winds[0] / length[1], cell.winds[1] / length[0])),
        "drive": (drive_secant(cell), FULL),
    }


def drive_secant(cell: Cell) -> Fraction:
    """Return the least secant of the drive's rate limit: h tau |y| <= limit, |y| as below.

    tau |y| = |beta_ref - beta| is at most the deviation of the law's pitch, with its lead, from the
    rest, plus the deviation of the pitch from the rest.
    """
    law, sides, plant = cell.law, cell.sides, cell.plant
    shed = max(psi(U, law.overlap) for U in cell.efforts_at_rest)
    bend = size(cell.secants(law.effectiveness))
    away = sides.schedule if cell.lag is None else size(cell.lag)
    moved = cell.share[1] * sides.effort + shed * bend / cell.b[0] * away
    led = size(cell.lead) / cell.b0 * cell.schedule_rate
    most = moved / cell.b_reach[0] + led + sides.pitch / cell.b0
    return down(min(FULL, plant.rate_limit * plant.lag / most))


def cut(ends: Span, parts: int) -> list[Span]:
    """Divide the interval into equal parts."""
    width = (ends[1] - ends[0]) / parts
    return [(ends[0] + width * i, ends[0] + width * (i + 1)) for i in range(parts)]


def _outward(ends: Span) -> Span:
    """Return seven decimals, rounded outward."""
    return down(ends[0]), up(ends[1])
