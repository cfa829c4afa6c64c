r"""``sector-embedding``: on its box the plant is the blend of its vertices.

1. Equations, outputs and mass matrix are defined everywhere on the box; det M is not 0.
   A signal marked ``unknown`` has a column of 0 in E, and no gain goes with it.
2. M(x) (A(z(x)) dx + B(z(x)) du + E(z(x)) dw) = f, and C dx + D du = y - y at rest, by algebra.
3. Every premise keeps its bounds, by bisection of ranges with rational ends.
4. Each entry has at most degree one in each premise (``plant``).

Steps that this checker cannot decide, such as ranges of tables or N / x^2 at x = 0, raise
``NotReplayed``.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import NotReplayed, entry, rationals
from takagi.certificates.cross_check.loop.loop import close
from takagi.certificates.cross_check.plant.algebra import Algebra, identical, not_zero
from takagi.certificates.cross_check.plant.expression import (
    Tree,
    minus,
    names_in,
    number,
    plus,
    put,
    times,
    value_of,
)
from takagi.certificates.cross_check.plant.interval import Box, Interval, Undefined, range_of
from takagi.certificates.cross_check.plant.law_fits import goes_with_known
from takagi.certificates.cross_check.plant.plant import (
    TreePlant,
    Variable,
    plant_loop,
    plant_of_form,
)

MOST_BOXES, MOST_ROWS = 6_000, 6


def embedded(model: Any, gains: Any) -> Obligations:
    """Yield the facts of the module, in its order."""
    plant = plant_of_form(model, "sector")
    if gains is not None:
        yield from trim_fits(plant, gains)
        if "references" in gains:
            # Imported here: most laws follow no reference.
            from takagi.certificates.cross_check.plant.law_fits import followed

            yield from followed(model, plant, gains)
    yield from _unknown_to_the_law(model, plant, gains)
    differences = _differences(plant)
    at_zero = {v.symbol: number(0) for v in plant.variables}
    algebra = Algebra([
        *(tree for _, tree in differences),
        *_numerators(plant.f + plant.outputs + [p.tree for p in plant.premises], at_zero),
    ])  # fmt: skip
    box = {v.symbol: v.side for v in plant.variables}
    search = Search(algebra, box)
    for label, tree in _parts(plant):
        yield Fact(f"{label} is defined", search.holds(tree, lambda found: True))
    if plant.mass is not None:
        if len(plant.mass) > MOST_ROWS:
            raise NotReplayed("a mass matrix of many rows")
        away = search.holds(_determinant(plant.mass), not_zero)
        yield Fact("the mass matrix is regular", away)
    for label, tree in differences:
        yield Fact(label, identical(algebra, tree, box, label))
    yield from within(plant, search)


def _unknown_to_the_law(model: Any, plant: TreePlant, gains: Any) -> Obligations:
    """Yield that unknown signals occur in coefficients alone, and that no gain depends on one."""
    hidden = [v for v in plant.pushes if v.unknown]
    if not hidden:
        return
    columns = [plant.pushes.index(v) for v in hidden]
    rows = plant.entries.get("E", [])
    still = all(value_of(row[k]) == 0 for row in rows for k in columns)
    yield Fact("unknown signals do not push the state", still)
    if gains is None:
        return
    free = goes_with_known(plant, {v.symbol for v in hidden}, gains)
    yield Fact("no gain goes with an unknown signal", free)
    loop = close(plant_loop(model), gains)
    yield Fact("gains go by the weights of the model", len(loop.K) == 1 or loop.together)


def within(plant: TreePlant, search: Search) -> Obligations:
    """Yield that every premise keeps its bounds."""
    for k, p in enumerate((*plant.premises, *plant.numbers)):
        kept = search.holds(p.tree, _between(p.lower, p.upper))
        yield Fact(f"premise {k + 1} keeps its bounds", kept)


def trim_fits(plant: TreePlant, gains: Any) -> Obligations:
    """Yield the fact that the law's trim is the plant's equilibrium."""
    trim = entry(gains, "trim")
    for key, variables in (("state", plant.states), ("input", plant.inputs)):
        if variables:
            for v, stated in zip(variables, rationals(trim, key, len(variables)), strict=True):
                found = range_of(v.rest, {}, lambda *_: False)
                off = _rounding(abs(stated), v.side)
                near = found is not None and max(abs(stated - end) for end in found) <= off
                yield Fact("the law's trim is the plant's", near)


def _rounding(value: fmpq, side: Interval) -> fmpq:
    """Return by how much a law's decimals may miss a rest of this size that is no decimal.

    Its first twelve digits are right, and the error is a billionth of the range at most.
    """
    most = value / 10**12
    return most if side is None else min(most, (side[1] - side[0]) / 10**9)


def _parts(plant: TreePlant) -> list[tuple[str, Tree]]:
    found = [(f"equation {k + 1}", tree) for k, tree in enumerate(plant.f)]
    found += [(f"output {k + 1}", tree) for k, tree in enumerate(plant.outputs)]
    return found + [("the mass matrix", tree) for row in plant.mass or [] for tree in row]


def _numerators(trees: list[Tree], at_zero: dict[str, Tree]) -> list[Tree]:
    """Return the numerators of all quotients, also with a variable of the denominator set to 0.

    ``Search`` may later ask whether they vanish there, and the algebra must know their angles then.
    """
    found: list[Tree] = []
    for tree in trees:
        if tree[0] == "/":
            found.append(tree[1])
            found += [put(tree[1], {name: at_zero[name]}) for name in set(names_in(tree[2]))
                      if name in at_zero]  # fmt: skip
        found += _numerators([part for part in tree[1:] if _is_tree(part)], at_zero)
        if tree[0] == "call":
            found += _numerators(list(tree[2]), at_zero)
    return found


def _is_tree(part: Any) -> bool:
    return isinstance(part, tuple) and bool(part) and isinstance(part[0], str)


def _differences(plant: TreePlant) -> list[tuple[str, Tree]]:
    """Return (label, tree that must be 0) for each row of step 2."""
    z = {p.name: p.tree for p in (*plant.premises, *plant.numbers)}
    variables: dict[str, list[Variable]] = dict.fromkeys("AC", plant.states)
    variables |= {"B": plant.inputs, "D": plant.inputs, "E": plant.pushes}

    def rows(letters: str, count: int) -> list[Tree]:
        found = [number(0)] * count
        for letter in letters:
            for i, row in enumerate(plant.entries.get(letter, [])):
                for one, v in zip(row, variables[letter], strict=True):
                    found[i] = plus(found[i], times(put(one, z), ("name", v.symbol)))
        return found

    rates = rows("ABE", len(plant.states))
    if plant.step is not None:
        rates = [plus(v.rest, rate) for v, rate in zip(plant.states, rates, strict=True)]
    if plant.mass is not None:
        whole = []
        for row in plant.mass:
            total = number(0)
            for m, rate in zip(row, rates, strict=True):
                total = plus(total, times(m, rate))
            whole.append(total)
        rates = whole
    at_rest = {v.symbol: number(0) for v in plant.variables}
    found = [(f"equation {k + 1}", plus(a, minus(b)))
             for k, (a, b) in enumerate(zip(rates, plant.f, strict=True))]  # fmt: skip
    for k, (a, y) in enumerate(zip(rows("CD", len(plant.outputs)), plant.outputs, strict=True)):
        found.append((f"output {k + 1}", plus(a, plus(minus(y), put(y, at_rest)))))
    return found


def _determinant(rows: list[list[Tree]]) -> Tree:
    """Return the determinant, expanded along the first row."""
    if not rows:
        return number(1)
    total = number(0)
    for j, one in enumerate(rows[0]):
        if one != number(0):
            minor = _determinant([[*row[:j], *row[j + 1 :]] for row in rows[1:]])
            term = times(one, minor)
            total = plus(total, minus(term) if j % 2 else term)
    return total


def _between(lower: fmpq, upper: fmpq) -> Callable[[Interval], bool]:
    return lambda a: a is not None and lower <= a[0] and a[1] <= upper


class Search:
    """Bisection of the box until the range of a tree is good on every part.

    ``limits`` : N / x is enclosed across x = 0 where N is shown to vanish there.
    """

    def __init__(self, algebra: Algebra, box: dict[str, Interval], *, limits: bool = True) -> None:
        self.algebra, self.box, self.limits = algebra, box, limits
        self.removed: dict[tuple[Tree, str], bool] = {}

    def removable(self, top: Tree, name: str) -> bool:
        """Return whether a numerator is shown to vanish where the variable is 0."""
        if not self.limits:
            return False
        key = (top, name)
        if key not in self.removed:
            self.removed[key] = self.algebra.vanishes(put(top, {name: number(0)}))
        return self.removed[key]

    def holds(self, tree: Tree, good: Callable[[Interval], bool]) -> bool:
        """Return True where every part of the box is good, False at a point that is not.

        Raises
        ------
        NotReplayed : neither was found in ``MOST_BOXES`` boxes.
        """
        names = sorted(set(names_in(tree)) & set(self.box))
        waiting: list[Box] = [{name: self.box[name] for name in names}]
        for _ in range(MOST_BOXES):
            if not waiting:
                return True
            box = waiting.pop()
            if self._good(tree, box, good):
                continue
            sides = {n: side for n, side in box.items() if side is not None}
            if self._bad_point(tree, box, good):
                return False
            wide = max(sides, key=lambda n: self._share(n, sides[n]), default="")
            if not wide or sides[wide][0] == sides[wide][1]:
                break
            low, high = sides[wide]
            # A cut at 0 makes a denominator x of one sign in both halves, apart from the end 0.
            middle = fmpq(0) if low < 0 < high else (low + high) / 2
            waiting += [{**box, wide: (low, middle)}, {**box, wide: (middle, high)}]
        raise NotReplayed("a range that this search does not settle")

    def _share(self, name: str, side: tuple[fmpq, fmpq]) -> fmpq:
        whole = self.box[name]
        return fmpq(0) if whole is None else (side[1] - side[0]) / (whole[1] - whole[0])

    def _good(self, tree: Tree, box: Box, good: Callable[[Interval], bool]) -> bool:
        try:
            return good(range_of(tree, box, self.removable))
        except Undefined:
            return False

    def _bad_point(self, tree: Tree, box: Box, good: Callable[[Interval], bool]) -> bool:
        """Return whether the value at a corner or at the middle is certainly not good."""
        if any(side is None for side in box.values()):
            return False
        ends = [[(side[0], side[0]), (side[1], side[1])] for side in box.values() if side]
        middle = tuple(((s[0] + s[1]) / 2,) * 2 for s in box.values() if s)
        for place in [*product(*ends), middle] if len(ends) <= 4 else [middle]:
            try:
                a = range_of(tree, dict(zip(box, place, strict=True)), self.removable)
            except Undefined as reason:
                if reason.surely:
                    return True
                continue
            # The value lies between two ends that are less than 1e-30 apart.  Where neither end is
            # good the value counts as not good: the claim is UNDECIDED then, never DISPROVED.
            if a is not None and a[1] - a[0] < fmpq(1, 10**30):
                if not good((a[0], a[0])) and not good((a[1], a[1])):
                    return True
        return False
