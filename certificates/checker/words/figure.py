"""Proved numbers of a claim, with units: what reports show, and what two certificates compare."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Figure:
    """One number; ``value`` is None where there is no bound.

    ``larger`` : whether a larger value is the stronger claim.
    ``span`` : the reference of a relative change; None for the number itself.
    """

    name: str
    unit: str
    value: Fraction | None
    larger: bool = True
    span: Fraction | None = None


@dataclass(frozen=True, slots=True)
class WindProfile:
    """A number for each span (low, high, value) of winds [m/s]; larger is stronger."""

    name: str
    unit: str
    spans: tuple[tuple[Fraction, Fraction, Fraction], ...]


Figures = tuple[Figure | WindProfile, ...]
