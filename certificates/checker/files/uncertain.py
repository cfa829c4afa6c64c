"""The uncertain parameters of a plant file, in the form of the file's signals.

A parameter with a range, ``m = { range = [0.9, 1.1], unit = "kg" }`` or ``m = "[0.9, 1.1] kg"``, is
a signal of the certificate that no law knows.  Its rest is its value; without a value, the middle
of its range.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

LARGEST = 100  # exponent of ten, in a figure
FIGURE = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*"
RANGE = re.compile(rf"\s*\[{FIGURE},{FIGURE}\](.*)", re.ASCII)


def uncertain_in(parameters: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return name -> unit, range and rest, of the parameters that have a range."""
    return {
        name: signal
        for name, entry in parameters.items()
        for signal in [_signal(entry)]
        if signal is not None
    }


def _signal(entry: Any) -> dict[str, Any] | None:
    if isinstance(entry, str):
        found = RANGE.fullmatch(entry)
        if found is None:
            return None
        entry = {"range": [Decimal(found[1]), Decimal(found[2])], "unit": found[3].strip() or "-"}
    elif isinstance(entry, list):
        entry = {"range": entry}
    if not isinstance(entry, dict) or entry.get("range") is None:
        return None
    ends = entry["range"]
    rest = entry.get("value")
    if rest is None and isinstance(ends, list) and len(ends) == 2:
        rest = _middle(*ends)
    return {"unit": entry.get("unit", "-"), "range": ends, "rest": rest}


def _middle(low: Any, high: Any) -> Fraction | None:
    """Return (low + high)/2; None for ends that are no finite numbers of usual size."""
    if any(isinstance(end, bool) or not isinstance(end, int | Decimal) for end in (low, high)):
        return None
    ends = [Decimal(low), Decimal(high)]
    if not all(end.is_finite() and abs(end.adjusted()) <= LARGEST for end in ends):
        return None
    return (Fraction(ends[0]) + Fraction(ends[1])) / 2
