"""The matrix inequalities of one wind cell, over integers.

Stated coefficients have seven decimals: they are integers over 10^7, corner matrices over 10^14.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, positive
from takagi.certificates.checker.kernel.reader import number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError

UNIT = 10**7
RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
SLOPES = ("effectiveness_slope", "reference_slope")
BOUNDS = ("residual", "wind_gain", "inertia_gain", *SLOPES, "lag_disturbance")
NODES = ("wind", "effectiveness_limit")
CLASS = ("integral_rate", "wind_error", "wind_rate", "multiplier", "decay_rate")
Integers = list[list[int]]


@dataclass(frozen=True)
class Stated:
    """One wind cell as a claim states it: ranges of its winds, of the wake's pitch effectiveness
    and of five coefficients, and single numbers.
    """

    ranges: dict[str, list[Fraction]]
    sizes: dict[str, Fraction]
    where: str

    @classmethod
    def read(cls, cell: Any, where: str) -> Stated:
        """Return the cell."""
        ranges = {name: numbers(cell, name, where, 2) for name in (*NODES, *RANGES)}
        sizes = {name: number(cell, name, where) for name in (*BOUNDS, *CLASS)}
        return cls(ranges, sizes, where)

    @property
    def drift(self) -> Fraction:
        """Bound of |w_e| but for the schedule wind's rate: kappa (r + g wind_error)."""
        size = self.sizes
        return size["inertia_gain"] * (size["residual"] + size["wind_gain"] * size["wind_error"])


class Corners:
    """The matrices of one cell: every corner of the ranges, in integers.

    Raises
    ------
    CertificateError : a number with more than seven decimals.
    """

    def __init__(self, stated: Stated) -> None:
        sizes, where = stated.sizes, stated.where
        self.ends = [
            sorted({_scaled(v, f"{where}.{name}") for v in stated.ranges[name]}) for name in RANGES
        ]
        self.nu, self.alpha, self.rho = (
            _scaled(sizes[name], f"{where}.{name}")
            for name in ("integral_rate", "multiplier", "decay_rate")
        )
        rate = sizes["wind_rate"]
        self.residual = _up(sizes["inertia_gain"] * sizes["residual"])
        # Bounds of |w_e| and |w_zeta|, rounded up.
        self.w = _up(stated.drift) + _up(sizes["reference_slope"] * rate)
        self.z = _up(sizes["lag_disturbance"])
        # With T - (b'/b) v_s', both signs of v_s', in the place of T.
        turning, lag = _up(sizes["effectiveness_slope"] * rate), self.ends[4]
        self.moving_ends = [*self.ends[:4], sorted({lag[0] - turning, lag[-1] + turning})]

    def obligations(self, P: Matrix) -> Obligations:
        """Yield the inequalities of the cell, for P > 0."""
        # Where v is constant the rest has e = zeta = 0 and |x| <= kappa r / Gamma.
        low_gain, outside = self.ends[1][0], "the equilibrium is not inside the set"
        yield positive(low_gain, outside)
        yield positive(low_gain**2 - P[2, 2] * self.residual**2, outside)
        whole, scale = P.rows, P.below
        yield from self._decay(whole, self.rho, "the decay inequality fails at a corner")
        for corner in product(*self.moving_ends):
            base = _shifted(_matrix(corner, self.nu), whole, self.alpha)
            # d and -d give congruent matrices, so of the four sign pairs of w_e and w_zeta two
            # suffice.
            for sign in (1, -1) if self.z else (1,):
                d = (self.w * UNIT, corner[3] * self.w + sign * self.z * UNIT)
                border = [-(row[0] * d[0] + row[1] * d[1]) for row in whole]
                rows = [[*row, edge] for row, edge in zip(base, border, strict=True)]
                matrix = Matrix([*rows, [*border, self.alpha * UNIT * scale]])
                yield positive(matrix, "the invariance inequality fails at a corner")

    def settling(self, R: Matrix, decay: Fraction) -> Obligations:
        """Yield -(A'R + RA + 2 decay R) > 0 at every corner, for R > 0."""
        rate = _scaled(decay, "settling.decay_rate")
        failure = "the common decay inequality fails at a corner"
        return self._decay(R.rows, rate, failure)

    def _decay(self, P: Integers, rho: int, failure: str) -> Obligations:
        for corner in product(*self.ends):
            yield positive(Matrix(_shifted(_matrix(corner, self.nu), P, 2 * rho)), failure)


def _matrix(corner: tuple[int, ...], nu: int) -> tuple[tuple[int, ...], ...]:
    """Return the matrix over 10^14 of a corner (a, G, S, f, T)."""
    a, g, s, f, t = corner
    return (
        ((a - g) * UNIT, s * UNIT, g * UNIT),
        (f * (a - g + nu), f * s - t * UNIT, f * g),
        (-nu * UNIT, 0, 0),
    )


def _shifted(A: tuple[tuple[int, ...], ...], P: Integers, rate: int) -> Integers:
    """Return -(A'P + PA + rate P), where A is over 10^14, rate over 10^7."""
    PA = [[sum(P[i][k] * A[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    shift = rate * UNIT
    return [[-(PA[i][j] + PA[j][i] + shift * P[i][j]) for j in range(3)] for i in range(3)]


def _scaled(value: Fraction, where: str) -> int:
    whole = value * UNIT
    if whole.denominator != 1:
        raise CertificateError(f"{where}: {float(value):.12g} has more than seven decimals")
    return int(whole)


def _up(value: Fraction) -> int:
    return -((-value * UNIT).__floor__())
