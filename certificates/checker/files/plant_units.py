"""Numbers of plant files in SI: an independent reading of the closed list of units.

Names with spaces or ``*`` between them, powers with ``^``, one ``/``.  For units with pi (deg, rpm)
the value in SI is the nearest decimal with 12 places, as the page on plant files says.
"""

from __future__ import annotations

import re
from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import Refused

PI = Fraction("3.14159265358979323846264338327950288419716939937510")
PLACES = 12
COHERENT = frozenset("kg m s A K mol cd rad N Pa J W C V Ohm S F Wb H T".split())
# Factor to coherent units, and the power of pi in it.
OTHER = {
    "g": (Fraction(1, 1000), 0),
    "t": (Fraction(1000), 0),
    "L": (Fraction(1, 1000), 0),
    "bar": (Fraction(100000), 0),
    "min": (Fraction(60), 0),
    "h": (Fraction(3600), 0),
    "deg": (Fraction(1, 180), 1),
    "rpm": (Fraction(1, 30), 1),
    "%": (Fraction(1, 100), 0),
}
PREFIXES = {"G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "u": -6, "n": -9}
PREFIXED = (COHERENT - {"kg", "cd"}) | {"g", "L", "bar"}
FACTOR = re.compile(r"([A-Za-z%]+)(?:(?:\^|\*\*)(-?[0-9]{1,2}))?", re.ASCII)


def in_si(value: Fraction, unit: str) -> Fraction:
    """Return the value in SI.

    Raises
    ------
    Refused : a unit that is not in the list, or a text of another form.
    """
    if unit.strip() == "-":
        return value
    above, slash, below = (part.strip() for part in unit.strip().partition("/"))
    if not above or (slash and not below) or (above == "1" and not slash):
        raise Refused(f"the unit {unit[:40]!a} cannot be read")
    if below.startswith("(") and below.endswith(")"):
        below = below[1:-1]
    factor, turns = Fraction(1), 0
    for part, sign in (("" if above == "1" else above, 1), (below, -1)):
        for word in re.sub(r"(?<!\*)\*(?!\*)", " ", part).split():
            match = FACTOR.fullmatch(word)
            if match is None:
                raise Refused(f"the unit {unit[:40]!a} cannot be read")
            scale, power_of_pi = _meaning(match.group(1), unit)
            power = sign * int(match.group(2) or 1)
            factor *= scale**power
            turns += power_of_pi * power
    found = value * factor
    return round(found * PI**turns, PLACES) if turns else found


def _meaning(name: str, unit: str) -> tuple[Fraction, int]:
    if name in COHERENT:
        return Fraction(1), 0
    if name in OTHER:
        return OTHER[name]
    if name[:1] in PREFIXES and name[1:] in PREFIXED:
        scale, turns = _meaning(name[1:], unit)
        return scale * Fraction(10) ** PREFIXES[name[0]], turns
    raise Refused(f"the unit {unit[:40]!a} is not known")
