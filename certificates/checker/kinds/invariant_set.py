r"""An ellipsoid {x'Px <= c} that no solution of the loop leaves, with and without disturbance.

Let V = x'Px with P > 0, c > 0 the level, and s > 0 a multiplier (in 1/s; in discrete time a number
per sample, at most 1).  F, G, H are the matrices of V' (or V(x+) - V) = -x'Fx + 2 x'Gw + w'Hw; at a
corner w of the box |w_k| <= b_k the column E w takes the place of E, so that G is a column and H a
number.  The conditions for every blend are:

    no disturbance       F - s P >= 0
    |w_k| <= b_k         [ F - s P   -G      ]
    at each corner w     [ .         s c - H ]  >= 0
    |w|_2 <= b           [ F - s P   -b G           ]
                         [ .         s c I - b^2 H  ]  >= 0

Each gives V' <= s (c - V), or V(x+) - V <= s (c - V) (with c = 0 if there is no disturbance).  So V
does not rise above c once it is below; while it is above, V - c decays as e^(-s t), or (1 - s)^k.
The left sides are concave in (A, E w), so that corners and blends suffice, however fast weights and
w change.

The set may touch the box: V' <= 0 on its whole boundary keeps every solution inside (Nagumo), if
the solutions of the plant are unique.

Evidence: ``P``, ``level``, ``multiplier``; with a disturbance ``disturbance`` ("disturbances": E,
or "inputs": added to u) and ``disturbance_bounds`` (b_k) or ``disturbance_norm`` (b).

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.3 (S-procedure); Abedor, Nagpal,
Poolla (1996).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, numbers, positive
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.disturbance_channel import (
    entrance,
    quadratic_change,
    scaled_identity,
)
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.box_of_validity import beyond_range, outside_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded

MOST_DISTURBANCES = 10


@dataclass(frozen=True)
class InvariantSet:
    """The set as the claim states it; ``why_not`` checks it.

    ``way`` : "disturbances", "inputs", or empty without disturbance.
    ``bounds`` : bounds of the |w_k|, or the bound of |w|_2 where ``is_ball``; None for w = 0.
    ``E`` : the matrices through which w enters.
    ``claim``, ``where`` : the claim, and its place in the file for messages.
    """

    P: Matrix
    level: Fraction
    multiplier: Fraction
    way: str = ""
    E: tuple[Matrix, ...] = ()
    bounds: tuple[Fraction, ...] | None = None
    is_ball: bool = False
    claim: Any = None
    where: str = ""

    def why_not(self, loop: PolytopicLoop) -> str:
        """Return why the set is not proved invariant and inside the box; empty if it is proved."""
        if not self.P.is_positive_definite:
            return "P is not symmetric positive definite"
        for label, whole in self._inequalities(loop):
            if not whole.is_positive_semidefinite:
                return f"the inequality of invariance fails at {label}"
        bounds = self.each_bound
        idle = (Fraction(0),) * len(loop.disturbances)
        beyond = beyond_range(loop, bounds if self.way == "disturbances" else idle)
        if beyond:
            return beyond
        return outside_of(loop, self.P, self.level, bounds if self.way == "inputs" else ())

    @property
    def each_bound(self) -> tuple[Fraction, ...]:
        """Bounds on |w_k|; () without disturbance."""
        if self.bounds is None:
            return ()
        # |w|_2 <= b implies |w_k| <= b for every k.
        return self.bounds * self.E[0].shape[1] if self.is_ball else self.bounds

    def _inequalities(self, loop: PolytopicLoop) -> Iterator[tuple[str, Matrix]]:
        entering = replace(loop, E=self.E) if self.E else loop
        corners = 1 if self.bounds is None or self.is_ball else 1 << (len(self.bounds) - 1)
        wide = self.E[0].shape[1] if self.is_ball else 1
        blends = blends_of(entering, self.claim, self.where)
        bounded(len(blends) * corners, loop.order + wide)
        for blend in blends:
            if self.bounds is None:
                idle = Matrix([[0]] * loop.order)
                F, _, _ = quadratic_change(blend.A, idle, self.P, discrete=loop.is_discrete)
                yield blend.label, F - self.multiplier * self.P
                continue
            for W in self._corners():
                F, G, H = quadratic_change(blend.A, blend.E @ W, self.P, discrete=loop.is_discrete)
                rest = scaled_identity(W.shape[1], self.multiplier * self.level) - H
                yield (
                    blend.label,
                    Matrix.blocks([[F - self.multiplier * self.P, -G], [-G.T, rest]]),
                )

    def _corners(self) -> Iterator[Matrix]:
        """Yield b I for a ball, or the corners of the box as columns, one of w and -w each."""
        assert self.bounds is not None
        if self.is_ball:
            yield scaled_identity(self.E[0].shape[1], self.bounds[0])
            return
        # w and -w give the same inequality, so the first sign is fixed.
        for signs in product((1, -1), repeat=len(self.bounds) - 1):
            yield Matrix.of([[s * b] for s, b in zip((1, *signs), self.bounds, strict=True)])


def read_invariant_set(claim: Any, loop: PolytopicLoop, where: str) -> InvariantSet:
    """Return the claim's set.

    Raises
    ------
    CertificateError : wrong shapes, numbers that are not positive, or a disturbance that the model
        does not have.
    """
    n = loop.order
    P = read_matrix(claim, "P", where, (n, n))
    level, multiplier = (positive(claim, key, where) for key in ("level", "multiplier"))
    # V(x+) <= (1 - s) V + s c keeps V <= c from V <= c only for s <= 1.
    if loop.is_discrete and multiplier > 1:
        raise CertificateError(f"{where}.multiplier: at most 1 in discrete time")
    if "disturbance" not in claim:
        return InvariantSet(P, level, multiplier, claim=claim, where=where)
    way, E = entrance(claim, loop, where)
    ball = "disturbance_norm" in claim
    if ball:
        bounds = [number(claim, "disturbance_norm", where)]
    else:
        bounds = numbers(claim, "disturbance_bounds", where, E[0].shape[1])
    if any(bound < 0 for bound in bounds):
        raise CertificateError(f"{where}: bounds on the disturbance are not negative")
    if len(bounds) > MOST_DISTURBANCES:
        raise CertificateError(
            f"{where}.disturbance_bounds: at most {MOST_DISTURBANCES}, whose corners are checked"
        )
    return InvariantSet(
        P=P,
        level=level,
        multiplier=multiplier,
        way=way,
        E=E,
        bounds=tuple(bounds),
        is_ball=ball,
        claim=claim,
        where=where,
    )
