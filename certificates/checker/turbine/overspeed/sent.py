r"""The least torque that the law asks for while the measured speed is at least some speed.

At a schedule wind v_s, with the measured speed at least m and |x| at most its limit,

    omega_m - omega*(v_s) - x >= s = m - limit - omega*(v_s),
    U >= U_0 = q*(v_s) + gamma(v_s) s,      T_c >= T_rated - E (psi(-U_0) + g)

held within 0 and T_rated; g is the limit of the feed-forward.  Ranges are over equal parts of each
interval of the tables.
"""

from __future__ import annotations

from bisect import bisect_right
from fractions import Fraction
from itertools import pairwise

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law

PARTS = 8
NIL = Fraction(0)
# Of a part of an interval: the greatest omega*, the least q*, and both ends of gamma.
Part = tuple[Fraction, Fraction, Fraction, Fraction]


class LeastTorque:
    """What the law asks for at least, at all schedule winds from ``least`` on.

    Raises
    ------
    Refused : no schedule wind of the tables is above ``least``.
    """

    def __init__(self, law: Law, least: Fraction) -> None:
        self.law = law
        # The parts of each interval of the tables, with g there.
        self.intervals: list[tuple[list[Part], Fraction]] = []
        low, high = max(least, law.wind[0]), law.wind[-1]
        if not low < high:
            raise Refused("no schedule wind of the law's tables is left")
        inner = [node for node in law.wind if low < node < high]
        for start, stop in pairwise([low, *inner, high]):
            k = bisect_right(law.wind, start) - 1
            width = (stop - start) / PARTS
            winds = [start + width * i for i in range(PARTS + 1)]
            columns = [_along(law, c, k, winds) for c in (law.speed, law.effort, law.gamma)]
            parts = [
                (max(speed), min(effort), min(gamma), max(gamma))
                for speed, effort, gamma in zip(*map(pairwise, columns), strict=True)
            ]
            self.intervals.append((parts, law.inertia_limit[k]))

    def above(self, measured: Fraction) -> Fraction:
        """Return the torque on the high-speed shaft [N m] for a least measured speed [rad/s]."""
        signal = measured - self.law.integral_limit
        return min(self._of(parts, fed, signal) for parts, fed in self.intervals)

    def _of(self, parts: list[Part], fed: Fraction, signal: Fraction) -> Fraction:
        """Return the least torque of an interval, which is that of the part with the least U."""
        law = self.law
        U = min(
            effort + (low if signal >= speed else high) * (signal - speed)
            for speed, effort, low, high in parts
        )
        asked = law.rated_torque - law.effort_torque * (psi(-U, law.overlap) + fed)
        return min(max(asked, NIL), law.rated_torque)


def _along(law: Law, column: list[Fraction], k: int, winds: list[Fraction]) -> list[Fraction]:
    """Return the values of a column at winds of interval k."""
    slope = law.slope(column, k)
    return [column[k] + slope * (wind - law.wind[k]) for wind in winds]
