r"""``secant-embedding``: the plant's deviation from rest is a blend of its vertices.

f has continuous partial derivatives on the box, a convex set that contains the rest x*, so that

    f(x) - f(x*) = (int_0^1 f_x(x* + s (x - x*)) ds) (x - x*),

likewise for inputs, disturbances and outputs.  An entry that is affine in the premises has a mean
along the segment; it is the entry's value at the means of the premises.  These means keep the
bounds that the premises keep on the box.  The checker decides in this order:

1. There is no absolute value; equations, outputs and all their slopes are defined on the box.
2. At rest the equations are 0 (x* in discrete time).
   For an unknown signal with a column of 0 in E they are 0 at every value of it.
3. The slopes are equal to the entries, by algebra; no output depends on a disturbance.
4. Every premise keeps its bounds.

Source: the mean value theorem in its integral form.

Partial derivatives of trees, by the rules of differentiation.

    (a b)' = a' b + a b'      (a/b)' = a'/b - a b'/b^2      (a^q)' = q a^(q-1) a'
    F(a)'  = F'(a) a'         with F' from the table below

An absolute value has no derivative at 0, and this checker has no slopes of tables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import NotReplayed, Refusal, stack
from takagi.certificates.cross_check.plant.algebra import Algebra, identical
from takagi.certificates.cross_check.plant.embedding import Search, trim_fits, within
from takagi.certificates.cross_check.plant.expression import (
    Tree,
    minus,
    number,
    plus,
    put,
    times,
    value_of,
)
from takagi.certificates.cross_check.plant.plant import TreePlant, Variable, plant_of_form


def lies_in_secants(model: Any, gains: Any, *, at_rest: bool = True) -> Obligations:
    """Yield the facts of the module, in its order.

    Without ``at_rest`` they are about differences between any two points, and step 2 is left out.
    """
    plant = plant_of_form(model, "secant")
    if plant.mass is not None:
        raise Refusal("secants are of x' = f, without a mass matrix")
    if gains is not None:
        yield from trim_fits(plant, gains)
        K = stack(gains, "K")
        known = not any(v.unknown for v in plant.pushes)
        yield Fact("no gain goes with an unknown signal", known or all(one == K[0] for one in K))
        if "references" in gains:
            # Imported here: most laws follow no reference.
            from takagi.certificates.cross_check.plant.law_fits import followed

            yield from followed(model, plant, gains)
    whole = [*plant.f, *plant.outputs]
    yield Fact("there is no absolute value", not any(map(has_kink, whole)))
    still = [v for v in plant.pushes if v.unknown and _is_zero(plant, v)]
    slopes = list(_slopes(plant, still))
    resting = [*(_at_rest(plant) if at_rest else ()), *_at_rest_for_all(plant, still)]
    differences = [*resting, *((label, plus(a, minus(b))) for label, a, b in slopes)]
    algebra = Algebra([tree for _, tree in differences])
    box = {v.symbol: v.side for v in plant.variables}
    # Slopes have to exist everywhere: no quotient is taken for its limit.
    smooth = Search(algebra, box, limits=False)
    named = [(f"part {k + 1}", tree) for k, tree in enumerate(whole)]
    for label, tree in [*named, *((label, a) for label, a, _ in slopes)]:
        yield Fact(f"{label} is defined", smooth.holds(tree, lambda found: True))
    for label, tree in differences:
        yield Fact(label, identical(algebra, tree, box, label))
    yield from within(plant, Search(algebra, box))


def _at_rest(plant: TreePlant) -> Iterator[tuple[str, Tree]]:
    """Yield (label, tree that must be 0) for each equation at rest."""
    zero = {v.symbol: number(0) for v in plant.variables}
    for state, tree in zip(plant.states, plant.f, strict=True):
        target = number(0) if plant.step is None else state.rest
        yield f"{state.name} is at rest", plus(put(tree, zero), minus(target))


def _is_zero(plant: TreePlant, v: Variable) -> bool:
    column = plant.pushes.index(v)
    return all(value_of(row[column]) == 0 for row in plant.entries["E"])


def _at_rest_for_all(plant: TreePlant, still: list[Variable]) -> Iterator[tuple[str, Tree]]:
    """Yield what has to be 0 where the rest does not move with these signals, all at once."""
    if not still:
        return
    symbols = [v.symbol for v in still]
    others = {v.symbol: number(0) for v in plant.variables if v.symbol not in symbols}
    for state, tree in zip(plant.states, plant.f, strict=True):
        moved = put(tree, others)
        at_zero = put(moved, {symbol: number(0) for symbol in symbols})
        yield f"{state.name} rests for every unknown signal", plus(moved, minus(at_zero))


def _slopes(plant: TreePlant, still: list[Variable]) -> Iterator[tuple[str, Tree, Tree]]:
    """Yield (label, slope of the plant, entry of the embedding) for every entry.

    The columns of E of ``still`` are 0: differences are taken at equal values of these signals.
    """
    meaning = {p.name: p.tree for p in plant.premises}
    groups: list[tuple[str, list[Tree], list[Variable]]] = [
        ("A", plant.f, plant.states),
        ("B", plant.f, plant.inputs),
        ("E", plant.f, plant.pushes),
        ("C", plant.outputs, plant.states),
        ("D", plant.outputs, plant.inputs),
    ]
    for letter, rows, columns in groups:
        for i, tree in enumerate(rows):
            for j, v in enumerate(columns):
                if letter == "E" and v in still:
                    continue
                said = put(plant.entries[letter][i][j], meaning)
                yield f"{letter}[{i + 1}][{j + 1}]", slope_of(tree, v.symbol), said
    for i, tree in enumerate(plant.outputs):
        for v in plant.pushes:
            yield f"output {i + 1} by {v.name}", slope_of(tree, v.symbol), number(0)


ONE, TWO = number(1), number(2)


def _call(name: str, a: Tree) -> Tree:
    return ("call", name, (a,))


def _square(a: Tree) -> Tree:
    return ("^", a, fmpq(2))


def _over(a: Tree) -> Tree:
    return ("/", ONE, a)


def _bell(a: Tree) -> Tree:
    """Return erf' = 2 / sqrt(pi) exp(-a^2)."""
    front = ("/", TWO, ("^", ("name", "pi"), fmpq(1, 2)))
    return times(front, _call("exp", minus(_square(a))))


OUTER: dict[str, Callable[[Tree], Tree]] = {
    "sin": lambda a: _call("cos", a),
    "cos": lambda a: minus(_call("sin", a)),
    "tan": lambda a: plus(ONE, _square(_call("tan", a))),
    "exp": lambda a: _call("exp", a),
    "log": _over,
    "sqrt": lambda a: _over(times(TWO, _call("sqrt", a))),
    "sinh": lambda a: _call("cosh", a),
    "cosh": lambda a: _call("sinh", a),
    "tanh": lambda a: plus(ONE, minus(_square(_call("tanh", a)))),
    "atan": lambda a: _over(plus(ONE, _square(a))),
    "asinh": lambda a: _over(_call("sqrt", plus(ONE, _square(a)))),
    "asin": lambda a: _over(_call("sqrt", plus(ONE, minus(_square(a))))),
    "acos": lambda a: minus(_over(_call("sqrt", plus(ONE, minus(_square(a)))))),
    "acosh": lambda a: _over(_call("sqrt", plus(_square(a), number(-1)))),
    "atanh": lambda a: _over(plus(ONE, minus(_square(a)))),
    "erf": _bell,
}


def slope_of(tree: Tree, name: str) -> Tree:
    """Return the partial derivative of a tree by a variable.

    Raises
    ------
    NotReplayed : a function whose slope is not known here, such as a table.
    """
    kind = tree[0]
    if kind == "number":
        return number(0)
    if kind == "name":
        return number(int(tree[1] == name))
    if kind == "+":
        return plus(slope_of(tree[1], name), slope_of(tree[2], name))
    if kind == "^":
        inner = slope_of(tree[1], name)
        if inner == number(0):
            return inner
        power = tree[2]
        lower = ONE if power == 1 else tree[1] if power == 2 else ("^", tree[1], power - 1)
        return times(times(number(power), lower), inner)
    if kind == "call":
        inners = [slope_of(part, name) for part in tree[2]]
        if all(inner == number(0) for inner in inners):
            return number(0)
        if len(inners) != 1 or tree[1] not in OUTER:
            raise NotReplayed(f"the slope of {tree[1][:40]!a} is not known here")
        return times(OUTER[tree[1]](tree[2][0]), inners[0])
    a, b = tree[1], tree[2]
    da, db = slope_of(a, name), slope_of(b, name)
    if kind == "*":
        # Where da is 0 the factor b is left out, also where ``times`` would keep it because it may
        # be undefined: b is a part of the tree, hence defined wherever the tree is.
        left = da if da == number(0) else times(da, b)
        return plus(left, db if db == number(0) else times(a, db))
    first = number(0) if da == number(0) else ("/", da, b)
    if db == number(0):
        return first
    return plus(first, minus(("/", times(a, db), _square(b))))


def has_kink(tree: Tree) -> bool:
    """Return whether a tree contains an absolute value or a sign."""
    if tree[0] == "call":
        return tree[1] in ("abs", "sign") or any(map(has_kink, tree[2]))
    return any(has_kink(part) for part in tree[1:] if isinstance(part, tuple))
