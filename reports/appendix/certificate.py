"""The certificate as it was written: claims, P, cells, and the checker's sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.reports.appendix.tex import (
    Tex,
    checked_context,
    decimal,
    escape,
    interval,
    matrix,
    range_text,
)
from takagi.reports.page.rounded_bounds import at_most_to

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
    "speed_signal": r"|e - x| \le",
    "integral": r"|x| \le",
}


def certificate_context(design: TurbineDesign) -> dict[str, Any]:
    """Return verdict, claims and, for the effort-sharing law, the tables of its cells."""
    claims = list(design.document.get("claims", ()))
    context = checked_context(design.document, design.checked) | {
        "assumes": "; ".join(design.checked.assumes).replace("<=", "at most"),
        "other_claims": [_other(claim) for claim in claims if claim.get("kind") != "coherent-loop"],
    }
    loops = [claim for claim in claims if claim.get("kind") == "coherent-loop"]
    if loops:
        context["loop"] = _loop(loops[0], design)
    return context


def _power(uncertainty: Mapping[str, Any]) -> Tex | None:
    """Return the interval of the true c_P relative to the table; None if it is only 1."""
    low, high = uncertainty.get("power_coefficient", (1, 1))
    return interval([low, high]) if low < high else None


def _loop(claim: Mapping[str, Any], design: TurbineDesign) -> dict[str, Any]:
    """Return the numbers of theorem and tables, read from the claim that is checked."""
    cells: Sequence[Mapping[str, Any]] = claim["cells"]
    inertia = claim["uncertainty"]["inertia"]
    peak, turbine = claim["peaks"]["speed_error"], design.turbine
    top = max(cell_speed(design, k) for k in range(len(cells)))
    return {
        "P": matrix(claim["P"], exactly=True),
        "R": matrix(claim["settling"]["P"], exactly=True),
        "common": decimal(claim["settling"]["decay_rate"]),
        "states": [escape(name) for name in claim["state"]],
        "low": decimal(cells[0]["wind"][0]),
        "high": decimal(cells[-1]["wind"][1]),
        "count": len(cells),
        "inertia": interval(inertia),
        "frozen_wake": claim["uncertainty"]["frozen_wake"],
        "power": _power(claim["uncertainty"]),
        "box": {name: decimal(value) for name, value in claim["box"].items()},
        "peaks": [Tex(f"{_PEAKS[name]} {decimal(v)}") for name, v in
                  claim["peaks"].items()],
        "inertia_gain": range_text((cell["inertia_gain"] for cell in cells), 7),
        "decay": decimal(min(cell["decay_rate"] for cell in cells)),
        "decay_range": range_text((cell["decay_rate"] for cell in cells), 5),
        "error_range": range_text((cell["wind_error"] for cell in cells), 5),
        "rate_range": range_text((cell["wind_rate"] for cell in cells), 5),
        "overspeed": Tex(
            at_most_to(100 * ((top + peak) / turbine.rated_rotor_speed - 1), 2)
        ),
        "corners": 32,
        "ranges": [_range_rows(k, cell) for k, cell in enumerate(cells, start=1)],
        "claimed": [_claimed_row(k, cell) for k, cell in enumerate(cells, start=1)],
    }  # fmt: skip


def cell_speed(design: TurbineDesign, k: int) -> float:
    """Return the largest reference speed of cell k [rad/s]."""
    law = design.effort_sharing_law
    if law is None:
        return design.turbine.rated_rotor_speed
    return float(max(law.schedule.rotor_speed[k : k + 2]))


def _range_rows(k: int, cell: Mapping[str, Any]) -> tuple[list[Tex], list[Tex]]:
    """Return two rows: the lower ends and the upper ends of the cell's coefficients."""
    rows = []
    for end in (0, 1):
        number = escape(k) if end == 0 else Tex("")
        rows.append([number, *(decimal(cell[name][end]) for name in ("wind", *_RANGES))])
    return rows[0], rows[1]


def _claimed_row(k: int, cell: Mapping[str, Any]) -> list[Tex]:
    low, high = cell["wind"]
    wind = Tex(f"{decimal(low)} to {decimal(high)}")
    return [escape(k), wind, *(decimal(cell[name]) for name in (*_SIZES, *_CLAIMED))]


def _other(claim: Mapping[str, Any]) -> dict[str, Any]:
    """Return name, single values and P of a claim of any kind."""
    facts = [
        [escape(name.replace("_", " ")), _value(value)]
        for name, value in claim.items()
        if name not in ("name", "kind") and isinstance(value, (str, int, float, bool))
    ]
    P: Any = claim.get("P")
    return {
        "name": claim.get("name", ""),
        "kind": claim.get("kind", ""),
        "facts": facts,
        "P": matrix(P, exactly=True) if _is_matrix(P) else None,
        "cells": len(claim["cells"]) if isinstance(claim.get("cells"), (list, tuple)) else 0,
    }


def _value(value: Any) -> Tex:
    return escape(value) if isinstance(value, (str, bool)) else decimal(value)


def _is_matrix(value: Any) -> bool:
    """Return whether this is a matrix of numbers; some claims have P as a list or as a text."""
    if not isinstance(value, (list, tuple)) or not value:
        return False
    return all(
        isinstance(row, (list, tuple)) and row and all(isinstance(x, (int, float)) for x in row)
        for row in value
    )
