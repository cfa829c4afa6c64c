"""A second reading of what a certificate says, to judge verdicts by: nothing is shared with the
checker but the strict reader.

Claims are tried at exact rational weights: corners, middles, and random ones.  There the matrices
of the sentence are made anew with python-flint, and definiteness is read off the signs of the
characteristic polynomial, not by elimination.  The plant is tried at points of its box by ball
arithmetic.  So "no" is a proof that a sentence is false; "yes" that no counterexample was found.

Whether a plant leaves its Takagi-Sugeno model somewhere in its box, by balls at points.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import product
from typing import Any

import flint

Data = dict[str, Any]
Mat = Any
Name = Callable[[str], Any]
# Kinds of claims that may name the disturbances which enter.
NAMING = ("l2-gain", "h2-norm", "peak", "fuzzy-l2-gain")
MIDDLES = (Fraction(0), Fraction(1), Fraction(1, 2))


def rational(value: Any) -> Any:
    """Return a number, or a constant expression such as "250/9", exactly."""
    if isinstance(value, (flint.fmpq, flint.fmpz)):
        return flint.fmpq(value)
    try:
        exact = Fraction(value)
    except ValueError:
        return evaluated(value, {}, flint.fmpq)
    return flint.fmpq(exact.numerator, exact.denominator)


def matrix(rows: Any) -> Mat:
    return flint.fmpq_mat([[rational(entry) for entry in row] for row in rows])


def zeros(rows: int, columns: int) -> Mat:
    return flint.fmpq_mat(rows, columns)


def identity(size: int, value: Any = 1) -> Mat:
    return flint.fmpq_mat([[value if i == j else 0 for j in range(size)] for i in range(size)])


def blocks(parts: list[list[Mat]]) -> Mat:
    rows: list[list[Any]] = []
    for line in parts:
        for i in range(line[0].nrows()):
            rows.append([part[i, j] for part in line for j in range(part.ncols())])
    return flint.fmpq_mat(rows)


def is_symmetric(M: Mat) -> bool:
    return bool(M.nrows() == M.ncols() and M == M.transpose())


def is_semidefinite(M: Mat) -> bool:
    """Return whether det(s I + M) has no negative coefficient: M symmetric has no root s > 0."""
    return all(c >= 0 for c in (-M).charpoly().coeffs())


def is_definite(M: Mat) -> bool:
    """Return whether every coefficient is positive."""
    coefficients = (-M).charpoly().coeffs()
    return len(coefficients) == M.nrows() + 1 and all(c > 0 for c in coefficients)


# ------------------------------------------------------------------ expressions


def evaluated(text: str, names: Mapping[str, Any], number: Callable[[Any], Any]) -> Any:
    """Return the value of an expression with + - * / ^ and functions of balls."""
    tree = ast.parse(text.replace("^", "**"), mode="eval").body
    return _value(tree, names, number)


def _value(node: ast.expr, names: Mapping[str, Any], number: Callable[[Any], Any]) -> Any:
    match node:
        case ast.Constant():
            exact = Fraction(ast.unparse(node))
            return number(exact.numerator) / number(exact.denominator)
        case ast.Name():
            if node.id == "pi" and "pi" not in names:
                return flint.arb.pi()
            return names[node.id]
        case ast.UnaryOp(op=ast.USub()):
            return -_value(node.operand, names, number)
        case ast.UnaryOp(op=ast.UAdd()):
            return _value(node.operand, names, number)
        case ast.BinOp():
            left = _value(node.left, names, number)
            if isinstance(node.op, ast.Pow):
                return left ** int(Fraction(ast.unparse(node.right)))
            right = _value(node.right, names, number)
            operations: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
                ast.Add: lambda a, b: a + b,
                ast.Sub: lambda a, b: a - b,
                ast.Mult: lambda a, b: a * b,
                ast.Div: lambda a, b: a / b,
            }
            return operations[type(node.op)](left, right)
        case ast.Call(func=ast.Name()):
            (argument,) = (_value(part, names, number) for part in node.args)
            name = node.func.id if isinstance(node.func, ast.Name) else ""
            return abs(argument) if name == "abs" else getattr(argument, name)()
    raise SyntaxError(f"{ast.unparse(node)} is not read")


# ------------------------------------------------------------------ the loop at given weights


class Loop:
    """The vertices and gains of a document, blended at drawn weights."""

    def __init__(self, document: Data) -> None:
        model, law = document["model"], document.get("gains")
        self.step = None if model["sample_time"] is None else rational(model["sample_time"])
        self.rules: list[tuple[int, ...]] | None = None
        if model["kind"] == "plant":
            self._read_plant(model)
        else:
            self._read_vertices(model)
        self.order = self.stacks["A"][0].nrows()
        self.gains = [] if law is None else [matrix(K) for K in law["K"]]
        premises = model["embedding"]["premises"] if model["kind"] == "plant" else None
        ours = model.get("premises") if premises is None else premises
        rules: Any = model.get("rules") if premises is None else self.rules
        theirs = {} if law is None else law
        self.law_rules = _corners(theirs.get("rules")) or self.rules
        self.shared = _weights(ours, rules) == _weights(theirs.get("premises"), theirs.get("rules"))

    def _read_plant(self, model: Data) -> None:
        embedding = model["embedding"]
        premises = embedding["premises"]
        sides = []
        for p in premises:
            low, high = rational(p["lower"]), rational(p["upper"])
            sides.append([low] if low == high else [low, high])
        self.rules = list(product(*(range(len(side)) for side in sides)))
        self.stacks: dict[str, list[Mat]] = {}
        for letter in "ABCDE":
            if letter not in embedding:
                continue
            found = []
            for corner in self.rules:
                names = {
                    p["name"]: side[c] for p, side, c in zip(premises, sides, corner, strict=True)
                }
                rows = [[evaluated(e, names, flint.fmpq) for e in row] for row in embedding[letter]]
                found.append(flint.fmpq_mat(rows))
            self.stacks[letter] = found
        self.sides = _sides(model["states"]), _sides(model["inputs"])
        disturbances = model.get("disturbances", [])
        self.pushed = _sides(disturbances)
        self.pushing = [f"{v.get('symbol', v['name'])} [{v['unit']}]" for v in disturbances]

    def _read_vertices(self, model: Data) -> None:
        self.stacks = {x: [matrix(M) for M in model[x]] for x in "ABCDE" if x in model}
        self.rules = _corners(model.get("rules"))
        box = model.get("box", {})

        def sides(key: str) -> list[Any]:
            return [
                [rational(v) for v in box[name]] if name in box else None
                for name in model.get(key) or []
            ]

        self.sides = sides("state_names"), sides("input_names")
        self.pushed = sides("disturbance_names")
        self.pushing = list(model.get("disturbance_names") or [])

    @property
    def count(self) -> int:
        return max(len(stack) for stack in self.stacks.values())

    def weights(self, rng: random.Random, corners: Any, count: int, stretch: Any = 1) -> list[Any]:
        """Return weights of rules, products where they are; stretched about the middle."""
        if corners:
            sizes = [max(column) + 1 for column in zip(*corners, strict=True)]
            parts = []
            for size in sizes:
                w = rng.choice((*MIDDLES, Fraction(rng.randrange(17), 16)))
                w = Fraction(1, 2) + (w - Fraction(1, 2)) * stretch
                parts.append([1 - w, w] if size == 2 else [Fraction(1)])
            found = []
            for corner in corners:
                weight = Fraction(1)
                for part, c in zip(parts, corner, strict=True):
                    weight *= part[c]
                found.append(weight)
            return found
        chosen = [Fraction(rng.choice((0, 0, 0, 1, rng.randrange(9)))) for _ in range(count)]
        chosen[rng.randrange(count)] += 1
        mean = Fraction(1, count)
        return [mean + stretch * (w / sum(chosen) - mean) for w in chosen]

    def blended(self, letter: str, h: list[Any]) -> Mat:
        return blend(self.stacks[letter], h)

    def entrance(self, claim: Data, h: list[Any]) -> Mat:
        """Return the columns of E that the claim names, all without names; or B."""
        if claim["disturbance"] != "disturbances":
            return self.blended("B", h)
        E, columns = self.blended("E", h), self.entering(claim)
        return flint.fmpq_mat([[E[i, k] for k in columns] for i in range(E.nrows())])

    def entering(self, claim: Data) -> list[int]:
        """Return the numbers of the disturbances that w consists of; the others are at rest."""
        if "entering" not in claim or claim["kind"] not in NAMING:
            return list(range(self.stacks["E"][0].ncols()))
        return [self.pushing.index(name) for name in claim["entering"]]

    def pair(self, rng: random.Random, *, own: bool = False, stretch: Any = 1) -> tuple[Any, Any]:
        """Return (h, g): the weights of vertices and of gains."""
        h = self.weights(rng, self.rules, self.count, stretch)
        if not own and self.shared and len(self.gains) in (0, 1, self.count):
            return h, h if len(self.gains) == self.count else [Fraction(1)]
        corners = self.law_rules if len(self.law_rules or ()) == len(self.gains) else None
        return h, self.weights(rng, corners, max(len(self.gains), 1))

    def closed(self, h: Any, g: Any, K: Mat | None = None, letters: str = "AB") -> Mat:
        """Return A - B K, or C - D K."""
        found = self.blended(letters[0], h)
        if not self.gains or letters[1] not in self.stacks:
            return found
        return found - self.blended(letters[1], h) * (blend(self.gains, g) if K is None else K)


def blend(stack: list[Mat], weights: list[Any]) -> Mat:
    """Return sum_i w_i M_i; one matrix stands for all."""
    if len(stack) == 1:
        return stack[0] * rational(sum(weights))
    total = stack[0] * rational(weights[0])
    for w, M in zip(weights[1:], stack[1:], strict=True):
        total = total + M * rational(w)
    return total


def _corners(rows: Any) -> list[tuple[int, ...]] | None:
    return [tuple(int(Fraction(c)) for c in row) for row in rows] if rows else None


def _weights(premises: Any, rules: Any) -> list[Any]:
    """Return what weights are made of, numbers as numbers."""
    said = [
        [p.get("name"), p.get("expression"), rational(p["lower"]), rational(p["upper"])]
        for p in premises or []
    ]
    return [said, _corners(rules)]


def _sides(variables: list[Data]) -> list[Any]:
    found: list[Any] = []
    for v in variables:
        if v.get("range") is None:
            found.append(None)
        else:
            rest = rational(v["rest"])
            found.append([rational(end) - rest for end in v["range"]])
    return found


POINTS, BITS = 150, 200
REACH = (Fraction(-1), Fraction(-1, 2), Fraction(1, 10**6), Fraction(1, 2), Fraction(1))


def ball(value: Any) -> Any:
    """Return a ball around an exact number, or around a constant such as "sqrt(2)/3"."""
    if isinstance(value, str):
        try:
            value = rational(value)
        except (ValueError, AttributeError, TypeError):
            return evaluated(value, {}, ball)
    if isinstance(value, Fraction):
        value = flint.fmpq(value.numerator, value.denominator)
    return flint.arb(value)


def why_not_the_plant(document: Data, rng: random.Random) -> str:
    """Return where a premise leaves its bounds or an equation differs; empty if nowhere seen."""
    before, flint.ctx.prec = flint.ctx.prec, BITS
    try:
        model = document["model"]
        why = _wrong_trim(document)
        return why or next(filter(None, (_at_a_point(model, rng) for _ in range(POINTS))), "")
    finally:
        flint.ctx.prec = before


def _wrong_trim(document: Data) -> str:
    law, model = document.get("gains"), document["model"]
    if law is None:
        return ""
    for key, variables in (("state", model["states"]), ("input", model["inputs"])):
        for variable, stated in zip(variables, law["trim"][key], strict=False):
            off = abs(ball(variable["rest"]) - ball(stated))
            if off > ball("1e-11") * (1 + abs(ball(stated))):
                return f"the law rests elsewhere in {variable['name']}"
    return ""


def _at_a_point(model: Data, rng: random.Random) -> str:
    names: dict[str, Any] = {key: ball(value) for key, value in model["parameters"].items()}
    moved: dict[str, list[Any]] = {}
    for key in ("states", "inputs", "disturbances"):
        moved[key] = []
        for variable in model.get(key, []):
            rest, off = ball(variable["rest"]), _drawn(variable, rng)
            moved[key].append(off)
            names[variable["name"]] = rest + off
            if "symbol" in variable and variable["symbol"] != variable["name"]:
                names[variable["symbol"]] = off
    embedding = model["embedding"]
    values: dict[str, Any] = {}
    for premise in embedding["premises"]:
        found = evaluated(premise["expression"], names, ball)
        if not found.is_finite():
            return ""
        if found < ball(premise["lower"]) or found > ball(premise["upper"]):
            return f"premise {premise['name']} is {found}"
        values[premise["name"]] = found
    rates = [_row(embedding, "ABE", i, moved, values) for i in range(len(model["states"]))]
    if model["sample_time"] is not None:
        rests = [ball(v["rest"]) for v in model["states"]]
        rates = [rest + rate for rest, rate in zip(rests, rates, strict=True)]
    if model.get("mass"):
        mass = [[evaluated(entry, names, ball) for entry in row] for row in model["mass"]]
        rates = [sum((m * r for m, r in zip(row, rates, strict=True)), ball(0)) for row in mass]
    for k, (rate, text) in enumerate(zip(rates, model["equations"], strict=True)):
        if not rate.overlaps(evaluated(text, names, ball)):
            return f"equation {k + 1} differs"
    return _outputs_differ(model, names, moved, values)


def _outputs_differ(model: Data, names: Data, moved: Data, values: Data) -> str:
    resting = dict(names)
    for key in moved:
        for variable in model.get(key, []):
            resting[variable["name"]] = ball(variable["rest"])
            if "symbol" in variable:
                resting[variable["symbol"]] = ball(0)
            if ball(variable["rest"]) == 0:
                resting[variable["name"]] = ball(0)
    for k, output in enumerate(model.get("outputs", [])):
        seen = _row(model["embedding"], "CD", k, moved, values)
        there = evaluated(output["expression"], names, ball)
        here = evaluated(output["expression"], resting, ball)
        if here.is_finite() and not seen.overlaps(there - here):
            return f"output {k + 1} differs"
    return ""


def _row(embedding: Data, letters: str, i: int, moved: Data, values: Data) -> Any:
    total = ball(0)
    for letter in letters:
        if letter not in embedding:
            continue
        key = {"A": "states", "C": "states", "E": "disturbances"}.get(letter, "inputs")
        for entry, off in zip(embedding[letter][i], moved[key], strict=True):
            total += evaluated(entry, values, ball) * off
    return total


def _drawn(variable: Data, rng: random.Random) -> Any:
    """Return a deviation from rest: an end, a middle or any point of the range."""
    share = rng.choice((*REACH, Fraction(rng.randrange(-1000, 1001), 1000)))
    if variable.get("range") is None:
        return ball(share * 7)
    low, high = (ball(end) - ball(variable["rest"]) for end in variable["range"])
    return high * ball(share) if share > 0 else low * ball(-share)
