r"""Numbers that are not decimals: derived parameters, and rests that were solved for.

A certificate gives such a number as a ball: a decimal c and a radius r.  In the graph it is a
variable with the range [c - r, c + r].  Two kinds are proved here, before anything uses them:

1. A number that ``equals`` an expression without variables: its enclosure lies in the ball.
2. The rests s that were solved for.  F(s) are the rows of f at rest (in discrete time f - M x*)
   that do not vanish by algebra; there must be as many as there are s.  Let F' be the slopes over
   the balls, and Y a regular matrix near the inverse of F'(c).  The condition is

       |Y F(c)|_i + sum_k |I - Y F'|_ik r_k < r_i   for every i.

   Then F has exactly one zero in the balls.  Proof: g(s) = s - Y F(s) has the slopes I - Y F'.  By
   the mean value theorem |g(s) - c|_i is at most the left side.  So g maps the balls into
   themselves, and it is a contraction in the norm max |s_i| / r_i.  It has one fixed point, at
   which Y F = 0.  Y is regular, because |I - Y F'| < 1 in that norm; so F vanishes there.  The
   other rows vanish by algebra, so the plant rests.

In F the numbers of kind 1 are replaced by the expressions that they equal.

Source: Krawczyk (1969), Computing 4, 187-201; Neumaier (1990), Interval Methods, section 5.1
(recalled).
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.interval import ONE, enclose, product
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.derivative import derivative, substituted
from takagi.certificates.checker.plant.evaluate import Box
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import Ball, PlantNodes

MOST_SOLVED = 12
Ends = tuple[Fraction, Fraction]


def residuals(plant: PlantNodes) -> list[int]:
    """Return the rows of f at rest (in discrete time f - M x*), which are 0 at the plant's rest."""
    g = plant.graph
    left_sides = [g.constant(0)] * len(plant.states)
    if plant.sample_time is not None:
        left_sides = [v.rest for v in plant.states]
    rows = zip(plant.f, plant.times_mass(left_sides), strict=True)
    return [plant.at_rest(g.subtract(node, left_side)) for node, left_side in rows]


def prove_balls(plant: PlantNodes, algebra: Algebra, ranges: Ranges) -> None:
    """Prove that every ball contains its number, and that all ``residuals`` vanish there.

    Raises
    ------
    Refused : a ball is not shown to contain its number, or the balls to contain a rest.
    """
    g = plant.graph
    closed: dict[str, int] = {}
    for ball in plant.balls.values():
        if ball.equals is not None:
            ranges.prove_defined(ball.equals, ball.name)
            enclosure = ranges.evaluator.value(ball.equals, {})
            if enclosure is None or not enclosure.within(*ball.side):
                raise Refused(f"{ball.name} is not shown to lie in its ball")
            closed[ball.name] = ball.equals
    rows = []
    for node in residuals(plant):
        ranges.prove_defined(node, "an equation at rest")
        row = substituted(g, node, closed)
        if not algebra.vanishes(node) and not algebra.vanishes(row):
            ranges.prove_defined(row, "an equation at rest")
            rows.append(row)
    solved = [ball for ball in plant.balls.values() if ball.equals is None]
    if len(rows) != len(solved) or len(rows) > MOST_SOLVED:
        raise Refused(
            f"{len(rows)} equations do not vanish by algebra at rest, for {len(solved)} values "
            "that were solved for"
        )
    if rows:
        _prove_zero(ranges, rows, solved)


def relations(plant: PlantNodes, algebra: Algebra) -> dict[str, int]:
    """Return solved rest -> its node, from the equations at rest that are linear in it."""
    g = plant.graph
    solved_rests: dict[str, int] = {}
    for row in residuals(plant):
        node = substituted(g, row, solved_rests)
        try:
            linear = algebra.polynomial(node)
        except Refused:
            continue
        names = [m[0][0] for m in linear if m]
        solved = [n for n in names if n in plant.balls and plant.balls[n].equals is None]
        if not solved or any(len(m) > 1 or m[0][1] > 1 for m in linear if m):
            continue
        leading = ((solved[-1], 1),)
        value = g.total(
            g.multiply(
                g.constant(-c / linear[leading]), g.variable(m[0][0]) if m else g.constant(1)
            )
            for m, c in linear.items()
            if m != leading
        )
        solved_rests = {n: substituted(g, e, {solved[-1]: value}) for n, e in solved_rests.items()}
        solved_rests[solved[-1]] = value
    return solved_rests


def _prove_zero(ranges: Ranges, rows: list[int], solved: list[Ball]) -> None:
    """Prove that the rows vanish at one point of the balls of ``solved``."""
    g, size = ranges.graph, range(len(rows))
    slopes = [[derivative(g, row, ball.name) for ball in solved] for row in rows]
    for node in (node for line in slopes for node in line):
        if any(g[operand].op == "sign" for operand in g.below([node])):
            raise Refused("an absolute value has a kink at rest")
        ranges.prove_defined(node, "a slope at rest")
    box = {ball.name: enclose(*ball.side) for ball in solved}
    # The middles are rounded outward to the grid, so that F(c) is enclosed and Y is only near the
    # inverse; the condition holds for any regular Y.
    centre = {ball.name: enclose(ball.middle, ball.middle) for ball in solved}
    at = [_value(ranges, row, centre) for row in rows]
    over = [[_value(ranges, node, box) for node in line] for line in slopes]
    Y = _inverse([[_value(ranges, node, centre)[0] for node in line] for line in slopes])
    for i, ball in enumerate(solved):
        reach = _largest(_combined(Y[i], at))
        for k in size:
            low, high = _combined(Y[i], [over[j][k] for j in size])
            reach += _largest((int(i == k) - high, int(i == k) - low)) * solved[k].radius
        if not reach < ball.radius:
            raise Refused(f"no rest is shown in the ball of {ball.name}")


def _value(ranges: Ranges, node: int, box: Box) -> Ends:
    enclosure = ranges.evaluator.value(node, box)
    if enclosure is None:
        raise Refused("an equation at rest has no value in the balls")
    return Fraction(enclosure[0], ONE), Fraction(enclosure[1], ONE)


def _combined(factors: list[Fraction], intervals: list[Ends]) -> Ends:
    """Return the range of sum_j factors_j intervals_j."""
    terms = [product((c, c), interval) for c, interval in zip(factors, intervals, strict=True)]
    return sum((t[0] for t in terms), Fraction(0)), sum((t[1] for t in terms), Fraction(0))


def _largest(ends: Ends) -> Fraction:
    return max(abs(ends[0]), abs(ends[1]))


def _inverse(rows: list[list[Fraction]]) -> list[list[Fraction]]:
    """Return the exact inverse, by Gauss and Jordan's elimination.

    Raises
    ------
    Refused : the matrix is singular.
    """
    size = len(rows)
    work = [[*row, *(Fraction(i == k) for k in range(size))] for i, row in enumerate(rows)]
    for i in range(size):
        pivot = max(range(i, size), key=lambda k: abs(work[k][i]))
        if work[pivot][i] == 0:
            raise Refused("the slopes at rest are singular")
        work[i], work[pivot] = work[pivot], work[i]
        work[i] = [value / work[i][i] for value in work[i]]
        for k in range(size):
            if k != i and work[k][i] != 0:
                factor = work[k][i]
                work[k] = [a - factor * b for a, b in zip(work[k], work[i], strict=True)]
    return [row[size:] for row in work]
