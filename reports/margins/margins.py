"""Gain, phase, delay and disk margins, sensitivity peaks and bandwidth of one loop.

    gain    factors g with 1 + g L(j omega) = 0: g = -1 / L where L is real and negative
    phase   |arg(-L)| where |L| = 1, the smallest over all such frequencies
    delay   (arg L + pi mod 2 pi) / omega there, the smallest
    M_s, M_t   sup |S|, sup |T| with S = 1/(1 + L), T = 1 - S
    bandwidth  the lowest frequency at which |S| reaches 1/sqrt 2

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

    end = response.at_infinity
    at_end = None if end is None else float(height(end[None])[0])
    peak, frequency = largest(height, response, at_end)
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


INF = float("inf")


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """The margins of one loop. For an unstable closed loop all margins are 0.

    stable : of the closed loop.
    gain_decrease, gain_increase : factors below and above 1 at which it becomes unstable [-];
        0 and inf where there is none.
    gain_decrease_frequency, gain_increase_frequency : where L is negative real there [rad/s];
        nan where there is none.
    phase : smallest phase margin [rad]; inf where |L| never is 1.
    phase_frequency : where it is found [rad/s]; nan where there is none.
    delay : smallest delay that makes it unstable [s]; inf where |L| never is 1.
    crossovers : all frequencies with |L| = 1, increasing [rad/s].
    bandwidth : lowest frequency with |S| = 1/sqrt 2 from below [rad/s]; 0 where |S| starts above.
    sensitivity_peak, complementary_peak : M_s and M_t [-]; inf for an unstable loop.
    sensitivity_peak_frequency, complementary_peak_frequency : [rad/s].
    disk : symmetric disk margin.
    """

    stable: bool
    gain_decrease: float
    gain_increase: float
    gain_decrease_frequency: float
    gain_increase_frequency: float
    phase: float
    phase_frequency: float
    delay: float
    crossovers: tuple[float, ...]
    bandwidth: float
    sensitivity_peak: float
    sensitivity_peak_frequency: float
    complementary_peak: float
    complementary_peak_frequency: float
    disk: DiskMargin

    @property
    def gain(self) -> float:
        """The factor by which the gain may both grow and fall [-]; 1 for an unstable loop."""
        return min(self.gain_increase, 1 / self.gain_decrease if self.gain_decrease > 0 else INF)

    @property
    def crossover(self) -> float:
        """The highest frequency with |L| = 1 [rad/s]; nan where there is none."""
        return self.crossovers[-1] if self.crossovers else float("nan")


def loop_margins(response: LoopResponse) -> Margins:
    """Return the margins of one loop L under negative feedback.

    Frequencies are found on a grid made from the open- and closed-loop poles and refined by
    root finding; a crossing pair closer than the grid (1.5 %, finer at lightly damped modes) could
    be missed.
    """
    scalar = _Scalar(response, response.values[:, 0, 0])
    crossovers = _roots(scalar, lambda L: np.log(np.maximum(np.abs(L), 1e-300)))
    factors = _gain_factors(scalar)
    peaks = _peaks(response)
    unstable = not response.stable
    below = max(((g, w) for g, w in factors if g < 1), default=(0.0, float("nan")))
    above = min(((g, w) for g, w in factors if g > 1), default=(INF, float("nan")))
    phase = _phase(scalar, crossovers)
    return Margins(
        stable=response.stable,
        gain_decrease=1.0 if unstable else below[0],
        gain_increase=1.0 if unstable else above[0],
        gain_decrease_frequency=below[1],
        gain_increase_frequency=above[1],
        phase=0.0 if unstable else phase[0],
        phase_frequency=phase[1],
        delay=0.0 if unstable else _delay(scalar, crossovers),
        crossovers=tuple(crossovers),
        bandwidth=_bandwidth(scalar),
        sensitivity_peak=INF if unstable else peaks[0][0],
        sensitivity_peak_frequency=peaks[0][1],
        complementary_peak=INF if unstable else peaks[1][0],
        complementary_peak_frequency=peaks[1][1],
        disk=disk_of(response),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Scalar:
    response: LoopResponse
    values: Complex

    def __call__(self, omega: float) -> Complex:
        return self.response.evaluate(np.array([omega]))[:, 0, 0]


def _roots(scalar: _Scalar, level: Callable[[Complex], Floats]) -> list[float]:
    """Return the frequencies at which a real function of L changes sign [rad/s], increasing."""
    from scipy.optimize import brentq

    grid, sampled = scalar.response.frequencies, level(scalar.values)
    found = [float(w) for w, value in zip(grid, sampled, strict=True) if value == 0.0 and w > 0]

    def at(w: float) -> float:
        return float(level(scalar(w))[0])

    for k in np.flatnonzero(sampled[:-1] * sampled[1:] < 0):
        # A sign that is rounding may be another one where the frequency is evaluated alone.
        if at(grid[k]) * at(grid[k + 1]) < 0:
            found.append(float(brentq(at, grid[k], grid[k + 1], xtol=1e-14, rtol=1e-12)))
    return sorted(found)


def _gain_factors(scalar: _Scalar) -> list[tuple[float, float]]:
    """Return (g, omega) with g L(j omega) = -1, the ends 0 and infinity included."""
    found = []
    # A loop that is real at all frequencies has no isolated crossing; only its ends matter.
    for w in _roots(scalar, lambda L: np.asarray(L.imag, dtype=np.float64)):
        value = scalar(w)[0]
        # At a jump of a lightly damped pole the sign changes without L being real.
        if value.real < 0 and abs(value.imag) < 1e-6 * abs(value):
            found.append((float(-1 / value.real), w))
    if scalar.response.frequencies[0] == 0.0 and scalar.values[0].real < 0:
        found.append((float(-1 / scalar.values[0].real), 0.0))
    end = scalar.response.at_infinity
    if end is not None and end[0, 0].real < 0:
        found.append((float(-1 / end[0, 0].real), scalar.response.end))
    return found


def _phase(scalar: _Scalar, crossovers: list[float]) -> tuple[float, float]:
    sizes = [(abs(float(np.angle(-scalar(w)[0]))), w) for w in crossovers]
    return min(sizes, default=(INF, float("nan")))


def _delay(scalar: _Scalar, crossovers: list[float]) -> float:
    lags = [float((np.angle(scalar(w)[0]) + np.pi) % (2 * np.pi)) / w for w in crossovers]
    return min(lags, default=INF)


def _bandwidth(scalar: _Scalar) -> float:
    def excess(L: Complex) -> Floats:
        return np.asarray(0.5 - np.abs(1 + L) ** -2.0, dtype=np.float64)

    if excess(scalar.values[:1])[0] <= 0:
        return 0.0
    return next(iter(_roots(scalar, excess)), INF)


def _peaks(response: LoopResponse) -> tuple[tuple[float, float], tuple[float, float]]:
    def sensitivity(L: Complex) -> Floats:
        return np.asarray(1 / np.abs(1 + L), dtype=np.float64)

    def complementary(L: Complex) -> Floats:
        return np.asarray(np.abs(L / (1 + L)), dtype=np.float64)

    def peak(of: Callable[[Complex], Floats]) -> tuple[float, float]:
        end = response.at_infinity
        limit = None if end is None else float(of(end[0])[0])
        return largest(lambda L: of(L[:, 0, 0]), response, limit)

    return peak(sensitivity), peak(complementary)
