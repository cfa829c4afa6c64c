"""The greatest acceleration that the table's torque gives the rotor, over ranges.

T_r / J = c v^2 c_Q(R omega / v, beta), with both arguments of c_Q held within the table.
"""

from __future__ import annotations

from flint import fmpq

from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.surface import Band, NumberRange

# Equal parts of the winds, of the pitch and of the table's tip-speed ratios.
OF_WIND, OF_PITCH, OF_RATIO = 48, 6, 24
ZERO = fmpq(0)


def driven(rotor: Rotor, slow: fmpq, fast: fmpq, top: fmpq) -> fmpq:
    """Return a bound at speeds from slow to fast and winds from 0 to top."""
    last, most, bands = rotor.surface.x.breaks[-1], ZERO, _bands(rotor)
    for part in range(1, OF_WIND + 1):
        behind, ahead = top * (part - 1) / OF_WIND, top * part / OF_WIND
        low = rotor.radius * slow / ahead
        high = rotor.radius * fast / behind if behind > 0 else last
        coefficient = _largest(bands, _inside(rotor, low), _inside(rotor, high))
        most = max(most, coefficient * ahead * ahead)
    return rotor.c * most


def driven_at_all(rotor: Rotor, top: fmpq) -> fmpq:
    """Return a bound at all speeds and winds up to top."""
    first, last = rotor.surface.x.breaks[0], rotor.surface.x.breaks[-1]
    cuts = [first + (last - first) * i / OF_RATIO for i in range(OF_RATIO + 1)]
    bands = _bands(rotor)
    most = max(_largest(bands, low, high) for low, high in zip(cuts[:-1], cuts[1:], strict=True))
    return rotor.c * top * top * max(most, ZERO)


def _bands(rotor: Rotor) -> list[Band]:
    """Return the surface over equal parts of all pitch from the lower limit on."""
    edges = rotor.surface.y.breaks
    least = min(max(rotor.pitch_min, edges[0]), edges[-1])
    step = (edges[-1] - least) / OF_PITCH
    parts = [NumberRange(least + i * step, least + (i + 1) * step) for i in range(OF_PITCH)]
    return [Band(rotor.surface, part) for part in parts]


def _largest(bands: list[Band], low: fmpq, high: fmpq) -> fmpq:
    """Return a bound of c_Q over tip-speed ratios and the bands."""
    return max(band.over(NumberRange(low, high)).high for band in bands)


def _inside(rotor: Rotor, ratio: fmpq) -> fmpq:
    breaks = rotor.surface.x.breaks
    return min(max(ratio, breaks[0]), breaks[-1])
