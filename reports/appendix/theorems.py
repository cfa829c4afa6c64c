"""The claims of a certificate as theorems: numbers of each claim, and its matrices once."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.kernel.result import Checked
from takagi.reports.appendix.tex import Tex, decimal, escape, listed, matrix

# Kind of claim -> heading of its theorem, with the source of the inequality.
TITLES = {
    "sector-embedding": r"Exact embedding \cite{takagi-tanaka}",
    "secant-embedding": r"Embedding in secants \cite{takagi-boyd}",
    "slope-embedding": r"Embedding of differences \cite{takagi-boyd}",
    "effort-blend": "Two actuators, one effort",
    "decay": r"Common quadratic decay \cite{takagi-tanaka,takagi-boyd}",
    "transient": r"Overshoot and settling \cite{takagi-boyd}",
    "gain-rounding": "Errors of the gains",
    "invariant-ellipsoid": r"Invariant set \cite{takagi-boyd}",
    "input-limits": r"Inputs within limits \cite{takagi-boyd}",
    "tracking": "Following a reference",
    "observed-loop": r"Plant and observer together \cite{takagi-tanaka}",
    "sampled-loop": "Sampled law",
    "region": r"Region of eigenvalues \cite{takagi-chilali}",
    "exit-probability": r"White noise \cite{takagi-kushner}",
    "no-common-decay": "No common quadratic function",
    "l2-gain": r"Energy gain \cite{takagi-boyd}",
    "h2-norm": r"Response to white noise \cite{takagi-boyd}",
    "peak": r"Peak gain \cite{takagi-boyd}",
    "observer": r"Error of the observer \cite{takagi-tanaka}",
    "observed-feedback": r"Law with its observer \cite{takagi-tanaka}",
    "fuzzy-decay": r"Decay by $P(h)$ \cite{takagi-oliveira}",
    "fuzzy-l2-gain": r"Energy gain by $P(h)$ \cite{takagi-oliveira}",
    "coherent-loop": "Invariance, bounds and decay",
    "wind-rate": "Admissible winds",
    "bumpless": "Hand-over without bumps",
    "running-loop": "The loop with its observer",
    "set-points": "Constant set-points of speed and power",
    "paper-loop": "The loop of Schulte's law",
}
# Of a function of the weights so many matrices are printed.
MOST_MATRICES = 8


def theorems_context(document: Mapping[str, Any], checked: Checked) -> dict[str, Any]:
    """Return the claims in their order, and the different matrices P among them.

    ``theorems`` has (claim, macro, title, proved, verdict, text): macro is the name of the kind
    in the templates, and the claim has the member ``number`` of its P.  ``matrices`` has (number,
    P exactly as emitted, its levels).
    """
    rows: list[dict[str, Any]] = []
    numbers: dict[str, tuple[Tex, list[Tex]]] = {}
    for claim, result in zip(document.get("claims", ()), checked.claims, strict=False):
        kind, P = str(claim.get("kind")), claim.get("P")
        members = dict(claim)
        if is_matrix(P):
            key = json.dumps(P)
            _, levels = numbers.setdefault(key, (matrix(P, exactly=True), []))
            members["number"] = list(numbers).index(key) + 1
            if "level" in claim and (level := decimal(claim["level"])) not in levels:
                levels.append(level)
        if kind.startswith("fuzzy"):
            members |= _weighted(claim)
        members["same"] = _same_set(claim, rows)
        rows.append(
            {
                "claim": members,
                "macro": kind.replace("-", "_"),
                "title": Tex(TITLES[kind]) if kind in TITLES else escape(result.name),
                "proved": kind in TITLES and result.verdict.name == "PROVED",
                "verdict": result.verdict.name,
                "text": f"{result.name}: {result.text}",
            }
        )
    return {
        "theorems": rows,
        "matrices": [(k, *entry) for k, entry in enumerate(numbers.values(), start=1)],
    }


def _weighted(claim: Mapping[str, Any]) -> dict[str, Any]:
    """Return P(w) of a claim for its theorem: its matrices by exponents, and rates of weights."""
    rates = claim.get("rates", ())
    matrices = [
        (Tex("".join(f"({listed(powers)})" for powers in coefficient["powers"])),
         matrix(coefficient["matrix"], exactly=True))
        for coefficient in claim["P"]
    ]  # fmt: skip
    return {
        "shown": matrices[:MOST_MATRICES],
        "hidden": max(len(matrices) - MOST_MATRICES, 0),
        "of_premises": len(claim["degrees"]) > 1,
        "rates": [Tex(r"\text{any}") if row is None else listed(row) for row in rates],
        "bounded": any(row is not None for row in rates),
    }


def _same_set(claim: Mapping[str, Any], rows: list[dict[str, Any]]) -> int | None:
    """Return the number of the theorem before that proves this claim's set to be invariant."""
    members = ("P", "level", "multiplier", "disturbance", "disturbance_bounds", "disturbance_norm")
    for number, row in enumerate(rows, start=1):
        earlier = row["claim"]
        if row["macro"] == "invariant_ellipsoid" and row["proved"]:
            if all(claim.get(member) == earlier.get(member) for member in members):
                return number
    return None


def is_matrix(value: Any) -> bool:
    """Return whether this is a matrix of numbers; some claims have P in another form."""
    return bool(value) and isinstance(value, list | tuple) and all(
        isinstance(row, list | tuple) and row and all(isinstance(x, int | float) for x in row)
        for row in value
    )  # fmt: skip
