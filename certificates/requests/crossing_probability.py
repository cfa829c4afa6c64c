"""Requests a bound on the probability that a signal reaches a limit under white noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates.requests.loop.decimals import floats, rounded_up, short, stack_of
from takagi.certificates.requests.loop.disturbance_channel import WAYS
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Attempt, first_proved, or_else
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

DIGITS = (6, 9, 12)
# Relative margin of the probability, and the least that is claimed: numbers go to 1e-48.
ABOVE, LEAST = 1e-6, 1e-40


@dataclass(frozen=True, slots=True, eq=False)
class CrossingProbability:
    """P(|y| reaches the limit within the horizon) <= probability, for constant weights.

    Attributes
    ----------
    noise : (q,) root of the intensity (two-sided spectral density) of each disturbance, in its
        unit times sqrt(s); 0 for one that is at rest.
    horizon : T in s.
    signal : y, a name or label of a state, or a row (n,) of factors of the states.
    limit : b in the unit of y.
    probability : p of the claim; None takes slightly more than the least that is found.
    pieces : the set of weights is cut into at most so many pieces, each with its own covariance,
        until the probability is shown.
    disturbance : "disturbances" (E) or "inputs" (added to u); None takes the first that exists.
    """

    noise: ArrayLike
    horizon: float
    signal: str | ArrayLike
    limit: float
    probability: float | None = None
    pieces: int = 1
    disturbance: str | None = None

    def __post_init__(self) -> None:
        for name in ("horizon", "limit"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ModelError(f"{name} = {value!r} was given; a positive number is needed")
        if self.probability is not None and not 0 < self.probability < 1:
            raise ModelError(f"probability = {self.probability!r}: a number between 0 and 1")
        if self.pieces < 1:
            raise ModelError(f"pieces = {self.pieces!r}: at least 1 is needed")

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``crossing-probability``.

        Raises
        ------
        ModelError : discrete time, no such disturbance or state, sizes that do not fit.
        """
        evidence = self._evidence(loop)
        leaves = list(self._grown(loop, evidence))
        if any(leaf.C is None for leaf in leaves):
            why = "no covariance was found: a vertex is not stable, or one C is not enough"
            return first_proved(loop, [(why, self._idle(loop, evidence))])
        bound = max(leaf.logarithm for leaf in leaves)
        words = (
            f"the bound is e^{bound:.3g} on {len(leaves)} pieces; more pieces, a larger limit, "
            "less noise or a smaller horizon may be proved"
        )
        claims = self._claims(evidence, leaves)
        return first_proved(loop, or_else(claims, (words, self._idle(loop, evidence))))

    def _evidence(self, loop: ClaimedLoop) -> dict[str, Any]:
        exact = loop.exact
        if exact.is_discrete:
            raise ModelError("white noise as it is meant here enters loops in continuous time")
        found = {"disturbances": bool(exact.E), "inputs": bool(exact.B)}
        way = self.disturbance or next((name for name in WAYS if found[name]), "disturbances")
        if not found.get(way, False):
            raise ModelError(f"disturbance {way!r}: the model {loop.model.name!r} has none such")
        q = (exact.E if way == "disturbances" else exact.B)[0].shape[1]
        noise = np.asarray(self.noise, dtype=np.float64)
        if noise.shape != (q,) or not np.all(np.isfinite(noise) & (noise >= 0)):
            raise ModelError(f"noise = {self.noise!r}: {q} numbers >= 0 are needed")
        if not noise.any():
            raise ModelError("noise: all entries are 0; give at least one intensity above 0")
        return {"disturbance": way, "noise": noise.tolist(), "row": self._row(loop).tolist()}

    def _row(self, loop: ClaimedLoop) -> Floats:
        names, n = list(loop.exact.states), loop.exact.order
        if isinstance(self.signal, str):
            short_names = [name.split(" ")[0] for name in names]
            if self.signal not in (*names, *short_names):
                raise ModelError(f"signal: there is no state {self.signal!r}; {', '.join(names)}")
            known = names if self.signal in names else short_names
            return np.asarray(np.eye(n)[known.index(self.signal)], dtype=np.float64)
        row = np.asarray(self.signal, dtype=np.float64)
        if row.shape != (n,) or not np.isfinite(row).all() or not row.any():
            raise ModelError(f"signal = {self.signal!r}: a state's name, or {n} numbers, not all 0")
        return row

    def _grown(self, loop: ClaimedLoop, evidence: dict[str, Any]) -> list[_Leaf]:
        """Return the pieces in the order of their tree; the worst is cut as often as is allowed."""
        exact = loop.exact
        entering = exact.E if evidence["disturbance"] == "disturbances" else exact.B
        whole = self._leaf(replace(exact, more=(entering,)), evidence, ())
        leaves = [whole]
        may_cut = exact.rules > 1 and (exact.shared_weights or len(exact.K) <= 1)
        target = np.log(self.probability) if self.probability else -np.inf
        while may_cut and len(leaves) < self.pieces:
            worst = max(leaves, key=lambda leaf: leaf.logarithm)
            if worst.logarithm <= target:
                break
            leaves.remove(worst)
            cut = _best_cut(worst)
            for k, half in enumerate(_halves(worst.loop, *cut)):
                leaves.append(self._leaf(half, evidence, (*worst.path, (k, cut))))
        return sorted(leaves, key=lambda leaf: [k for k, _ in leaf.path])

    def _leaf(self, loop: PolytopicLoop, evidence: dict[str, Any], path: Path) -> _Leaf:
        from takagi.lmi.analysis.disturbance.covariance_bound import covariance_bound

        blends = loop.blends()
        A = stack_of(blend.A for blend in blends)
        noise = np.array(evidence["noise"])
        S = np.array([floats(blend.of(loop.more[0])) for blend in blends])
        S = S[:, :, noise > 0] * noise[noise > 0]
        row = np.array(evidence["row"])
        C = covariance_bound(A, S, row)
        found = _Leaf(loop, path, A, row, C)
        found.logarithm = self._logarithm(found, C)
        return found

    def _logarithm(self, leaf: _Leaf, C: Floats | None) -> float:
        """Return the logarithm of the bound; inf where there is none, or the limit is below s."""
        if C is None:
            return np.inf
        variance = float(leaf.row @ C @ leaf.row)
        rows = leaf.row @ leaf.A
        rate = float(np.einsum("ij,jk,ik->i", rows, C, rows).max())
        ratio = self.limit**2 / (2 * variance) if variance > 0 else 0.0
        if ratio < 0.5 or rate < 0:
            return np.inf
        outside = 1 / np.sqrt(np.pi * ratio)
        return float(np.log(outside + self.horizon / np.pi * np.sqrt(rate / variance)) - ratio)

    def _claims(
        self, evidence: dict[str, Any], leaves: list[_Leaf]
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        for digits in DIGITS:
            C = [short(leaf.C, digits) for leaf in leaves if leaf.C is not None]
            bounds = [self._logarithm(leaf, one) for leaf, one in zip(leaves, C, strict=True)]
            bound = float(np.exp(min(max(bounds), 1.0)))
            probability = self.probability or rounded_up(max(bound * (1 + ABOVE), LEAST), 4)
            if probability >= 1 or bound > probability:
                continue
            tree = {"halvings": _tree(leaves)} if len(leaves) > 1 else {}
            claim = self._claim(evidence, [one.tolist() for one in C], probability) | tree
            yield f"probability {probability:.4g}, C to {digits} digits", claim

    def _claim(
        self, evidence: dict[str, Any], C: list[list[list[float]]], probability: float
    ) -> dict[str, Any]:
        return {
            "name": "probability of reaching a limit under white noise",
            "kind": "crossing-probability",
            **evidence,
            "limit": self.limit,
            "C": C,
            "horizon": self.horizon,
            "probability": probability,
        }

    def _idle(self, loop: ClaimedLoop, evidence: dict[str, Any]) -> dict[str, Any]:
        """Return the requested claim with evidence that proves nothing."""
        # A covariance above the limit.
        wide = float(np.abs(evidence["row"]).max()) ** -2 * 4 * self.limit**2
        one = (wide * np.eye(loop.exact.order)).tolist()
        return self._claim(evidence, [one], self.probability or 0.5)


Cut = tuple[int, int, int]
Path = tuple[tuple[int, Cut], ...]


@dataclass(slots=True, eq=False)
class _Leaf:
    """One piece: its exact loop, the way to it in the tree, its vertices, and the C found."""

    loop: PolytopicLoop
    path: Path
    A: Floats
    row: Floats
    C: Floats | None
    logarithm: float = np.inf


def _halves(loop: PolytopicLoop, premise: int, i: int, j: int) -> tuple[PolytopicLoop, ...]:
    """Return the two halves in the order of ``halvings``."""
    from takagi.certificates.checker.loop.halvings import halved

    return halved(loop, premise, i, j), halved(loop, premise, j, i)


def _cuts(loop: PolytopicLoop) -> list[Cut]:
    premises, sides = (len(loop.corners[0]), 2) if loop.corners else (1, loop.rules)
    return [(p, i, j) for p in range(premises) for i, j in combinations(range(sides), 2)]


def _best_cut(leaf: _Leaf) -> Cut:
    """Return the cut that is likely to help most.

    With D the difference of the halves' mean matrices, Y of A'Y + YA + h'h = 0, a covariance X and
    M = Y^(1/2) D X^(1/2), the variance of y differs by 2 tr M to first order: this is in the worst
    vertex, and no cut takes it away.  The sum of the singular values of M is what one C for both
    pays.  The difference of the two is compared.
    """
    mean, n = leaf.A.mean(axis=0), leaf.A.shape[1]
    X = np.eye(n) if leaf.C is None else leaf.C
    Y = np.eye(n)
    if np.linalg.eigvals(mean).real.max() < 0:
        Y = solve_continuous_lyapunov(mean.T, -np.outer(leaf.row, leaf.row))
    left, right = _root(Y), _root(X)

    def effect(cut: Cut) -> float:
        first, second = (
            stack_of(blend.A for blend in half.blends()).mean(axis=0)
            for half in _halves(leaf.loop, *cut)
        )
        moved = left @ (first - second) @ right
        return float(np.linalg.norm(moved, "nuc") - abs(np.trace(moved)))

    return max(_cuts(leaf.loop), key=effect)


def _root(matrix: Floats) -> Floats:
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T)


def _tree(leaves: list[_Leaf], depth: int = 0) -> list[list[int]]:
    """Return the tree in preorder; the leaves are in its order."""
    if len(leaves) == 1 and len(leaves[0].path) == depth:
        return [[]]
    cut = leaves[0].path[depth][1]
    halves = [[one for one in leaves if one.path[depth][0] == k] for k in (0, 1)]
    return [list(cut), *_tree(halves[0], depth + 1), *_tree(halves[1], depth + 1)]
