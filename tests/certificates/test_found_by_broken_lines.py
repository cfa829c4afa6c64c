"""What no test had noticed of broken lines, and would have let a false claim pass."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import permutations, product
from math import prod

import pytest

from takagi.certificates.checker.arithmetic.dual import Dual, chained, greater, lesser
from takagi.certificates.checker.arithmetic.interval import Interval, enclose
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant import ranges
from takagi.certificates.checker.plant.evaluate import Evaluator
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.words.ellipsoid_size import _determinant

Exact = tuple[Fraction, tuple[Fraction, ...]]


def leibniz(rows: list[list[Fraction]]) -> Fraction:
    """The determinant, as the sum over all permutations with their signs."""
    size, total = len(rows), Fraction(0)
    for order in permutations(range(size)):
        odd = sum(order[i] > order[j] for i in range(size) for j in range(i, size)) % 2
        total += (-1) ** odd * prod(rows[i][order[i]] for i in range(size))
    return total


def test_the_size_of_an_ellipsoid_rests_on_the_determinant() -> None:
    """Elimination gives what the sum over all permutations gives, for L L' + 3 I."""
    draw = random.Random(1)
    for size in (1, 2, 3, 4, 5):
        L = [[draw.randint(-9, 9) for _ in range(size)] for _ in range(size)]
        rows = [[sum(a * b for a, b in zip(p, q, strict=True)) + 3 * (p is q) for q in L]
                for p in L]  # fmt: skip
        exact = leibniz([[Fraction(v, 7) for v in row] for row in rows])
        assert _determinant(Matrix(rows, 7)) == exact


def graph_of(text: str) -> tuple[Graph, int]:
    graph = Graph()
    scope = Scope({name: graph.variable(name) for name in "xy"}, {})
    return graph, read_expression(text, graph, scope, "here")


def same(first: str, second: str) -> bool:
    graph, difference = graph_of(f"({first}) - ({second})")
    return Algebra(graph, {}).equal(difference, graph.constant(0))


def test_an_angle_with_large_multiples_is_not_doubled() -> None:
    """sin(x/y) is 40 times the unit that sin(x/40y) brings, and is taken whole then."""
    rest = "sin(x/(40*y))"
    half = "sin(x/(2*y))*cos(x/(2*y))"

    assert same(f"sin(x/y) + {rest}", f"2*{half} + {rest}")
    assert not same(f"sin(x/y) + {rest}", f"4*{half}*(1 - 2*sin(x/(2*y))^2) + {rest}")


def exactly(x: Fraction, y: Fraction) -> Exact:
    """(x y - x) / (y + 3) + 2 x - y / 7 at a point, with its slopes in x and y."""
    value = (x * y - x) / (y + 3) + 2 * x - y / 7
    return value, ((y - 1) / (y + 3) + 2, 4 * x / (y + 3) ** 2 - Fraction(1, 7))


def number(value: Fraction) -> Interval:
    return enclose(value, value)


@pytest.mark.parametrize("size", [0, 1])
@pytest.mark.parametrize("low", [(-2, -1), (0, 0), (1, 2)])
def test_slopes_over_a_box_contain_those_at_its_points(low: tuple[int, int], size: int) -> None:
    """Sums, negatives, products, quotients, and products with a number.

    A box would hide a sign: at a point nothing is lost but rounding.
    """
    one, none = number(Fraction(1)), number(Fraction(0))
    x, y = (Interval(k * 10**36, (k + size) * 10**36) for k in low)
    a, b = Dual(x, (one, none)), Dual(y, (none, one))

    found = (a * b - a) / b.plus(number(Fraction(3)))
    found = found + a.by(number(Fraction(2))) - b.by(number(Fraction(1, 7)))

    for s, t in product((Fraction(k, 4) * size for k in range(5)), repeat=2):
        value, slopes = exactly(low[0] + s, low[1] + t)
        brackets = zip((found.value, *found.slopes), (value, *slopes), strict=True)
        assert all(least <= exact * 10**36 <= most for (least, most), exact in brackets)
    assert size or all(most <= least + 20 for least, most in (found.value, *found.slopes))


SIDES = [(low, high) for low in range(-2, 2) for high in range(low + 1, 3)]


@pytest.mark.parametrize("larger", [True, False])
@pytest.mark.parametrize("x", SIDES)
def test_the_larger_of_two_has_the_slopes_of_both_where_either_may_be(
    x: tuple[int, int], larger: bool
) -> None:
    """At points where x is larger than y and where it is smaller, for all places of both ranges."""
    one, none = number(Fraction(1)), number(Fraction(0))
    for y in SIDES:
        a = Dual(Interval(x[0] * 10**36, x[1] * 10**36), (one, none))
        b = Dual(Interval(y[0] * 10**36, y[1] * 10**36), (none, one))
        found = greater(a, b) if larger else lesser(a, b)
        for s, t in product(*([low + (high - low) * Fraction(k, 7) for k in range(8)]
                              for low, high in (x, y))):  # fmt: skip
            if s != t:
                slopes = (1, 0) if (s > t) is larger else (0, 1)
                exact = [s if (s > t) is larger else t, *map(Fraction, slopes)]
                brackets = zip((found.value, *found.slopes), exact, strict=True)
                assert all(low <= value * 10**36 <= high for (low, high), value in brackets)


def test_a_function_of_two_has_the_slopes_that_each_brings() -> None:
    """f(x, y) with the partial derivatives 2 and -5, of x = (s, 3 t) and y = (7 s, t)."""

    def dual(*slopes: int) -> Dual:
        return Dual(number(Fraction(1)), tuple(number(Fraction(k)) for k in slopes))

    two, five = number(Fraction(2)), number(Fraction(-5))
    found = chained(number(Fraction(4)), (two, dual(1, 3)), (five, dual(7, 1)))

    assert found == Dual(number(Fraction(4)), dual(2 - 35, 6 - 5).slopes)


def test_a_quantity_that_is_clamped_has_no_slope() -> None:
    x = Dual(Interval(3 * 10**36, 4 * 10**36), (number(Fraction(1)), number(Fraction(2))))
    zero, one = number(Fraction(0)), number(Fraction(1))

    assert x.clamped(zero, one) == Dual(one, (zero, zero))
    assert x.clamped(zero, number(Fraction(5))) == x


def boxes_of_a_sine() -> int:
    """Prove 0.84 <= sin(x)/x <= 1 over [-1, 1]; return how many boxes that took."""
    graph, root = graph_of("sin(x)/x")
    one = Fraction(1)
    evaluator = Evaluator(graph, {}, {"x": (-one, one)})
    search = ranges.Ranges(evaluator, Algebra(graph, {}), {"x": enclose(-one, one)})
    search.prove_within(root, Fraction("0.84"), one, "it")
    return search.boxes


@pytest.mark.parametrize("name", ["MOST_BOXES", "MOST_IN_ALL"])
def test_a_bound_is_given_up_after_so_many_boxes(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Either limit ends the search: that of one bound, and that of all bounds together."""
    boxes = boxes_of_a_sine()
    monkeypatch.setattr(ranges, name, boxes)
    assert boxes_of_a_sine() == boxes

    monkeypatch.setattr(ranges, name, boxes - 1)
    with pytest.raises(Refused, match="not shown to stay in its bounds"):
        boxes_of_a_sine()
