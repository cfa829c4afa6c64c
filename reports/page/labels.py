"""Labels of variables, such as ``"angle [rad]"``, in their two parts."""

from __future__ import annotations


def name_of(label: str) -> str:
    """Return the name without its unit."""
    return label.split(" [")[0]


def unit_of(label: str) -> str:
    """Return the unit; "-" for a pure number, empty where the label has none."""
    return label.partition(" [")[2].rstrip("]")
