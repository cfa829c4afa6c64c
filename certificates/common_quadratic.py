"""Claims about Takagi-Sugeno models with a common quadratic function: candidate, then proof."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.certificates.checker.certificate import check_document
from takagi.certificates.checker.reader import read_json
from takagi.certificates.checker.result import Checked, Verdict
from takagi.certificates.document import certificate_document, dumps
from takagi.certificates.provenance import provenance
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer
    from takagi.models.ts_model import TSModel

__all__ = ["Certificate", "certify", "load_certificate"]

Floats = NDArray[np.float64]
# Shares of the rate that was found; each is tried until the rounded numbers prove.
BACK_OFF = (0.999, 0.99, 0.9, 0.5)
DIGITS = (6, 9, 12)


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """A certificate and what the independent checker says about it.

    Attributes
    ----------
    document : the file as plain data.
    checked : verdict per claim.
    tried : what was tried, in words, in order.
    """

    document: Mapping[str, Any]
    checked: Checked
    tried: tuple[str, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """PROVED, DISPROVED or UNDECIDED."""
        return self.checked.verdict

    def save(self, path: Path | str) -> Path:
        """Write the file beside its place, then rename it there; return the path."""
        target = Path(path)
        beside = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            beside.write_text(dumps(self.document), encoding="utf-8")
            os.replace(beside, target)
        finally:
            beside.unlink(missing_ok=True)
        return target


def load_certificate(path: Path | str) -> Certificate:
    """Return a certificate read from a file and checked again.

    Raises
    ------
    CertificateError : the file is refused.
    """
    document = read_json(Path(path))
    from takagi.certificates.checker.certificate import check

    return Certificate(document, check(path))


def certify(
    model: TSModel, gains: ArrayLike | None = None, *, decay_rate: float | None = None
) -> Certificate:
    """Return a proof attempt: V = x'Px decays along every blend of the model (and its gains).

    With gains, u = -sum_j h_j K_j x and the inequalities are those of G_ii and G_ij + G_ji, G_ij =
    A_i - B_i K_j, about the decimals of A, B and K as given.

    Parameters
    ----------
    model : continuous time, A (r, n, n), B (r, n, m).
    gains : K (r, m, n); one for all rules may be given as (m, n).
    decay_rate : alpha [1/s] that is asked for; None proves what can be found, less a little.

    Returns
    -------
    PROVED with P and alpha; DISPROVED with exact multipliers when no common P exists for these
    vertices; UNDECIDED otherwise, with what was tried.

    Raises
    ------
    ModelError : shapes, numbers that are not finite, or a model of discrete time.

    Source: Tanaka and Wang (2001), chapter 3; Boyd et al. (1994), section 5.1.
    """
    from takagi.lmi import common_lyapunov, max_decay_rate

    _check_continuous(model)
    K = _gains(model, gains)
    loops = _loops(model, K)
    if decay_rate is None:
        answer = max_decay_rate(loops)
        if answer.decay_rate is not None and answer.decay_rate <= 0:
            return _no(model, K, loops, 0.0, answer)
        rates = [share * (answer.decay_rate or 0.0) for share in BACK_OFF]
    else:
        if not (np.isfinite(decay_rate) and decay_rate >= 0):
            raise ModelError(
                f"decay_rate = {decay_rate!r} was given; a number >= 0 [1/s] is needed"
            )
        answer = common_lyapunov(loops, decay_rate=decay_rate)
        rates = [decay_rate]
    if answer.P is None:
        return _no(model, K, loops, decay_rate or 0.0, answer)
    return _proof(model, K, np.asarray(answer.P), rates, answer)


def _check_continuous(model: TSModel) -> None:
    if model.sample_time is not None:
        raise ModelError(
            f"the model is of discrete time (sample time {model.sample_time:g} s); certificates "
            "are of continuous time so far: takagi.lmi.common_lyapunov(model) gives a candidate P"
        )


def _proof(
    model: TSModel, K: Floats | None, P: Floats, rates: list[float], answer: Answer
) -> Certificate:
    tried: list[str] = []
    last: Certificate | None = None
    for rate in rates:
        for digits in DIGITS:
            claim = _claim(model, K, _short(P, digits), _rounded_down(rate))
            last = _checked(claim, answer, tried)
            tried.append(f"decay rate {claim['decay_rate']:.6g} 1/s, P to {digits} digits")
            if last.verdict is Verdict.PROVED:
                return Certificate(last.document, last.checked, tuple(tried))
    assert last is not None  # there is always a rate
    return Certificate(last.document, last.checked, tuple(tried))


def _no(
    model: TSModel, K: Floats | None, loops: Floats, rate: float, answer: Answer
) -> Certificate:
    """Return DISPROVED if exact multipliers exclude a common P for the closed loops."""
    factors = _multipliers(loops, rate)
    tried = [answer.diagnosis or "no candidate P"]
    if factors is None:
        claim = _claim(model, K, np.eye(model.A.shape[1]), rate)
        found = _checked(claim, answer, tried)
        return Certificate(found.document, found.checked, (*tried, "multipliers: none found"))
    claim = {
        "name": "no common quadratic function",
        "kind": "no-common-quadratic",
        "A": loops.tolist(),
        "decay_rate": rate,
        "multiplier_factors": factors.tolist(),
    }
    return _checked(claim, answer, tried)


def _checked(claim: dict[str, Any], answer: Answer, tried: list[str]) -> Certificate:
    document = certificate_document(
        model={"kind": "takagi-sugeno"},
        gains=None,
        claims=[claim],
        provenance=provenance({}, {"candidate": str(answer.solver.get("status", ""))}),
    )
    return Certificate(document, check_document(document), tuple(tried))


def _claim(model: TSModel, K: Floats | None, P: Floats, rate: float) -> dict[str, Any]:
    claim: dict[str, Any] = {
        "name": f"common quadratic decay of {model.name or 'the model'}",
        "kind": "quadratic-decay",
        "A": model.A.tolist(),
        "decay_rate": rate,
        "P": P.tolist(),
    }
    return claim if K is None else claim | {"B": model.B.tolist(), "K": K.tolist()}


def _gains(model: TSModel, gains: ArrayLike | None) -> Floats | None:
    if gains is None:
        return None
    K = np.asarray(gains, dtype=np.float64)
    r, n, m = model.B.shape
    if K.shape == (m, n):
        K = np.broadcast_to(K, (r, m, n)).copy()
    if K.shape != (r, m, n) or not np.all(np.isfinite(K)):
        raise ModelError(
            f"gains have shape {K.shape}; {r} rules, {m} inputs and {n} states need "
            f"({r}, {m}, {n}), all finite"
        )
    return K


def _loops(model: TSModel, K: Floats | None) -> Floats:
    """Return the matrices whose decay is claimed: vertices, or G_ii and (G_ij + G_ji) / 2."""
    if K is None:
        return np.asarray(model.A, dtype=np.float64)
    r = len(K)
    G = model.A[:, None] - np.einsum("inm,jmk->ijnk", model.B, K)
    i, j = np.triu_indices(r)
    return np.asarray((G[i, j] + G[j, i]) / 2, dtype=np.float64)


def _multipliers(loops: Floats, rate: float) -> Floats | None:
    """Return rounded factors L_i of Z_i = L_i L_i', with sum He(A_i Z_i) + 2 alpha Z_i > 0.

    Floating point; the checker decides.
    """
    from takagi.lmi.analysis.impossibility import impossibility_multipliers

    Z = impossibility_multipliers(loops, decay_rate=rate)
    if Z is None:
        return None
    values, vectors = np.linalg.eigh(Z)
    factors = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return np.asarray(np.round(factors, 9), dtype=np.float64)


def _short(P: Floats, digits: int) -> Floats:
    """Return P rounded to ``digits`` significant digits of each sqrt(P_ii P_jj)."""
    size = np.sqrt(np.abs(np.outer(np.diag(P), np.diag(P))))
    places = np.clip(digits - 1 - np.floor(np.log10(np.maximum(size, 1e-30))), -30, 30)
    rounded = [
        [round(float(P[i, j]), int(min(places[i, j], places[j, i]))) for j in range(len(P))]
        for i in range(len(P))
    ]
    symmetric = np.array(rounded)
    return np.asarray(np.tril(symmetric) + np.tril(symmetric, -1).T, dtype=np.float64)


def _rounded_down(rate: float) -> float:
    """Return the rate with six significant digits, rounded down, so that the file is short."""
    if rate <= 0:
        return 0.0
    scale = 10.0 ** (5 - np.floor(np.log10(rate)))
    return float(f"{np.floor(rate * scale) / scale:.12g}")
