r"""Replays a claim about the loop with the coherent law: embedding, LMIs, bounds, consequences.

State (e, zeta, x): speed error, effort that pitch still owes, the law's integral.  For schedule
winds v_s in a cell, |v - v_s| <= wind_error and |v_s'| <= wind_rate, the loop's matrix and
disturbance lie in the hull of the corners of

    A = [ a - G           S          G     ]      d = ( w,  f w + z, 0 )
        [ f (a - G + nu)  f S - T    f G   ]      w = kappa (r + g wind_error) + o wind_rate
        [ -nu             0          0     ]      z = l wind_rate        (each of both signs)

whose eleven coefficients are enclosed here from the tables of the law and the plant's surface, and
compared with those the certificate states.  Then, exactly, at every corner

    -[[A'P + PA + alpha P, P d], [d'P, -alpha]] > 0    so  {V <= 1} is invariant, V = xi' P xi,
    -(A'P + PA + 2 rho P) > 0                          so  V decays as exp(-2 rho t), v constant,

and P > h h' / peak^2 bounds each state on {V <= 1}, which must lie inside the enclosed box.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import lcm
from typing import Any

from takagi.certificates.checker.definite import is_positive_definite, positive_definite_integers
from takagi.certificates.checker.fixed import (
    BITS,
    ONE,
    Q,
    add,
    div,
    enclose,
    hull,
    magnitude,
    mul,
    point,
    square,
    sub,
    within,
)
from takagi.certificates.checker.reader import increasing, matrix, member, number, numbers
from takagi.certificates.checker.refusal import CertificateError, Refused
from takagi.certificates.checker.result import Claim, Verdict
from takagi.certificates.checker.spline import Spline

__all__ = ["check_coherent"]

# Stated coefficients have seven decimals, so that corners are integers over 10^7.
UNIT = 10**7
PIECES = 8
# Rows h of h xi: e, zeta, e - x, x.
DIRECTIONS = {
    "speed_error": (1, 0, 0),
    "effort_lag": (0, 1, 0),
    "speed_signal": (1, 0, -1),
    "integral": (0, 0, 1),
}
RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
BOUNDS = ("residual", "wind_gain", "inertia_gain", "reference_slope", "lag_slope")


@dataclass(frozen=True)
class _Plant:
    """The plant's numbers, exactly."""

    torque_per_inertia: Fraction
    gear_per_inertia: Fraction
    radius: Fraction
    lag: Fraction
    rate_limit: Fraction
    rated_speed: Fraction
    pitch_min: Fraction
    pitch_max: Fraction
    surface: Spline

    @classmethod
    def read(cls, model: Any) -> _Plant:
        gear = number(model, "gear_ratio", "model")
        inertia = number(model, "rotor_inertia", "model")
        inertia += gear**2 * number(model, "generator_inertia", "model")
        table = member(model, "torque_surface", "model")
        where = "model.torque_surface"
        positive = {
            key: number(model, key, "model")
            for key in ("torque_constant", "rotor_radius", "pitch_time_constant")
        }
        positive |= {k: number(model, k, "model") for k in ("pitch_rate_limit", "rated_rotor_speed")}
        if inertia <= 0 or gear <= 0 or any(value <= 0 for value in positive.values()):
            raise CertificateError("model: inertia, gear ratio and every constant must be positive")
        return cls(
            positive["torque_constant"] / inertia,
            gear / inertia,
            positive["rotor_radius"],
            positive["pitch_time_constant"],
            positive["pitch_rate_limit"],
            positive["rated_rotor_speed"],
            number(model, "pitch_min", "model"),
            number(model, "pitch_max", "model"),
            Spline(
                numbers(table, "tip_speed_ratio_knots", where),
                numbers(table, "pitch_knots", where),
                matrix(table, "coefficients", where),
            ),
        )


@dataclass(frozen=True)
class _Law:
    """The law's tables, exactly; one row entry per wind node."""

    wind: list[Fraction]
    speed: list[Fraction]
    effort: list[Fraction]
    effectiveness: list[Fraction]
    limit: list[Fraction]
    gamma: list[Fraction]
    nu: list[Fraction]
    overlap: Fraction
    rated_torque: Fraction
    effort_torque: Fraction
    pitch_min: Fraction
    pitch_max: Fraction
    integral_limit: Fraction

    @classmethod
    def read(cls, gains: Any) -> _Law:
        wind = numbers(gains, "wind", "gains")
        increasing(wind, "gains.wind")
        count = len(wind)
        names = ("rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit", "proportional")
        columns = [numbers(gains, name, "gains", count) for name in names]
        nu = numbers(gains, "integral_rate", "gains", count - 1)
        scalars = [
            number(gains, name, "gains")
            for name in (
                "overlap",
                "rated_torque",
                "effort_torque",
                "pitch_min",
                "pitch_max",
                "integral_limit",
            )
        ]
        law = cls(wind, *columns, nu, *scalars)  # type: ignore[arg-type]
        positive = [law.overlap, law.rated_torque, law.effort_torque, law.integral_limit]
        if min(positive) <= 0 or min(wind[0], *law.effectiveness, *law.gamma, *nu) <= 0:
            raise CertificateError("gains: winds, gains, effectiveness and limits must be positive")
        return law


@dataclass(frozen=True)
class _Box:
    speed_error: Fraction
    effort_lag: Fraction
    speed_signal: Fraction
    wind_share: Fraction

    @classmethod
    def read(cls, claim: Any, where: str) -> _Box:
        box = member(claim, "box", where)
        names = ("speed_error", "effort_lag", "speed_signal", "wind_share")
        values = [number(box, name, f"{where}.box") for name in names]
        if min(values) <= 0 or values[3] >= 1:
            raise CertificateError(f"{where}.box: positive bounds, and a wind share below 1")
        return cls(*values)


def check_coherent(claim: Any, model: Any, gains: Any, where: str) -> Claim:
    """Return the verdict on one claim of kind ``coherent-loop``, with what fails and where.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    plant, law, box = _Plant.read(model), _Law.read(gains), _Box.read(claim, where)
    if plant.pitch_min != law.pitch_min or plant.pitch_max != law.pitch_max:
        raise CertificateError("gains: pitch limits differ from the model's")
    uncertainty = member(claim, "uncertainty", where)
    inertia = numbers(uncertainty, "inertia", f"{where}.uncertainty", 2)
    if not 0 < inertia[0] <= inertia[1]:
        raise CertificateError(f"{where}.uncertainty.inertia: 0 < low <= high is needed")
    frozen = member(uncertainty, "frozen_wake", f"{where}.uncertainty")
    if not isinstance(frozen, bool):
        raise CertificateError(f"{where}.uncertainty.frozen_wake: true or false is needed")
    P = matrix(claim, "P", where)
    failures = list(_set_failures(P, claim, box, law, where))
    cells = member(claim, "cells", where)
    if not isinstance(cells, list) or len(cells) != len(law.wind) - 1:
        raise CertificateError(f"{where}.cells: one per interval of the law's winds is needed")
    unproved = []
    for k, cell in enumerate(cells):
        loop = _Loop(plant, law, box, (1 / inertia[1], 1 / inertia[0]), frozen, k)
        reason = _cell_failure(loop, cell, P, f"{where}.cells[{k}]")
        if reason:
            unproved.append(f"wind {_span(law.wind[k : k + 2])} m/s: {reason}")
    name = str(member(claim, "name", where))
    if failures or unproved:
        return Claim(name, Verdict.UNDECIDED, _listed([*failures, *unproved], len(cells)))
    return Claim(name, Verdict.PROVED, _statement(claim, plant, law, cells, inertia, frozen, where))


def _listed(reasons: list[str], cells: int) -> str:
    more = f" (+{len(reasons) - 12} more)" if len(reasons) > 12 else ""
    return f"not proved, of {cells} wind cells: " + "; ".join(reasons[:12]) + more


def _set_failures(P: Any, claim: Any, box: _Box, law: _Law, where: str) -> Iterator[str]:
    """Check P > 0 and that {V <= 1} lies inside the stated peaks, and those inside the box."""
    if len(P) != 3 or any(len(row) != 3 for row in P) or not is_positive_definite(P):
        yield "P is not symmetric positive definite"
        return
    peaks = member(claim, "peaks", where)
    limits = {
        "speed_error": box.speed_error,
        "effort_lag": box.effort_lag,
        "speed_signal": box.speed_signal,
        "integral": law.integral_limit,
    }
    for name, h in DIRECTIONS.items():
        peak = number(peaks, name, f"{where}.peaks")
        inside = [[peak**2 * P[i][j] - h[i] * h[j] for j in range(3)] for i in range(3)]
        if not 0 < peak <= limits[name] or not is_positive_definite(inside):
            yield f"the set is not inside its stated bound on {name}"


class _Loop:
    """Enclosures of the loop's coefficients in cell k, from tables and surface alone."""

    def __init__(
        self,
        plant: _Plant,
        law: _Law,
        box: _Box,
        kappa: tuple[Fraction, Fraction],
        frozen: bool,
        k: int,
    ) -> None:
        self.plant, self.law, self.box, self.k, self.frozen = plant, law, box, k, frozen
        self.width = law.wind[k + 1] - law.wind[k]
        self.wind = enclose(law.wind[k], law.wind[k + 1])
        self.kappa, self.largest_kappa = enclose(*kappa), kappa[1]
        self.c = point(plant.torque_per_inertia)
        self.share_of_torque = point(law.effort_torque * plant.gear_per_inertia)
        self.b = self._range(law.effectiveness)
        self.gamma = self._range(law.gamma)
        lows = [law.effort[i] - g * box.speed_signal for i in (k, k + 1) for g in law.gamma[k : k + 2]]
        highs = [law.effort[i] + g * box.speed_signal for i in (k, k + 1) for g in law.gamma[k : k + 2]]
        self.low, self.high = min(lows), max(highs)
        ramp = self._ramp(self.low, self.high)
        owed_low = max(self._psi(self.low) - box.effort_lag, Fraction(0))
        self.owed = enclose(owed_low, self._psi(self.high) + box.effort_lag)
        self.pitch = add(div(self.owed, self.b), point(law.pitch_min))
        self.ramp = ramp

    def _range(self, column: list[Fraction]) -> Q:
        a, b = column[self.k], column[self.k + 1]
        return enclose(min(a, b), max(a, b))

    def _slope(self, column: list[Fraction]) -> Fraction:
        return (column[self.k + 1] - column[self.k]) / self.width

    def _psi(self, s: Fraction) -> Fraction:
        eps = self.law.overlap
        if s <= -eps:
            return Fraction(0)
        return s if s >= eps else (s + eps) ** 2 / (4 * eps)

    def _ramp(self, low: Fraction, high: Fraction) -> Q:
        return enclose(self._psi(low), self._psi(high))

    def _share(self, low: Fraction, high: Fraction) -> Q:
        eps = self.law.overlap
        held = [min(max((s + eps) / (2 * eps), Fraction(0)), Fraction(1)) for s in (low, high)]
        return enclose(held[0], held[1])

    def _tip_speed(self, speed_error: Fraction, wind_error: Fraction) -> Q:
        """Return the range of R (omega* + e) / (v_s + dv): monotone in each, so at corners."""
        corners = [
            self.plant.radius * (self.law.speed[i] + e) / (self.law.wind[i] + dv)
            for i in (self.k, self.k + 1)
            for e in ({-speed_error, speed_error})
            for dv in ({-wind_error, wind_error})
        ]
        return enclose(min(corners), max(corners))

    def ranges_hold(self, stated: dict[str, list[Fraction]]) -> str:
        """Return the name of a coefficient that leaves its stated range, or nothing."""
        for name, (low, high) in self._rational_ranges().items():
            if not stated[name][0] <= low <= high <= stated[name][1]:
                return name
        for name, found in self._enclosed_ranges().items():
            if not within(found, *stated[name]):
                return name
        return ""

    def _rational_ranges(self) -> dict[str, tuple[Fraction, Fraction]]:
        """Return the coefficients that need no enclosure."""
        eps, gamma = self.law.overlap, self.law.gamma[self.k : self.k + 2]
        low, high = (min(max((s + eps) / (2 * eps), Fraction(0)), Fraction(1)) for s in (self.low, self.high))
        fastest = 1 / self.plant.lag
        slowest = fastest * min(Fraction(1), self.plant.rate_limit / self.pitch_rate())
        return {
            "share_gain": (low * min(gamma), high * max(gamma)),
            "lag_rate": (slowest, fastest),
        }

    def _enclosed_ranges(self) -> dict[str, Q]:
        """Return the coefficients that come from the surface."""
        bounds = self.plant.surface.bounds
        ratio = self._tip_speed(self.box.speed_error, Fraction(0))
        radius = point(self.plant.radius)
        a = mul(mul(bounds(ratio, self.pitch, 1, 0), self.wind), mul(self.c, radius))
        at_trim = self._tip_speed(Fraction(0), Fraction(0))
        return {
            "stiffness": mul(self.kappa, a),
            "loop_gain": mul(mul(self.kappa, self.gamma), self._curve_gain(at_trim)),
            "lag_gain": mul(self.kappa, self._sigma(at_trim, self.pitch)),
        }

    def pitch_rate(self) -> Fraction:
        """Return the largest pitch rate that is demanded, |zeta| / (b tau)."""
        least = min(self.law.effectiveness[self.k : self.k + 2])
        return self.box.effort_lag / (least * self.plant.lag)

    def magnitudes(self) -> dict[str, int]:
        """Return the coefficients that enter by their size, over 2^96."""
        feedforward = add(
            mul(enclose(-self.box.speed_signal, self.box.speed_signal), point(self._slope(self.law.gamma))),
            point(self._slope(self.law.effort)),
        )
        relative = div(point(self._slope(self.law.effectiveness)), self.b)
        share = self._share(self.low, self.high)
        return {
            "residual": self._residual(),
            "wind_gain": magnitude(self._wind_gain()),
            "lag_slope": magnitude(sub(mul(share, feedforward), mul(self.owed, relative))),
        }

    def rational_sizes(self) -> dict[str, Fraction]:
        """Return the coefficients that enter by their size and need no enclosure."""
        return {
            "inertia_gain": self.largest_kappa,
            "reference_slope": abs(self._slope(self.law.speed)),
        }

    def _wind_gain(self) -> Q:
        error = self.box.wind_share * self.law.wind[self.k]
        ratio = self._tip_speed(self.box.speed_error, error)
        bounds = self.plant.surface.bounds
        value = bounds(ratio, self.pitch)
        inner = sub(add(value, value), mul(ratio, bounds(ratio, self.pitch, 1, 0)))
        wind = enclose(self.law.wind[self.k] - error, self.law.wind[self.k + 1] + error)
        return mul(mul(inner, wind), self.c)

    def _sigma(self, ratio: Q, pitch: Q) -> Q:
        slope = mul(mul(self.plant.surface.bounds(ratio, pitch, 0, 1), square(self.wind)), self.c)
        sigma = div((-slope[1], -slope[0]), self.b)
        if not self.frozen:
            return sigma
        return sigma[0], max(sigma[1], div(self._range(self.law.limit), self.b)[1])

    def _curve_gain(self, ratio: Q) -> Q:
        eps, m = self.law.overlap, self.share_of_torque
        cuts = {self.low, self.high}
        start, stop = max(self.low, -eps), min(self.high, eps)
        if start < stop:
            cuts |= {start + (stop - start) * i / PIECES for i in range(PIECES + 1)}
        ordered = sorted(cuts)
        found = []
        for low, high in zip(ordered, ordered[1:], strict=False):
            share = self._share(low, high)
            if share[1] <= 0:
                found.append(m)
                continue
            pitch = add(div(self._ramp(low, high), self.b), point(self.law.pitch_min))
            found.append(sub(m, mul(share, sub(m, self._sigma(ratio, pitch)))))
        return hull(*found)

    def limits_failure(self) -> str:
        """Return why the set may demand what the actuators cannot deliver, or nothing."""
        if self.law.rated_torque < self.law.effort_torque * self._psi(-self.low):
            return "negative torque may be demanded"
        if self.pitch[1] > self.law.pitch_max * ONE:
            return "pitch beyond its limit may be demanded"
        return ""

    def _residual(self) -> int:
        """Return a bound of the trim residual: its ends, and width^2 / 8 times its curvature."""
        ends = max(magnitude(self._residual_at(i)) for i in (self.k, self.k + 1))
        eighth = enclose(self.width**2 / 8, self.width**2 / 8)
        bent = self._residual_curvature()
        return ends + mul((0, magnitude(bent)), eighth)[1]

    def _residual_at(self, i: int) -> Q:
        law = self.law
        ratio = point(self.plant.radius * law.speed[i] / law.wind[i])
        pitch = point(law.pitch_min + self._psi(law.effort[i]) / law.effectiveness[i])
        torque = mul(self.plant.surface.bounds(ratio, pitch), mul(self.c, point(law.wind[i] ** 2)))
        demanded = law.rated_torque - law.effort_torque * self._psi(-law.effort[i])
        return sub(torque, point(demanded * self.plant.gear_per_inertia))

    def _residual_curvature(self) -> Q:
        """Return r'' over the cell, from the derivatives of lambda(v), beta(v) and c_Q."""
        law, k = self.law, self.k
        v = self.wind
        # lambda = R omega* / v with omega* = speed + slope (v - v_k): lambda' = -R w0 / v^2.
        intercept = law.speed[k] - self._slope(law.speed) * law.wind[k]
        r_w0 = point(self.plant.radius * intercept)
        lam1 = div((-r_w0[1], -r_w0[0]), square(v))
        twice = add(r_w0, r_w0)
        lam2 = div(twice, mul(square(v), v))
        # beta = psi(q) / b with q and b linear.
        q_low, q_high = sorted(law.effort[k : k + 2])
        q1, b1 = point(self._slope(law.effort)), point(self._slope(law.effectiveness))
        psi0, psi1 = self._ramp(q_low, q_high), mul(self._share(q_low, q_high), q1)
        psi2 = mul(self._bend(q_low, q_high), square(q1))
        beta0 = div(psi0, self.b)
        beta1 = div(sub(psi1, mul(beta0, b1)), self.b)
        slope_b = mul(beta1, b1)
        beta2 = div(sub(psi2, add(slope_b, slope_b)), self.b)
        ratio = self._tip_speed(Fraction(0), Fraction(0))
        pitch = add(beta0, point(law.pitch_min))
        c = {
            order: self.plant.surface.bounds(ratio, pitch, *order)
            for order in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
        }
        c1 = add(mul(c[1, 0], lam1), mul(c[0, 1], beta1))
        cross = mul(mul(c[1, 1], lam1), beta1)
        c2 = add(mul(c[2, 0], square(lam1)), mul(c[0, 2], square(beta1)))
        c2 = add(add(c2, add(cross, cross)), add(mul(c[1, 0], lam2), mul(c[0, 1], beta2)))
        # (v^2 c_Q)'' = 2 c_Q + 4 v c_Q' + v^2 c_Q''.
        two, four = (2 * ONE, 2 * ONE), (4 * ONE, 4 * ONE)
        torque = add(mul(two, c[0, 0]), add(mul(mul(four, v), c1), mul(square(v), c2)))
        reserve = mul(self._bend(-q_high, -q_low), square(q1))
        return add(mul(self.c, torque), mul(self.share_of_torque, reserve))

    def _bend(self, low: Fraction, high: Fraction) -> Q:
        """Return the range of psi'': 1 / (2 eps) inside the ramp, 0 outside."""
        eps = self.law.overlap
        if high <= -eps or low >= eps:
            return (0, 0)
        return (0, point(1 / (2 * eps))[1])


def _cell_failure(loop: _Loop, cell: Any, P: list[list[Fraction]], where: str) -> str:
    """Return what is not proved about one cell, or nothing."""
    law, k = loop.law, loop.k
    if numbers(cell, "wind", where, 2) != law.wind[k : k + 2]:
        raise CertificateError(f"{where}.wind: must be the law's interval {k}")
    if number(cell, "integral_rate", where) != law.nu[k]:
        raise CertificateError(f"{where}.integral_rate: differs from the law's")
    stated = {name: numbers(cell, name, where, 2) for name in RANGES}
    sizes = {name: number(cell, name, where) for name in BOUNDS}
    try:
        wrong, extent = loop.ranges_hold(stated), loop.magnitudes()
    except Refused as reason:
        return str(reason)
    if wrong:
        return f"the loop's {wrong} leaves the stated range"
    for name, least in loop.rational_sizes().items():
        if least > sizes[name]:
            return f"the loop's {name} exceeds the stated bound"
    for name, size in extent.items():
        if size * sizes[name].denominator > sizes[name].numerator << BITS:
            return f"the loop's {name} exceeds the stated bound"
    if limit := loop.limits_failure():
        return limit
    error, rate = number(cell, "wind_error", where), number(cell, "wind_rate", where)
    if not (0 <= error <= loop.box.wind_share * law.wind[k] and rate >= 0):
        return "the wind class is outside the enclosed one"
    alpha, decay = number(cell, "multiplier", where), number(cell, "decay_rate", where)
    if alpha <= 0 or decay < 0:
        return "multiplier or decay rate has the wrong sign"
    return _Corners(stated, sizes, law.nu[k], where).failure(P, error, rate, alpha, decay)


class _Corners:
    """The matrix inequalities of one cell over integers."""

    def __init__(
        self, stated: dict[str, list[Fraction]], sizes: dict[str, Fraction], nu: Fraction, where: str
    ) -> None:
        self.ends = [sorted({_scaled(v, where) for v in stated[name]}) for name in RANGES]
        self.sizes = sizes
        self.nu = _scaled(nu, where)

    def failure(
        self, P: list[list[Fraction]], error: Fraction, rate: Fraction, alpha: Fraction, decay: Fraction
    ) -> str:
        size = self.sizes
        # The matrix is over UNIT^2; gains, disturbances (rounded up), alpha and rho over UNIT.
        w = _up(size["inertia_gain"] * (size["residual"] + size["wind_gain"] * error))
        w += _up(size["reference_slope"] * rate)
        z = _up(size["lag_slope"] * rate)
        a, rho = _exactly(alpha), _exactly(decay)
        scale = lcm(*(entry.denominator for row in P for entry in row))
        whole = [[int(entry * scale) for entry in row] for row in P]
        low_gain = self.ends[1][0]
        r = _up(size["inertia_gain"] * size["residual"])
        # At an equilibrium e = zeta = 0 and G x = kappa r, so |x| <= kappa r / G.
        if low_gain <= 0 or P[2][2] * r * r >= low_gain**2:
            return "the equilibrium is not inside the set"
        for a_, g_, s_, f_, t_ in product(*self.ends):
            A = _matrix(a_, g_, s_, f_, t_, self.nu)
            H = _lyapunov(A, whole)
            if not _holds(H, whole, 2 * rho):
                return "the decay inequality fails at a corner"
            base = [[-H[i][j] - a * UNIT * whole[i][j] for j in range(3)] for i in range(3)]
            for sign in (1, -1):
                d = (w * UNIT, f_ * w + sign * z * UNIT, 0)
                Pd = [whole[i][0] * d[0] + whole[i][1] * d[1] for i in range(3)]
                if not positive_definite_integers(_bordered(base, Pd, a, scale)):
                    return "the invariance inequality fails at a corner"
        return ""


def _matrix(a: int, g: int, s: int, f: int, t: int, nu: int) -> tuple[tuple[int, ...], ...]:
    """Return the corner over UNIT^2."""
    return (
        ((a - g) * UNIT, s * UNIT, g * UNIT),
        (f * (a - g + nu), f * s - t * UNIT, f * g),
        (-nu * UNIT, 0, 0),
    )


def _lyapunov(A: tuple[tuple[int, ...], ...], P: list[list[int]]) -> list[list[int]]:
    """Return A'P + PA."""
    PA = [[sum(P[i][k] * A[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return [[PA[i][j] + PA[j][i] for j in range(3)] for i in range(3)]


def _holds(H: list[list[int]], P: list[list[int]], twice_rate: int) -> bool:
    rows = [[-H[i][j] - twice_rate * UNIT * P[i][j] for j in range(3)] for i in range(3)]
    return positive_definite_integers(rows)


def _bordered(base: list[list[int]], Pd: list[int], alpha: int, scale: int) -> list[list[int]]:
    """Return [[base, -P d], [-d'P, alpha]] over the common scale UNIT^2 times that of P."""
    rows = [[*base[i], -Pd[i]] for i in range(3)]
    return [*rows, [-Pd[0], -Pd[1], -Pd[2], alpha * UNIT * scale]]


def _scaled(value: Fraction, where: str) -> int:
    whole = value * UNIT
    if whole.denominator != 1:
        raise CertificateError(f"{where}: {float(value):.12g} has more than seven decimals")
    return int(whole)


def _exactly(value: Fraction) -> int:
    """Return the value over UNIT; refuses more than seven decimals."""
    return _scaled(value, "multiplier or decay rate")


def _up(value: Fraction) -> int:
    return -((-value * UNIT).__floor__())


def _span(ends: list[Fraction]) -> str:
    return f"{float(ends[0]):g} to {float(ends[1]):g}"


def _statement(
    claim: Any,
    plant: _Plant,
    law: _Law,
    cells: list[Any],
    inertia: list[Fraction],
    frozen: bool,
    where: str,
) -> str:
    peak = number(member(claim, "peaks", where), "speed_error", f"{where}.peaks")
    overspeed = (max(law.speed) + peak) / plant.rated_speed - 1
    decay = min(number(cell, "decay_rate", where) for cell in cells)
    errors = [number(cell, "wind_error", where) for cell in cells]
    rates = [number(cell, "wind_rate", where) for cell in cells]
    wake = "equilibrium to frozen wake" if frozen else "equilibrium wake"
    return (
        f"winds {_span([law.wind[0], law.wind[-1]])} m/s in {len(cells)} cells, inertia "
        f"{float(inertia[0]):g} to {float(inertia[1]):g} of nominal, pitch effectiveness {wake}: the "
        f"set is invariant for |v - v_s| up to {float(min(errors)):.3g} to {float(max(errors)):.3g} "
        f"m/s and |v_s'| up to {float(min(rates)):.3g} to {float(max(rates)):.3g} m/s^2; overspeed at "
        f"most {100 * float(overspeed):.2f} %; at constant wind the loop settles at no less than "
        f"{float(decay):.4g} 1/s"
    )
