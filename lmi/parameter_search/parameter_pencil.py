r"""A condition as matrix pencils in one of its parameters.

Let d = 1 if the largest value is sought and d = -1 if the smallest is sought.  An LMI that contains
the parameter is affine in it:

    sign F_k(x, theta + d s) = sign F_k(x, theta) - s G_k(x),     G_k = -d sign dF_k/dtheta,

If G_k(x) > 0, the unknowns x satisfy the LMIs at theta + d s for every s below the smallest
generalised eigenvalue of the pencils (sign F_k, G_k).  They are then said to allow that value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.condition.evaluate import lmi_value, shares, smallest_eigenvalues
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.cone.cone_program import Assembled, assemble, pack
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
