r"""``invariant-ellipsoid``: {x'Px <= c} lies in the model's box, and no solution leaves it.

So the model equals its plant along every solution that starts inside.  Without disturbance the set
is a region of attraction: every such solution tends to 0.  ``box_of_validity`` has the inequalities
about the box.  ``input-limits`` and ``peak`` are about such a set too.

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

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 6.1.3 (S-procedure); Abedor,
Nagpal, Poolla (1996).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import ClassVar, NamedTuple

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.reader import number as read_number
from takagi.certificates.checker.kernel.reader import numbers as read_numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.disturbance_channel import (
    entrance,
    quadratic_change,
)
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.box_of_validity import disturbances_in_range, inside_box
from takagi.certificates.checker.loop.polytopic_loop import Stack, bounded
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.ellipsoid_size import (
    LARGEST,
    rounded_size,
    square_root_below,
    volume_below,
)
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, exactly

MOST_DISTURBANCES = 10


class Disturbance(NamedTuple):
    """The bounded disturbance of a claim.

    ``source`` : "disturbances", "inputs", or empty for w = 0; ``E`` : the matrices through which w
    enters.  ``bounds`` : of the |w_k|, or of |w|_2 where ``is_ball``; () for w = 0.  ``columns`` :
    numbers of the model's disturbances that w consists of, the others at rest; () for all.
    """

    source: str = ""
    E: Stack = ()
    bounds: tuple[Fraction, ...] = ()
    is_ball: bool = False
    columns: tuple[int, ...] = ()

    @property
    def each_bound(self) -> tuple[Fraction, ...]:
        """Bounds on |w_k|; () without disturbance."""
        # |w|_2 <= b implies |w_k| <= b for every k.
        return self.bounds * self.E[0].shape[1] if self.is_ball else self.bounds

    def bounds_of_all(self, count: int) -> tuple[Fraction, ...]:
        """Return bounds on each of the model's disturbances, 0 for those that are at rest."""
        if not self.columns:
            return self.each_bound
        bound_of = dict(zip(self.columns, self.each_bound, strict=True))
        return tuple(bound_of.get(k, Fraction(0)) for k in range(count))

    def corners(self) -> Iterator[Matrix]:
        """Yield b I for a ball, or the corners of the box as columns, one of w and -w each."""
        if self.is_ball:
            yield self.bounds[0] * Matrix.identity(self.E[0].shape[1])
            return
        # w and -w give the same inequality, so the first sign is fixed.
        for signs in product((1, -1), repeat=len(self.bounds) - 1):
            yield Matrix.of([[s * b] for s, b in zip((1, *signs), self.bounds, strict=True)])


@dataclass(frozen=True)
class InvariantSet(LoopClaim):
    """A claim about an invariant set {x'Px <= level}."""

    asks: ClassVar[tuple[str, ...]] = ("disturbance",)
    P: Matrix = matrix("n", "n")
    level: Fraction = number(positive=True)
    multiplier: Fraction = number("1/s", positive=True)

    def __post_init__(self) -> None:
        # V(x+) <= (1 - s) V + s c keeps V <= c from V <= c only for s <= 1.
        if self.loop.is_discrete and self.multiplier > 1:
            raise CertificateError(f"{self.where}.multiplier: at most 1 in discrete time")

    @cached_property
    def disturbance(self) -> Disturbance:
        """The disturbance of the claim.

        Raises
        ------
        CertificateError : bounds that do not fit, or a disturbance that the model does not have.
        """
        claim, where = self.claim, self.where
        if "disturbance" not in claim:
            return Disturbance()
        source, E = entrance(claim, self.loop, where)
        is_ball = "disturbance_norm" in claim
        if is_ball:
            bounds = [read_number(claim, "disturbance_norm", where)]
        else:
            bounds = read_numbers(claim, "disturbance_bounds", where, E[0].shape[1])
        if any(bound < 0 for bound in bounds):
            raise CertificateError(f"{where}: bounds on the disturbance are not negative")
        if len(bounds) > MOST_DISTURBANCES:
            raise CertificateError(
                f"{where}.disturbance_bounds: at most {MOST_DISTURBANCES}, whose corners are "
                "checked"
            )
        return Disturbance(source, E, tuple(bounds), is_ball)

    def obligations(self) -> Obligations:
        """Yield what makes the set invariant, and keeps it inside the box."""
        loop, P, w = self.loop, self.P, self.disturbance
        yield positive(P, NOT_DEFINITE)
        corners = 1 if not w.bounds or w.is_ball else 1 << (len(w.bounds) - 1)
        blends = blends_of(replace(loop, E=w.E or loop.E), self.claim, self.where)
        bounded(len(blends) * corners, loop.order + (w.E[0].shape[1] if w.is_ball else 1))
        idle = Matrix.zeros(loop.order, 1)
        for blend in blends:
            failure = f"the inequality of invariance fails at {blend.label}"
            if not w.bounds:
                F, _, _ = quadratic_change(blend.A, idle, P, discrete=loop.is_discrete)
                yield nonnegative(F - self.multiplier * P, failure)
                continue
            for W in w.corners():
                F, G, H = quadratic_change(blend.A, blend.E @ W, P, discrete=loop.is_discrete)
                corner = self.multiplier * self.level * Matrix.identity(W.shape[1]) - H
                falling = F - self.multiplier * P
                yield nonnegative(Matrix.blocks([[falling, -G], [-G.T, corner]]), failure)
        at_rest = (Fraction(0),) * len(loop.disturbances)
        yield from disturbances_in_range(
            loop,
            w.bounds_of_all(len(at_rest)) if w.source == "disturbances" else at_rest,
        )
        yield from inside_box(loop, P, self.level, w.each_bound if w.source == "inputs" else ())

    def figures(self) -> Iterator[Figure | WindProfile]:
        """Yield the set's volume, and how far each state may start with the others at rest.

        The largest x_k in the set with the others at rest is sqrt(level / P_kk).
        """
        yield from super().figures()
        if self.loop.order <= LARGEST:
            yield Figure("volume of the set", "", volume_below(self.P, self.level))
        for k, label in enumerate(self.loop.states):
            name, _, unit = label.removesuffix("]").partition(" [")
            start = square_root_below(self.level / self.P[k, k])
            yield Figure(f"safe start of {name}, others at rest", unit, start)
        yield from self._disturbance_figures()

    def _disturbance_figures(self) -> Iterator[Figure]:
        w, name = self.disturbance, "bound on disturbance"
        for k, bound in enumerate(w.bounds, start=1):
            yield Figure(name if w.is_ball else f"{name} {k}", "", bound)

    @property
    def set_in_words(self) -> str:
        """The set with its exact level; for another level it may leave the box."""
        return f"{{x'Px <= {exactly(self.level)}}}"

    @property
    def where_valid(self) -> str:
        """Where the set lies, and the assumptions."""
        if not self._is_boxed:
            return ""
        return f" and lies in the model's box{words.granted(self.loop, disturbances_too=False)}"

    @property
    def motion(self) -> str:
        """How V moves outside the set, and for which disturbances."""
        loop, w = self.loop, self.disturbance
        unit = "(1 - {})^k" if loop.is_discrete else "exp(-{} t)"
        speed = unit.format(at_least(self.multiplier, 6))
        if not w.bounds:
            undisturbed = " without disturbance" if loop.E else ""
            return f"from inside V = x'Px falls as {speed}{undisturbed}"
        alone = ", without the model's disturbance," if loop.E else ""
        source = "the model's disturbance" if w.source == "disturbances" else f"w added to u{alone}"
        bounds = [at_least(b, 6) for b in w.bounds]
        size = f"|w|_2 <= {bounds[0]}" if w.is_ball else f"|w_k| <= {', '.join(bounds)}"
        outside = "from outside, but within the box," if self._is_boxed else "from outside"
        return f"for {source} with {size}; {outside} V - level falls as {speed}"

    @property
    def own_letter(self) -> str:
        """``w`` if it is the model's disturbance; a w that is added to u is no deviation."""
        return "w" if self.disturbance.source == "disturbances" else ""

    @property
    def _is_boxed(self) -> bool:
        return any(side is not None for side in self.loop.box) or bool(self.loop.other_box)


@dataclass(frozen=True)
class InvariantEllipsoid(InvariantSet):
    """No solution leaves {x'Px <= level}; see the module."""

    def sentence(self) -> str:
        loop = self.loop
        return (
            f"{self.set_in_words} is invariant{self.where_valid}, along {words.about(loop)}; "
            f"{self.motion}{rounded_size(self.P, self.level, loop.states)}"
            f"{words.deviations(loop, 'x' + self.own_letter)}"
        )
