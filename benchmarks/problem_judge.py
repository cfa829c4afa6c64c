"""Whether a claim about a conic problem is false, read a second time with FLINT.

A point, multipliers and rays are recomputed as their sentences state them: equations solved in the
places of ``basis`` by FLINT's reduced echelon form, semidefinite cones by the signs of the
characteristic polynomial; where a block has sqrt(2) off its diagonal, by a ball v'Sv < 0.  A bound
and "no solution" are tried by points of the problem: those that the document states, and what
clarabel finds, each taken only where it satisfies every constraint exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import flint
import numpy as np
from second_reading import Data, is_semidefinite, rational

from takagi.lmi.problem_files.problem import Block, ConicProblem
from takagi.lmi.problem_files.solve import most_inside, solve_conic

BITS, FARTHEST = 400, 100.0
Vector = list[Any]


def why_false(document: Data) -> str:
    """Return which claim of the document is false, and why; empty when none was seen to be."""
    read = Reading(document["model"])
    points = [x for claim in document["claims"] if (x := read.stated_point(claim)) is not None]
    points += [x for x in read.found_points() if not read.outside(read.values(x))]
    for claim in document["claims"]:
        why = read.why_false(claim, points)
        if why:
            return f"{claim['kind']}: {why}"
    return ""


class Reading:
    """The problem of a document, with its numbers as rationals."""

    def __init__(self, model: Data) -> None:
        self.c = [rational(value) for value in model["objective"]]
        self.offset = rational(model["offset"])
        self.blocks: list[tuple[str, int, bool]] = []
        # Of all blocks one above the other: B, A by rows, and how often a value counts.
        self.B: Vector = []
        self.A: list[Vector] = []
        self.weights: Vector = []
        for block in model["blocks"]:
            cone, size, scaled = block["cone"], int(rational(block["size"])), block.get("scaled")
            length = size * (size + 1) // 2 if cone == "semidefinite" else size
            rows = [[rational(0)] * (len(self.c) + 1) for _ in range(length)]
            for index, position, value in block["entries"]:
                rows[int(rational(position))][int(rational(index))] = rational(value)
            self.blocks.append((cone, size, bool(scaled)))
            self.B += [row[0] for row in rows]
            self.A += [row[1:] for row in rows]
            diagonal = {i * (i + 3) // 2 for i in range(size)}
            twice = cone == "semidefinite" and not scaled
            self.weights += [2 if twice and k not in diagonal else 1 for k in range(length)]

    def values(self, x: Vector, *, constant: bool = True) -> Vector:
        """Return S(x), or without its constant."""
        pairs = zip(self.A, self.B, strict=True)
        return [dot(row, x) + (b if constant else 0) for row, b in pairs]

    def parts(self, values: Vector) -> Iterator[tuple[str, int, bool, Vector]]:
        """Yield (cone, size, scaled, values) of every block."""
        first = 0
        for cone, size, scaled in self.blocks:
            length = size * (size + 1) // 2 if cone == "semidefinite" else size
            yield cone, size, scaled, values[first : first + length]
            first += length

    def outside(self, values: Vector, *, dual: bool = False) -> bool:
        """Return whether values are seen to leave a cone, or its dual."""
        for cone, size, scaled, part in self.parts(values):
            if cone == "zero":
                leaves = not dual and any(part)
            elif cone == "nonnegative":
                leaves = min(part) < 0
            elif cone == "second-order":
                leaves = part[0] < 0 or part[0] ** 2 < dot(part[1:], part[1:])
            else:
                leaves = not_semidefinite(size, scaled, part)
            if leaves:
                return True
        return False

    def solved(self, claim: Data, key: str, *, dual: bool, right: bool) -> Vector | None:
        """Return the stated numbers with their equations solved in ``basis``; None without."""
        start = [rational(value) for value in claim[key]]
        basis = [int(rational(place)) for place in claim["basis"]]
        if dual:
            rows = [
                [w * row[i] for w, row in zip(self.weights, self.A, strict=True)]
                for i in range(len(self.c))
            ]
            wanted = list(self.c) if right else [rational(0)] * len(self.c)
        else:
            cones = [cone for cone, *_, part in self.parts(self.B) for _ in part]
            places = [k for k, cone in enumerate(cones) if cone == "zero"]
            rows = [self.A[k] for k in places]
            wanted = [-self.B[k] if right else rational(0) for k in places]
        missing = [r - dot(row, start) for row, r in zip(rows, wanted, strict=True)]
        if not any(missing):
            return start
        if not basis:
            return None
        system = flint.fmpq_mat(
            [[row[k] for k in basis] + [m] for row, m in zip(rows, missing, strict=True)]
        )
        reduced, rank = system.rref()
        count = len(basis)
        if rank != count or any(reduced[k, k] != 1 for k in range(count)):
            return None
        for k, place in enumerate(basis):
            start[place] += reduced[k, count]
        return start

    def stated_point(self, claim: Data) -> Vector | None:
        """Return the point of the problem that a claim states, where it satisfies everything."""
        if claim["kind"] == "unbounded" and claim["form"] == "dual":
            return None
        if claim["kind"] not in ("feasible-point", "unbounded"):
            return None
        x = self.solved(claim, "point", dual=False, right=True)
        return None if x is None or self.outside(self.values(x)) else x

    def found_points(self) -> Iterator[Vector]:
        """Yield what clarabel finds."""
        blocks = []
        first = 0
        for cone, size, scaled in self.blocks:
            block = Block(cone, size, scaled)
            for k in range(block.length):
                for i, value in enumerate([self.B[first + k], *self.A[first + k]]):
                    block.add(i, k, float(value.p) / float(value.q))
            blocks.append(block)
            first += block.length
        c = np.array([float(value.p) / float(value.q) for value in self.c])
        problem = ConicProblem("judged", c, 0.0, False, tuple(blocks))
        solution = solve_conic(problem).solution
        inside = most_inside(problem, FARTHEST)
        for x in (None if solution is None else solution.x, None if inside is None else inside[0]):
            if x is not None:
                yield [rational(repr(float(value))) for value in x]

    def why_false(self, claim: Data, points: list[Vector]) -> str:
        """Return why a claim is false; empty when it was not seen to be."""
        kind = claim["kind"]
        if kind == "feasible-point":
            return "" if self.stated_point(claim) else "the point leaves a cone, or an equation"
        if kind == "no-solution":
            return "there is a solution" if points else ""
        if kind == "optimum-bound":
            return self._passed(claim, points)
        if claim["form"] == "problem":
            d = self.solved(claim, "ray", dual=False, right=False)
            if d is None or self.outside(self.values(d, constant=False)) or dot(self.c, d) >= 0:
                return "no such ray"
            return "" if self.stated_point(claim) else "no such point"
        y = self.solved(claim, "point", dual=True, right=True)
        z = self.solved(claim, "ray", dual=True, right=False)
        if points or y is None or z is None or self.outside(y, dual=True):
            return "there is a solution, or no such multipliers"
        return "" if not self.outside(z, dual=True) and self.product(z) < 0 else "no such ray"

    def product(self, y: Vector) -> Any:
        """Return <B, y>."""
        return dot([w * b for w, b in zip(self.weights, self.B, strict=True)], y)

    def _passed(self, claim: Data, points: list[Vector]) -> str:
        radius = rational(claim["radius"]) if "radius" in claim else None
        y = self.solved(claim, "point", dual=True, right=True)
        bound = self.offset
        if radius is not None:
            y = [rational(value) for value in claim["point"]]
            columns = zip(*self.A, strict=True)
            weighted = [[w * a for w, a in zip(self.weights, A, strict=True)] for A in columns]
            bound -= radius * sum(abs(c - dot(A, y)) for c, A in zip(self.c, weighted, strict=True))
        if y is None:
            return "the equations of the multipliers have no solution"
        bound -= self.product(y)
        for x in points:
            near = radius is None or max(abs(value) for value in x) <= radius
            if near and dot(self.c, x) + self.offset < bound:
                return "a solution is better"
        return ""


def dot(a: Vector, b: Vector) -> Any:
    return sum((u * v for u, v in zip(a, b, strict=True) if u and v), rational(0))


def not_semidefinite(size: int, scaled: bool, part: Vector) -> bool:
    """Return whether the symmetric matrix of a lower triangle is seen to be indefinite."""
    places = [(i, j) for i in range(size) for j in range(i + 1)]
    if not scaled:
        S = flint.fmpq_mat(size, size)
        for (i, j), value in zip(places, part, strict=True):
            S[i, j] = S[j, i] = value
        return not is_semidefinite(S)
    before, flint.ctx.prec = flint.ctx.prec, BITS
    try:
        half = 1 / flint.arb(2).sqrt()
        balls = [
            flint.arb(v) * (1 if i == j else half) for (i, j), v in zip(places, part, strict=True)
        ]
        M = np.zeros((size, size))
        for (i, j), value in zip(places, balls, strict=True):
            M[i, j] = M[j, i] = float(value)
        v = [flint.arb(float(value)) for value in np.linalg.eigh(M)[1][:, 0]]
        form = sum(
            (
                u * v[i] * v[j] * (1 if i == j else 2)
                for (i, j), u in zip(places, balls, strict=True)
            ),
            flint.arb(0),
        )
        return bool(form < 0)
    finally:
        flint.ctx.prec = before
