r"""Symmetric disk margins: how far gain and phase of a loop may move together.

The factor f = (1 + (alpha/2) delta) / (1 - (alpha/2) delta), |delta| <= 1, in every loop leaves it
stable exactly while alpha is below

    alpha_max = 1 / sup_omega mu(S - I/2) = 2 / sup_omega mu(S - T)

with mu over diagonal complex delta.  For one loop mu is the modulus.  From alpha follow a gain
margin ((2 - alpha)/(2 + alpha), (2 + alpha)/(2 - alpha)) and a phase margin 2 atan(alpha/2).

Source: Seiler, Packard, Gahinet (2020), An Introduction to Disk Margins, IEEE Control Systems
Magazine 40(5), with skew 0; Packard & Doyle (1993), The complex structured singular value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.reports.margins.response import LoopResponse, largest, loop_response

if TYPE_CHECKING:
    from control import FrequencyResponseData, StateSpace, TransferFunction

# Balancing rows and columns converges in a few sweeps; each sweep leaves a valid upper bound.
SWEEPS = 12


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


def disk_margin(
    loop: StateSpace | TransferFunction | FrequencyResponseData | LoopResponse,
) -> DiskMargin:
    """Return alpha_max = 1 / sup |S - 1/2| of one loop.

    For a sampled response the figure presumes a stable closed loop, which samples cannot show.

    Raises
    ------
    ModelError : the loop is not single-input single-output (or what ``loop_response`` refuses).
    """
    response = loop_response(loop)
    size = response.evaluate(response.frequencies[-1:]).shape[1]
    if size != 1:
        raise ModelError(
            f"the loop is {size} x {size}; disk_margin takes one loop, disk_of several"
        )
    return _smallest(response, lambda m: np.abs(m[:, 0, 0]))


def disk_of(response: LoopResponse) -> DiskMargin:
    """Return the disk margin of all loops of a response, perturbed at once and independently.

    From an upper bound of mu, so it never promises too much; exact for up to two loops.
    """
    return _smallest(response, scaled_bound)


def scaled_bound(matrices: Complex) -> Floats:
    """Return an upper bound of mu over diagonal complex delta: min_D sigma_max(D M D^-1).

    For 2 x 2 the scaling d^2 = |m21| / |m12| is optimal, since sigma_1 sigma_2 = |det M| does not
    depend on d while sigma_1^2 + sigma_2^2 is smallest there, and the bound equals mu.  Larger
    matrices are balanced by Osborne's sweeps: still a bound, not always the smallest.

    Parameters
    ----------
    matrices : (k, m, m).

    Source: Packard & Doyle (1993), sec. 5 (three blocks or fewer: equality); Osborne (1960).
    """
    size = matrices.shape[1]
    if size == 1:
        return np.asarray(np.abs(matrices[:, 0, 0]), dtype=np.float64)
    if size == 2:
        return _two_by_two(matrices)
    scaled = matrices.copy()
    off = ~np.eye(size, dtype=bool)
    for _ in range(SWEEPS):
        for i in range(size):
            row = np.linalg.norm(np.where(off[i], scaled[:, i, :], 0), axis=1)
            column = np.linalg.norm(np.where(off[i], scaled[:, :, i], 0), axis=1)
            ratio = np.sqrt(np.divide(column, row, out=np.ones_like(row), where=row * column > 0))
            scaled[:, i, :] *= ratio[:, None]
            scaled[:, :, i] /= ratio[:, None]
    return np.asarray(np.linalg.norm(scaled, ord=2, axis=(1, 2)), dtype=np.float64)


def _two_by_two(m: Complex) -> Floats:
    """Return the least norm over diagonal scalings; the best one makes |m_01| and |m_10| equal."""
    square = np.abs(m[:, 0, 0]) ** 2 + np.abs(m[:, 1, 1]) ** 2
    square = square + 2 * np.abs(m[:, 0, 1] * m[:, 1, 0])
    product = np.abs(m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] * m[:, 1, 0])
    root = np.sqrt(np.maximum(square**2 - 4 * product**2, 0.0))
    return np.asarray(np.sqrt((square + root) / 2), dtype=np.float64)


def _smallest(response: LoopResponse, measure: Callable[[Complex], Floats]) -> DiskMargin:
    if response.stable is False:
        return DiskMargin(alpha=0.0, frequency=float("nan"))

    def height(omega: Floats) -> Floats:
        return np.asarray(measure(_centred(response.evaluate(omega))), dtype=np.float64)

    end = None
    if response.at_infinity is not None:
        end = float(measure(_centred(response.at_infinity[None]))[0])
    peak, frequency = largest(height, response, end)
    return DiskMargin(alpha=1 / peak if peak > 0 else float("inf"), frequency=frequency)


def _centred(loops: Complex) -> Complex:
    """Return S - I/2 for a stack of loops."""
    eye = np.eye(loops.shape[1])
    return np.asarray(np.linalg.inv(eye + loops) - eye / 2, dtype=np.complex128)
