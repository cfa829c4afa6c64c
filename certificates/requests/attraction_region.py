"""Requests a region of attraction {V <= 1} with V a polynomial, for a loop that is one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.attraction_region import polynomial_loop
from takagi.certificates.checker.plant.polynomial import Polynomial
from takagi.certificates.checker.plant.reading import Variable, read_plant
from takagi.certificates.document.model_data import as_read, rounded_down, short
from takagi.certificates.requests.invariant_ellipsoid import set_in_floats
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, Request
from takagi.lmi.sums_of_squares.attraction_set import (
    Limited,
    Squares,
    largest_set,
    multipliers,
    volume,
)
from takagi.lmi.sums_of_squares.polynomial import (
    StatePolynomial,
    function_of_linearisation,
    monomials,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Degree of V by the number of states; with more states the matrices are too large to decide.
DEGREES = {1: 4, 2: 4, 3: 4, 4: 4, 5: 2, 6: 2}
FREE = 10.0  # times its reach in the first set that a state without a range may go
DIGITS, DIGITS_OF_V = (6, 9, 12), 9
# By how much V is larger in the claim than in the search, so that its matrices may be rounded.
LIFTS = (1.0, 1.002, 1.02, 1.1)


@dataclass(frozen=True, slots=True, eq=False)
class AttractionRegion(Request):
    """Every motion from {V <= 1}, V a polynomial, comes to rest within all ranges.

    Attributes
    ----------
    degree : of V, even; None takes 4 for up to four states, 2 for more.
    """

    degree: int | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``attraction-region``.

        Raises
        ------
        ModelError : the loop is no polynomial in the states, has too many of them, or is not
            stable at rest to first order.
        """
        search = _Search.of(loop)
        n = len(search.states)
        if n not in DEGREES:
            raise ModelError(
                f"safe_start polynomial: model {loop.model.name!r} has {n} states, and such a set "
                f"is sought for up to {max(DEGREES)}; leave safe_start out"
            )
        degree = self.degree or DEGREES[n]
        larger = list(largest_set(search.field, search.limited, search.first, degree))
        if not larger:
            claim = search.claim(search.first, [], 0)
            words = "no set of a polynomial was found, however small"
            return Attempt(claim, loop.replay(claim, of_plant=True), (words,))
        times = volume(larger[-1]) / volume(search.first)
        words = (
            f"a polynomial of degree {degree}: about {times:.3g} times the volume of the quadratic "
            "set that the search began with"
        )
        for claim in search.claims(larger[-1]):
            attempt = Attempt(claim, loop.replay(claim, of_plant=True), (words,))
            if attempt.proved:
                break
        return attempt


def require_polynomial(model_data: Any, name: str) -> None:
    """Raise ModelError for a plant whose equations are no polynomials in the states.

    ``model_data`` : the plant as a certificate states it; None where it states none.
    """
    try:
        if model_data is None:
            raise Refused("it cannot be written into a certificate")
        model = as_read(model_data, "model")
        polynomial_loop(read_plant(model, "model"), model, None)
    except (Refused, CertificateError) as error:
        raise ModelError(
            f"safe_start polynomial: plant {name!r}: {error}; such a set is for polynomial "
            "equations in continuous time, so leave safe_start out"
        ) from error


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """The loop in coordinates z = x / scale, in which the first set reaches about 1.

    ``units`` : what each of ``limited`` is divided by; ``box`` : of the states.
    """

    loop: ClaimedLoop
    states: list[Variable]
    scale: Floats
    field: list[StatePolynomial]
    limited: list[Limited]
    units: list[float]
    box: list[tuple[float, float]]
    first: StatePolynomial

    @classmethod
    def of(cls, loop: ClaimedLoop) -> _Search:
        data, name = loop.written, loop.model.name
        if data["model"]["kind"] != "plant":
            raise ModelError(f"safe_start polynomial: model {name!r} is not that of a plant")
        plant = read_plant(data["model"], "model")
        try:
            exact = polynomial_loop(plant, data["model"], data["gains"])
        except Refused as error:
            raise ModelError(f"safe_start polynomial: model {name!r}: {error}") from error
        n = len(plant.states)
        P = _first_set(loop, [_in_states(p, n) for p in exact.F])
        scale = np.array([float(f"{s:.2g}") for s in np.sqrt(np.diag(np.linalg.inv(P)))])
        box = [_sides(v, FREE * float(s)) for v, s in zip(plant.states, scale, strict=True)]
        limited, units = [], []
        for k, (low, high) in enumerate(box):
            q = StatePolynomial(n, {tuple(int(j == k) for j in range(n)): Fraction(1)})
            limited.append(Limited(q, *(Fraction(end / float(scale[k])) for end in (low, high))))
            units.append(float(scale[k]))
        for v, u in zip(plant.inputs, exact.u, strict=True):
            if v.side is not None:
                unit = max(-v.side[0], v.side[1])
                q = _scaled(_in_states(u, n), scale).times(1 / unit)
                limited.append(Limited(q, v.side[0] / unit, v.side[1] / unit))
                units.append(float(unit))
        field = [
            _scaled(_in_states(p, n), scale).times(Fraction(1 / float(s)))
            for p, s in zip(exact.F, scale, strict=True)
        ]
        first = StatePolynomial.quadratic(short(P * np.outer(scale, scale), DIGITS_OF_V))
        return cls(loop, plant.states, scale, field, limited, units, box, first)

    def claims(self, V: StatePolynomial) -> Iterator[dict[str, Any]]:
        """Yield claims about {V <= 1}, the largest set first."""
        for lift in LIFTS:
            lifted = self._stated(V.times(Fraction(str(lift))))
            squares = multipliers(self.field, self.limited, _scaled(lifted, self.scale), spare=True)
            for digits in DIGITS if squares is not None else ():
                yield self.claim(V.times(Fraction(str(lift))), squares or [], digits)
        yield self.claim(V, [], 0)

    def claim(self, V: StatePolynomial, squares: Sequence[Squares], digits: int) -> dict[str, Any]:
        """Return the claim about {V <= 1}; without squares one that is not proved."""
        n = len(self.scale)
        entries = [self._entry(line, k, digits) for k, line in enumerate(squares)]
        if not entries:
            zeros = (np.zeros((n + 1 - least, n + 1 - least)).tolist() for least in (1, 0))
            entries = [
                {"degree": 1, "squares": Z, "multiplier_degree": 1, "multiplier": Z} for Z in zeros
            ]
            entries = entries[:1] + entries[1:] * len(self.limited)
        return {
            "name": f"region of attraction of {self.loop.model.name} by a polynomial",
            "kind": "attraction-region",
            "function": self._text(self._stated(V)),
            "level": 1,
            "box": [list(sides) for sides in self.box],
            "decrease": entries[:1],
            "states": entries[1 : n + 1],
            "inputs": entries[n + 1 :],
        }

    def _entry(self, line: Squares, k: int, digits: int) -> dict[str, Any]:
        """Return the matrices of an identity in the units of the states, rounded."""
        unit = self.units[k - 1] ** 2 if k else 1.0

        def stated(G: Floats, degree: int) -> list[list[float]]:
            z = monomials(len(self.scale), range(int(k == 0), degree + 1))
            sizes = np.array([np.prod(self.scale ** np.array(a)) for a in z])
            rows: list[list[float]] = short(unit * G / np.outer(sizes, sizes), digits).tolist()
            return rows

        return {
            "degree": line.degree,
            "squares": stated(line.S, line.degree),
            "multiplier_degree": line.multiplier_degree,
            "multiplier": stated(line.Lambda, line.multiplier_degree),
        }

    def _stated(self, V: StatePolynomial) -> StatePolynomial:
        """Return V in the states, with the decimals of the claim."""
        terms = {
            a: f"{float(c) / float(np.prod(self.scale ** np.array(a))):.{DIGITS_OF_V}g}"
            for a, c in V.terms.items()
        }
        return StatePolynomial(V.n, {a: Fraction(text) for a, text in terms.items()})

    def _text(self, V: StatePolynomial) -> str:
        words = []
        for a, c in sorted(V.terms.items(), key=lambda item: (sum(item[0]), item[0][::-1])):
            factors = [f"{v.symbol}^{k}" for v, k in zip(self.states, a, strict=True) if k]
            words.append("*".join([f"{float(c):.{DIGITS_OF_V}g}", *factors]).replace("^1*", "*"))
        return " + ".join(word.removesuffix("^1") for word in words).replace("+ -", "- ")


def _sides(v: Variable, free: float) -> tuple[float, float]:
    """Return the range of a state's deviation, rounded inward."""
    if v.side is None:
        return -free, free
    return -rounded_down(float(-v.side[0]), 9), rounded_down(float(v.side[1]), 9)


def _first_set(loop: ClaimedLoop, field: Sequence[StatePolynomial]) -> Floats:
    """Return P of {x'Px <= 1} in the box: invariant if one is found, else of the linear loop."""
    sides = loop.exact.box
    P = None
    if any(side is not None for side in sides):
        P = set_in_floats(loop, None)
    if P is not None:
        return P
    try:
        linear = function_of_linearisation(field)
    except ModelError as error:
        raise ModelError(
            f"safe_start polynomial: the loop of model {loop.model.name!r} is not stable at rest "
            "to first order"
        ) from error
    n = len(field)
    P = np.zeros((n, n))
    for a, c in linear.terms.items():
        i, j = (k for k in range(n) for _ in range(a[k]))
        P[i, j] += float(c) / 2
        P[j, i] += float(c) / 2
    reach = np.sqrt(np.diag(np.linalg.inv(P)))
    room = [float(min(-s[0], s[1])) / r for s, r in zip(sides, reach, strict=True) if s is not None]
    return np.asarray(P / min(room, default=1.0) ** 2)


def _in_states(p: Polynomial, n: int) -> StatePolynomial:
    terms = {tuple(dict(m).get(k, 0) for k in range(n)): c for m, c in p.items()}
    return StatePolynomial(n, terms)


def _scaled(p: StatePolynomial, scale: Floats) -> StatePolynomial:
    """Return p(scale z)."""
    exact = [Fraction(str(float(s))) for s in scale]
    terms = {}
    for a, c in p.terms.items():
        for s, power in zip(exact, a, strict=True):
            c *= s**power
        terms[a] = c
    return StatePolynomial(p.n, terms)
