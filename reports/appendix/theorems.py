"""The claims of a certificate as theorems: numbers of each claim, and its matrices once."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.kernel.result import Checked
from takagi.reports.appendix.tex import Tex, decimal, escape, listed, matrix
from takagi.reports.kinds_in_words import KINDS_IN_WORDS

# Of a function of the weights so many matrices are printed.
MOST_MATRICES = 8


def theorems_context(document: Mapping[str, Any], checked: Checked) -> dict[str, Any]:
    """Return the claims in their order, and the different matrices P among them.

    ``theorems`` has (claim, macro, title, proved, verdict, sentence, text): macro is the name of
    the kind in the templates; a kind without one is stated by its sentence.  The claim has the
    member ``number`` of its P.  ``matrices`` has (number,
    P exactly as emitted, its levels).
    """
    rows: list[dict[str, Any]] = []
    numbers: dict[str, tuple[Tex, list[Tex]]] = {}
    for claim, result in zip(document.get("claims", ()), checked.claims, strict=False):
        kind, P = str(claim.get("kind")), claim.get("P")
        words = KINDS_IN_WORDS.get(kind)
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
                "title": Tex(words.title) if words else escape(result.name),
                "proved": result.verdict.name == "PROVED",
                "verdict": result.verdict.name,
                "sentence": result.text,
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
