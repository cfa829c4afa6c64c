"""The matrix inequalities of one wind cell, decided over integers.

Stated coefficients have seven decimals: they are integers over 10^7, corner matrices over 10^14.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import lcm

from takagi.certificates.checker.kernel.definite import positive_definite_integers
from takagi.certificates.checker.kernel.refusal import CertificateError

__all__ = ["BOUNDS", "RANGES", "Corners"]

UNIT = 10**7
RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
BOUNDS = (
    "residual",
    "wind_gain",
    "inertia_gain",
    "effectiveness_slope",
    "reference_slope",
    "lag_disturbance",
)
Integers = list[list[int]]


class Corners:
    """One cell's family: ranges of five coefficients, sizes of six more, and the integral rate."""

    def __init__(
        self,
        stated: dict[str, list[Fraction]],
        sizes: dict[str, Fraction],
        nu: Fraction,
        where: str,
    ) -> None:
        self.ends = [
            sorted({_scaled(v, f"{where}.{name}") for v in stated[name]}) for name in RANGES
        ]
        self.sizes, self.where = sizes, where
        self.nu = _scaled(nu, f"{where}.integral_rate")

    def failure(
        self,
        P: list[list[Fraction]],
        error: Fraction,
        rate: Fraction,
        alpha: Fraction,
        decay: Fraction,
    ) -> str:
        """Return the inequality that fails for P > 0 and the wind class (error, rate), or nothing.

        Raises
        ------
        CertificateError : a number with more than seven decimals.
        """
        a = _scaled(alpha, f"{self.where}.multiplier")
        rho = _scaled(decay, f"{self.where}.decay_rate")
        if not self._equilibrium_inside(P):
            return "the equilibrium is not inside the set"
        scale = lcm(*(entry.denominator for row in P for entry in row))
        whole = [[int(entry * scale) for entry in row] for row in P]
        w, z = self._disturbance(error, rate)
        for corner in product(*self.ends):
            H = _lyapunov(_matrix(corner, self.nu), whole)
            if not positive_definite_integers(_shifted(H, whole, 2 * rho)):
                return "the decay inequality fails at a corner"
        for corner in product(*self._moving_ends(rate)):
            base = _shifted(_lyapunov(_matrix(corner, self.nu), whole), whole, a)
            for sign in (1, -1) if z else (1,):
                d = (w * UNIT, corner[3] * w + sign * z * UNIT)
                Pd = [row[0] * d[0] + row[1] * d[1] for row in whole]
                if not positive_definite_integers(_bordered(base, Pd, a * UNIT * scale)):
                    return "the invariance inequality fails at a corner"
        return ""

    def settles(self, R: list[list[Fraction]], decay: Fraction) -> bool:
        """Return whether -(A'R + RA + 2 decay R) > 0 at every corner, for R > 0."""
        rho = _scaled(decay, "settling.decay_rate")
        scale = lcm(*(entry.denominator for row in R for entry in row))
        whole = [[int(entry * scale) for entry in row] for row in R]
        for corner in product(*self.ends):
            H = _lyapunov(_matrix(corner, self.nu), whole)
            if not positive_definite_integers(_shifted(H, whole, 2 * rho)):
                return False
        return True

    def _disturbance(self, error: Fraction, rate: Fraction) -> tuple[int, int]:
        """Return bounds of |w_e| and |w_zeta| over 10^7, rounded up."""
        size = self.sizes
        w = _up(size["inertia_gain"] * (size["residual"] + size["wind_gain"] * error))
        return w + _up(size["reference_slope"] * rate), _up(size["lag_disturbance"])

    def _moving_ends(self, rate: Fraction) -> list[list[int]]:
        """Return the ends with T - (b'/b) v_s', both signs of v_s', in the place of T."""
        turning = _up(self.sizes["effectiveness_slope"] * rate)
        lag = self.ends[4]
        return [*self.ends[:4], sorted({lag[0] - turning, lag[-1] + turning})]

    def _equilibrium_inside(self, P: list[list[Fraction]]) -> bool:
        """Return whether V < 1 where v is constant: e = zeta = 0 and |x| <= kappa r / Gamma."""
        low_gain = self.ends[1][0]
        r = _up(self.sizes["inertia_gain"] * self.sizes["residual"])
        return low_gain > 0 and P[2][2] * r * r < low_gain**2


def _matrix(corner: tuple[int, ...], nu: int) -> tuple[tuple[int, ...], ...]:
    """Return the matrix over 10^14 of a corner (a, G, S, f, T)."""
    a, g, s, f, t = corner
    return (
        ((a - g) * UNIT, s * UNIT, g * UNIT),
        (f * (a - g + nu), f * s - t * UNIT, f * g),
        (-nu * UNIT, 0, 0),
    )


def _lyapunov(A: tuple[tuple[int, ...], ...], P: Integers) -> Integers:
    """Return A'P + PA."""
    PA = [[sum(P[i][k] * A[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return [[PA[i][j] + PA[j][i] for j in range(3)] for i in range(3)]


def _shifted(H: Integers, P: Integers, rate: int) -> Integers:
    """Return -(H + rate P), where H is over 10^14 times the scale of P and rate over 10^7."""
    return [[-H[i][j] - rate * UNIT * P[i][j] for j in range(3)] for i in range(3)]


def _bordered(base: Integers, Pd: list[int], corner: int) -> Integers:
    """Return the lower half of [[base, -P d], [-d'P, corner]]."""
    return [*base, [-Pd[0], -Pd[1], -Pd[2], corner]]


def _scaled(value: Fraction, where: str) -> int:
    whole = value * UNIT
    if whole.denominator != 1:
        raise CertificateError(f"{where}: {float(value):.12g} has more than seven decimals")
    return int(whole)


def _up(value: Fraction) -> int:
    return -((-value * UNIT).__floor__())
