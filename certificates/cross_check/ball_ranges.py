r"""Ranges of expressions over boxes, in the ball arithmetic of FLINT (Arb).

A box is bisected until the expression keeps its bounds on each piece.  On a piece the expression is
enclosed by its value, and by f(m) + sum_i f_i(X) (X_i - m_i); a variable in which it is monotone is
set to its ends.  Slopes are coefficients of truncated power series, with balls as coefficients.  A
quotient N / x^k that has a limit at x = 0 is the coefficient k of the series of N along x, taken
over the hull of the piece and 0 (Taylor's formula, see the checker's ``quotient_form``).

Bounds that are attained are kept up to 1e-20 of their size, a bound 0 up to 1e-20 of the other one
where that is below 1: balls are not exact.

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
TOLERANCE, SLOPE_ROUNDING = Fraction(1, 10**20), arb(1) / 10**6
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
    "tanh": lambda x: 1 - 2 / _nonzero((2 * x).exp() + 1),
}


class NotEnclosed(Exception):
    """A part of the expression has no enclosure on a piece of the box."""


class Unknown(Exception):
    """A part of the expression that has no enclosure here on any box."""


def keeps_bounds(required: Obligation) -> bool | None:
    """Return whether an expression keeps its bounds on its box; None where that is not decided."""
    if not isinstance(required, Enclosure):
        return None
    try:
        with ctx.workprec(PRECISION):
            return _keeps_bounds(required)
    except (NotEnclosed, Unknown):
        return None


def _keeps_bounds(required: Enclosure) -> bool | None:
    ranges, bounds = required.ranges, (required.lower, required.upper)
    slack = [
        TOLERANCE * (abs(bound) or min(Fraction(1), abs(opposite)))
        for bound, opposite in (bounds, bounds[::-1])
    ]
    low, high = fmpq_of(bounds[0] - slack[0]), fmpq_of(bounds[1] + slack[1])
    sides = ranges.evaluator.sides
    vanishing = frozenset(v for v, side in sides.items() if side[0] <= 0 <= side[1])
    expression = _Expression(ranges.graph, *parted(ranges.graph, required.node, vanishing))
    if not expression.variables <= sides.keys():
        return None
    whole_box = {name: sides[name] for name in expression.variables}
    if not expression.has_limits(whole_box):
        return None
    boxes: list[Box] = [whole_box]
    for _ in range(MOST_PIECES):
        if not boxes:
            return True
        box = boxes.pop()
        slopes: Mapping[str, arb | None] = dict.fromkeys(box)
        try:
            value = expression.value(box)
            if low <= value and value <= high:
                continue
            slopes = {name: expression.slope(box, name) for name in box}
            low_face, high_face, error = _faces(box, slopes)
            lowest = expression.mean_value(low_face, slopes) - error
            largest = expression.mean_value(high_face, slopes) + error
            if low <= lowest and largest <= high:
                continue
            for face in (low_face, high_face):
                inside = expression.value(_middle(face))
                if inside < low or inside > high:
                    return False
        except NotEnclosed:
            pass
        boxes += _halves(box, slopes, expression.powers)
    return None if boxes else True


class _Expression:
    """N over a product of powers of variables that may vanish on the box."""

    def __init__(self, graph: Graph, top: int, powers: dict[str, int]) -> None:
        self.graph, self.top, self.powers = graph, top, powers
        direct = top
        for name, power in powers.items():
            direct = graph.divide(direct, graph.power(graph.variable(name), power))
        self.direct = direct
        self.variables = graph.variables(direct)

    def has_limits(self, box: Box) -> bool:
        """Return whether N and its slopes vanish exactly where N / x^k is a limit."""
        zero = Fraction(0), Fraction(0)
        for name, power in self.powers.items():
            series = _series(self.graph, self.top, {**box, name: zero}, name, power)
            if not all(series[order].is_zero() for order in range(power)):
                return False
        return True

    def value(self, box: Box) -> arb:
        """Return a ball that holds the values over the box, limits included.

        Around a limit it is narrowed by f(0) + f'(0) x + x^2 f''(X) / 2 in the variable x.
        """
        value, name = self._coefficient(box, 0), self._singular(box)
        if not name or box[name][0] == box[name][1] or self.powers[name] + 2 >= HIGHEST_ORDER:
            return value
        zero, (low, high) = Fraction(0), box[name]
        lowest = zero if low <= 0 <= high else min(low * low, high * high)
        squared = ball((lowest, max(low * low, high * high)))
        there = {**box, name: (zero, zero)}
        linear = self._coefficient(there, 0) + self._coefficient(there, 1, name) * ball(box[name])
        return value.intersection(linear + squared * self._coefficient(box, 2, name))

    def slope(self, box: Box, name: str) -> arb | None:
        """Return a ball that holds the slopes in a variable; None where there is none."""
        try:
            if self._singular(box) in ("", name):
                return self._coefficient(box, 1, name)
        except NotEnclosed:
            pass
        return None

    def mean_value(self, box: Box, slopes: Mapping[str, arb | None]) -> arb:
        """Return a ball that holds the values over the box, by its middle and the slopes."""
        value = self.value(box)
        free = [name for name, (low, high) in box.items() if low < high]
        if not free or any(slopes[name] is None for name in free):
            return value
        middle = _middle(box)
        mean = self.value(middle)
        for name in free:
            slope = slopes[name]
            assert slope is not None
            mean += slope * (ball(box[name]) - ball(middle[name]))
        return mean if mean.rad() < value.rad() else value

    def _singular(self, box: Box) -> str:
        """Return the variable that divides and whose side contains or nearly contains 0."""
        sides = {name: box[name] for name in self.powers}
        # The distance from 0 is at most the width.
        names = [
            name
            for name, (low, high) in sides.items()
            if low <= 0 <= high or min(abs(low), abs(high)) <= high - low
        ]
        if len(names) > 1:
            raise NotEnclosed("two variables that vanish")
        return names[0] if names else ""

    def _coefficient(self, box: Box, order: int, along: str = "") -> arb:
        singular = self._singular(box)
        if not singular:
            return _series(self.graph, self.direct, box, along, order + 1)[order]
        low, high = box[singular]
        hull = {**box, singular: (min(low, Fraction(0)), max(high, Fraction(0)))}
        order += self.powers[singular]
        if order >= HIGHEST_ORDER:
            raise NotEnclosed("a high power in a denominator")
        coefficient = _series(self.graph, self.top, hull, singular, order + 1)[order]
        for name, power in self.powers.items():
            if name != singular:
                coefficient /= ball(box[name]) ** power
        return coefficient


def _series(graph: Graph, root: int, box: Box, along: str, length: int) -> arb_series:
    """Return the series of a node in t, where the variable ``along`` is its side plus t."""
    values: dict[int, arb_series] = {}
    previous_cap, ctx.cap = ctx.cap, length
    try:
        for number in graph.below([root]):
            node = graph[number]
            operands = [values[operand] for operand in node.operands]
            series = _node(node, operands, box, along)
            # Zero times a series without a value would be zero.
            if not all(series[order].is_finite() for order in range(length)):
                raise NotEnclosed("a part that has no value somewhere")
            values[number] = series
    finally:
        ctx.cap = previous_cap
    return values[root]


def _node(node: Node, children: list[arb_series], box: Box, along: str) -> arb_series:
    if node.op == "const":
        return arb_series([arb(fmpq_of(node.value))])
    if node.op == "pi":
        return arb_series([arb.pi()])
    if node.op == "variable":
        return arb_series(
            [ball(box[node.name]), 1] if node.name == along else [ball(box[node.name])]
        )
    if node.op == "add":
        return children[0] + children[1]
    if node.op == "multiply":
        return children[0] * children[1]
    if node.op == "divide":
        return children[0] / _nonzero(children[1])
    if node.op == "power":
        return _power(children[0], node.value)
    if node.op == "call" and node.name in FUNCTIONS:
        return FUNCTIONS[node.name](children[0])
    raise Unknown(node.op)


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


def _faces(box: Box, slopes: Mapping[str, arb | None]) -> tuple[Box, Box, arb]:
    """Return where on a piece the expression is least and largest by its slopes, up to an error.

    Where a bound is attained a slope is 0, and its ball reaches beyond 0 by its rounding: with
    s >= -e the expression is nowhere below its value at the lower end by more than e times the
    width.
    """
    low_face, high_face, error = dict(box), dict(box), arb(0)
    for name, (low, high) in box.items():
        slope = slopes[name]
        if slope is None or not slope.is_finite():
            continue
        size = abs(slope).upper() * SLOPE_ROUNDING
        for against, ends in ((-slope.lower(), (low, high)), (slope.upper(), (high, low))):
            if against <= size:
                low_face[name], high_face[name] = ((end, end) for end in ends)
                error += arb(fmpq_of(high - low)) * max(arb(0), against)
                break
    return low_face, high_face, error


def _middle(box: Box) -> Box:
    return {name: ((low + high) / 2,) * 2 for name, (low, high) in box.items()}


def _halves(box: Box, slopes: Mapping[str, arb | None], powers: Mapping[str, int]) -> list[Box]:
    """Return both halves, cut across the side along which the expression changes most."""

    def change(name: str) -> tuple[bool, float]:
        width, slope = float(box[name][1] - box[name][0]), slopes[name]
        is_bounded = slope is not None and slope.is_finite()
        steepness = float(abs(slope).upper()) if slope is not None and is_bounded else 1.0
        return not is_bounded, width * steepness

    name = max((n for n in box if box[n][0] < box[n][1]), key=change, default="")
    if not name:
        raise NotEnclosed("a point at which the bounds are not decided")
    low, high = box[name]
    # A side is cut at 0 where the variable divides, so that neither half has 0 inside.
    cut = Fraction(0) if name in powers and low < 0 < high else (low + high) / 2
    return [{**box, name: (low, cut)}, {**box, name: (cut, high)}]


def ball(side: Side) -> arb:
    """Return a ball that holds a side."""
    low, high = fmpq_of(side[0]), fmpq_of(side[1])
    return arb((low + high) / 2, (high - low) / 2) if low < high else arb(low)


def fmpq_of(value: Fraction) -> fmpq:
    """Return a fraction as a number of FLINT."""
    return fmpq(value.numerator, value.denominator)
