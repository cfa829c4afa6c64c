"""The loop that requests are about: floats to find candidates, the checker's reading to prove."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, product
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.loop.averages import why_averages_fail
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from takagi.certificates.document.model_data import as_read, pdc_law_data, ts_model_data
from takagi.certificates.document.plant_embedding import law_members
from takagi.certificates.requests.loop.weight_pieces import Cuts, Point, loop_at, weights_at
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError
from takagi.models.ts.vertex_arrays import finite_array

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer
    from takagi.models.ts.model import TSModel


@dataclass(frozen=True, slots=True, eq=False)
class ClaimedLoop:
    """A model with a feedback law, or without one.

    Attributes
    ----------
    gains : K (r, m, n) of u = -sum_j h_j K_j x; None for the model as it is.
    model_data, gains_data : as they go into the file.
    exact : the checker's reading of both, exact.
    pairs, sizes : (vertex, gain) of all blends one after the other, (2, pairs), and how many of
        them each blend has, (N,).
    shares : of each pair in its blend, (pairs,); they sum to 1 in each.
    searched : the loop whose blends are used: ``exact`` itself, or some points of its weights.
    points : the weights of the blends, where they are points.
    cuts : how many pieces of the weights may still be tried for a claim; None means that claims
        are proved without pieces.
    functions : blends, as bytes, and rate -> the function that was sought for them: several
        requests begin with the same one.
    """

    model: TSModel
    gains: Floats | None
    model_data: Mapping[str, Any]
    gains_data: Mapping[str, Any] | None
    exact: PolytopicLoop
    pairs: Indices
    sizes: Indices
    shares: Floats
    searched: PolytopicLoop
    points: tuple[Point, ...] = ()
    cuts: Cuts | None = None
    functions: dict[tuple[bytes, float | None], Answer] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls,
        model: TSModel,
        gains: ArrayLike | None = None,
        *,
        model_data: Mapping[str, Any] | None = None,
        law: Mapping[str, Any] | None = None,
    ) -> ClaimedLoop:
        """Return the loop.

        Parameters
        ----------
        gains : (r, m, n), or (m, n) for one gain in all rules.
        model_data : what to write for the model; None writes the vertices.
        law : what to write for the gains, with their ``K``; None writes K and the names.

        Raises
        ------
        ModelError : gains of another shape, or that are not finite.
        """
        if law is not None and gains is None:
            gains = law["K"]
        K = None if gains is None else _gains(model, gains, law_rules=law is not None)
        if model_data is None:
            model_data = ts_model_data(model)
        if law is None and K is not None:
            law = pdc_law_data(model, K) | law_members(model_data)
            if "references" in law:
                # The means of slopes are no weights that a law can have; it has one gain.
                law = {key: law[key] for key in law if key not in ("premises", "rules")}
        exact = read_model_loop(_read(model_data), _read(law))
        groups = [pairs for _, pairs in exact.groups()]
        sizes = np.array([len(pairs) for pairs in groups], dtype=np.intp)
        return cls(
            model=model,
            gains=K,
            model_data=model_data,
            gains_data=law,
            exact=exact,
            pairs=np.array(list(chain(*groups)), dtype=np.intp).T,
            sizes=sizes,
            shares=np.repeat(1 / sizes, sizes),
            searched=exact,
        )

    @property
    def is_double_sum(self) -> bool:
        """Whether there are blends of pairs of rules, and the law has the model's weights."""
        return self.exact.shared_weights and len(self.sizes) > self.exact.rules

    def at(self, points: Sequence[Point]) -> ClaimedLoop:
        """Return the loop that has only the blends A(h) - B(h) K(h) of these weights.

        These are matrices that the loop has at some instant; ``A`` of the whole loop encloses all
        of them.  A candidate for these points is then tried on pieces of the weights.
        """
        rows = [weights_at(self.exact, point) for point in points]
        active_rules = [[i for i, share in enumerate(h) if share] for h in rows]
        groups = [list(product(rules, rules)) for rules in active_rules]
        shares = [
            float(h[i] * h[j]) for h, pairs in zip(rows, groups, strict=True) for i, j in pairs
        ]
        return replace(
            self,
            pairs=np.array(list(chain(*groups)), dtype=np.intp).T,
            sizes=np.array([len(pairs) for pairs in groups], dtype=np.intp),
            shares=np.array(shares),
            searched=loop_at(self.exact, rows),
            points=tuple(points),
            cuts=Cuts.of(self.exact),
        )

    @property
    def sample_time(self) -> float | None:
        """T in s, None in continuous time."""
        return self.model.sample_time

    @property
    def A(self) -> Floats:
        """Closed-loop matrices of the blends, (N, n, n), in the order of ``exact.blends()``."""
        return self._closed(self.model.A, self.model.B)

    @property
    def C(self) -> Floats:
        """Outputs of the blends, (N, p, n): means of C_i - D_i K_j."""
        return self._closed(self.model.C, self.model.D)

    @property
    def E(self) -> Floats:
        """Disturbance inputs of the blends, (N, n, q)."""
        return self.per_pair(self.model.E, "vertex")

    @property
    def K(self) -> Floats:
        """Gains of the blends, (N, m, n)."""
        assert self.gains is not None
        return self.per_pair(self.gains, "gain")

    def per_pair(self, stack: Floats, of: Literal["vertex", "gain"]) -> Floats:
        """Return, for each blend, the mean of a quantity of its vertices or gains over its pairs.

        ``stack`` is (r, ., .).
        """
        return self._means(stack[self.pairs[0 if of == "vertex" else 1]])

    def refuse_averages(self, subject: str) -> None:
        """Refuse a request that needs the weights of a secant embedding, which cannot be evaluated.

        ``subject`` : "observer", "function" or "output".

        Raises
        ------
        ModelError : the model is a secant embedding.
        """
        if why := why_averages_fail(self.exact, subject):
            raise ModelError(f"model {self.model.name!r}: {why}")

    def replay(self, claim: Mapping[str, Any], *, of_plant: bool = False) -> Claim:
        """Return the checker's verdict on a claim about this loop.

        ``of_plant`` : whether the claim's kind reads model and law themselves.

        Raises
        ------
        CertificateError : the claim is malformed.
        """
        read = as_read(claim, "claim")
        data = self.written if of_plant else None
        return replay(read, data, self.exact, [], "claim").in_words()

    @property
    def written(self) -> dict[str, Any]:
        """Model and law as the checker reads them from the file."""
        members = {"model": self.model_data, "gains": self.gains_data}
        return as_read(members, "claim")

    def with_pieces(self, claim: Mapping[str, Any]) -> tuple[Mapping[str, Any], Claim]:
        """Return a claim with the pieces of the weights that it needs, and the verdict on it."""
        checked = self.replay(claim)
        if self.cuts is None or checked.verdict is not Verdict.UNDECIDED:
            return claim, checked
        halvings = self.cuts.halvings(as_read(claim, "claim"), self.exact)
        claim_on_pieces = {**claim, "halvings": halvings}
        return (claim_on_pieces, self.replay(claim_on_pieces)) if halvings else (claim, checked)

    def _closed(self, X: Floats, Y: Floats) -> Floats:
        i, j = self.pairs
        if self.gains is None:
            return self._means(X[i])
        return self._means(X[i] - Y[i] @ self.gains[j])

    def _means(self, stack: Floats) -> Floats:
        starts = np.concatenate([[0], np.cumsum(self.sizes)[:-1]])
        return np.asarray(np.add.reduceat(self.shares[:, None, None] * stack, starts, axis=0))


def _read(data: Mapping[str, Any] | None) -> Any:
    return None if data is None else as_read(data, "model or gains")


def _gains(model: TSModel, gains: ArrayLike, *, law_rules: bool) -> Floats:
    K = finite_array("K", gains)
    r, n, m = model.B.shape
    if law_rules and K.ndim == 3 and K.shape[1:] == (m, n):
        # A law with weights of its own may have another number of rules.
        return K if np.any(K != K[0]) else np.broadcast_to(K[:1], (r, m, n)).copy()
    if K.shape in ((m, n), (1, m, n)):
        K = np.broadcast_to(K, (r, m, n)).copy()
    if K.shape != (r, m, n):
        raise ModelError(
            f"gains have shape {K.shape}; {r} rules, {m} inputs and {n} states need "
            f"({r}, {m}, {n}), or ({m}, {n}) for one gain in all rules"
        )
    return K
