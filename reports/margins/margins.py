"""Gain, phase, delay and disk margins, and the sensitivity peak of one loop.

    gain    factors g with 1 + g L(j omega) = 0: g = -1 / L where L is real and negative
    phase   |arg(-L)| where |L| = 1, the smallest over all such frequencies
    delay   (arg L + pi mod 2 pi) / omega there, the smallest
    M_s     sup |S| with S = 1/(1 + L)

Source: Astrom & Murray (2008), Feedback Systems, sec. 9.3; Skogestad & Postlethwaite (2005),
Multivariable Feedback Control, sec. 2.4.

The disk margin is how far gain and phase of a loop may move together.  The factor
f = (1 + (alpha/2) delta) / (1 - (alpha/2) delta), |delta| <= 1, in every loop leaves it stable
exactly while alpha is below

    alpha_max = 1 / sup_omega mu(S - I/2) = 2 / sup_omega mu(S - T)

with mu over diagonal complex delta.  For one loop mu is the modulus.  From alpha follow a gain
margin ((2 - alpha)/(2 + alpha), (2 + alpha)/(2 - alpha)) and a phase margin 2 atan(alpha/2).

Source: Seiler, Packard, Gahinet (2020), An Introduction to Disk Margins, IEEE Control Systems
Magazine 40(5), with skew 0; Packard & Doyle (1993), The complex structured singular value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.reports.margins.response import LoopResponse, largest


@dataclass(frozen=True, slots=True)
class DiskMargin:
    """The largest symmetric disk of gain and phase variation a loop survives.

    Attributes
    ----------
    alpha : size of the disk [-]; 0 for an unstable loop, 2 at most where L vanishes at high
        frequency.
    frequency : where it is smallest [rad/s]; inf where that is the high-frequency limit.
    """

    alpha: float
    frequency: float

    @property
    def gain_decrease(self) -> float:
        """Gain factor guaranteed tolerable downwards, max(0, (2 - alpha)/(2 + alpha)) [-]."""
        return max(0.0, (2 - self.alpha) / (2 + self.alpha)) if np.isfinite(self.alpha) else 0.0

    @property
    def gain_increase(self) -> float:
        """Gain factor guaranteed tolerable upwards, (2 + alpha)/(2 - alpha), inf from 2 on [-]."""
        return (2 + self.alpha) / (2 - self.alpha) if self.alpha < 2 else float("inf")

    @property
    def phase(self) -> float:
        """Phase guaranteed tolerable either way, 2 atan(alpha/2) [rad]."""
        return float(2 * np.arctan(self.alpha / 2))


def disk_of(response: LoopResponse) -> DiskMargin:
    """Return the disk margin of one loop, or of two perturbed at once and independently."""
    if not response.stable:
        return DiskMargin(alpha=0.0, frequency=float("nan"))

    def height(loops: Complex) -> Floats:
        eye = np.eye(loops.shape[1])
        centred = np.asarray(np.linalg.inv(eye + loops) - eye / 2, dtype=np.complex128)
        return np.abs(centred[:, 0, 0]) if len(eye) == 1 else scaled_bound(centred)

    peak, frequency = largest(height, response)
    return DiskMargin(alpha=1 / peak if peak > 0 else float("inf"), frequency=frequency)


def scaled_bound(matrices: Complex) -> Floats:
    """Return mu over diagonal complex delta, min_D sigma_max(D M D^-1), of matrices (k, 2, 2).

    The scaling d^2 = |m21| / |m12| is optimal, since sigma_1 sigma_2 = |det M| does not depend on d
    while sigma_1^2 + sigma_2^2 is smallest there, and the bound equals mu.

    Source: Packard & Doyle (1993), sec. 5 (three blocks or fewer: equality).
    """
    m = matrices
    assert m.shape[1:] == (2, 2)
    square = np.abs(m[:, 0, 0]) ** 2 + np.abs(m[:, 1, 1]) ** 2
    square = square + 2 * np.abs(m[:, 0, 1] * m[:, 1, 0])
    product = np.abs(m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] * m[:, 1, 0])
    root = np.sqrt(np.maximum(square**2 - 4 * product**2, 0.0))
    return np.asarray(np.sqrt((square + root) / 2), dtype=np.float64)


INF, NAN = float("inf"), float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """The margins of one loop. For an unstable closed loop all margins are 0.

    Attributes
    ----------
    stable : of the closed loop.
    gain_decrease, gain_increase : factors below and above 1 at which it becomes unstable [-];
        0 and inf where there is none.
    gain_increase_frequency : where L is negative real there [rad/s]; nan where there is none.
    phase : smallest phase margin [rad]; inf where |L| never is 1.
    phase_frequency : where it is found [rad/s]; nan where there is none.
    delay : smallest delay that makes it unstable [s]; inf where |L| never is 1.
    crossovers : all frequencies with |L| = 1, increasing [rad/s].
    sensitivity_peak : M_s [-]; inf for an unstable loop.
    disk : symmetric disk margin.
    """

    stable: bool
    gain_decrease: float
    gain_increase: float
    gain_increase_frequency: float
    phase: float
    phase_frequency: float
    delay: float
    crossovers: tuple[float, ...]
    sensitivity_peak: float
    disk: DiskMargin

    @property
    def gain(self) -> float:
        """The factor by which the gain may both grow and fall [-]; 1 for an unstable loop."""
        return min(self.gain_increase, 1 / self.gain_decrease if self.gain_decrease > 0 else INF)

    @property
    def crossover(self) -> float:
        """The highest frequency with |L| = 1 [rad/s]; nan where there is none."""
        return self.crossovers[-1] if self.crossovers else NAN


def loop_margins(response: LoopResponse) -> Margins:
    """Return the margins of one loop L under negative feedback.

    Frequencies are found on a grid made from the open- and closed-loop poles and refined by
    root finding; a crossing pair closer than the grid (1.5 %, finer at lightly damped modes) could
    be missed.
    """
    crossovers = _roots(response, lambda L: np.log(np.maximum(np.abs(L), 1e-300)))
    there = [(w, _loop_at(response, w)) for w in crossovers]
    phase, where = min(((abs(float(np.angle(-L))), w) for w, L in there), default=(INF, NAN))
    lags = [float((np.angle(L) + np.pi) % (2 * np.pi)) / w for w, L in there]
    factors, stable = _gain_factors(response), response.stable
    increase, phase_crossover = min(((g, w) for g, w in factors if g > 1), default=(INF, NAN))
    peak, _ = largest(lambda L: np.asarray(1 / np.abs(1 + L[:, 0, 0]), np.float64), response)
    return Margins(
        stable=stable,
        gain_decrease=max((g for g, _ in factors if g < 1), default=0.0) if stable else 1.0,
        gain_increase=increase if stable else 1.0,
        gain_increase_frequency=phase_crossover,
        phase=phase if stable else 0.0,
        phase_frequency=where,
        delay=min(lags, default=INF) if stable else 0.0,
        crossovers=tuple(crossovers),
        sensitivity_peak=peak if stable else INF,
        disk=disk_of(response),
    )


def _loop_at(response: LoopResponse, omega: float) -> complex:
    return complex(response.evaluate(np.array([omega]))[0, 0, 0])


def _roots(response: LoopResponse, level: Callable[[Complex], Floats]) -> list[float]:
    """Return the frequencies at which a real function of L changes sign [rad/s], increasing."""
    from scipy.optimize import brentq

    grid, sampled = response.frequencies, level(response.values[:, 0, 0])
    roots = [float(w) for w in grid[(sampled == 0.0) & (grid > 0)]]

    def at(w: float) -> float:
        return float(level(response.evaluate(np.array([w]))[:, 0, 0])[0])

    for k in np.flatnonzero(sampled[:-1] * sampled[1:] < 0):
        # A sign that is rounding may be another one where the frequency is evaluated alone.
        if at(grid[k]) * at(grid[k + 1]) < 0:
            roots.append(float(brentq(at, grid[k], grid[k + 1], xtol=1e-14, rtol=1e-12)))
    return sorted(roots)


def _gain_factors(response: LoopResponse) -> list[tuple[float, float]]:
    """Return (g, omega) with g L(j omega) = -1, the ends 0 and infinity included."""
    # A loop that is real at all frequencies has no isolated crossing; only its ends matter.
    roots = _roots(response, lambda L: np.asarray(L.imag, dtype=np.float64))
    crossings = [(w, _loop_at(response, w)) for w in roots]
    # At a jump of a lightly damped pole the sign changes without L being real.
    crossings = [(w, L) for w, L in crossings if abs(L.imag) < 1e-6 * abs(L)]
    if response.frequencies[0] == 0.0:
        crossings.append((0.0, complex(response.values[0, 0, 0])))
    if response.at_infinity is not None:
        crossings.append((response.end, complex(response.at_infinity[0, 0])))
    return [(-1 / L.real, w) for w, L in crossings if L.real < 0]
