r"""``turbine-crossing``: the linear loop's speed leaves its reference in turbulence rarely.

On each piece of the parameters' box X > 0, with A X + X A' + S S' < 0 at the corners.  With
v = h X h' and w = max h A X A' h', and the limit b = overspeed times rated speed, b^2 >= v, the
bound of ``loop.crossing`` is at most the claim's probability.  A is affine in each of 1/inertia,
the four factors and 1/wake_length, so that the corners' hull holds the matrices of the piece.

Written from docs/turbine-crossing.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import negative, transposed
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, entry, rational, stack
from takagi.certificates.cross_check.loop.crossing import at_most
from takagi.certificates.cross_check.turbine.linear.linear_rates import (
    NAMES,
    Ends,
    LinearRates,
    parameters,
)
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.running.machine import Machine, same_controller
from takagi.certificates.cross_check.turbine.running.shortened import shortened
from takagi.certificates.cross_check.turbine.surface import Outside

MOST_PIECES = 256
MOST_EFFORT = 100_000_000  # corners of all pieces times the fourth power of the order


def turbine_crossing(claim: Any, document: Any) -> Obligations:
    """Yield the conditions of the module's text."""
    model, gains = entry(document, "model"), entry(document, "gains")
    rotor, machine = Rotor(model, gains), Machine(claim, model, gains)
    if not same_controller(claim, document):
        raise Refusal("observer or filters are not the controller's")
    mean, overspeed, T, p = (
        rational(claim, name) for name in ("wind", "overspeed", "horizon", "probability")
    )
    if min(mean, overspeed, T, p) <= 0 or p >= 1:
        raise Refusal("wind, overspeed, horizon above 0, and a probability, are needed")
    pieces = list(_pieces(claim, parameters(claim)))
    covariances = stack(claim, "C")
    n = 11 if machine.stop is None else 13
    square = (covariances[0].nrows(), covariances[0].ncols()) == (n, n)
    if len(covariances) != len(pieces) or not square:
        raise Refusal(f"C: {len(pieces)} matrices of order {n}, one for each piece")
    if sum(sum(1 for _ in _corners(piece)) for piece in pieces) * n**4 > MOST_EFFORT:
        raise Refusal("more corners of pieces than are tested")
    try:
        loop = LinearRates(rotor, machine, claim, mean)
    except Outside as reason:
        yield Fact(f"a derivative at the trim ({reason})", False)
        return
    b, h, S = overspeed * rational(model, "rated_rotor_speed"), loop.signal(), loop.spread()
    for number, (piece, X) in enumerate(zip(pieces, covariances, strict=True), 1):
        yield Definite(f"C of piece {number}", X)
        v, w = (h * X * transposed(h))[0, 0], fmpq(0)
        yield Fact(f"the limit is a deviation or more in piece {number}", b * b >= v)
        for corner in _corners(piece):
            A = loop.at(corner)
            growth = A * X + transposed(A * X) + S
            yield Definite(f"covariance of piece {number}", shortened(negative(growth)))
            rate = h * A
            w = max(w, (rate * X * transposed(rate))[0, 0])
        yield Fact(f"probability in piece {number}", at_most(b, v, w, T, p))


def _pieces(claim: Any, box: Ends) -> Iterator[Ends]:
    """Yield the leaves of the tree of halves; its nodes stand before their halves."""
    nodes = claim.get("cuts", [""])
    if not isinstance(nodes, list) or len(nodes) not in range(1, 2 * MOST_PIECES):
        raise Refusal(f"cuts: a tree of at most {MOST_PIECES} pieces is needed")
    left = iter(nodes)

    def below(ends: Ends, depth: int) -> Iterator[Ends]:
        name = next(left, None)
        if name == "":
            yield ends
            return
        if not isinstance(name, str) or name not in ends or depth > MOST_PIECES:
            raise Refusal("cuts: a parameter's name, or an empty text for a piece, is needed")
        low, high = ends[name]
        if low == high:
            raise Refusal("cuts: a parameter that has one value is not halved")
        half = (low + high) / 2
        yield from below({**ends, name: (low, half)}, depth + 1)
        yield from below({**ends, name: (half, high)}, depth + 1)

    yield from below(box, 0)
    if next(left, None) is not None:
        raise Refusal("cuts: more nodes than the tree has")


def _corners(piece: Ends) -> Iterator[dict[str, fmpq]]:
    ends = [piece[name] if piece[name][0] != piece[name][1] else piece[name][:1] for name in NAMES]
    for values in product(*ends):
        yield dict(zip(NAMES, values, strict=True))
