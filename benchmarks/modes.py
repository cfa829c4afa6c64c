"""Loops of modes in disguise: decoupled scalar motions, in other states of other sizes.

    A = S T diag(a_i) T^-1 S^-1,   E = S T diag(b_i),   C = diag(c_i) T^-1 S^-1

with T of integers, as its inverse is, and S of powers of ten: all entries are decimals, and closed
forms of the modes stay true of the loop.  P = S^-1 T^-T diag(p_i) T^-1 S^-1 is the sum p_i z_i^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from exact_truth import Rows, diagonal, inverse, times, transposed
from known_loops import Random, unimodular

from takagi.certificates.checker.kernel.reader import Number

Data = dict[str, Any]
TINY = ("0", "1e-25", "1e-15", "1e-12", "1e-9", "1e-6", "1e-3")
LONGEST = 58


class TooLong(ValueError):
    """A number that a certificate cannot hold."""


class Known(NamedTuple):
    """A claim about a loop, whether it is true, and whether its evidence is the best there is."""

    model: Data
    gains: Data | None
    claim: Data
    truth: bool
    fits: bool = True


@dataclass(frozen=True)
class Disguise:
    """The change of states X = S T."""

    X: Rows
    back: Rows

    @classmethod
    def draw(cls, rng: Random, n: int) -> Disguise:
        T, inverted = unimodular(rng, n)
        sizes = [Fraction(10) ** int(k) for k in rng.integers(-8, 9, size=n)]
        if rng.random() < 0.5:
            sizes = [Fraction(1)] * n
        S = diagonal(sizes)
        return cls(times(S, T), times(inverted, inverse(S)))

    def loop(self, block: Rows) -> Rows:
        return times(times(self.X, block), self.back)

    def entering(self, block: Rows) -> Rows:
        return times(self.X, block)

    def leaving(self, block: Rows) -> Rows:
        return times(block, self.back)

    def function(self, weights: Sequence[Fraction]) -> Rows:
        return times(times(transposed(self.back), diagonal(weights)), self.back)


def beside(rng: Random, value: Fraction) -> Fraction:
    """Return the value, or a hair to either side, as a decimal."""
    tiny = Fraction(str(rng.choice(TINY))) * int(rng.choice((-1, 1)))
    return short(value * (1 + tiny))


def short(value: Fraction, digits: int = 45) -> Fraction:
    """Return the nearest decimal of this many significant digits."""
    if value == 0:
        return value
    places = digits - len(str(int(abs(value)))) if abs(value) >= 1 else digits
    return Fraction(round(value * 10**places), 10**places)


def some(rng: Random, low: int = 1, high: int = 400) -> Fraction:
    """Return a random decimal of two places, positive for the defaults."""
    return Fraction(int(rng.integers(low, high)), 100)


def model_of(A: Sequence[Rows], step: Fraction | None = None, **others: Any) -> Data:
    """Return a model of kind ``takagi-sugeno`` as plain data."""
    names = [f"x{k}" for k in range(len(A[0]))]
    return {
        "kind": "takagi-sugeno",
        "sample_time": step,
        "state_names": names,
        "A": list(A),
        **others,
    }


def law_of(K: Sequence[Rows], step: Fraction | None = None) -> Data:
    """Return the law u = -sum_j h_j K_j x as plain data."""
    names = [f"x{k}" for k in range(len(K[0][0]))]
    return {"name": "pdc", "sample_time": step, "state_names": names, "K": list(K)}


def claim_of(kind: str, **evidence: Any) -> Data:
    return {"name": kind, "kind": kind, **evidence}


def as_read(value: Any) -> Any:
    """Return plain data as the checker's reader hands it on: numbers are the text of decimals."""
    if isinstance(value, Mapping):
        return {key: as_read(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_read(item) for item in value]
    if isinstance(value, (Fraction, int)) and not isinstance(value, bool):
        return Number(written(Fraction(value)))
    return value


def written(value: Fraction) -> str:
    """Return a decimal fraction exactly.

    Raises
    ------
    TooLong : it is not a decimal fraction, or a longer one than the reader takes.
    """
    places, scaled = 0, value
    while scaled.denominator != 1:
        scaled *= 10
        places += 1
        if places > 300:
            raise TooLong(f"{value} is no short decimal")
    digits = str(abs(scaled.numerator))
    sign = "-" if value < 0 else ""
    text = f"{sign}{digits[0]}.{digits[1:] or '0'}e{len(digits) - 1 - places}"
    if len(text) > LONGEST:
        raise TooLong(f"{value} has too many digits")
    return text


def functions(rng: Random, best: Rows, *, scaled_fits: bool = True) -> list[tuple[Rows, bool]]:
    """Return P's to be thrown at the checker, and whether each is as good as the best.

    The best one, scaled by a power of two, moved a little, turned round, made unsymmetric or
    indefinite, the identity, and a random one.
    """
    n = len(best)
    zero = [[Fraction(0)] * n for _ in range(n)]
    power = Fraction(2) ** int(rng.integers(0, 6))
    scaled = [[entry * power for entry in row] for row in best]
    moved = [list(row) for row in best]
    i = int(rng.integers(n))
    moved[i][i] *= 1 + Fraction(int(rng.integers(-5, 6)), 1000)
    negative = [[-entry for entry in row] for row in best]
    lopsided = [list(row) for row in best]
    if n > 1:
        lopsided[0][1] += Fraction(1, 1000)
    indefinite = [list(row) for row in best]
    indefinite[i][i] *= -1
    one = diagonal([Fraction(1)] * n)
    factor = [[Fraction(int(v)) for v in row] for row in rng.integers(-3, 4, size=(n, n))]
    anyone = times(factor, transposed(factor))
    found = [(best, True), (scaled, scaled_fits)]
    return found + [(P, False) for P in (moved, negative, lopsided, indefinite, one, anyone, zero)]


def signs(rng: Random, n: int) -> list[Fraction]:
    return [Fraction(int(s)) for s in np.where(rng.random(n) < 0.5, -1, 1)]
