"""The effort-sharing law's tables on one interval between wind nodes, and its commands, exactly."""

from __future__ import annotations

from fractions import Fraction

from takagi.models.intervals.interval import Interval, exact
from takagi.models.intervals.jet import Jet
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.loops.effort_sharing.loop_cell import LoopBox
from takagi.models.ramps.exact_effort_ramp import ramp, ramp_slope

CURVE_PIECES = 8


class LawInterval:
    """The law for schedule winds from node k to node k + 1, with deviations inside the box.

    Attributes
    ----------
    wind : [m/s];  width : of the interval [m/s].
    ends : column -> its values at the two nodes.
    nu : integral rate;  inertia, effort_limit, pitch_lead : f, g, tau_lead.
    effectiveness, gamma : ranges of b and gamma.
    signal : e - x;  demand : efforts U = q* + gamma (e - x);  owed : psi(U) - zeta, cut at 0,
        which is b (beta - beta_min).
    """

    def __init__(self, law: EffortSharingLaw, box: LoopBox, k: int) -> None:
        table, gains, ahead = law.schedule, law.gains, law.feedforward
        columns = (
            ("wind", table.wind),
            ("speed", table.rotor_speed),
            ("effort", table.trim_effort),
            ("effectiveness", table.effectiveness),
            ("limit", table.effectiveness_limit),
            ("gamma", gains.proportional),
        )
        self.ends = {
            name: (exact(float(column[k])), exact(float(column[k + 1]))) for name, column in columns
        }
        self.wind = hull(self.ends["wind"])
        self.width = self.wind.width
        self.overlap = exact(table.overlap)
        self.nu = exact(float(gains.integral_rate[k]))
        self.inertia = exact(float(ahead.inertia[k]))
        self.effort_limit = exact(float(ahead.effort_limit[k]))
        self.pitch_lead = exact(ahead.pitch_lead)
        self.rated_torque, self.effort_torque = exact(law.rated_torque), exact(law.effort_torque)
        self.pitch_min, self.pitch_max = exact(law.pitch_min), exact(law.pitch_max)
        self.effectiveness = hull(self.ends["effectiveness"])
        self.gamma = hull(self.ends["gamma"])
        self.signal = Interval(-box.speed_signal, box.speed_signal)
        self.demand = hull(self.ends["effort"]) + self.gamma * self.signal
        owed = self.ramp(self.demand) + Interval(-box.effort_lag, box.effort_lag)
        self.owed = Interval(max(owed.lower, Fraction(0)), owed.upper)

    def slope(self, name: str) -> Fraction:
        """Return the slope of a column over wind."""
        first, last = self.ends[name]
        return (last - first) / self.width

    def ramp(self, effort: Interval) -> Interval:
        """Return the range of psi, which is monotone."""
        return Interval(self.psi(effort.lower), self.psi(effort.upper))

    def psi(self, s: Fraction) -> Fraction:
        """Return the effort ramp at one effort."""
        return ramp(s, self.overlap)

    def share(self, effort: Interval) -> Interval:
        """Return the range of F = psi', which is monotone."""
        ends = (ramp_slope(end, self.overlap) for end in (effort.lower, effort.upper))
        return Interval(*ends)

    def pieces(self) -> list[Interval]:
        """Return the efforts that the set can demand, in small pieces where the ramp bends."""
        low, high, eps = self.demand.lower, self.demand.upper, self.overlap
        cuts = {low, high}
        start, stop = max(low, -eps), min(high, eps)
        if start < stop:
            step = (stop - start) / CURVE_PIECES
            cuts.update(start + step * i for i in range(CURVE_PIECES + 1))
        ordered = sorted(cuts)
        return [Interval(a, b) for a, b in zip(ordered, ordered[1:], strict=False)]

    def ramp_jet(self, effort: Jet) -> Jet:
        """Return the jet of psi(s(v)) for a line s: psi'' is 1 / (2 eps) in the ramp, else 0."""
        share = self.share(effort.value)
        bent = Interval(Fraction(0), 1 / (2 * self.overlap))
        if effort.value.upper <= -self.overlap or effort.value.lower >= self.overlap:
            bent = Interval(Fraction(0), Fraction(0))
        return Jet(self.ramp(effort.value), share * effort.slope, bent * effort.slope**2)


def hull(ends: tuple[Fraction, Fraction]) -> Interval:
    """Return the interval between two numbers in either order."""
    return Interval(min(ends), max(ends))
