r"""The greatest torque of the rotor over ranges of speed and wind, over J.

    T_r / J = c v^2 c_Q(R omega / v, beta),

c_Q the spline of the file, with tip-speed ratio and pitch held within its knots.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.interval import ONE, enclose
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.running_loop.inputs import Span

# The winds, the pitch angles and the tip-speed ratios are divided into this many parts.
WINDS, PITCHES, RATIOS = 48, 6, 24
NIL = Fraction(0)


def greatest(plant: Plant, speeds: Span, highest: Fraction) -> Fraction:
    """Return a bound, not below 0, of T_r/J [rad/s^2] at winds from 0 to ``highest``.

    Parameters
    ----------
    speeds : of the rotor, positive [rad/s].
    """
    found, width = NIL, highest / WINDS
    ends = plant.surface.x.breaks
    for i in range(WINDS):
        low, high = width * i, width * (i + 1)
        first = _held(plant.radius * speeds[0] / high, ends)
        last = _held(plant.radius * speeds[1] / low, ends) if i else ends[-1]
        found = max(found, high**2 * _coefficient(plant, (first, last)))
    return plant.torque_per_inertia * found


def greatest_at_any_speed(plant: Plant, highest: Fraction) -> Fraction:
    """Return a bound of T_r/J [rad/s^2] at winds up to ``highest`` and all speeds."""
    ends = plant.surface.x.breaks
    width = (ends[-1] - ends[0]) / RATIOS
    parts = ((ends[0] + width * i, ends[0] + width * (i + 1)) for i in range(RATIOS))
    most = max(_coefficient(plant, part) for part in parts)
    return plant.torque_per_inertia * highest**2 * max(most, NIL)


def _coefficient(plant: Plant, ratios: Span) -> Fraction:
    """Return a bound of c_Q over tip-speed ratios, at every pitch from the lower limit on."""
    ends = plant.surface.y.breaks
    low, high = _held(plant.pitch_min, ends), ends[-1]
    width = (high - low) / PITCHES
    found = [
        plant.surface.bounds(enclose(*ratios), enclose(low + width * j, low + width * (j + 1))).high
        for j in range(PITCHES)
    ]
    return Fraction(max(found), ONE)


def _held(value: Fraction, ends: list[Fraction]) -> Fraction:
    return min(max(value, ends[0]), ends[-1])
