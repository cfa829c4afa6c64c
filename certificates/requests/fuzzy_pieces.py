"""Searches P(h) at single blends, and the pieces of the weights on which it is proved.

The coefficients of a double sum may have the wrong sign at every practical degree of Polya's
relaxation, although P(h) is valid at every blend.  So P(h) is searched at single blends of the
loop, and the simplex of weights is halved until all coefficients have the right sign on each
piece.  A corner of a piece at which P(h) fails is added to the blends of the search.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import combinations
from typing import Any

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.fuzzy_decay import inequalities
from takagi.certificates.checker.kinds.simplex_polynomial import Polynomial
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.requests.loop.weight_points import (
    Corners,
    Point,
    corners_of,
    halved_corners,
    point_at,
)

MOST_PIECES = 400


class Cut:
    """``halvings`` : the tree, empty if none was found.
    ``failed`` : blends at which P(h) fails."""

    def __init__(self) -> None:
        self.halvings: list[list[int]] = []
        self.failed: list[Point] = []


def cut(claim: dict[str, Any], exact: PolytopicLoop) -> Cut:
    """Return the pieces that prove a claim ``fuzzy-decay``; the longest edges are cut first."""
    found = Cut()
    try:
        asked, _ = inequalities(read_text(json.dumps(claim), "claim"), exact, "claim")
    except CertificateError:
        return found
    tree: list[list[int]] = []
    left = [([X for X, _ in asked], corners_of(exact))]
    while left and len(tree) < MOST_PIECES:
        conditions, places = left.pop()
        open_ = [X for X in conditions if X.failing()]
        if not open_:
            tree.append([])
            continue
        found.failed += [point_at(exact, places, rule) for rule in _failing_rules(open_, exact)]
        if found.failed:
            return found
        premise, i, j = _longest(places)
        tree.append([premise, i, j])
        for kept, moved in ((j, i), (i, j)):
            # A coefficient that is positive on a piece is positive on its halves.
            half = [X.halved(premise, kept, moved) for X in open_]
            left.append((half, halved_corners(places, premise, kept, moved)))
    if not left:
        found.halvings = tree
    return found


def _failing_rules(conditions: list[Polynomial], exact: PolytopicLoop) -> Iterator[int]:
    """Yield the corners of a piece, as rules, at which an inequality fails by itself."""
    corners = exact.corners or tuple((i,) for i in range(exact.rules))
    for rule, corner in enumerate(corners):
        for X in conditions:
            place = tuple(
                tuple(degree * (c == at) for c in range(size))
                for size, degree, at in zip(X.sizes, X.degrees, corner, strict=True)
            )
            if place not in X.terms or not X.terms[place].is_positive_definite:
                yield rule
                break


def _longest(places: Corners) -> tuple[int, int, int]:
    """Return the premise and the two corners that are furthest apart."""
    edges = [
        (sum((a - b) ** 2 for a, b in zip(rows[i], rows[j], strict=True)), -premise, -i, -j)
        for premise, rows in enumerate(places)
        for i, j in combinations(range(len(rows)), 2)
    ]
    _, premise, i, j = max(edges)
    return -premise, -i, -j
