r"""The least torque that the law asks for while the measured speed is at least some speed.

At a schedule wind v_s, with the measured speed at least m and |x| at most its limit,

    omega_m - omega*(v_s) - x >= s = m - limit - omega*(v_s),
    U >= U_0 = q*(v_s) + gamma(v_s) s,      T_c >= T_rated - E (psi(-U_0) + g)

held within 0 and T_rated; g is the limit of the feed-forward.  Ranges are over equal parts of each
interval of the tables.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law

PARTS = 8
NIL = Fraction(0)
# Of a part of an interval: the greatest omega*, the least q*, both ends of gamma, and g.
Part = tuple[Fraction, Fraction, Fraction, Fraction, Fraction]


class LeastTorque:
    """What the law asks for at least, at all schedule winds from ``least`` on.

    Raises
    ------
    Refused : no schedule wind of the tables is above ``least``.
    """

    def __init__(self, law: Law, least: Fraction) -> None:
        self.law = law
        self.parts: list[Part] = []
        low, high = max(least, law.wind[0]), law.wind[-1]
        if not low < high:
            raise Refused("no schedule wind of the law's tables is left")
        inner = [node for node in law.wind if low < node < high]
        for start, stop in pairwise([low, *inner, high]):
            k = bisect_right(law.wind, start) - 1
            width = (stop - start) / PARTS
            for i in range(PARTS):
                ends = start + width * i, start + width * (i + 1)
                speed, effort, gamma = (
                    [_at(law, column, k, v) for v in ends]
                    for column in (law.speed, law.effort, law.gamma)
                )
                fed = law.inertia_limit[k]
                self.parts.append((max(speed), min(effort), min(gamma), max(gamma), fed))

    def above(self, measured: Fraction) -> Fraction:
        """Return the torque on the high-speed shaft [N m] for a least measured speed [rad/s]."""
        return min(self._of(part, measured - self.law.integral_limit) for part in self.parts)

    def _of(self, part: Part, signal: Fraction) -> Fraction:
        law, (speed, effort, low, high, fed) = self.law, part
        s = signal - speed
        U = effort + (low if s >= 0 else high) * s
        asked = law.rated_torque - law.effort_torque * (psi(-U, law.overlap) + fed)
        return min(max(asked, NIL), law.rated_torque)


def _at(law: Law, column: Sequence[Fraction], k: int, wind: Fraction) -> Fraction:
    return column[k] + law.slope(list(column), k) * (wind - law.wind[k])
