"""Requests a region of attraction {V <= 1} with V a polynomial, for a loop that is one."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Claim
from takagi.certificates.checker.plant.attraction_region import polynomial_loop
from takagi.certificates.checker.plant.polynomial import Polynomial
from takagi.certificates.checker.plant.reading import PlantNodes, read_plant
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.document.decimals import rounded_down, short
from takagi.certificates.requests.invariant_ellipsoid import set_in_floats
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt
from takagi.lmi.sums_of_squares.attraction_set import (
    Limited,
    Squares,
    largest_set,
    multipliers,
    size,
)
from takagi.lmi.sums_of_squares.polynomial import StatePolynomial, monomials
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Degree of V by the number of states; with more states the matrices are too large to decide.
DEGREES = {1: 4, 2: 4, 3: 4, 4: 4, 5: 2, 6: 2}
# A state without a range keeps this many times its reach in the first set.
FREE = 10.0
DIGITS = (6, 9, 12)  # of matrices
DIGITS_OF_V = 9
# By how much V is larger in the claim than in the search, so that its matrices may be rounded.
LIFTS = (1.0, 1.002, 1.02, 1.1)
WITHOUT = {"degree": 1, "multiplier_degree": 1}


@dataclass(frozen=True, slots=True, eq=False)
class AttractionRegion:
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
        ModelError : the loop is no polynomial in the states, or has too many of them.
        """
        search = _Search.of(loop)
        n = len(search.scale)
        if n not in DEGREES:
            raise ModelError(
                f"safe_start polynomial: model {loop.model.name!r} has {n} states, and such a set "
                f"is sought for up to {max(DEGREES)}; leave safe_start out"
            )
        degree = self.degree or DEGREES[n]
        best = None
        for V, _ in largest_set(search.field, search.limited, search.first, degree):
            best = V
        if best is None:
            words = "no set of a polynomial was found, however small"
            claim = search.idle()
            return Attempt(claim, search.replay(claim), (words,))
        tried = [f"a polynomial of degree {best.degree}, {size(best):.4g} times the first volume"]
        for claim in search.claims(best):
            checked = search.replay(claim)
            attempt = Attempt(claim, checked, tuple(tried))
            if attempt.proved:
                break
        return attempt


def require_polynomial(model_data: Any, name: str) -> None:
    """Raise ModelError for a plant whose equations are no polynomials in the states.

    Parameters
    ----------
    model_data : the plant as a certificate states it; None where it states none.
    """
    try:
        if model_data is None:
            raise Refused("it cannot be written into a certificate")
        model = read_text(json.dumps(model_data), "model")
        polynomial_loop(read_plant(model, "model"), model, None)
    except (Refused, CertificateError) as error:
        raise ModelError(
            f"safe_start polynomial: plant {name!r}: {error}; such a set is for polynomial "
            "equations in continuous time, so leave safe_start out"
        ) from error


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """The loop in coordinates z = x / scale, in which the first set reaches 1 along each axis."""

    loop: ClaimedLoop
    data: Any
    plant: PlantNodes
    scale: Floats
    field: list[StatePolynomial]
    limited: list[Limited]
    units: list[float]
    box: list[tuple[float, float]]
    first: StatePolynomial

    @classmethod
    def of(cls, loop: ClaimedLoop) -> _Search:
        written = json.dumps({"model": loop.model_data, "gains": loop.gains_data})
        data = read_text(written, "claim")
        name = loop.model.name
        if data["model"]["kind"] != "plant":
            raise ModelError(f"safe_start polynomial: model {name!r} is not that of a plant")
        plant = read_plant(data["model"], "model")
        try:
            exact = polynomial_loop(plant, data["model"], data["gains"])
        except Refused as error:
            raise ModelError(f"safe_start polynomial: model {name!r}: {error}") from error
        n = len(plant.states)
        P = _first_set(loop, [_in_states(p, n) for p in exact.F])
        scale = np.sqrt(np.diag(np.linalg.inv(P)))
        scale = np.array([float(f"{value:.2g}") for value in scale])
        box = [
            (-FREE * s, FREE * s) if v.side is None
            else (-rounded_down(float(-v.side[0]), 9), rounded_down(float(v.side[1]), 9))
            for v, s in zip(plant.states, scale, strict=True)
        ]  # fmt: skip
        units = list(scale)
        quantities = [
            (StatePolynomial(n, {_unit(n, k): Fraction(1)}), box[k][0] / s, box[k][1] / s)
            for k, s in enumerate(scale)
        ]
        for v, u in zip(plant.inputs, exact.u, strict=True):
            if v.side is not None:
                low, high = map(float, v.side)
                unit = max(-low, high)
                units.append(unit)
                q = _scaled(_in_states(u, n), scale).times(Fraction(1 / unit))
                quantities.append((q, low / unit, high / unit))
        return cls(
            loop,
            data,
            plant,
            scale,
            [
                _scaled(_in_states(p, n), scale).times(Fraction(1 / s))
                for p, s in zip(exact.F, scale, strict=True)
            ],
            [Limited(q, Fraction(low), Fraction(high)) for q, low, high in quantities],
            units,
            box,
            StatePolynomial.quadratic(short(P * np.outer(scale, scale), DIGITS_OF_V)),
        )

    def claims(self, V: StatePolynomial) -> Iterator[dict[str, Any]]:
        """Yield claims about {V <= 1}, the largest set first."""
        for lift in LIFTS:
            stated = self._stated({a: float(c) * lift for a, c in V.terms.items()})
            squares = multipliers(self.field, self.limited, _scaled(stated, self.scale), spare=True)
            for digits in DIGITS if squares is not None else ():
                yield self._claim(self._text(stated), squares or [], digits)
        yield self.idle()

    def idle(self) -> dict[str, Any]:
        """Return a claim that is not proved."""
        zero = [[0.0] * len(self.scale)] * len(self.scale)
        larger = [[0.0] * (len(self.scale) + 1)] * (len(self.scale) + 1)
        ones = [WITHOUT | {"squares": larger, "multiplier": larger}]
        text = self._text(self._stated({a: float(c) for a, c in self.first.terms.items()}))
        return self._members(text) | {
            "decrease": [WITHOUT | {"squares": zero, "multiplier": zero}],
            "states": ones * len(self.scale),
            "inputs": ones * (len(self.limited) - len(self.scale)),
        }

    def _members(self, text: str) -> dict[str, Any]:
        return {
            "name": f"region of attraction of {self.loop.model.name} by a polynomial",
            "kind": "attraction-region",
            "function": text,
            "level": 1,
            "box": [list(sides) for sides in self.box],
        }

    def _stated(self, terms: dict[tuple[int, ...], float]) -> StatePolynomial:
        """Return V in the states, with the decimals of the claim."""
        n = len(self.scale)
        return StatePolynomial(
            n,
            {
                a: Fraction(f"{c / float(np.prod(self.scale ** np.array(a))):.{DIGITS_OF_V}g}")
                for a, c in terms.items()
            },
        )

    def _text(self, V: StatePolynomial) -> str:
        names = [v.symbol for v in self.plant.states]
        words = ""
        for a, c in sorted(V.terms.items(), key=lambda item: (sum(item[0]), item[0][::-1])):
            factors = [
                name if power == 1 else f"{name}^{power}"
                for name, power in zip(names, a, strict=True)
                if power
            ]
            sign = ("-" if c < 0 else "") if not words else (" - " if c < 0 else " + ")
            words += sign + "*".join([f"{abs(float(c)):.{DIGITS_OF_V}g}", *factors])
        return words

    def _claim(self, text: str, squares: Sequence[Squares], digits: int) -> dict[str, Any]:
        n = len(self.scale)
        entries = []
        for k, line in enumerate(squares):
            unit = self.units[k - 1] ** 2 if k else 1.0
            entries.append(
                {
                    "degree": line.degree,
                    "squares": self._in_units(line.S, k, line.degree, unit, digits),
                    "multiplier_degree": line.multiplier_degree,
                    "multiplier": self._in_units(
                        line.Lambda, k, line.multiplier_degree, unit, digits
                    ),
                }
            )
        return self._members(text) | {
            "decrease": entries[:1],
            "states": entries[1 : n + 1],
            "inputs": entries[n + 1 :],
        }

    def _in_units(
        self, G: Floats, k: int, degree: int, unit: float, digits: int
    ) -> list[list[float]]:
        """Return a Gram matrix in the units of the states, rounded."""
        z = monomials(len(self.scale), range(int(k == 0), degree + 1))
        sizes = np.array([np.prod(self.scale ** np.array(a)) for a in z])
        rows: list[list[float]] = short(unit * G / np.outer(sizes, sizes), digits).tolist()
        return rows

    def replay(self, claim: dict[str, Any]) -> Claim:
        """Return the checker's verdict."""
        read = read_text(json.dumps(claim), "claim")
        return replay(read, self.data, self.loop.exact, [], "claim").in_words()


def _first_set(loop: ClaimedLoop, field: Sequence[StatePolynomial]) -> Floats:
    """Return P of {x'Px <= 1} in the box, invariant if one is found; else of the linear loop."""
    from scipy.linalg import solve_continuous_lyapunov

    n = len(field)
    try:
        P = set_in_floats(loop, None) if any(side is not None for side in loop.exact.box) else None
    except ModelError:
        P = None
    if P is not None:
        return P
    A = np.array([[float(p.terms.get(_unit(n, k), 0)) for k in range(n)] for p in field])
    if np.linalg.eigvals(A).real.max() >= 0:
        raise ModelError(
            f"safe_start polynomial: the loop of model {loop.model.name!r} is not stable at rest "
            "to first order"
        )
    P = np.asarray(solve_continuous_lyapunov(A.T, -np.eye(n)))
    sides = [side for side in loop.exact.box]
    squares = np.diag(np.linalg.inv(P))
    limits = [
        float(min(-side[0], side[1])) ** 2 / square
        for side, square in zip(sides, squares, strict=True)
        if side is not None
    ]
    return np.asarray((P + P.T) / 2 / min(limits, default=1.0))


def _in_states(p: Polynomial, n: int) -> StatePolynomial:
    terms = {}
    for monomial, c in p.items():
        powers = dict(monomial)
        terms[tuple(powers.get(k, 0) for k in range(n))] = c
    return StatePolynomial(n, terms)


def _scaled(p: StatePolynomial, scale: Floats) -> StatePolynomial:
    """Return p(scale z)."""
    exact = [Fraction(str(s)) for s in scale]
    terms = {}
    for a, c in p.terms.items():
        for s, power in zip(exact, a, strict=True):
            c *= s**power
        terms[a] = c
    return StatePolynomial(p.n, terms)


def _unit(n: int, k: int) -> tuple[int, ...]:
    return tuple(int(j == k) for j in range(n))
