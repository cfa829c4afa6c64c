r"""Ranges of expressions over boxes, in the ball arithmetic of FLINT (Arb).

A box is bisected until the expression keeps its bounds on each piece.  On a piece the expression is
enclosed by its value, and by f(m) + sum_i f_i(X) (X_i - m_i); a variable in which it is monotone is
set to its ends.  Slopes are coefficients of truncated power series, with balls as coefficients.  A
quotient N / x^k that has a limit at x = 0 is the coefficient k of the series of N along x, taken
over the hull of the piece and 0 (Taylor's formula, see the checker's ``quotient_form``).

Bounds that are attained are kept up to 1e-20 of their size: balls are not exact.

Source: Johansson (2017), IEEE Trans. Computers 66(8), for ball arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

from flint import arb, arb_series, ctx, fmpq

from takagi.certificates.checker.kernel.obligation import Obligation
from takagi.certificates.checker.plant.graph import Graph, Node
from takagi.certificates.checker.plant.plant_claim import Enclosure
from takagi.certificates.checker.plant.quotient_form import parted

PRECISION, MOST_PIECES, HIGHEST_ORDER = 160, 400, 6
TOLERANCE = Fraction(1, 10**20)
Side = tuple[Fraction, Fraction]
Box = Mapping[str, Side]
FUNCTIONS: dict[str, Callable[[arb_series], arb_series]] = {
    "sin": arb_series.sin,
    "cos": arb_series.cos,
    "tan": arb_series.tan,
    "asin": arb_series.asin,
    "acos": arb_series.acos,
    "atan": arb_series.atan,
    "exp": arb_series.exp,
    "log": arb_series.log,
    "erf": arb_series.erf,
    "sinh": lambda x: (x.exp() - (-x).exp()) / 2,
    "cosh": lambda x: (x.exp() + (-x).exp()) / 2,
    "tanh": lambda x: 1 - 2 / ((2 * x).exp() + 1),
}


class NotEnclosed(Exception):
    """A part of the expression has no enclosure here."""


def keeps_bounds(required: Obligation) -> bool | None:
    """Return whether an expression keeps its bounds on its box; None where that is not decided."""
    if not isinstance(required, Enclosure):
        return None
    ranges, bounds = required.ranges, (required.lower, required.upper)
    slack = [TOLERANCE * max(Fraction(1), abs(bound)) for bound in bounds]
    low, high = fmpq_of(bounds[0] - slack[0]), fmpq_of(bounds[1] + slack[1])
    sides = ranges.evaluator.sides
    vanishing = frozenset(v for v, side in sides.items() if side[0] <= 0 <= side[1])
    with ctx.workprec(PRECISION):
        expression = _Expression(ranges.graph, *parted(ranges.graph, required.node, vanishing))
        if not expression.variables <= sides.keys():
            return None
        pieces: list[Box] = [{name: sides[name] for name in expression.variables}]
        for _ in range(MOST_PIECES):
            if not pieces:
                return True
            piece = pieces.pop()
            try:
                value = expression.value(piece)
                if low <= value and value <= high:
                    continue
                slopes = {name: expression.slope(piece, name) for name in piece}
                least, largest = expression.ends(piece, slopes)
            except NotEnclosed:
                return None
            if low <= least and largest <= high:
                continue
            if largest < low or least > high:
                return False
            pieces += _halves(piece, slopes, expression.powers)
    return None if pieces else True


class _Expression:
    """N over a product of powers of variables that may vanish on the box."""

    def __init__(self, graph: Graph, top: int, powers: dict[str, int]) -> None:
        self.graph, self.top, self.powers = graph, top, powers
        direct = top
        for name, power in powers.items():
            direct = graph.divide(direct, graph.power(graph.variable(name), power))
        self.direct = direct
        self.variables = graph.variables(direct)

    def value(self, box: Box) -> arb:
        """Return a ball that holds the values over the box, limits included."""
        return self._coefficient(box, 0)

    def slope(self, box: Box, name: str) -> arb | None:
        """Return a ball that holds the slopes in a variable; None where there is none."""
        singular = self._singular(box)
        if singular not in ("", name):
            return None
        return self._coefficient(box, 1, name)

    def ends(self, box: Box, slopes: Mapping[str, arb | None]) -> tuple[arb, arb]:
        """Return balls: below the first and above the second is no value over the box."""
        faces: list[dict[str, Side]] = [dict(box), dict(box)]
        for name, (low, high) in box.items():
            slope = slopes[name]
            if slope is not None and (slope >= 0 or slope <= 0):
                ends = (low, high) if slope >= 0 else (high, low)
                for face, end in zip(faces, ends, strict=True):
                    face[name] = (end, end)
        return self._mean_value(faces[0], slopes).lower(), self._mean_value(
            faces[1], slopes
        ).upper()

    def _mean_value(self, box: Box, slopes: Mapping[str, arb | None]) -> arb:
        value = self.value(box)
        free = [name for name, (low, high) in box.items() if low < high]
        if not free or any(slopes[name] is None for name in free):
            return value
        middle = dict(box)
        for name in free:
            middle[name] = ((box[name][0] + box[name][1]) / 2,) * 2
        mean = self.value(middle)
        for name in free:
            slope = slopes[name]
            assert slope is not None
            mean += slope * (ball(box[name]) - ball(middle[name]))
        return mean if mean.rad() < value.rad() else value

    def _singular(self, box: Box) -> str:
        """Return the variable that divides and whose side contains 0; empty for none."""
        names = [name for name in self.powers if box[name][0] <= 0 <= box[name][1]]
        if len(names) > 1:
            raise NotEnclosed("two variables that vanish")
        return names[0] if names else ""

    def _coefficient(self, box: Box, order: int, along: str = "") -> arb:
        singular = self._singular(box)
        if not singular:
            return _series(self.graph, self.direct, box, along, order + 1)[order]
        order += self.powers[singular]
        if order >= HIGHEST_ORDER:
            raise NotEnclosed("a high power in a denominator")
        coefficient = _series(self.graph, self.top, box, singular, order + 1)[order]
        for name, power in self.powers.items():
            if name != singular:
                coefficient /= ball(box[name]) ** power
        if not coefficient.is_finite():
            raise NotEnclosed("no bound")
        return coefficient


def _series(graph: Graph, root: int, box: Box, along: str, length: int) -> arb_series:
    """Return the series of a node in t, where the variable ``along`` is its side plus t."""
    values: dict[int, arb_series] = {}
    before, ctx.cap = ctx.cap, length
    try:
        for number in graph.below([root]):
            node = graph[number]
            parts = [values[part] for part in node.operands]
            values[number] = _node(node, parts, box, along)
    finally:
        ctx.cap = before
    return values[root]


def _node(node: Node, parts: list[arb_series], box: Box, along: str) -> arb_series:
    if node.op == "const":
        return arb_series([arb(fmpq_of(node.value))])
    if node.op == "pi":
        return arb_series([arb.pi()])
    if node.op == "variable":
        return arb_series(
            [ball(box[node.name]), 1] if node.name == along else [ball(box[node.name])]
        )
    if node.op == "add":
        return parts[0] + parts[1]
    if node.op == "multiply":
        return parts[0] * parts[1]
    if node.op == "divide":
        return parts[0] / _nonzero(parts[1])
    if node.op == "power":
        return _power(parts[0], node.value)
    if node.op == "call" and node.name in FUNCTIONS:
        return FUNCTIONS[node.name](parts[0])
    raise NotEnclosed(node.op)


def _power(base: arb_series, exponent: Fraction) -> arb_series:
    if exponent.denominator == 1:
        power = base ** abs(int(exponent))
        return power if exponent > 0 else 1 / _nonzero(power)
    if not base[0] > 0:
        raise NotEnclosed("a root at 0")
    if exponent.denominator == 2:
        root = base.sqrt() ** abs(exponent.numerator)
        return root if exponent > 0 else 1 / root
    return (base.log() * arb(fmpq_of(exponent))).exp()


def _nonzero(series: arb_series) -> arb_series:
    if not (series[0] > 0 or series[0] < 0):
        raise NotEnclosed("a denominator that may vanish")
    return series


def _halves(piece: Box, slopes: Mapping[str, arb | None], powers: Mapping[str, int]) -> list[Box]:
    """Return both halves, cut across the side along which the expression changes most."""

    def change(name: str) -> tuple[bool, float]:
        width, slope = float(piece[name][1] - piece[name][0]), slopes[name]
        known = slope is not None and slope.is_finite()
        return not known, width * (float(abs(slope).upper()) if known and slope is not None else 1)

    name = max((n for n in piece if piece[n][0] < piece[n][1]), key=change, default="")
    if not name:
        raise NotEnclosed("a point at which the bounds are not decided")
    low, high = piece[name]
    # A side is cut at 0 where the variable divides, so that neither half has 0 inside.
    cut = Fraction(0) if name in powers and low < 0 < high else (low + high) / 2
    return [{**piece, name: (low, cut)}, {**piece, name: (cut, high)}]


def ball(side: Side) -> arb:
    """Return a ball that holds a side."""
    low, high = fmpq_of(side[0]), fmpq_of(side[1])
    return arb((low + high) / 2, (high - low) / 2) if low < high else arb(low)


def fmpq_of(value: Fraction) -> fmpq:
    """Return a fraction as a number of FLINT."""
    return fmpq(value.numerator, value.denominator)
