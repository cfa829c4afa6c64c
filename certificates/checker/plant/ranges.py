"""Bounds and signs of nodes over a box, proved by bisection.

On each box the interval evaluation is tried first.  Then each variable in which the node is
monotone is set to its ends, and for the others the mean-value form
f(m) + sum_i f_i(X) (X_i - m_i) is used, f_i being partial derivatives.  A box that stays undecided
is halved, at 0 if a denominator vanishes there.  The search is part of the checker: a certificate
states bounds, but no boxes.

Where a vanishes inside a box the slope of |a| is taken as [-1, 1], and where a vanishes at its edge
as the slope beside it.  This is enough for monotonicity and for the mean-value form, since the
function is absolutely continuous along each axis.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.evaluate import Box, Evaluator
from takagi.certificates.checker.plant.graph import Node
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.linear_sum import (
    LinearSum,
    vanishing_sums,
    with_variable,
)
from takagi.certificates.checker.plant.quotient_form import Form, parted, with_signs

MOST_BOXES = 4_000  # for one bound
MOST_IN_ALL = 40_000  # for all bounds of one ``Ranges``
MOST_POLES, MOST_POWERS = 3, 8  # variables that vanish in one denominator, and their powers
MANY = "is divided by too many variables that vanish on the box"
ROUNDING = 10**9  # units of the grid by which rounding may miss a bound that is attained
SPLINES = ONE // 10**12  # the same for splines, whose ranges are rounded more coarsely
ENDLESS = 10**400 * ONE  # no bound on this side
Bounds = tuple[int, int]


class Ranges:
    """Proofs about nodes over one box.

    Attributes
    ----------
    box : range of each relevant variable; a variable without a range is unbounded.
    boxes : the number of boxes examined so far.
    removable : the variables at whose zero some quotient is defined by its limit.
    signs : |v|/v is sign(v), with every value in [-1, 1] at v = 0; the caller has to show that it
        matters nowhere which one it is.
    """

    def __init__(
        self, evaluator: Evaluator, algebra: Algebra, box: Box, *, signs: bool = False
    ) -> None:
        self.signs = signs
        self.evaluator, self.algebra, self.box = evaluator, algebra, dict(box)
        self.graph = evaluator.graph
        self.boxes = 0
        self.removable: set[str] = set()
        self._sums: dict[LinearSum, str] = {}
        self._defined: set[int] = set()

    # ------------------------------------------------------------------ claims

    def prove_within(self, root: int, lower: Fraction, upper: Fraction, subject: str) -> None:
        """Prove that the node is defined on the box and lower <= node <= upper, limits included.

        Raises
        ------
        Refused : a value lies outside, a part has a singularity, or the search does not decide.
        """
        form = self.form(root, subject)
        for name in form.poles:
            if form.continued(name) is None:
                raise Refused(f"{subject} has no limit at {name} = 0 that this checker can show")
        # On the grid the bounds are rounded inward: rounding cannot make a proof of what is false.
        low = -(-lower.numerator * ONE // lower.denominator)
        high = upper.numerator * ONE // upper.denominator
        self._prove(form, (low, high), subject, (lower, upper))

    def prove_continuous(self, root: int, subject: str) -> None:
        """Prove that the node is defined and continuous on the box, except at removable zeros."""
        self.form(root, subject)

    def prove_nonzero(self, root: int, subject: str) -> None:
        """Prove that the node has no zero on the box."""
        self.prove_defined(root, subject)
        self._nonzero(root, subject)

    def form(self, root: int, subject: str) -> Form:
        """Return N / x^k for a node, after proving that every part of N is defined on the box."""
        root = self._with_sums(with_signs(self.graph, root) if self.signs else root, subject)
        vanishing = frozenset(v for v, side in self.box.items() if side[0] <= 0 <= side[1])
        top, poles = parted(self.graph, root, vanishing)
        if len(poles) > MOST_POLES or sum(poles.values()) > MOST_POWERS:
            raise Refused(f"{subject} {MANY}")
        self.prove_defined(top, subject)
        self.removable |= set(poles)
        return Form(self.evaluator, self.algebra, top, poles)

    def _with_sums(self, root: int, subject: str) -> int:
        """Return the node with a variable for each sum in a denominator that may vanish."""
        sums = vanishing_sums(self.graph, root, self.evaluator.sides)
        if len(sums) > MOST_POLES:
            raise Refused(f"{subject} {MANY}")
        for a, side in sums.items():
            (name, _), *further_factors = a.factors
            if further_factors:
                name = self._sums.setdefault(a, a.name(len(self._sums) + 1))
                self.box[name] = self.evaluator.add_side(name, side)
            root = with_variable(self.graph, root, a, self.graph.variable(name))
        return root

    # ------------------------------------------------------------------ where parts are defined

    def prove_defined(self, root: int, subject: str) -> None:
        """Prove that every part of the node is defined on the whole box."""
        numbers = self.graph.below([root])
        idle = any(self.graph.has_zero_factor(number) for number in numbers)
        for number in numbers:
            if number not in self._defined:
                try:
                    self._define_one(self.graph[number], subject)
                except Refused as error:
                    if not idle:
                        raise
                    raise Refused(f"{error}; leave out what is multiplied by 0") from error
                self._defined.add(number)

    def _define_one(self, node: Node, subject: str) -> None:
        if node.op == "divide":
            self._nonzero(node.operands[1], f"{subject}: a denominator")
        elif node.op == "power":
            base, is_integer_power = node.operands[0], node.value.denominator == 1
            if node.value < 0 and is_integer_power:
                self._nonzero(base, f"{subject}: a denominator")
            elif not is_integer_power:
                self._bound(base, int(node.value < 0), ENDLESS, f"{subject}: a root's argument")
        elif node.op == "table":
            sides = self.evaluator.tables[node.name].sides
            for argument, (low, high) in zip(node.operands, sides, strict=True):
                ends = (-(-low.numerator * ONE // low.denominator),
                        high.numerator * ONE // high.denominator)  # fmt: skip
                self._bound(argument, *ends, f"{subject}: an argument of the table {node.name}")
        elif node.op == "call":
            domains: dict[str, Bounds] = {
                "log": (1, ENDLESS),
                "asin": (-ONE, ONE),
                "acos": (-ONE, ONE),
                "acosh": (ONE, ENDLESS),
                "atanh": (1 - ONE, ONE - 1),
                "exp": (-700 * ONE, 700 * ONE),
                "sinh": (-700 * ONE, 700 * ONE),
                "cosh": (-700 * ONE, 700 * ONE),
            }
            if node.name in domains:
                self._bound(
                    node.operands[0],
                    *domains[node.name],
                    f"{subject}: an argument of {node.name}",
                )
            elif node.name == "tan":
                self._nonzero(self.graph.call("cos", node.operands[0]), f"{subject}: cos under tan")

    def _nonzero(self, root: int, subject: str) -> None:
        form = Form(self.evaluator, self.algebra, root, {})
        # A continuous function without a zero has one sign, so its sign in the middle is to be
        # proved.
        at = form.value({name: _middle(self._side(name, subject)) for name in form.variables})
        if at is None or at[0] <= 0 <= at[1]:
            raise Refused(f"{subject} vanishes, or may vanish, in the middle of the box")
        self._prove(form, (1, ENDLESS) if at[0] > 0 else (-ENDLESS, -1), subject)

    def _bound(self, root: int, low: int, high: int, subject: str) -> None:
        self._prove(Form(self.evaluator, self.algebra, root, {}), (low, high), subject)

    def _side(self, name: str, subject: str) -> Interval:
        if name not in self.box:
            raise Refused(f"{subject} depends on {name}, which has no range")
        return self.box[name]

    # ------------------------------------------------------------------ bisection

    def _prove(
        self,
        form: Form,
        bounds: Bounds,
        subject: str,
        limits: tuple[Fraction, Fraction] | None = None,
    ) -> None:
        """Prove the bounds, which are on the grid; ``limits`` are the exact bounds, if others."""
        limits = limits or (Fraction(bounds[0], ONE), Fraction(bounds[1], ONE))
        full_box = {n: self._side(n, subject) for n in form.variables}
        remaining_boxes: list[dict[str, Interval]] = [full_box]
        box_count = 0
        while remaining_boxes:
            box = remaining_boxes.pop()
            box_count += 1
            self.boxes += 1
            # Work is counted for each bound and for all together, so that no file can block the
            # checker.
            if box_count > MOST_BOXES or self.boxes > MOST_IN_ALL:
                raise Refused(f"{subject} is not shown to stay in its bounds {_near(box)}")
            plain = form.value(box)
            if _inside(plain, bounds) or _attained(form, plain, box, box, limits):
                continue
            slopes = {n: form.slope(box, n) for n in form.variables}
            low, high = _monotone_ends(box, slopes)
            bracket, attained = _tightened(form, box, plain, slopes, low, high)
            if _inside(bracket, bounds) or _attained(form, bracket, low, high, limits):
                continue
            for value in attained:
                if value[1] < bounds[0] or value[0] > bounds[1]:
                    # With a sum as an extra variable this point may not belong to the box.
                    word = "may leave" if {*self._sums.values()} & box.keys() else "leaves"
                    raise Refused(f"{subject} {word} its bounds {_near(box)}")
            remaining_boxes += _halves(form, box, slopes, full_box, subject)


def _monotone_ends(
    box: dict[str, Interval], slopes: dict[str, Interval | None]
) -> tuple[dict[str, Interval], dict[str, Interval]]:
    """Return the face of the box that has the least value, and the face that has the greatest.

    Each variable in which the node is monotone is set to one end.
    """
    low, high = dict(box), dict(box)
    for name, (start, end) in box.items():
        slope = slopes[name]
        if slope is not None and not slope[0] < 0 < slope[1]:
            ends = (Interval(start, start), Interval(end, end))
            low[name], high[name] = ends if slope[0] >= 0 else ends[::-1]
    return low, high


def _attained(
    form: Form,
    bracket: Interval | None,
    low: dict[str, Interval],
    high: dict[str, Interval],
    limits: tuple[Fraction, Fraction],
) -> bool:
    """Return whether the exact ends keep the limits, if rounding may explain the excess."""
    if bracket is None:
        return False
    rounding = SPLINES if form.has_table else ROUNDING
    slack = Fraction(rounding, ONE) * max(1, abs(bracket[0]) // ONE, abs(bracket[1]) // ONE)
    if bracket[0] < (limits[0] - slack) * ONE or bracket[1] > (limits[1] + slack) * ONE:
        return False
    lowest, highest = form.exact_ends(low), form.exact_ends(high)
    return (
        lowest is not None
        and highest is not None
        and limits[0] <= lowest[0]
        and highest[1] <= limits[1]
    )


def _tightened(
    form: Form,
    box: dict[str, Interval],
    plain: Interval | None,
    slopes: dict[str, Interval | None],
    low: dict[str, Interval],
    high: dict[str, Interval],
) -> tuple[Interval | None, list[Interval]]:
    """Return a bracket over the box, and brackets of the values at two points of it."""
    free = [name for name in box if low[name] == high[name] == box[name]]
    free = [name for name in free if box[name][0] < box[name][1]]
    sides: list[Interval | None] = []
    attained = []
    for corner in (low, high):
        bracket = form.value(corner) if len(free) < len(box) else plain
        middle = {**corner, **{name: _middle(corner[name]) for name in free}}
        at = form.value(middle) if free else bracket
        if at is not None:
            attained.append(at)
            total, has_slopes = at, True
            for name in free:
                slope = slopes[name]
                if slope is None:
                    has_slopes = False
                    break
                m = middle[name][0]
                total = total + slope * Interval(box[name].low - m, box[name].high - m)
            if has_slopes:
                bracket = total if bracket is None else _common(bracket, total)
        sides.append(bracket)
    if sides[0] is None or sides[1] is None:
        return None, attained
    return Interval(sides[0].low, sides[1].high), attained


def _common(a: Interval, b: Interval) -> Interval:
    return Interval(max(a.low, b.low), min(a.high, b.high))


def _halves(
    form: Form,
    box: dict[str, Interval],
    slopes: dict[str, Interval | None],
    full: dict[str, Interval],
    subject: str,
) -> list[dict[str, Interval]]:
    """Return both halves of the box, cut across the side along which the node changes most.

    Without a slope it is the side with the largest share of its side of ``full``.
    """

    def change(name: str) -> tuple[int, Fraction]:
        width, slope = box[name][1] - box[name][0], slopes[name]
        if slope is None:
            return (1 if width > 1 else 0), Fraction(width, max(1, full[name][1] - full[name][0]))
        return 0, Fraction(max(-slope[0], slope[1]) * width if width > 1 else 0)

    if not box:
        raise Refused(f"{subject} is not shown to stay in its bounds")
    name = max(box, key=change)
    low, high = box[name]
    if high - low < 2:
        raise Refused(f"{subject} is not shown to stay in its bounds {_near(box)}")
    # Where x^k is divided out the box is cut at 0, so that neither half has the zero inside; and
    # where |x| or sign(x) has no slope.
    at_zero = name in form.poles or slopes[name] is None
    cut = 0 if at_zero and low < 0 < high else (low + high) // 2
    return [{**box, name: Interval(low, cut)}, {**box, name: Interval(cut, high)}]


def _middle(side: Interval) -> Interval:
    cut = (side[0] + side[1]) // 2
    return Interval(cut, cut)


def _inside(value: Interval | None, bounds: Bounds) -> bool:
    return value is not None and bounds[0] <= value[0] and value[1] <= bounds[1]


def _near(box: dict[str, Interval]) -> str:
    values = ", ".join(f"{n} = {(low + high) / 2 / ONE:.6g}" for n, (low, high) in box.items())
    return f"near {values}" if values else ""
