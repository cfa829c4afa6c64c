"""Questions to public functions in odd units, scales and optima, with the true answers.

Each function draws one question and returns the verdicts that the answer amounts to, each with
whether it is true: PROVED for what it states, DISPROVED for "infeasible", else UNDECIDED.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from math import sqrt
from typing import Any

import numpy as np
import sympy as sp
from exact_truth import diagonal, exact, is_hurwitz, is_schur, minus, times
from known_loops import Random, unimodular
from problems import least_trace_condition

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.document.certificate_file import certificate_document
from takagi.lmi import common_lyapunov, hinf_pdc, optimise
from takagi.models import Interval, ModelError, Plant, TSModel, Variable, sector_model

Answered = list[tuple[Verdict, bool]]
NOTHING = [(Verdict.UNDECIDED, True)]


def size(rng: Random, low: int = -15, high: int = 12) -> Fraction:
    return Fraction(10) ** int(rng.integers(low, high + 1))


def another_rest(rng: Random) -> Answered:
    """x' = u - x and a law that rests elsewhere: false from a millionth of the range on."""
    unit, share = size(rng), size(rng, -15, -1) * int(rng.integers(0, 5))
    rest = float(int(rng.choice((0, 3, 300))) * unit)
    half = float(size(rng, -3, 0) * unit)
    row = {"unit": "C", "rest": rest, "range": [f"{rest!r} {sign} {half!r}" for sign in "-+"]}
    names = ("q", "u") if rest == 0 else ("dq", "du")
    states, inputs = ([{"name": s[-1], "symbol": s, **row}] for s in names)
    model: dict[str, Any] = {"kind": "plant", "sample_time": None, "equations": ["u - q"]}
    embedding = {"premises": [], "A": [["-1"]], "B": [["1"]]}
    model |= {"states": states, "inputs": inputs, "embedding": embedding}
    trim = [rest, rest]
    trim[int(rng.integers(2))] += float(share * 2 * Fraction(half))
    law: dict[str, Any] = {"state_names": [f"{names[0]} [C]"], "input_names": [f"{names[1]} [C]"]}
    law |= {"sample_time": None, "K": [[[1]]], "trim": {"state": trim[:1], "input": trim[1:]}}
    truth = all(abs(Fraction(v) - Fraction(rest)) <= Fraction(half) / 500_000 for v in trim)
    claims = [{"name": "e", "kind": "sector-embedding"}]
    document = certificate_document(model=model, gains=law, claims=claims, provenance={})
    with suppress(CertificateError):
        return [(check_document(document).verdict, truth)]
    return [(Verdict.UNDECIDED, truth)]


def mixed_scales(rng: Random) -> Answered:
    """x' = -c form with a form/x of known range: its bounds contain that."""
    (t, s, c), root = (size(rng, -7, 7) for _ in range(3)), sp.sqrt
    x, y = sp.symbols("x y", real=True)
    z = y / sp.Rational(s)
    forms: list[tuple[sp.Expr, float, float]] = [
        (x * root(2 - z * sp.tanh(50 * x / sp.Rational(t))), 1, sqrt(3)),
        (x * (root(2 - z) + root(2 + z)) + sp.Abs(x) * (root(2 - z) - root(2 + z)), 2, sqrt(12)),
        (x * (2 + z**2 - x**2 / sp.Rational(t) ** 2), 1, 3),
    ]
    form, least, most = forms[int(rng.integers(len(forms)))]
    states = (Variable(x, "-", Interval(-t, t)), Variable(y, "-", Interval(-s, s)))
    plant = Plant(equations=(-sp.Rational(c) * form, -y), states=states, name="p")
    with suppress(ModelError):
        ends = sector_model(plant).A[:, 0, 0] / -float(c)
        return [(Verdict.PROVED, bool(ends.min() < least + 1e-9 and ends.max() > most - 1e-9))]
    return NOTHING


def least_norm_zero(rng: Random) -> Answered:
    """z = D (u - K x) with a stable A + B K: the least norm from any w to z is 0."""
    n, step = int(rng.integers(1, 4)), None if rng.random() < 0.5 else 0.1
    (B, _), (T, back) = unimodular(rng, n), unimodular(rng, n)
    modes = [Fraction(-int(k), 1 if step is None else 4) for k in rng.integers(1, 4, size=n)]
    K, D = (exact(rng.integers(1, 4, s).astype(np.float64)) for s in ((n, n), (1, n)))
    A, unit = minus(times(times(T, diagonal(modes)), back), times(B, K)), float(size(rng, -3, 3))
    a, b, c, d = (np.array(M, float) for M in (A, B, times(D, K), D))
    model = TSModel([a], [b], E=np.full((1, n, 1), unit), sample_time=step)
    found = hinf_pdc(model, performance=(-unit * c, unit * d))
    if found.status == "infeasible" or not found.found or found.gains is None:
        return [(Verdict.DISPROVED, True)] if found.status == "infeasible" else NOTHING
    stable = is_hurwitz if step is None else is_schur
    return [(Verdict.PROVED, stable(minus(A, times(B, exact(found.gains[0])))))]


def slow_beside_fast(rng: Random) -> Answered:
    """Modes in common coordinates, perhaps one that rises: P, and its least or greatest trace."""
    n, r = (int(k) for k in rng.integers(1, 4, size=2))
    T, back = unimodular(rng, n)
    rates = np.array([[-float(size(rng, -8, 3)) for _ in range(n)] for _ in range(r)])
    stable, least = bool(rng.random() < 0.8), bool(rng.random() < 0.3)
    rates[0, 0] = rates[0, 0] if stable else float(size(rng, -1, 3))
    A = np.array([times(times(T, exact(np.diag(row))), back) for row in rates], float)
    posed, right = least_trace_condition(A), ("candidate", "candidate" if least else "unbounded")
    posed = posed if least else replace(posed, objective={"P": -posed.objective["P"]})
    found = zip((common_lyapunov(TSModel(A)).status, optimise(posed).status), right, strict=True)
    return [
        (Verdict.DISPROVED, stable) if status == "infeasible" else
        NOTHING[0] if status == "unknown" else (Verdict.PROVED, stable and status == wanted)
        for status, wanted in found
    ]  # fmt: skip


ANSWERS: dict[str, Callable[[Random], Answered]] = {
    "laws that rest beside the plant": another_rest,
    "premises of mixed scales": mixed_scales,
    "least norm zero": least_norm_zero,
    "slow modes beside fast ones, and no end": slow_beside_fast,
}
