r"""A second opinion on a conic problem: exact claims from a solver's numbers, or from given ones.

A solution x at the edge of a cone leaves it when it is rounded.  So the problem is solved again
with smaller cones, S_k(x) - d e_k in K_k with e_k well inside, and d grows until every constraint
holds exactly.  The same is done with multipliers: y in the dual cones with <A_i, y> = c_i bounds
the optimum from the other side.  Where no solution exists, multipliers with
<A_i, y> = 0 and <B, y> < 0 say so; where the objective has no bound, a ray from the point does.
Equations are solved exactly by the checker, which changes the
places of ``basis``; here only these places are chosen, by a factorisation with pivots.

Source: Jansson, Chaykin, Keil (2007), SIAM J. Numer. Anal. 46(1), for the perturbed problems.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.checker.replay.claim_kinds import class_of
from takagi.certificates.document.certificate_file import as_read, certificate_document
from takagi.lmi.problem_files.problem import (
    ROOT,
    SECOND_ORDER,
    SEMIDEFINITE,
    ZERO,
    Block,
    ConicProblem,
    Solution,
    as_data,
    values_by_block,
)
from takagi.lmi.problem_files.reading import FORMS, ending_of
from takagi.lmi.problem_files.solve import (
    LONGEST_RAY,
    contradiction,
    falling_ray,
    most_inside,
    multiplier_problem,
    shrunken,
    solve_conic,
)
from takagi.models.arrays import Floats

# By these shares of the solution's size the cones are made smaller, one after another.
SMALLER = (1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
# The way from the solver's point, which is a little outside, to one inside is gone to 2^power of
# it, with this least power and so many steps of bisection.
SMALLEST_POWER, BISECTIONS = -16.0, 5
# It is tried from the solver's point and from so many of the last candidates outside.
NEAREST = 1
# A point inside is looked for within this many times the size of the solution.
FARTHEST = 100.0
# A bound that holds in a box alone holds for variables of this many times the solution's size.
RADIUS = 10.0
# The problem of more multipliers than these is not solved by itself: that takes minutes.
MOST_MULTIPLIERS = 1_500
# A factor of the largest pivot below which a place is no use for the equations.
RANK = 1e-11
# The checker refuses numbers with longer exponents.
SMALLEST = 1e-30
# A ray that misses its cones by more is not worth a word.
NEAR = 1e-3
Claim = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Verification:
    """The certificate of a problem, and what the checker says of it.

    Attributes
    ----------
    settled : whether there is an answer: no solution, or a solution and, where the problem has an
        objective, a bound of the optimum or that there is none.
    notes : what was not proved, and how far from it.
    """

    document: dict[str, Any]
    checked: Checked
    settled: bool
    notes: tuple[str, ...]

    @property
    def verdict(self) -> Verdict:
        """UNDECIDED where a question is open, also if claims that say less are proved."""
        return self.checked.verdict if self.settled else Verdict.UNDECIDED


def verify(
    problem: ConicProblem,
    solution: Solution | None = None,
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> Verification:
    """Return what can be proved of a problem.

    Parameters
    ----------
    solution : of another solver; None solves the problem here.
    tell : is told of each step.
    """
    status = "given"
    if solution is None:
        tell("solving")
        solved = solve_conic(problem)
        status, solution = solved.status, solved.solution
    given = solution or Solution(np.zeros(len(problem.objective)))
    prover = _Prover(problem)
    tell("a point that satisfies every constraint")
    point, distance = prover.feasible(given.x)
    claims: list[Claim] = [] if point is None else [point]
    notes: list[str] = []
    if point is None:
        tell("multipliers that contradict every point")
        claims, notes = prover.contradicted(distance)
    elif np.any(problem.objective):
        tell("a bound of the optimum")
        claims, notes = prover.bounded(point, given)
    settled = bool(claims) and not notes
    forms = FORMS.get(ending_of(problem.name), ("the problem", "its dual"))
    notes += [
        f"the objective without bound is that of {forms[claim['form'] == 'dual']}"
        for claim in claims
        if claim["kind"] == "unbounded"
    ]
    if problem.rounded:
        notes.append(
            f"{problem.rounded} numbers of the file have more digits than a float: the certificate "
            "is about the nearest floats"
        )
    if not claims:
        # What was nearest, so that the file says which constraint fails.
        claims = [prover.point_claim(given.x)]
    provenance = {"solver": status, "file": problem.name}
    document = certificate_document(
        model=prover.model, gains=None, claims=claims, provenance=provenance
    )
    return Verification(document, check_document(document), settled, tuple(notes))


class _Prover:
    """Claims about one problem, each decided exactly before it is given."""

    def __init__(self, problem: ConicProblem) -> None:
        self.problem, self.model = problem, dict(as_data(problem))
        self._data = {"model": as_read(self.model)}
        self._A, self._constant = problem.stacked()
        self._weights = problem.weights

    def feasible(self, x: Floats) -> tuple[Claim | None, float]:
        """Return the claim of a point near x; without one, how far the best point is outside."""
        claim_of, cost = self.point_claim, self.problem.objective
        claim, outside = self._best(_candidates(x, self.problem), claim_of, cost)
        distance = min(self._outside(z) for z in (x, *outside))
        return claim and self._outwards(claim, outside, claim_of, cost), distance

    def bounded(self, point: Claim, given: Solution) -> tuple[list[Claim], list[str]]:
        """Return the claims on the optimum of a problem with a point, and what was not proved."""
        ray = falling_ray(self.problem)
        is_near = ray is not None and ray[1] > -NEAR
        unbounded = self._unbounded("problem", point, ray[0]) if ray and is_near else None
        if unbounded:
            return [unbounded], []
        y = given.y
        if y is None:
            solution = solve_conic(self.problem).solution
            y = solution.y if solution else None
        y = np.zeros(self._A.shape[0]) if y is None else y
        bound = self._bound(y)
        if bound:
            return [point, bound], []
        notes = ["the bound holds in a box alone: no multipliers inside their cones were found"]
        bound = self._bound_in_a_box(y, given.x)
        if bound is None:
            notes = ["no bound of the optimum: no multipliers were found"]
        if ray and is_near:
            notes.append(
                f"that the objective falls without end is not proved: a ray of entries up to "
                f"{LONGEST_RAY:.0e} along which it falls by 1 misses the cones by {_miss(ray[1])}"
            )
        return [point, *([bound] if bound else [])], notes

    def contradicted(self, distance: float) -> tuple[list[Claim], list[str]]:
        """Return the claims on a problem without a point, and what was not proved.

        ``distance`` : by how much the nearest point misses a constraint.
        """
        inside = contradiction(self.problem)
        claim = None
        if inside is not None:
            claim = self._multiplier_claim("no solution", "no-solution", inside[0])
        if claim is None or not self._holds(claim):
            notes = [f"no point was found; the nearest misses a constraint by {distance:.2g}"]
            if inside is not None and inside[1] > -NEAR:
                notes.append(
                    "that there is none is not proved: the nearest multipliers miss their cones "
                    f"by {_miss(inside[1])}"
                )
            return [], notes
        claims = [claim]
        if np.any(self.problem.objective):
            start = most_inside(multiplier_problem(self.problem), LONGEST_RAY)
            if start is not None:
                first = self._multiplier_claim("", "optimum-bound", start[0])
                dual = self._unbounded("dual", first, np.array(claim["point"]))
                claims += [dual] if dual else []
        return claims, []

    def _unbounded(self, form: str, start: Claim, ray: Floats) -> Claim | None:
        """Return the claim that the objective has no bound along a ray from the start's point."""
        for digits in (17, 9, 6, 3):
            claim = {
                "name": "no bound of the optimum",
                "kind": "unbounded",
                "form": form,
                "point": start["point"],
                "ray": _tiny_as_zero(np.round(ray, digits)),
                "basis": start["basis"],
            }
            if self._holds(claim):
                return claim
        return None

    def _bound(self, y: Floats) -> Claim | None:
        """Return the claim of multipliers near y that bound the optimum."""
        claim_of = partial(self._multiplier_claim, "bound of the optimum", "optimum-bound")
        products = self._weights * self._constant
        ways = [self._multipliers_near(y)]
        if len(y) <= MOST_MULTIPLIERS:
            ways.append(_candidates(y, multiplier_problem(self.problem)))
        pairs = [self._best(way, claim_of, products) for way in ways]
        bounds = [(claim, outside) for claim, outside in pairs if claim is not None]
        if not bounds:
            return None
        best, outside = min(bounds, key=lambda pair: float(products @ pair[0]["point"]))
        return self._outwards(best, outside, claim_of, products)

    def _best(
        self, way: Iterator[Floats], claim_of: Callable[[Floats], Claim], cost: Floats
    ) -> tuple[Claim | None, list[Floats]]:
        """Return the claim of the candidate with the least cost, and the candidates that fail.

        From the first that holds on the cost grows with the distance from the cones' edges, unless
        the solver did not arrive.
        """
        best, outside = None, []
        for candidate in way:
            claim = claim_of(candidate)
            if not self._holds(claim):
                outside.append(candidate)
            elif best is None or cost @ claim["point"] < cost @ best["point"]:
                best = claim
                if not np.any(cost):
                    break
            else:
                break
        return best, outside

    def _outwards(
        self,
        inside: Claim,
        outside: list[Floats],
        claim_of: Callable[[Floats], Claim],
        cost: Floats,
    ) -> Claim:
        """Return the claim of a point on the way to those outside, as far as it holds.

        The cones are convex: between a solver's point, which is outside by its tolerance, and one
        inside, all points hold from one on.  It is looked for by bisection of the power of 2.
        """
        best = inside
        for start in outside[:1] + outside[1:][-NEAREST:]:
            end, holds, fails = np.array(best["point"]), 0.0, SMALLEST_POWER
            if cost @ start >= cost @ end:
                continue
            for _ in range(BISECTIONS):
                middle = (holds + fails) / 2
                claim = claim_of(start + (end - start) * 2**middle)
                if self._holds(claim):
                    holds, best = middle, claim
                else:
                    fails = middle
        return best

    def _multipliers_near(self, y: Floats) -> Iterator[Floats]:
        """Yield multipliers near y, first y itself, then ever farther inside their cones.

        y = z + d e is inside by d, and <A_i, y> = c_i where z are the multipliers of the problem
        with the objective c_i - d <A_i, e>.
        """
        yield from (np.round(y, digits) if digits else y for digits in (0, 9, 6, 3))
        size = max(1.0, float(np.abs(y).max(initial=0.0)))
        inside = np.concatenate([block.interior for block in self.problem.blocks])
        products = self._A.T @ (self._weights * inside)
        for share in SMALLER:
            d = share * size
            moved = replace(self.problem, objective=self.problem.objective - d * products)
            solution = solve_conic(moved).solution
            if solution is not None and solution.y is not None:
                yield solution.y + d * inside

    def _bound_in_a_box(self, y: Floats, x: Floats) -> Claim | None:
        """Return a bound for all solutions within a multiple of this one's size.

        For a problem whose multipliers have no point inside their cones the equations cannot be
        solved exactly: the multipliers are put inside, and the equations are missed by a little.
        """
        radius = RADIUS * max(1.0, float(np.abs(x).max(initial=0.0)))
        parts = values_by_block(self.problem.blocks, y)
        pairs = list(zip(self.problem.blocks, parts, strict=True))
        size = max(1.0, float(np.abs(y).max(initial=0.0)))
        for share in SMALLER:
            moved = [
                part + max(0.0, _distance(block, part) + share * size) * block.interior
                if block.cone != ZERO
                else part
                for block, part in pairs
            ]
            claim = {
                "name": "bound of the optimum within a box",
                "kind": "optimum-bound",
                "point": np.concatenate(moved).tolist(),
                "basis": [],
                "radius": radius,
            }
            if self._holds(claim):
                return claim
        return None

    def point_claim(self, x: Floats) -> Claim:
        """Return the claim ``feasible-point`` of x, proved or not."""
        return {
            "name": "a solution",
            "kind": "feasible-point",
            "point": _tiny_as_zero(x),
            "basis": self._point_basis,
        }

    @cached_property
    def _point_basis(self) -> list[int]:
        """The variables in which the equations S = 0 are solved."""
        is_equation = np.concatenate(
            [np.full(block.length, block.cone == ZERO) for block in self.problem.blocks]
        )
        return _basis(self._A.toarray()[is_equation])

    @cached_property
    def _products(self) -> sp.csr_array:
        """The matrix of the products <A_i, y>."""
        return sp.csr_array(self._A.multiply(self._weights[:, None]).T)

    @cached_property
    def _multiplier_basis(self) -> list[int]:
        """The multipliers in which the equations <A_i, y> = c_i are solved."""
        return _basis(self._products.toarray())

    def _multiplier_claim(self, name: str, kind: str, y: Floats) -> Claim:
        """Return the claim of the multipliers next to y that hold their equations as floats.

        What the checker changes in the basis alone may leave the cones; the least change that
        solves the equations is smaller.
        """
        right = np.zeros(len(self.problem.objective))
        if kind == "optimum-bound":
            right = self.problem.objective
        for _ in range(2):
            y = y + self._products.T @ (self._inverse @ (right - self._products @ y))
        return {
            "name": name,
            "kind": kind,
            "point": _tiny_as_zero(y),
            "basis": self._multiplier_basis,
        }

    @cached_property
    def _inverse(self) -> Floats:
        """(E E')^+ of the equations E y = c; the least change of y is E' times it."""
        squares = (self._products @ self._products.T).toarray()
        return np.asarray(np.linalg.pinv(squares, hermitian=True))

    def _holds(self, claim: Claim) -> bool:
        read = class_of(claim["kind"]).read(as_read(claim), self._data, "claim")
        return not read.failure()

    def _outside(self, x: Floats) -> float:
        """Return the largest distance of S(x) from its cones."""
        values = values_by_block(self.problem.blocks, self._A @ x + self._constant)
        pairs = zip(self.problem.blocks, values, strict=True)
        return max(0.0, *(_distance(block, v) for block, v in pairs))


def _candidates(x: Floats, problem: ConicProblem) -> Iterator[Floats]:
    """Yield points of a problem near its solution x, first x itself, then ever farther inside.

    The solution of the problem with smaller cones is inside the cones by what they were made
    smaller, so that the solver's tolerance and rounding do not take it out.
    """
    yield x
    size = max(1.0, float(np.abs(x).max(initial=0.0)))
    for share in SMALLER:
        solution = solve_conic(shrunken(problem, share * size)).solution
        if solution is not None:
            yield solution.x
    for digits in (9, 6, 3):
        yield np.round(x, digits)
    inside = most_inside(problem, FARTHEST * size)
    if inside is not None:
        yield inside[0]


def _miss(inside: float) -> str:
    """Return by how much what is inside by a negative number misses its cones."""
    return f"{max(0.0, -inside):.2g}"


def _tiny_as_zero(values: Floats) -> list[float]:
    """Return the values, 0 for those that are smaller than the checker reads."""
    return [float(value) if abs(value) >= SMALLEST else 0.0 for value in values]


def _basis(equations: Floats) -> list[int]:
    """Return as many columns as the equations have rank, by a factorisation with pivots."""
    scale = np.abs(equations).max(axis=1, initial=0.0)
    rows = equations[scale > 0] / scale[scale > 0, None]
    if not len(rows):
        return []
    _, R, order = scipy.linalg.qr(rows, mode="economic", pivoting=True)
    pivots = np.abs(np.diag(R))
    return sorted(int(k) for k in order[: int((pivots > RANK * pivots[0]).sum())])


def _distance(block: Block, values: Floats) -> float:
    """Return by how much values are outside their cone."""
    if block.cone == ZERO:
        return float(np.abs(values).max(initial=0.0))
    if block.cone == SECOND_ORDER:
        return float(np.linalg.norm(values[1:]) - values[0])
    if block.cone == SEMIDEFINITE:
        matrix = np.zeros((block.size, block.size))
        rows = np.tril_indices(block.size)
        matrix[rows] = values / np.where(block.on_diagonal + (not block.scaled) > 0, 1.0, ROOT)
        matrix[rows[::-1]] = matrix[rows]
        return -float(np.linalg.eigvalsh(matrix)[0])
    return -float(values.min(initial=0.0))
