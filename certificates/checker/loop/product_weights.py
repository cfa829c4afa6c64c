"""Weights that are products of the weights of premises, and their definition as one text."""

from __future__ import annotations

from itertools import product
from math import prod
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def read_weights(
    model: Any, where: str, rules: int
) -> tuple[tuple[tuple[int, ...], ...] | None, str]:
    """Return the corners of the rules, or None, and the definition of the weights."""
    corners, premises = read_corners(model, where, rules), model.get("premises")
    definition = weights_of(premises, corners)
    if corners is not None:
        require_every_corner(premises, corners, where)
    return corners, definition


def shares_weights(plain: PolytopicLoop, gains: Any, where: str, *, several: bool) -> bool:
    """Return whether a law has the weights of the model; ``several`` : its gains differ."""
    # A gain that is written once applies to all rules of the law, however many these are.
    rows, premises = gains.get("rules"), gains.get("premises")
    count = len(rows if isinstance(rows, list) and len(gains["K"]) == 1 else gains["K"])
    law_corners = read_corners(gains, where, count)
    corners = law_corners or plain.corners
    shared = weights_of(premises, corners) == plain.weights
    # Equal gains too are one gain only where the law's weights have the sum 1. Without stated
    # premises nothing else is known about them.
    if corners and (law_corners or (premises and several and not shared)):
        require_every_corner(premises, corners, where)
    return shared


def read_corners(model: Any, where: str, rules: int) -> tuple[tuple[int, ...], ...] | None:
    """Return the corners of every rule; None where weights are not said to be products."""
    if "rules" not in model:
        return None
    rows = reader.matrix(model, "rules", where)
    corners = tuple(tuple(map(int, row)) for row in rows)
    is_binary = all(corner in (0, 1) for row in rows for corner in row)
    if not is_binary or not len(set(corners)) == len(corners) == rules:
        raise CertificateError(f"{where}.rules: {rules} different rows of 0 and 1 are needed")
    return corners


def weights_of(premises: Any, corners: tuple[tuple[int, ...], ...] | None) -> str:
    """Return the definition of the weights as one text; equal texts mean equal weights.

    Numbers are compared as written. So equal weights may be treated as different, but never
    different weights as equal.
    """
    if not premises and not corners:
        return ""
    if not isinstance(premises or [], list):
        raise CertificateError("premises: a list is needed")
    needed, rows = ("name", "lower", "upper"), [list(map(str, row)) for row in corners or ()]
    definitions = [[*(reader.member(p, key, "premises") for key in needed), p.get("expression")]
            for p in premises or []]  # fmt: skip
    return reader.canonical([definitions, rows])


def require_every_corner(premises: Any, corners: tuple[tuple[int, ...], ...], where: str) -> None:
    """Refuse products of weights that do not cover all corners, because their sum is not 1.

    Where no premises are stated, one that is at the same end in all rules counts as constant.
    """
    if premises:
        sides = [[reader.number(p, end, where) for end in ("lower", "upper")] for p in premises]
        ends = [(0,) if low == high else (0, 1) for low, high in sides]
    else:
        ends = [tuple(set(column)) for column in zip(*corners, strict=True)]
    # The count first: forty premises have more corners than fit into memory.
    if len(corners) != prod(map(len, ends)) or set(corners) != set(product(*ends)):
        raise CertificateError(
            f"{where}.rules: not the corners of its {len(ends)} premises, each of them once"
        )
