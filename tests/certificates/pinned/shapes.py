"""Short names for what the pinned expressions are about."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace as parts
from typing import Any

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.exponential import FINE
from takagi.certificates.checker.arithmetic.interval import Interval, enclose
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.checker.kernel.reader import Number, digest

__all__ = ["dual", "fine", "fractions", "hashed", "num", "parts", "span", "surface"]


def fine(value: str) -> int:
    """Return a number over 10^48, rounded down."""
    exact = Fraction(value)
    return exact.numerator * FINE // exact.denominator


def fractions(written: str) -> list[Fraction]:
    """Return the numbers of a text."""
    return [Fraction(word) for word in written.split()]


def span(low: str, high: str | None = None) -> Interval:
    """Return the interval of numbers from low to high, or of one number."""
    return enclose(Fraction(low), Fraction(high if high is not None else low))


def dual(value: tuple[str, str], *slopes: tuple[str, str]) -> Dual:
    """Return a quantity with its slopes."""
    return Dual(span(*value), tuple(span(*slope) for slope in slopes))


def surface(kind: str = "wavy") -> Spline:
    """Return a spline of two arguments over [0, 3] and [-1, 1].

    ``wavy`` : cells of three widths, and coefficients without symmetry; ``thirds`` : knots that
    are not decimals; ``steep`` : coefficients that leave the size that is bounded.
    """
    inner = {"wavy": "0.5 1.75", "thirds": "1/3 2/3", "steep": "0.001"}[kind]
    x = fractions(f"0 0 0 0 {inner} 3 3 3 3")
    y = fractions("-1 -1 -1 -1 0.25 1 1 1 1")
    size = 900 if kind == "steep" else 1
    rows = [
        [size * (Fraction((7 * i * i + 3 * j * i + 5 * j) % 11, 7) - (i == j)) for j in range(5)]
        for i in range(len(x) - 4)
    ]
    return Spline(x, y, rows)


def num(written: str) -> Number:
    """Return a number as the reader of files has it."""
    return Number(written)


def hashed(document: dict[str, Any], **others: str | None) -> dict[str, Any]:
    """Return a certificate with the hashes of its parts, but for those named: None is none."""
    parts = [p for p in ("model", "gains", "claims", "controller") if p in document]
    hashes: dict[str, str] = {part: digest(document[part]) for part in parts}
    for part, value in others.items():
        if value is None:
            del hashes[part]
        else:
            hashes[part] = value
    return {**document, "provenance": {"sha256": hashes}}
