"""The certificate as it was written: claims as theorems, each matrix once, cells, sentences."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.reports.appendix.tex import (
    Tex,
    checked_context,
    decimal,
    escape,
    interval,
    listed,
    matrix,
    range_text,
)
from takagi.reports.kinds_in_words import KINDS_IN_WORDS
from takagi.reports.page.rounded_bounds import at_least, at_most_to

_RANGES = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
_SIZES = (
    "integral_rate",
    "residual",
    "wind_gain",
    "effectiveness_slope",
    "reference_slope",
    "lag_disturbance",
)
_CLAIMED = ("multiplier", "wind_error", "wind_rate", "decay_rate")
_PEAKS = {
    "speed_error": r"|e| \le",
    "effort_lag": r"|\zeta| \le",
    "speed_signal": r"|e - x_\mathrm{I}| \le",
    "integral": r"|x_\mathrm{I}| \le",
}


# Nodes of a function of wind that are printed.
MOST_NODES = 40


def certificate_context(design: TurbineDesign) -> dict[str, Any]:
    """Return verdict, theorems and, for the effort-sharing law, the tables of its cells."""
    context = checked_context(design.document, design.checked)
    context |= theorems_context(design.document, design.checked)
    # The matrix of the loop stands beside its theorem; those of its cells are too many to print.
    context |= {"loop": None, "matrices": [], "tables": [], "running": None}
    for order, theorem in enumerate(context["theorems"], start=1):
        claim, kind = theorem["claim"], theorem["claim"].get("kind")
        claim["order"] = order
        if kind == "coherent-loop":
            context["loop"] = _loop(claim, design) | {"order": order}
        elif kind == "wind-rate":
            claim["spans"] = [_span_of_winds(span) for span in claim["ranges"]]
            context["tables"].append(_rates_table(claim))
        elif kind == "bumpless":
            claim |= _actuator_sizes(claim, design) | {"listed": context["loop"] is not None}
            # Schulte's law has hundreds of cells.
            if claim["listed"]:
                context["tables"].append(_actuators_table(claim, context["loop"]))
        elif kind == "running-loop":
            claim["spans"] = [Tex(f"{interval(ends)}~m/s") for ends in claim["winds"]]
            claim["order_of"] = len(claim["cells"][0]["P"])
            context["running"] = order if theorem["proved"] else None
    return context


def _span_of_winds(span: Mapping[str, Any]) -> Tex:
    ends = interval((span["wind"][0], span["wind"][-1]))
    low, high = (decimal(f(span["estimate_rate"])) for f in (min, max))
    rates = low if low == high else Tex(f"{low} to {high}")
    error = decimal(span["estimate_error"])
    return Tex(rf"{ends}~m/s with $\eta_v = {error}$~m/s and $a$ of {rates}~m/s$^2$")


def _rates_table(claim: Mapping[str, Any]) -> dict[str, Any]:
    """Return the functions of the first range, at every k-th node where there are many."""
    columns = (claim["ranges"][0][name] for name in ("wind", "estimate_rate", "schedule_rate"))
    nodes = list(zip(*columns, strict=True))
    step = -(-len(nodes) // MOST_NODES)
    rows = [*nodes[:-1:step], nodes[-1]]
    selection = f", {len(rows)} of {len(nodes)} nodes; the certificate has all" if step > 1 else ""
    words = f"functions of the first range{selection}"
    return {"kind": claim["kind"], "order": claim["order"], "words": words,
            "rows": [[decimal(x) for x in node] for node in rows]}  # fmt: skip


def _actuator_sizes(claim: Mapping[str, Any], design: TurbineDesign) -> dict[str, Any]:
    cells, model = claim["cells"], design.document["model"]
    limit = model["torque_rate_limit"]
    return {
        "pitch_most": decimal(max(cell["pitch_rate"] for cell in cells)),
        "torque_most": decimal(max(cell["torque_rate"] for cell in cells)),
        "pitch_limit": escape(at_least(model["pitch_rate_limit"], 6)),
        "torque_limit": decimal(limit),
        "torque_within": sum(cell["torque_rate"] <= limit for cell in cells),
    }


def _actuators_table(claim: Mapping[str, Any], loop: Mapping[str, Any]) -> dict[str, Any]:
    names = ("pitch_rate", "torque_rate")
    rows = [
        [*head[:2], *(decimal(cell[name]) for name in names)]
        for head, cell in zip(loop["claimed"], claim["cells"], strict=True)
    ]
    return {"kind": claim["kind"], "order": claim["order"], "rows": rows}


def _power(uncertainty: Mapping[str, Any]) -> Tex | None:
    """Return the interval of the true c_P relative to the table; None if it is only 1."""
    low, high = uncertainty.get("power_coefficient", (1, 1))
    return interval([low, high]) if low < high else None


def _loop(claim: Mapping[str, Any], design: TurbineDesign) -> dict[str, Any]:
    """Return the numbers of theorem and tables, read from the claim that is checked."""
    cells: Sequence[Mapping[str, Any]] = claim["cells"]
    law, rated = design.effort_sharing_law, design.turbine.rated_rotor_speed
    assert law is not None  # the claim is about it
    fastest = float(max(law.schedule.rotor_speed)) + claim["peaks"]["speed_error"]
    return {
        "claim": claim,
        "power": _power(claim["uncertainty"]),
        "peaks": [Tex(f"{_PEAKS[name]} {decimal(v)}") for name, v in
                  claim["peaks"].items()],
        "inertia_gain": range_text((cell["inertia_gain"] for cell in cells), 7),
        "decay_range": range_text((cell["decay_rate"] for cell in cells), 5),
        "overspeed": Tex(at_most_to(100 * (fastest / rated - 1), 2)),
        "ranges": [
            [escape(k), _winds(cell), *(decimal(end) for name in _RANGES for end in cell[name])]
            for k, cell in enumerate(cells, start=1)
        ],
        "claimed": [
            [escape(k), _winds(cell), *(decimal(cell[name]) for name in (*_SIZES, *_CLAIMED))]
            for k, cell in enumerate(cells, start=1)
        ],
    }  # fmt: skip


def _winds(cell: Mapping[str, Any]) -> Tex:
    low, high = cell["wind"]
    return Tex(f"{decimal(low)} to {decimal(high)}")


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
