"""Sums, products, quotients and whole powers of intervals with rational ends, not rounded."""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias

from takagi.certificates.checker.plant.graph import Node, largest_bits

__all__ = ["Ends", "exact_operation"]

Ends: TypeAlias = tuple[Fraction, Fraction]
MOST_BITS = 20_000


def exact_operation(node: Node, parts: list[Ends]) -> Ends | None:
    """Return the interval of a node from those of its parts; None for a division by 0.

    None too where a number grows beyond 20 000 bits.
    """
    if node.op == "const":
        return node.value, node.value
    if any(largest_bits(end) * _growth(node) > MOST_BITS for part in parts for end in part):
        return None
    a = parts[0]
    if node.op == "add":
        b = parts[1]
        return a[0] + b[0], a[1] + b[1]
    if node.op == "multiply":
        return _product(a, parts[1])
    if node.op == "divide":
        below = _inverse(parts[1])
        return None if below is None else _product(a, below)
    found = _power(a, abs(int(node.value)))
    return found if node.value > 0 else _inverse(found)


def _growth(node: Node) -> int:
    return abs(int(node.value)) if node.op == "power" else 1


def _product(a: Ends, b: Ends) -> Ends:
    corners = [p * q for p in a for q in b]
    return min(corners), max(corners)


def _inverse(a: Ends) -> Ends | None:
    return None if a[0] <= 0 <= a[1] else (1 / a[1], 1 / a[0])


def _power(a: Ends, exponent: int) -> Ends:
    low, high = a[0] ** exponent, a[1] ** exponent
    if exponent % 2:
        return low, high
    return (Fraction(0) if a[0] <= 0 <= a[1] else min(low, high)), max(low, high)
