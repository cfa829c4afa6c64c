r"""Ranges of trees over boxes: intervals with rational ends; functions are enclosed by balls.

An interval is a pair of rationals, or None where nothing is known.  Each range is computed together
with the range of the slope along one variable.  The slope serves where the denominator x may be 0
and the numerator N vanishes at x = 0 (``removable`` says so):

    N / x = int_0^1 N_x(s x) ds     lies in the range of N_x over the hull of the box and x = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeAlias

from flint import arb, ctx, fmpq

from takagi.certificates.cross_check.kernel.reading import NotReplayed
from takagi.certificates.cross_check.plant.expression import Tree

Interval: TypeAlias = tuple[fmpq, fmpq] | None
Box: TypeAlias = Mapping[str, Interval]
Removable: TypeAlias = Callable[[Tree, str], bool]
BITS, LONGEST, MOST_POWER = 160, 600, 20_000  # of balls, of a rational end, of a power of 2
ZERO, ONE = fmpq(0), fmpq(1)
POINT: Interval = (ZERO, ZERO)


class Undefined(Exception):
    """A part may be undefined somewhere on the box; with ``surely`` it is undefined everywhere."""

    def __init__(self, what: str, *, surely: bool = False) -> None:
        super().__init__(what)
        self.surely = surely


class Dual(NamedTuple):
    value: Interval
    slope: Interval


def range_of(tree: Tree, box: Box, removable: Removable) -> Interval:
    """Return an interval that holds the values of a tree over a box.

    Raises
    ------
    Undefined : a part may be undefined somewhere on the box.
    """
    with ctx.workprec(BITS):
        return _dual(tree, box, "", removable).value


def _dual(tree: Tree, box: Box, along: str, removable: Removable) -> Dual:
    kind = tree[0]
    if kind == "number":
        return Dual((tree[1], tree[1]), POINT)
    if kind == "name":
        if tree[1] == "pi":
            return Dual(_ends(arb.pi()), POINT)
        return Dual(box.get(tree[1]), (ONE, ONE) if tree[1] == along else POINT)
    if kind == "/":
        return _quotient(tree, box, along, removable)
    if kind == "^":
        return _power(_dual(tree[1], box, along, removable), tree[2])
    if kind == "call":
        if len(tree[2]) != 1 or tree[1] not in VALUES:
            raise NotReplayed(f"the function {tree[1][:40]!a} has no enclosure here")
        a = _dual(tree[2][0], box, along, removable)
        value = VALUES[tree[1]](a.value)
        if a.slope == POINT:
            return Dual(value, POINT)
        return Dual(value, _times(SLOPES[tree[1]](a.value), a.slope))
    # A product with 0 was kept only because its other factor may be undefined (``times``): no
    # limit is taken there.
    if kind == "*" and ("number", ZERO) in tree[1:]:
        removable = _never
    a, b = (_dual(part, box, along, removable) for part in tree[1:])
    if kind == "+":
        return Dual(_plus(a.value, b.value), _plus(a.slope, b.slope))
    slope = _plus(_times(a.slope, b.value), _times(a.value, b.slope))
    # x x is never negative; the product of two intervals would not know that.
    if tree[1] == tree[2]:
        return _power(a, fmpq(2))
    return Dual(_times(a.value, b.value), slope)


def _never(_top: Tree, _name: str) -> bool:
    """Return False: a product with 0 is not treated as a limit."""
    return False


def _quotient(tree: Tree, box: Box, along: str, removable: Removable) -> Dual:
    _, top, bottom = tree
    b = _dual(bottom, box, along, removable)
    if b.value is not None and not b.value[0] <= 0 <= b.value[1]:
        a = _dual(top, box, along, removable)
        inverse = (1 / b.value[1], 1 / b.value[0])
        slope = a.slope
        if b.slope != POINT:
            fallen = _times(_times(a.value, inverse), b.slope)
            slope = _plus(slope, None if fallen is None else (-fallen[1], -fallen[0]))
        return Dual(_times(a.value, inverse), _times(slope, inverse))
    if top == ("number", ZERO):
        # 0/x is not treated as a limit, since no plant needs it.
        raise Undefined("0 divided by what may be zero", surely=b.value == POINT)
    factor, name = _multiple(bottom)
    side = box.get(name)
    if along or not name or side is None or not removable(top, name):
        raise Undefined("a denominator that may be zero")
    wider = {**box, name: (min(side[0], ZERO), max(side[1], ZERO))}
    found = _dual(top, wider, name, removable).slope
    return Dual(_times(found, (1 / factor, 1 / factor)), POINT)


def _multiple(tree: Tree) -> tuple[fmpq, str]:
    """Return (c, x) of a tree c x; an empty name where the tree has another form."""
    if tree[0] == "name":
        return ONE, tree[1]
    if tree[0] == "*" and tree[1][0] == "number" and tree[2][0] == "name":
        return tree[1][1], tree[2][1]
    return ONE, ""


def _plus(a: Interval, b: Interval) -> Interval:
    return None if a is None or b is None else (a[0] + b[0], a[1] + b[1])


def _times(a: Interval, b: Interval) -> Interval:
    if POINT in (a, b):
        return POINT
    if a is None or b is None:
        return None
    products = [x * y for x in a for y in b]
    return _short((min(products), max(products)))


def _short(a: tuple[fmpq, fmpq]) -> Interval:
    """Return the interval; ends with long denominators are rounded outward, which saves time."""
    if max(int(end.q).bit_length() for end in a) < LONGEST:
        return a
    low, high = ((end.p << LONGEST // 2) // end.q for end in a)
    return fmpq(low, 1 << LONGEST // 2), fmpq(high + 1, 1 << LONGEST // 2)


def _power(a: Dual, power: fmpq) -> Dual:
    p, q = int(power.p), int(power.q)
    value, slope = a.value, a.slope
    if q > 1:
        if value is None or value[0] < 0 or (slope != POINT and value[0] == 0):
            surely = value is not None and value[1] < 0
            raise Undefined("a root of what may be negative", surely=surely)
        value = _ends_of(lambda x: x.root(q), value)
        if slope != POINT:
            low, high = value[0] ** (q - 1) * q, value[1] ** (q - 1) * q
            slope = _times(slope, (1 / high, 1 / low)) if low > 0 else None
    raised = _whole_power(value, p)
    if slope == POINT or p == 0:
        return Dual(raised, POINT)
    return Dual(raised, _times(_times((fmpq(p), fmpq(p)), _whole_power(value, p - 1)), slope))


def _whole_power(a: Interval, p: int) -> Interval:
    if p == 0:
        return ONE, ONE
    if a is None:
        if p < 0:
            raise Undefined("a power of what may be zero")
        return None
    if p < 0:
        if a[0] <= 0 <= a[1]:
            raise Undefined("a power of what may be zero")
        a, p = (1 / a[1], 1 / a[0]), -p
    ends = [a[0] ** p, a[1] ** p]
    least = ZERO if p % 2 == 0 and a[0] <= 0 <= a[1] else min(ends)
    return _short((least, max(ends)))


def _ends(ball: arb) -> tuple[fmpq, fmpq]:
    """Return the ends of a ball as rationals."""
    if not ball.is_finite():
        raise Undefined("no finite value")
    found = []
    for end in (ball.lower(), ball.upper()):
        mantissa, power = (int(part) for part in end.man_exp())
        if abs(power) > MOST_POWER:
            raise Undefined("a value that is too large or too small")
        found.append(fmpq(mantissa << power) if power >= 0 else fmpq(mantissa, 1 << -power))
    return found[0], found[1]


def _ends_of(function: Callable[[arb], arb], a: tuple[fmpq, fmpq]) -> tuple[fmpq, fmpq]:
    """Return the range of a function that increases."""
    low, high = (_ends(function(arb(end))) for end in a)
    return low[0], high[1]


def _growing(
    function: Callable[[arb], arb], least: fmpq | None = None, most: fmpq | None = None
) -> Callable[[Interval], Interval]:
    """Return the interval extension of a function that increases from ``least`` to ``most``."""

    def found(a: Interval) -> Interval:
        if a is None:
            return None if least is None or most is None else (least, most)
        low, high = _ends_of(function, a)
        return low if least is None else max(low, least), high if most is None else min(high, most)

    return found


def _wave(a: Interval, quarter: int) -> Interval:
    """Return the range of cos (0 quarters) or sin (1), whose maxima lie at (quarter/2 + 2 k) pi."""
    # 7 > 2 pi: the interval contains a whole period.
    if a is None or a[1] - a[0] > 7:
        return -ONE, ONE
    function = arb.sin if quarter else arb.cos
    values = [_ends(function(arb(end))) for end in a]
    low, high = min(v[0] for v in values), max(v[1] for v in values)
    # Extrema are at (quarter/2 + k) pi; a maximum where k is even.
    first = _ends(arb(a[0]) / arb.pi() - arb(quarter) / 2)[0]
    last = _ends(arb(a[1]) / arb.pi() - arb(quarter) / 2)[1]
    start = -int(-first.p // first.q)
    if last - first > 8:
        return -ONE, ONE
    for k in range(start, int(last.p // last.q) + 1):
        low, high = (low, ONE) if k % 2 == 0 else (-ONE, high)
    return max(low, -ONE), min(high, ONE)


def _size(a: Interval) -> Interval:
    if a is None:
        return None
    least = ZERO if a[0] <= 0 <= a[1] else min(abs(a[0]), abs(a[1]))
    return least, max(abs(a[0]), abs(a[1]))


def _inverse(a: Interval) -> Interval:
    return _whole_power(a, -1)


def _flat(a: Interval) -> Interval:
    """Return 1 - tanh^2."""
    square = _whole_power(VALUES["tanh"](a), 2)
    return None if square is None else (1 - square[1], 1 - square[0])


def _less(a: Interval) -> Interval:
    return None if a is None else (-a[1], -a[0])


def _tan(a: Interval) -> Interval:
    cosine = _wave(a, 0)
    if a is None or cosine is None or cosine[0] <= 0 <= cosine[1]:
        raise Undefined("a tangent at a right angle")
    return _ends_of(arb.tan, a)


def _log(a: Interval) -> Interval:
    if a is None or a[0] <= 0:
        surely = a is not None and a[1] <= 0
        raise Undefined("a logarithm of what may not be positive", surely=surely)
    return _ends_of(arb.log, a)


def _cosh(a: Interval) -> Interval:
    return None if (size := _size(a)) is None else _ends_of(arb.cosh, size)


def _root(a: Interval) -> Interval:
    return _power(Dual(a, POINT), fmpq(1, 2)).value


VALUES: dict[str, Callable[[Interval], Interval]] = {
    "sin": lambda a: _wave(a, 1),
    "cos": lambda a: _wave(a, 0),
    "tan": _tan,
    "exp": _growing(arb.exp),
    "log": _log,
    "sqrt": _root,
    "sinh": _growing(arb.sinh),
    "cosh": _cosh,
    "tanh": _growing(arb.tanh, -ONE, ONE),
    "atan": _growing(arb.atan),
    "asinh": _growing(arb.asinh),
    "erf": _growing(arb.erf, -ONE, ONE),
    "abs": _size,
}
SLOPES: dict[str, Callable[[Interval], Interval]] = {
    "sin": lambda a: _wave(a, 0),
    "cos": lambda a: _less(_wave(a, 1)),
    "tan": lambda a: _plus((ONE, ONE), _whole_power(_tan(a), 2)),
    "exp": _growing(arb.exp),
    "log": _inverse,
    "sqrt": lambda a: _inverse(_times((fmpq(2), fmpq(2)), _root(a))),
    "sinh": _cosh,
    "cosh": _growing(arb.sinh),
    "tanh": _flat,
    "atan": lambda a: _inverse(_plus((ONE, ONE), _whole_power(a, 2))),
    "asinh": lambda a: _inverse(_root(_plus((ONE, ONE), _whole_power(a, 2)))),
    "erf": lambda a: (ZERO, fmpq(2)),
    "abs": lambda a: (-ONE, ONE),
}
