r"""Partial derivatives of trees, by the rules of differentiation.

    (a b)' = a' b + a b'      (a/b)' = a'/b - a b'/b^2      (a^q)' = q a^(q-1) a'
    F(a)'  = F'(a) a'         with F' from the table below

An absolute value has no derivative at 0, and this checker has no slopes of tables.
"""

from __future__ import annotations

from collections.abc import Callable

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import NotReplayed
from takagi.certificates.cross_check.plant.expression import Tree, minus, number, plus, times

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
