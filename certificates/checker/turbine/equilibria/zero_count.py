r"""The number of zeros of f(v, s) in s, for every wind v of a cell, by branch and bound.

The range of s is cut into pieces.  A piece is decided when f keeps one sign on it for all winds of
the cell, or when df/ds keeps one sign: then f has at most one zero there at each wind.  Any other
piece is halved.  Pieces without a sign that touch each other make a *block*; where df/ds keeps one
sign all over a block, f has at most one zero in it, and exactly one when f has opposite signs at
the block's two ends.

f and its slopes are brackets; f is bounded by its own bracket and by the mean value form

    f(v, s) in f(v_m, s_m) + [df/dv] (v - v_m) + [df/ds] (s - s_m).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import Interval, point
from takagi.certificates.checker.kernel.refusal import Refused

Span = tuple[Fraction, Fraction]
# Of winds and of s: the bracket of f with its slopes along both, without slopes where f is not
# defined all over the rectangle, and None where it is defined nowhere on it.
Excess = Callable[[Span, Span], Dual | None]
ANY_SIGN = frozenset({-1, 1})


@dataclass(frozen=True)
class Piece:
    """A range of s to be cut; ``signs`` are those of f that may decide a part of it."""

    span: Span
    signs: frozenset[int] = ANY_SIGN


@dataclass(frozen=True)
class Count:
    """At each wind of the cell f has ``least`` to ``most`` zeros.

    Attributes
    ----------
    most : None where no bound was found.
    start, end : the sign of f at both ends of s, 0 where it is not known or changes.
    blocks : ranges of s that hold every zero.
    """

    least: int
    most: int | None
    start: int
    end: int
    blocks: tuple[Span, ...]

    @property
    def exact(self) -> int | None:
        """The number of zeros where it is known."""
        return self.least if self.most == self.least else None


@dataclass(frozen=True)
class _Part:
    """A decided part: the sign of f there, or else that of df/ds; 0 for unknown.

    ``empty`` if f is not defined there: it has no zero and no sign; ``whole`` if it is defined
    everywhere in the part.
    """

    span: Span
    sign: int = 0
    slope: int = 0
    empty: bool = False
    whole: bool = True


def count_zeros(f: Excess, winds: Span, pieces: Sequence[Piece], *, most_parts: int) -> Count:
    """Return how many zeros f has at each wind; the pieces follow each other without a gap.

    Parameters
    ----------
    most_parts : into how many parts all pieces together are cut at most.
    """
    parts = _cut(f, winds, pieces, most_parts)
    least, most = 0, 0
    unbounded, blocks = False, []
    for low, high in _blocks(parts):
        left = _end_sign(f, winds, parts[low - 1 : low], parts[low].span[0])
        right = _end_sign(f, winds, parts[high : high + 1], parts[high - 1].span[1])
        slopes = {part.slope for part in parts[low:high]}
        monotone = len(slopes) == 1 and 0 not in slopes
        blocks.append((parts[low].span[0], parts[high - 1].span[1]))
        # Equal signs at both ends of a monotone block exclude a zero inside.
        if monotone and left == right != 0:
            continue
        # A part where f is partly undefined may get its sign from winds that do not border the
        # block. A monotone block is defined everywhere, its ends included.
        beside = parts[max(low - 1, 0) : low] + parts[high : high + 1]
        if monotone or all(part.whole for part in beside):
            least += int(left * right < 0)
        most += 1
        unbounded |= not monotone
    start = _end_sign(f, winds, parts[:1], parts[0].span[0])
    end = _end_sign(f, winds, parts[-1:], parts[-1].span[1])
    return Count(least, None if unbounded else most, start, end, tuple(blocks))


def sign_over(f: Excess, winds: Span, span: Span) -> int:
    """Return the sign that f has all over the rectangle, or 0."""
    try:
        found = f(winds, span)
    except Refused:
        return 0
    return 0 if found is None else _sign(f, winds, span, found)


def _end_sign(f: Excess, winds: Span, beside: Sequence[_Part], at: Fraction) -> int:
    """Return the sign of f at one s, from the adjacent part if that has a sign."""
    if beside and beside[0].sign:
        return beside[0].sign
    return 0 if beside and beside[0].empty else sign_over(f, winds, (at, at))


def _cut(f: Excess, winds: Span, pieces: Sequence[Piece], most: int) -> list[_Part]:
    """Return the parts in order; the widest undecided one is halved first."""
    found: list[_Part] = []
    waiting: list[tuple[Fraction, int, Piece]] = []
    for number, piece in enumerate(pieces):
        heappush(waiting, (-_width(piece), number, piece))
    number = len(waiting)
    while waiting:
        _, _, piece = heappop(waiting)
        part = _looked_at(f, winds, piece)
        if part.sign or part.slope or part.empty or number >= 2 * most:
            found.append(part)
            continue
        low, high = piece.span
        middle = (low + high) / 2
        for half in ((low, middle), (middle, high)):
            heappush(waiting, (_width(piece) / -2, number, Piece(half, piece.signs)))
            number += 1
    return sorted(found, key=lambda part: part.span)


def _width(piece: Piece) -> Fraction:
    return piece.span[1] - piece.span[0]


def _looked_at(f: Excess, winds: Span, piece: Piece) -> _Part:
    try:
        found = f(winds, piece.span)
    except Refused:
        return _Part(piece.span)
    if found is None:
        return _Part(piece.span, empty=True)
    sign = _sign(f, winds, piece.span, found)
    if sign in piece.signs:
        return _Part(piece.span, sign=sign, whole=bool(found.slopes))
    return _Part(piece.span, slope=_bracket_sign(found.slopes[1]) if found.slopes else 0)


def _blocks(parts: Sequence[_Part]) -> list[tuple[int, int]]:
    """Return the runs [low, high) of parts without a sign."""
    found, start = [], None
    for k, part in enumerate(parts):
        decided = part.sign != 0 or part.empty
        if not decided and start is None:
            start = k
        elif decided and start is not None:
            found.append((start, k))
            start = None
    return found if start is None else [*found, (start, len(parts))]


def _sign(f: Excess, winds: Span, span: Span, found: Dual) -> int:
    natural = _bracket_sign(found.value)
    if natural or not found.slopes:
        return natural
    (v1, v2), (s1, s2) = winds, span
    if v1 == v2 and s1 == s2:
        return 0
    try:
        middle = f(((v1 + v2) / 2,) * 2, ((s1 + s2) / 2,) * 2)
    except Refused:
        return 0
    if middle is None:
        return 0
    value = middle.value
    for slope, width in zip(found.slopes, (v2 - v1, s2 - s1), strict=True):
        half = point(width / 2)[1]
        value = value + slope * Interval(-half, half)
    return _bracket_sign(value)


def _bracket_sign(bracket: Interval) -> int:
    return 1 if bracket[0] > 0 else -1 if bracket[1] < 0 else 0
