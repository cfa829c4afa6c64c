"""Regions of the complex plane that are LMIs: where the eigenvalues of a loop may lie.

A part is the set of z with  L + z M + conj(z) M' < 0,  L real symmetric, M real; a region is the
intersection of its parts.  All eigenvalues of A lie in it if and only if one P > 0 gives, for
every part,

    L (x) P + M (x) (P A) + M' (x) (A' P) < 0,

because y (x) v with A v = z v turns the left side into (v* P v) y* (L + z M + conj(z) M') y.

Source: Chilali and Gahinet (1996), IEEE Trans. Automatic Control 41(3), theorem 2.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.term import Array
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

Number: TypeAlias = float | Fraction
Rows: TypeAlias = tuple[tuple[Number, ...], ...]


@dataclass(frozen=True, slots=True)
class RegionPart:
    """{z : L + z M + conj(z) M' < 0}, with L symmetric; Fractions stay Fractions.

    Attributes
    ----------
    L, M : (k, k), as rows.
    kind : what it is, in plain words, e.g. ``"disc"``.
    name, latex : the set as a formula, in text and in LaTeX.

    Two parts with the same L and M are equal.
    """

    L: Rows
    M: Rows
    kind: str = field(compare=False)
    name: str = field(compare=False)
    latex: str = field(compare=False)

    def __post_init__(self) -> None:
        for letter in ("L", "M"):
            object.__setattr__(self, letter, _rows(letter, getattr(self, letter)))
        if len(self.L) != len(self.M):
            raise ModelError(
                f"L is {len(self.L)} x {len(self.L)}, M is {len(self.M)} x {len(self.M)}; both "
                "must be (k, k)"
            )
        if self.L != tuple(zip(*self.L, strict=True)):
            raise ModelError(f"L is not symmetric: {self.L}; give (L + L') / 2 if you mean that")

    @property
    def matrices(self) -> tuple[Array, Array]:
        """Return L and M as arrays: of Fractions if an entry is one, floats as their dyadics."""
        exact = any(isinstance(entry, Fraction) for row in (*self.L, *self.M) for entry in row)
        L, M = (np.array(matrix, dtype=object) for matrix in (self.L, self.M))
        if not exact:
            return L.astype(np.float64), M.astype(np.float64)
        as_fraction = np.vectorize(Fraction, otypes=[object])
        return as_fraction(L), as_fraction(M)

    def excess(self, z: ArrayLike) -> Floats:
        """Return the largest eigenvalue of L + z M + conj(z) M', as z has shape; < 0 inside."""
        L, M = (matrix.astype(np.float64) for matrix in self.matrices)
        points = np.asarray(z, dtype=np.complex128)[..., None, None]
        eigenvalues = np.linalg.eigvalsh(L + points * M + points.conj() * M.T)
        return np.asarray(eigenvalues[..., -1], dtype=np.float64)


@dataclass(frozen=True, slots=True, repr=False)
class EigenvalueRegion(ShortRepr):
    """Intersection of LMI regions; ``a & b`` is the intersection of two.

    Units are those of eigenvalues: 1/s for x' = A x, none for x+ = A x.  Every region is open,
    convex and symmetric about the real axis.

    Attributes
    ----------
    parts : without repetition, in an order that does not depend on how they were put together.
    """

    parts: tuple[RegionPart, ...]

    def __post_init__(self) -> None:
        if not self.parts:
            raise ModelError("a region needs at least one part; give one, or ask for nothing")
        ordered = sorted(set(self.parts), key=lambda part: (len(part.L), part.L, part.M))
        object.__setattr__(self, "parts", tuple(ordered))

    def __and__(self, other: EigenvalueRegion) -> EigenvalueRegion:
        return EigenvalueRegion(self.parts + other.parts)

    def __str__(self) -> str:
        return " and ".join(part.name for part in self.parts)

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the parts' kinds in plain words, numbered where one comes more than once."""
        kinds = [part.kind for part in self.parts]
        return tuple(
            kind if kinds.count(kind) == 1 else f"{kind} {kinds[: k + 1].count(kind)}"
            for k, kind in enumerate(kinds)
        )

    @property
    def latex(self) -> str:
        r"""Return the set in LaTeX, ``\{z \in \mathbb{C} : ...\}``."""
        inside = r",\; ".join(part.latex for part in self.parts)
        return rf"\{{z \in \mathbb{{C}} : {inside}\}}"

    def excess(self, z: ArrayLike) -> Floats:
        """Return the largest eigenvalue of all parts' L + z M + conj(z) M'; negative inside."""
        return np.asarray(np.max([part.excess(z) for part in self.parts], axis=0))

    def slowed(self, factor: float) -> EigenvalueRegion:
        """Return the region of the eigenvalues over a factor: those in another unit of time."""
        return EigenvalueRegion(
            tuple(
                replace(part, L=tuple(tuple(entry / factor for entry in row) for row in part.L))
                for part in self.parts
            )
        )

    def contains(self, z: complex) -> bool:
        """Return whether z lies in the region; on the boundary, rounding decides."""
        return bool(self.excess(z) < 0)

    @classmethod
    def half_plane(cls, decay_rate: Number) -> EigenvalueRegion:
        """Return {Re z < -alpha}, alpha = decay_rate in 1/s."""
        alpha = _real("decay_rate", decay_rate)
        return _one("half-plane", [[2 * alpha]], [[_like(alpha, 1)]], f"Re z < {_text(-alpha)}")

    @classmethod
    def vertical_strip(cls, slowest: Number, fastest: Number) -> EigenvalueRegion:
        """Return {-fastest < Re z < -slowest}, both in 1/s."""
        slow, fast = _real("slowest", slowest), _real("fastest", fastest)
        if slow >= fast:
            raise ModelError(
                f"slowest is {float(slow):g}, fastest {float(fast):g} 1/s; give slowest < fastest"
            )
        minus = -_like(fast, 1)
        half_plane_right = _one(
            "right half-plane", [[-2 * fast]], [[minus]], f"Re z > {_text(-fast)}"
        )
        return cls.half_plane(slowest) & half_plane_right

    @classmethod
    def horizontal_strip(cls, bandwidth: Number) -> EigenvalueRegion:
        """Return {|Im z| < bandwidth}, in rad/s."""
        w = _positive("bandwidth", bandwidth)
        one, zero = _like(w, 1), _like(w, 0)
        L, M = [[-2 * w, zero], [zero, -2 * w]], [[zero, one], [-one, zero]]
        return _one("horizontal strip", L, M, f"|Im z| < {_text(w)}")

    @classmethod
    def disc(cls, radius: Number, *, centre: Number = 0.0) -> EigenvalueRegion:
        """Return {|z - centre| < radius}, centre on the real axis.

        In discrete time disc(rho), rho <= 1, is |z| < rho: decay by rho in a sample.
        """
        r = _positive("radius", radius)
        c = _real("centre", centre)
        zero = _like(r, 0)
        L, M = [[-r, -c], [-c, -r]], [[zero, _like(r, 1)], [zero, zero]]
        around = "z" if c == 0 else f"z {_signed(-c)}"
        return _one("disc", L, M, f"|{around}| < {_text(r)}")

    @classmethod
    def sector(cls, half_angle: float, *, apex: Number = 0.0) -> EigenvalueRegion:
        """Return {|Im z| < tan(half_angle) (apex - Re z)}, half_angle in rad, below pi/2.

        The damping ratio of complex poles in it, with the apex at 0, is above cos(half_angle).
        """
        angle = float(_positive("half_angle", half_angle))
        if angle >= math.pi / 2:
            raise ModelError(
                f"half_angle is {angle:g} rad; it must be below pi/2: take half_plane for that"
            )
        t, a = math.tan(angle), float(_real("apex", apex))
        L, M = [[-2 * t * a, 0.0], [0.0, -2 * t * a]], [[t, 1.0], [-1.0, t]]
        return _one("sector", L, M, f"|Im z| < {_text(t)} ({_left_of(a)})")

    @classmethod
    def lmi(cls, L: ArrayLike, M: ArrayLike, *, name: str = "") -> EigenvalueRegion:
        """Return {L + z M + conj(z) M' < 0} for matrices of one's own, (k, k), L symmetric."""
        rows = _rows("L", np.asarray(L)), _rows("M", np.asarray(M))
        latex = r"L + z M + \bar z M^\top \prec 0"
        return cls((RegionPart(*rows, "LMI region", name or "L + z M + conj(z) M' < 0", latex),))


def _one(
    kind: str, L: Sequence[Sequence[Number]], M: Sequence[Sequence[Number]], name: str
) -> EigenvalueRegion:
    return EigenvalueRegion((RegionPart(_rows("L", L), _rows("M", M), kind, name, _typeset(name)),))


def _rows(letter: str, matrix: object) -> Rows:
    array = np.asarray(matrix, dtype=object)
    if array.ndim != 2 or array.shape[0] != array.shape[1] or not array.size:
        raise ModelError(f"{letter} has shape {array.shape}; a square (k, k) is needed")
    return tuple(tuple(_real(f"{letter}[{i}, {j}]", entry) for j, entry in enumerate(row))
                 for i, row in enumerate(array))  # fmt: skip


def _real(name: str, value: object) -> Number:
    if isinstance(value, Fraction):
        return value
    if not isinstance(value, (bool, str, complex)):
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            number = math.nan
        if math.isfinite(number):
            return number
    raise ModelError(f"{name} of a region is {value!r}; a finite real number is needed")


def _positive(name: str, value: object) -> Number:
    number = _real(name, value)
    if number <= 0:
        raise ModelError(f"{name} of a region is {float(number):g}; it must be positive")
    return number


def _like(number: Number, value: int) -> Number:
    """Return the value as a Fraction or as a float, like the given number."""
    return Fraction(value) if isinstance(number, Fraction) else float(value)


def _text(number: Number) -> str:
    return f"{float(number) + 0.0:.6g}"


def _signed(number: Number) -> str:
    return f"{'-' if number < 0 else '+'} {_text(max(number, -number))}"


def _left_of(apex: float) -> str:
    return "-Re z" if apex == 0 else f"{_text(apex)} - Re z"


def _typeset(name: str) -> str:
    for plain, written in (("Re z", r"\operatorname{Re} z"), ("Im z", r"\operatorname{Im} z")):
        name = name.replace(plain, written)
    return name
