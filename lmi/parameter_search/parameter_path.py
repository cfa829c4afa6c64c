r"""A primal-dual path to the largest value of a parameter, for homogeneous conditions.

The score s = d theta is largest at the best value, and the LMIs are F_k(x, s) = F_k0(x) - s G_k(x)
> 0.  The conditions for the largest s, with multipliers Z_k, are

    sum_k <dF_k/dx, Z_k> = lambda c,   sum_k <G_k(x), Z_k> = 1,   F_k Z_k = mu I,   c . x = 1,

where c . x = 1 fixes the size of x.  The path of their solutions is followed for mu -> 0 by Newton
steps.  The linearisation dF = F(dx, s) - ds G(x) omits the product ds G(dx).  F is therefore
evaluated again at each new point, and the step is shortened until F > 0: x is feasible, in floating
point, at every point of the path.  One path costs about as much as one solve at a fixed theta.  The
value at its end is recomputed by eigenvalues, and no bound is taken from the path.

Source: Helmberg, Rendl, Vanderbei and Wolkowicz (1996), SIAM J. Optimization 6(2), for the
direction; Mehrotra (1992), SIAM J. Optimization 2(4), for predictor and corrector.

A condition as matrix pencils in one of its parameters.

Let d = 1 if the largest value is sought and d = -1 if the smallest is sought.  An LMI that contains
the parameter is affine in it:

    sign F_k(x, theta + d s) = sign F_k(x, theta) - s G_k(x),     G_k = -d sign dF_k/dtheta,

If G_k(x) > 0, the unknowns x satisfy the LMIs at theta + d s for every s below the smallest
generalised eigenvalue of the pencils (sign F_k, G_k).  They are then said to allow that value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from takagi.lmi.condition.evaluate import lmi_value, shares, smallest_eigenvalues
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.cone.cone_program import Assembled, Cone, assemble, pack, unpack
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

Values = Mapping[str, Floats]

# Share of an LMI's own weight that is added to G.  Where G is singular, t would have no weight in
# that direction, and the next x could lie on the boundary of the LMI.
FLOOR = 1e-6
# Unknowns with a reciprocal condition number below this are not used.  If a value is approached but
# not attained, the unknowns tend to a singular matrix near it.  Rounding errors then dominate the
# eigenvalues from which the allowed value is computed.
WORST = 1e-8


@dataclass(frozen=True, slots=True, eq=False)
class ParameterPencil:
    """The condition, its cone data, and the part of each LMI that the parameter multiplies.

    ``worst`` is the reciprocal condition number below which unknowns are not used.
    """

    condition: Condition
    name: str
    d: float
    data: Assembled
    slopes: tuple[LMI | None, ...]
    worst: float = WORST

    @classmethod
    def of(
        cls, condition: Condition, name: str, *, largest: bool, worst: float = WORST
    ) -> ParameterPencil:
        """Separate a condition into the parts with and without the parameter.

        Raises
        ------
        ModelError : no term has the parameter.
        """
        slopes = tuple(_slope(lmi, name) for lmi in condition.lmis)
        if not any(slopes):
            raise ModelError(
                f"condition {condition.name}: no term has the parameter {name!r}; there are "
                f"{', '.join(condition.parameters) or 'none'}"
            )
        return cls(condition, name, 1.0 if largest else -1.0, assemble(condition), slopes, worst)

    def at(self, value: float) -> Condition:
        """Return the condition at a value of the parameter."""
        return self.condition.with_parameters(**{self.name: value})

    def size(self, values: Values, value: float) -> float:
        """Return max |F_k| / max |G_k|, a natural size of the parameter; 0 if G is zero."""
        parameters = self.at(value).parameters
        F = G = 0.0
        for lmi, slope in self._pairs():
            if slope is not None:
                G = max(G, float(np.abs(self._growth(slope, values)).max()))
                F = max(F, float(np.abs(lmi_value(lmi, values, parameters)).max()))
        return F / G if G > 0 else 0.0

    def allowed(self, values: Values, value: float) -> float:
        """Return the value that the unknowns allow, or nan if they allow none.

        The eigenvalues are those of the pencils at ``value``.  If some G_k is singular, the
        unknowns must satisfy its LMI at ``value``.
        """
        here = self.at(value)
        room = np.inf
        for lmi, slope in self._pairs():
            if slope is not None:
                F: Floats = lmi.sign * lmi_value(lmi, values, here.parameters)
                room = min(room, _room((F + F.transpose(0, 2, 1)) / 2, self._growth(slope, values)))
            elif lmi.strict:
                smallest = float(smallest_eigenvalues(here, lmi, values).min())
                if smallest <= self.worst * lmi.weight:
                    return float(np.nan)
            elif not float(shares(here, lmi, values).min()) >= -lmi.tolerance:
                return float(np.nan)
        return float(np.nan) if room == -np.inf else value + self.d * room

    def definiteness(self, values: Values) -> float:
        """Return the least reciprocal condition number of the G_k; 0 if one is singular."""
        reciprocal = 1.0
        for slope in self.slopes:
            if slope is not None:
                sizes = np.linalg.eigvalsh(self._growth(slope, values))
                reciprocal = min(reciprocal, float((sizes[:, 0] / np.abs(sizes).max(axis=1)).min()))
        return reciprocal

    def conditioning(self, values: Values) -> float:
        """Return the least reciprocal condition number of the unknowns in the parameter's terms."""
        reciprocal = 1.0
        for unknown in {term.unknown for slope in self.slopes if slope for term in slope.terms}:
            if unknown.symmetric:
                sizes = np.linalg.eigvalsh(values[unknown.name])
                reciprocal = min(
                    [
                        reciprocal,
                        *(
                            float(eigenvalues[0] / eigenvalues[-1])
                            for eigenvalues in sizes
                            if eigenvalues[0] > 0
                        ),
                    ]
                )
        return reciprocal

    def weighed(self, values: Values, tau: float, value: float) -> Assembled:
        """Return the cone data at a value, with the margin t weighted by tau G_k(values).

        A small multiple of I is added to that weight; see ``FLOOR``.  LMIs without the parameter
        keep their own weight.
        """
        columns = []
        for lmi, slope in self._pairs():
            eye = lmi.weight * np.eye(lmi.size)
            if slope is None:
                columns.append(np.tile(pack(eye), lmi.count))
            else:
                columns.append(pack(tau * self._growth(slope, values) + FLOOR * eye).ravel())
        return replace(self.data, condition=self.at(value), margin_column=np.concatenate(columns))

    def _pairs(self) -> zip[tuple[LMI, LMI | None]]:
        return zip(self.condition.lmis, self.slopes, strict=True)

    def _growth(self, slope: LMI, values: Values) -> Floats:
        """Return G_k(x), (count, size, size)."""
        at_one = {**self.condition.parameters, self.name: 1.0}
        G: Floats = -self.d * slope.sign * lmi_value(slope, values, at_one)
        return (G + G.transpose(0, 2, 1)) / 2


def _slope(lmi: LMI, name: str) -> LMI | None:
    """Return the part of an LMI that the parameter multiplies, or None."""
    terms = tuple(term for term in lmi.terms if term.parameter == name)
    return replace(lmi, terms=terms, constants=()) if terms else None


def _room(F: Floats, G: Floats) -> float:
    """Return the largest s with F - s G >= 0 for every item; -inf if none was found."""
    growths = np.linalg.eigvalsh(G)
    # A definite G is factorised: s is the smallest eigenvalue of (F, G).  If G is not definite, F
    # must be: then F is factorised, and s is the reciprocal of the largest eigenvalue of (G, F).
    definite = growths[:, 0] > WORST * growths[:, -1]
    room = np.inf
    if definite.any():
        room = float(_eigenvalues(F[definite], G[definite])[:, 0].min())
    if not definite.all():
        indefinite = F[~definite]
        if np.linalg.eigvalsh(indefinite).min() <= 0:
            return -np.inf
        fastest = float(_eigenvalues(G[~definite], indefinite)[:, -1].max())
        room = min(room, 1.0 / fastest if fastest > 0 else np.inf)
    return room


def _eigenvalues(A: Floats, B: Floats) -> Floats:
    """Return the eigenvalues of the pencils (A, B), ascending; B = L L' is factorised."""
    L = np.linalg.cholesky(B)
    half = np.linalg.solve(L, A)
    inside = np.linalg.solve(L, half.transpose(0, 2, 1))
    return np.asarray(np.linalg.eigvalsh((inside + inside.transpose(0, 2, 1)) / 2))


STEPS = 60
# A step goes this share of the distance to the boundary of the cone, so that F and Z stay definite.
INSIDE = 0.9
# A step shorter than this, relative to a full Newton step, ends the path: it has become singular.
SHORTEST = 1e-3
# Largest number of dense coefficients.  For larger conditions the sparse matrices of the solver are
# more efficient.
LARGEST = 4_000_000

Lists = list[Floats]


def follow_path(
    pencil: ParameterPencil, start: Values, value: float, near_enough: Callable[[float], float]
) -> tuple[float, Values, bool]:
    """Return the value reached, unknowns that allow it, and whether the path reached its end.

    No path is followed if the condition has more than one unknown, constants in a strict LMI, or
    more than ``LARGEST`` coefficients.

    ``start`` : unknowns that allow ``value``.
    ``near_enough`` : function from a value to the absolute tolerance there.
    """
    maps = _maps_of(pencil)
    if maps is None or not np.isfinite(value):
        return value, start, False
    X = pencil.condition.unknowns[0]
    x, best, score = X.numbers(start[X.name]), start, pencil.d * value
    slack = 0.5 * pencil.size(start, value) or 0.5 * near_enough(value)
    point = _started(maps, x / np.linalg.norm(x), score - slack)
    short, ended = 0.0, False
    for _ in range(STEPS):
        if point is None:
            break
        try:
            # Numbers may overflow where the path becomes singular.  The point is then not feasible,
            # and the step is refused.
            with np.errstate(all="ignore"):
                next_point = _moved(maps, point, short)
        except np.linalg.LinAlgError:
            break
        if next_point is None:
            break
        point, length = next_point
        short = 1.0 - length
        values = {X.name: _unit(X.value(point.x))}
        if np.linalg.eigvalsh(values[X.name])[:, 0].min() < pencil.worst:
            break
        allowed_score = pencil.d * pencil.allowed(values, pencil.d * point.score)
        if allowed_score > score:
            score, best = allowed_score, values
        if point.gap(maps) < 0.1 * near_enough(pencil.d * score):
            ended = True
            break
        if length < SHORTEST:
            break
    return pencil.d * score, best, ended


@dataclass(frozen=True, slots=True, eq=False)
class _Map:
    """The coefficients of F = x . D - s x . G; each is (items, variables, size, size)."""

    D: Floats
    G: Floats | None

    def at(self, x: Floats, score: float) -> Floats:
        F = _applied(self.D, x)
        return F if self.G is None else F - score * _applied(self.G, x)

    def growth(self, x: Floats) -> Floats:
        return np.zeros_like(self.D[:, 0]) if self.G is None else _applied(self.G, x)

    def slopes(self, x: Floats, score: float) -> Floats:
        """Return dF / d(x, s), (items, variables + 1, size, size)."""
        D = self.D if self.G is None else self.D - score * self.G
        return np.concatenate([D, -self.growth(x)[:, None]], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Point:
    """A point of the path: x, s, and the positive definite F and Z of every LMI."""

    x: Floats
    score: float
    F: Lists
    Z: Lists

    def gap(self, maps: list[_Map]) -> float:
        """Return sum <F, Z> / sum <G, Z>, an estimate of the distance from s to the largest s."""
        total = sum(float(np.sum(F * Z)) for F, Z in zip(self.F, self.Z, strict=True))
        weight = sum(
            float(np.sum(affine_map.growth(self.x) * Z))
            for affine_map, Z in zip(maps, self.Z, strict=True)
        )
        return total / weight if weight > 0 else np.inf


def _maps_of(pencil: ParameterPencil) -> list[_Map] | None:
    condition = pencil.condition
    counting = [lmi for lmi in condition.lmis if lmi.strict]
    X = condition.unknowns[0]
    numbers = sum(lmi.count * lmi.size**2 for lmi in counting) * X.length
    if len(condition.unknowns) > 1 or numbers > LARGEST:
        return None
    if not X.symmetric or any(lmi.constants for lmi in counting):
        return None
    zero = pencil.data.matrix({pencil.name: 0.0}).toarray()
    slope = pencil.data.matrix({pencil.name: 1.0}).toarray() - zero
    maps = []
    for lmi, cone in zip(condition.lmis, pencil.data.cones, strict=True):
        if lmi.strict:
            G = -pencil.d * _spread(slope[cone.rows], cone)
            maps.append(_Map(_spread(zero[cone.rows], cone), G if G.any() else None))
    return maps


def _spread(rows: Floats, cone: Cone) -> Floats:
    """Return (items, variables, size, size) from packed rows."""
    variables = rows.shape[1]
    packed = rows.reshape(cone.items, -1, variables).transpose(0, 2, 1)
    return unpack(packed, cone.size).reshape(cone.items, variables, cone.size, cone.size)


def _applied(D: Floats, x: Floats) -> Floats:
    items, variables, size, _ = D.shape
    return np.asarray((x @ D.reshape(items, variables, -1)).reshape(items, size, size))


def _started(maps: list[_Map], x: Floats, score: float) -> _Point | None:
    F = [affine_map.at(x, score) for affine_map in maps]
    if not all(_positive(matrix) for matrix in F):
        return None
    inverse = [_symmetric(np.linalg.inv(matrix)) for matrix in F]
    weight = sum(
        float(np.sum(affine_map.growth(x) * matrix))
        for affine_map, matrix in zip(maps, inverse, strict=True)
    )
    return _Point(x, score, F, [matrix / weight for matrix in inverse]) if weight > 0 else None


def _moved(maps: list[_Map], point: _Point, short: float) -> tuple[_Point, float] | None:
    """Return the point after a predictor and a corrector, and the length of the step.

    ``short`` is 1 minus the length of the last step.  After a short step the point is far from the
    path, so the step is centred more: it returns towards the path before it goes on.
    """
    newton = _Newton.of(maps, point)
    dF, dZ = newton.direction(0.0, None)[1:]
    ahead = (min(1.0, _length(point.F, dF)), min(1.0, _length(point.Z, dZ)))
    complementarity = sum(
        float(np.sum((F + ahead[0] * f) * (Z + ahead[1] * z)))
        for F, Z, f, z in zip(point.F, point.Z, dF, dZ, strict=True)
    )
    # Mehrotra's rule: the more of the gap the predictor leaves, the more the step is centred; the
    # corrector also takes the predictor's second-order term.
    centring = min(0.9, max(1e-3, complementarity / newton.gap, 0.0) ** 3 + 0.5 * short)
    bent = [_symmetric(inv @ f @ z) for inv, f, z in zip(newton.inverse, dF, dZ, strict=True)]
    dy, dF, dZ = newton.direction(centring * newton.gap / newton.order, bent)
    primal = min(1.0, INSIDE * _length(point.F, dF))
    dual = min(1.0, INSIDE * _length(point.Z, dZ))
    for _ in range(30):
        x, score = point.x + primal * dy[:-1], point.score + primal * float(dy[-1])
        F = [affine_map.at(x, score) for affine_map in maps]
        if all(_positive(matrix) for matrix in F):
            size = float(np.linalg.norm(x))
            Z = [(matrix + dual * z) * size for matrix, z in zip(point.Z, dZ, strict=True)]
            return _Point(x / size, score, [matrix / size for matrix in F], Z), min(primal, dual)
        primal *= 0.7
    return None


@dataclass(frozen=True, slots=True, eq=False)
class _Newton:
    """The linearised equations at a point, with one matrix for predictor and corrector."""

    point: _Point
    slopes: Lists
    inverse: Lists
    gradient: Floats
    solutions: Callable[[Floats], Floats]
    gap: float
    order: int

    @classmethod
    def of(cls, maps: list[_Map], point: _Point) -> _Newton:
        size = len(point.x) + 1
        M, gradient = np.zeros((size, size)), np.zeros(size)
        slopes, inverses = [], []
        for affine_map, F, Z in zip(maps, point.F, point.Z, strict=True):
            E, inverse = affine_map.slopes(point.x, point.score), _symmetric(np.linalg.inv(F))
            gradient += np.einsum("kvab,kab->v", E, inverse)
            turned = (inverse[:, None] @ E @ Z[:, None]).swapaxes(2, 3)
            M += _flat(E) @ _flat(turned).T
            slopes.append(E)
            inverses.append(inverse)
        # Near the end of the path M is badly scaled.  Its diagonal is scaled to ones, and a
        # multiple of I at rounding level keeps the solve regular.
        scale = 1.0 / np.sqrt(np.maximum(np.diag(M), 1e-300))
        scaled = _symmetric(M * scale * scale[:, None]) + 1e-15 * np.eye(size)
        c = np.append(point.x, 0.0)

        def solved(right_side: Floats) -> Floats:
            return scale[:, None] * np.linalg.solve(scaled, scale[:, None] * right_side)

        along = solved(c[:, None])[:, 0]

        def solutions(right_side: Floats) -> Floats:
            """Return dy with M dy + lambda c = right and c . dy = 0."""
            dy = solved(right_side[:, None])[:, 0]
            return np.asarray(dy - (c @ dy) / (c @ along) * along)

        gap = sum(float(np.sum(F * Z)) for F, Z in zip(point.F, point.Z, strict=True))
        order = sum(F.shape[0] * F.shape[1] for F in point.F)
        return cls(point, slopes, inverses, gradient, solutions, gap, order)

    def direction(self, mu: float, bent: Lists | None) -> tuple[Floats, Lists, Lists]:
        """Return d(x, s), dF and dZ towards F Z = mu I; ``bent`` is the second-order term."""
        right_side = mu * self.gradient
        right_side[-1] += 1.0
        for E, matrix in zip(self.slopes, bent or [], strict=bent is not None):
            right_side = right_side - np.einsum("kvab,kab->v", E, matrix)
        dy = self.solutions(right_side)
        dF = [_applied(E, dy) for E in self.slopes]
        dZ = [
            mu * inverse - Z - _symmetric(inverse @ f @ Z)
            for inverse, Z, f in zip(self.inverse, self.point.Z, dF, strict=True)
        ]
        if bent is not None:
            dZ = [z - matrix for z, matrix in zip(dZ, bent, strict=True)]
        return dy, dF, dZ


def _flat(E: Floats) -> Floats:
    return E.swapaxes(0, 1).reshape(E.shape[1], -1)


def _length(S: Lists, dS: Lists) -> float:
    """Return the largest a such that S + a dS is positive semidefinite for every S."""
    fastest = 0.0
    for matrix, d in zip(S, dS, strict=True):
        L = np.linalg.cholesky(matrix)
        inside = np.linalg.solve(L, np.linalg.solve(L, d).swapaxes(1, 2))
        fastest = max(fastest, -float(np.linalg.eigvalsh(_symmetric(inside))[:, 0].min()))
    return 1.0 / fastest if fastest > 0 else np.inf


def _positive(S: Floats) -> bool:
    try:
        np.linalg.cholesky(S)
    except np.linalg.LinAlgError:
        return False
    return True


def _symmetric(S: Any) -> Floats:
    return np.asarray((S + S.swapaxes(-1, -2)) / 2)


def _unit(X: Floats) -> Floats:
    return np.asarray(X / np.linalg.norm(X, 2, axis=(1, 2)).max())
