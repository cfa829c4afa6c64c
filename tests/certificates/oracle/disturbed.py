r"""Claims about a loop with disturbance: invariant sets, gains, limits of inputs.

    x' (or x+) = A x + E w,     y = C x + D w            along each mixture

For V = x'Px the change V' (or V(x+) - V) is z' N z with z = (x, w) and

    continuous   N = [[P A + A'P, P E], [E'P, 0]]
    discrete     N = [[A'P A - P, A'P E], [E'P A, E'P E]].

All inequalities below have the form -N + ... >= 0.  Sources: Boyd, El Ghaoui, Feron, Balakrishnan
(1994), chapters 5 to 7; Scherer, Gahinet, Chilali (1997); recalled.

The probability that a loop with white noise leaves an ellipsoid within a time.

    dx = (A x + D v) dt + S dW,     |v_k| <= 1 each,        V = x'Px,     the set is V <= 1

Suppose that for every mixture and every x, v

    2 x'P(A x + D v) + 2 k |S'Px|^2 <= -a V + sum b_k v_k^2.                                 (1)

The first term and tr(S'PS) are the drift of V, and 4 |S'Px|^2 dt is its quadratic variation.  So
exp(kV) drifts by at most g(V) = k exp(kV) (c - aV), with c = sum b_k + max tr(S'PS).  On [0, 1]

    max g = k c at V = 0 for k c <= a;      max g <= a exp(k c/a - 1), the value where g' = 0.

(1) is decided without Schur's complement: its left side less its right is a form in (x, v),

    [[PA + A'P + a P + 2 k P S S' P,  P D], [D'P, -diag(b)]],

convex in (A, D, S), so mixtures suffice.  From V = v0 the maximal inequality gives

    Prob(V reaches 1 by T) <= (exp(k v0) + T max g) / exp(k).

Source: derived from the formulas of docs/plant-theorems.md; Kushner (1967), recalled.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from flint import arb, ctx, fmpq, fmpq_mat

from tests.certificates.oracle.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    diagonal,
    entries,
    identity,
    negative,
    scaled,
    transposed,
    zeros,
)
from tests.certificates.oracle.loop import Mixture, Stack, VertexLoop, mixtures
from tests.certificates.oracle.reading import (
    Refusal,
    entry,
    rational,
    rationals,
    stack,
    table,
)

MOST_SIGNS = 1 << 10  # corners of a box of disturbances; w and -w count once


def change(loop: VertexLoop, P: fmpq_mat, A: fmpq_mat, E: fmpq_mat) -> fmpq_mat:
    """Return N of the module."""
    if loop.step is None:
        return blocks([[P * A + transposed(A) * P, P * E],
                       [transposed(E) * P, zeros(E.ncols(), E.ncols())]])  # fmt: skip
    both = blocks([[A, E]])
    old = blocks([[P, zeros(loop.n, E.ncols())],
                  [zeros(E.ncols(), loop.n), zeros(E.ncols(), E.ncols())]])  # fmt: skip
    return transposed(both) * P * both - old


@dataclass(frozen=True)
class DisturbanceChannel:
    """The matrices of x' (or x+) = A x + E w, y = C x + D w at one mixture."""

    mixture: Mixture
    A: fmpq_mat
    E: fmpq_mat
    C: fmpq_mat
    D: fmpq_mat


def disturbance_of(claim: Any, loop: VertexLoop) -> tuple[str, Stack]:
    """Return the claim's name of the disturbance, and its matrices: E, or B."""
    name = entry(claim, "disturbance")
    matrices: Stack = ()
    if isinstance(name, str):
        matrices = {"disturbances": loop.E, "inputs": loop.B}.get(name, ())
    if not matrices:
        raise Refusal(f"disturbance: {str(name)!a} is no way into this model")
    return str(name), matrices


def channel_of(claim: Any, loop: VertexLoop) -> tuple[VertexLoop, Stack, list[Stack]]:
    """Return the loop with the claim's output y, the matrices of w, and those of w in y."""
    name, E = disturbance_of(claim, loop)
    F: Stack = ()
    if "output" in claim:
        given = entry(claim, "output")
        m = loop.B[0].ncols() if loop.B else 0
        C = stack(given, "C")
        rows = C[0].nrows()
        D, F = (stack(given, key) if key in given else () for key in ("D", "F"))
        for matrices, width in ((C, loop.n), (D, m), (F, E[0].ncols())):
            if matrices and (
                (matrices[0].nrows(), matrices[0].ncols()) != (rows, width)
                or len(matrices) not in (1, loop.rules)
            ):
                raise Refusal("output: C, D, F do not fit the model")
            if loop.averages and len(matrices) > 1:
                raise Refusal("output: blended by weights that are averages over a segment")
        loop = replace(loop, C=C, D=D)
    if not loop.C:
        raise Refusal("there is no output")
    return loop, E, [stack for stack in (F, loop.D if name == "inputs" else ()) if stack]


def _channels(claim: Any, loop: VertexLoop) -> Iterator[DisturbanceChannel]:
    """Yield the channel from w to y at each mixture; y is the claim's, else the model's."""
    loop, E, direct = channel_of(claim, loop)
    for mixture in mixtures(claim, replace(loop, beside=(E, *direct))):
        E_mean, *further = (mixture.of(matrices) for matrices in mixture.loop.beside)
        D_mean = zeros(loop.C[0].nrows(), E[0].ncols())
        for matrices in further:
            D_mean = D_mean + matrices
        yield DisturbanceChannel(mixture, mixture.A, E_mean, mixture.C, D_mean)


def l2_gain(claim: Any, loop: VertexLoop) -> Obligations:
    """|y|_2 <= g |w|_2 from rest: -N + [[0, 0], [0, g I]] - [C D]'[C D] / g > 0.

    With ``energy_bound`` b also x'Px <= g b^2 for |w|_2 <= b, so that the state stays in the box.
    """
    P, g = table(claim, "P", (loop.n, loop.n)), rational(claim, "gain")
    if g <= 0:
        raise Refusal("gain: a positive number is needed")
    yield Definite("P", P)
    for channel in _channels(claim, loop):
        output = blocks([[channel.C, channel.D]])
        supply = _lower_block(loop.n, scaled(g, identity(channel.E.ncols())))
        dissipation = (
            supply
            - change(loop, P, channel.A, channel.E)
            - scaled(1 / g, transposed(output) * output)
        )
        yield Definite(f"gain at {channel.mixture.label}", dissipation)
    if "energy_bound" in claim:
        bound = rational(claim, "energy_bound")
        if bound <= 0:
            raise Refusal("energy_bound: a positive number is needed")
        limited = any(name in loop.inputs for name in loop.other_sides)
        added = entry(claim, "disturbance") == "inputs"
        yield Fact("no input with a range is pushed", not (added and limited))
        yield from within_box(loop, P, g * bound**2)


def _lower_block(n: int, corner: fmpq_mat) -> fmpq_mat:
    m = corner.ncols()
    return blocks([[zeros(n, n), zeros(n, m)], [zeros(m, n), corner]])


def h2_norm(claim: Any, loop: VertexLoop) -> Obligations:
    """The mean of E|y|^2 is at most norm^2: -N_11 - C'C > 0, tr(E'PE + D'D) <= norm^2.

    No premise may depend on a noisy signal: the weights would then be correlated with the noise of
    the same instant, and the formula for the variance would not hold.
    """
    P, norm = table(claim, "P", (loop.n, loop.n)), rational(claim, "norm")
    if norm <= 0:
        raise Refusal("norm: a positive number is needed")
    yield Definite("P", P)
    for channel in _channels(claim, loop):
        change_of_V = change(loop, P, channel.A, zeros(loop.n, 1))
        state_block = fmpq_mat([row[: loop.n] for row in entries(change_of_V)[: loop.n]])
        yield Definite(
            f"output at {channel.mixture.label}",
            negative(state_block) - transposed(channel.C) * channel.C,
        )
        direct = sum((v**2 for row in entries(channel.D) for v in row), fmpq(0))
        yield Fact("noise does not reach y directly", loop.step is not None or direct == 0)
        energy = transposed(channel.E) * P * channel.E
        total = sum((energy[k, k] for k in range(energy.nrows())), direct)
        yield Fact(f"variance at {channel.mixture.label}", total <= norm**2)
    noisy = loop.pushes if entry(claim, "disturbance") == "disturbances" else loop.inputs
    unaware = not any(name in noisy for name in loop.seen_by)
    yield Fact("premises do not depend on the noise of the same instant", unaware)


@dataclass(frozen=True)
class InvariantSet:
    """An invariant set {x'Px <= c} and the disturbance against which it is invariant.

    ``s`` is the multiplier: V' <= s (c - V).  ``disturbance`` is its name in the claim, ``E``
    its matrices.  With ``ball`` |w|_2 <= b[0], else |w_k| <= b[k].
    """

    P: fmpq_mat
    c: fmpq
    s: fmpq
    disturbance: str
    E: Stack
    b: list[fmpq]
    ball: bool
    claim: Any

    @property
    def by_entry(self) -> list[fmpq]:
        """A bound of each |w_k|; empty without a disturbance."""
        return self.b * self.E[0].ncols() if self.ball else self.b


def invariant_set_of(claim: Any, loop: VertexLoop) -> InvariantSet:
    """Return the set that the claim states to be invariant.

    Raises
    ------
    Refusal : numbers that are not positive, a disturbance that the model does not have.
    """
    P = table(claim, "P", (loop.n, loop.n))
    c, s = rational(claim, "level"), rational(claim, "multiplier")
    if c <= 0 or s <= 0 or (loop.step is not None and s > 1):
        raise Refusal("level and multiplier: positive, the second at most 1 in discrete time")
    if "disturbance" not in claim:
        return InvariantSet(P, c, s, "", (), [], False, claim)
    disturbance, E = disturbance_of(claim, loop)
    ball = "disturbance_norm" in claim
    if ball:
        b = [rational(claim, "disturbance_norm")]
    else:
        b = rationals(claim, "disturbance_bounds", E[0].ncols())
    if min(b) < 0 or 1 << (len(b) - 1) > MOST_SIGNS:
        raise Refusal("bounds on the disturbance: not negative, and not too many")
    return InvariantSet(P, c, s, disturbance, E, b, ball, claim)


def set_is_invariant(invariant: InvariantSet, loop: VertexLoop) -> Obligations:
    """V' <= s (c - V) at every mixture while w keeps its bounds, and the set lies in the box.

    The condition is -N - s [[P, 0], [0, 0]] + s c (1 or w'w / b^2) >= 0, with w at its bounds: N is
    convex in w, so that the corners of the bounds suffice.  E is multiplied by the bound, so that
    the lower right block is s c times the identity.
    """
    yield Definite("P", invariant.P)
    n = loop.n
    for mixture in mixtures(invariant.claim, replace(loop, beside=(invariant.E,))):
        for W in _extreme_disturbances(invariant):
            width = W.ncols() if invariant.b else 1
            E = mixture.of(mixture.loop.beside[0]) * W if invariant.b else zeros(n, 1)
            supply = (
                scaled(invariant.s * invariant.c, identity(width)) if invariant.b else zeros(1, 1)
            )
            set_block = blocks([[scaled(invariant.s, invariant.P), zeros(n, width)],
                          [zeros(width, n), negative(supply)]])  # fmt: skip
            dissipation = negative(change(loop, invariant.P, mixture.A, E) + set_block)
            yield Definite(f"invariance at {mixture.label}", dissipation, strict=False)
    pushes = invariant.by_entry
    yield from disturbances_in_box(loop, invariant.disturbance, pushes)
    yield from within_box(
        loop, invariant.P, invariant.c, pushes if invariant.disturbance == "inputs" else None
    )


def disturbances_in_box(loop: VertexLoop, disturbance: str, pushes: list[fmpq]) -> Obligations:
    """The model's disturbances are in their ranges: bounded by the claim, or 0."""
    for name, side in loop.other_sides.items():
        if disturbance == "disturbances" and moves_states(loop, name):
            fits = pushes[loop.pushes.index(name)] <= _reach_of(side)
            yield Fact("the disturbance stays in the box", fits)
        elif disturbance != "disturbances" and moves_states(loop, name):
            yield Fact("no disturbance stays in the box", _reach_of(side) >= 0)


def _extreme_disturbances(invariant: InvariantSet) -> Iterator[fmpq_mat]:
    if invariant.ball:
        yield scaled(invariant.b[0], identity(invariant.E[0].ncols()))
    elif not invariant.b:
        yield zeros(1, 1)
    else:
        # (x, w) and (-x, -w) give the same condition, so that the first sign can be fixed.
        first, *rest = invariant.b
        for signs in product((1, -1), repeat=len(rest)):
            yield fmpq_mat([[first], *([s * b] for s, b in zip(signs, rest, strict=True))])


def moves_states(loop: VertexLoop, name: str) -> bool:
    """Return whether a signal has a nonzero column of E; one without only sets the weights."""
    if name not in loop.pushes:
        return False
    k = loop.pushes.index(name)
    return any(E[i, k] != 0 for E in loop.E for i in range(loop.n))


def _reach_of(side: tuple[fmpq, fmpq]) -> fmpq:
    return min(-side[0], side[1])


def largest_extent(P: fmpq_mat, level: fmpq, row: fmpq_mat, limit: fmpq, label: str) -> Obligations:
    """|row x| <= limit on {x'Px <= level}: limit^2 P - level row'row >= 0."""
    yield Fact(f"{label}: there is room", limit >= 0)
    yield Definite(label, scaled(limit**2, P) - scaled(level, transposed(row) * row), strict=False)


def within_box(
    loop: VertexLoop, P: fmpq_mat, level: fmpq, added: list[fmpq] | None = None
) -> Obligations:
    """On {x'Px <= level} the states, and the inputs by each gain, are in the ranges of the box.

    ``added`` is a bound of what a disturbance adds to each input.
    """
    # The box has ranges by name: one that is also an input's or a disturbance's bounds two signals.
    others = {*loop.inputs, *loop.pushes}
    yield Fact("no state has the name of another signal", others.isdisjoint(loop.states))
    unit = identity(loop.n)
    for k, side in enumerate(loop.sides):
        if side is not None:
            row = fmpq_mat([entries(unit)[k]])
            yield from largest_extent(P, level, row, _reach_of(side), f"state {k + 1} in the box")
    for name, side in loop.other_sides.items():
        if name not in loop.inputs:
            continue
        k = loop.inputs.index(name)
        limit_left = _reach_of(side) - (added[k] if added else fmpq(0))
        yield Fact(f"input {k + 1}: there is room", limit_left >= 0)
        for j, K in enumerate(loop.K):
            row = fmpq_mat([entries(K)[k]])
            yield from largest_extent(
                P, level, row, limit_left, f"input {k + 1} by gain {j + 1} in the box"
            )


def invariant_ellipsoid(claim: Any, loop: VertexLoop) -> Obligations:
    """The set is invariant, and lies in the box."""
    yield from set_is_invariant(invariant_set_of(claim, loop), loop)


def peak(claim: Any, loop: VertexLoop) -> Obligations:
    """|y| <= g b on the set, for |w|_2 <= b:

    g^2 b^2 [[(1 - t) P / c, 0], [0, t I / b^2]] - [C D]'[C D] >= 0 with a share t.
    """
    invariant = invariant_set_of(claim, loop)
    g = rational(claim, "gain")
    t = rational(claim, "share") if "share" in claim else fmpq(0)
    if not invariant.ball or invariant.b[0] == 0 or g <= 0 or not 0 <= t <= 1:
        raise Refusal("a peak needs |w|_2 <= b, a gain, and a share from 0 to 1")
    yield from set_is_invariant(invariant, loop)
    b = invariant.b[0]
    for channel in _channels(claim, loop):
        output, width = blocks([[channel.C, channel.D]]), channel.D.ncols()
        supply = blocks([
            [scaled(g**2 * b**2 * (1 - t) / invariant.c, invariant.P), zeros(loop.n, width)],
            [zeros(width, loop.n), scaled(g**2 * t, identity(width))],
        ])  # fmt: skip
        margin = supply - transposed(output) * output
        yield Definite(f"output at {channel.mixture.label}", margin, strict=False)


BITS = 256  # of the balls


def exit_probability(claim: Any, loop: VertexLoop) -> Obligations:
    """Test that V reaches 1 within the horizon with at most the claim's probability."""
    if loop.step is not None:
        raise Refusal("noise of this kind enters loops in continuous time")
    P = table(claim, "P", (loop.n, loop.n))
    a, k, v0, T, p = (
        rational(claim, key) for key in ("rate", "exponent", "start", "horizon", "probability")
    )
    if min(a, k, T, p) <= 0 or v0 < 0 or v0 >= 1 or p >= 1:
        raise Refusal("rate, exponent, horizon > 0; start from 0 to 1; probability between")
    disturbance, E = disturbance_of(claim, loop)
    width = E[0].ncols()
    noise = rationals(claim, "noise", width)
    bounds = [fmpq(0)] * width
    if "disturbance_bounds" in claim:
        bounds = rationals(claim, "disturbance_bounds", width)
    if min(*noise, *bounds) < 0 or max(noise) == 0:
        raise Refusal("noise and bounds: not negative, and some noise")
    moving = [j for j in range(width) if bounds[j] > 0]
    b = rationals(claim, "multipliers", len(moving)) if moving else []
    if any(multiplier < 0 for multiplier in b):
        raise Refusal("multipliers: not negative")
    yield Definite("P", P)
    names = loop.pushes if disturbance == "disturbances" else loop.inputs
    for j, name in enumerate(names):
        free = name not in loop.other_sides and name not in (loop.seen_by or ())
        yield Fact("noise has no range and is in no premise", noise[j] == 0 or free)
    largest_variation = fmpq(0)
    for mixture in mixtures(claim, replace(loop, beside=(E,))):
        E_mean = mixture.of(mixture.loop.beside[0])
        S = _columns(E_mean, [(j, size) for j, size in enumerate(noise) if size > 0])
        PS, PA = P * S, P * mixture.A
        form = PA + transposed(PA) + scaled(a, P) + scaled(2 * k, PS * transposed(PS))
        if moving:
            PD = P * _columns(E_mean, [(j, bounds[j]) for j in moving])
            form = blocks([[form, PD], [transposed(PD), negative(diagonal(b))]])
        yield Definite(f"drift at {mixture.label}", negative(form), strict=False)
        variation = transposed(S) * PS
        largest_variation = max(
            largest_variation, sum((variation[j, j] for j in range(S.ncols())), fmpq(0))
        )
    c = sum(b, largest_variation)
    yield Fact("the maximum of the drift lies below the level", k * c <= a * (1 + k))
    yield Fact("probability", _at_most(a, k, c, v0, T, p))
    yield from disturbances_in_box(loop, disturbance, bounds)
    yield from within_box(loop, P, fmpq(1), bounds if disturbance == "inputs" else None)


def _columns(matrix: fmpq_mat, columns: list[tuple[int, fmpq]]) -> fmpq_mat:
    """Return these columns of a matrix, each times its factor."""
    return fmpq_mat([[row[j] * size for j, size in columns] for row in entries(matrix)])


def _at_most(a: fmpq, k: fmpq, c: fmpq, v0: fmpq, T: fmpq, p: fmpq) -> bool:
    """Return whether the bound is certainly at most p; by balls that enclose exp."""
    with ctx.workprec(BITS):
        drift = arb(k * c) if k * c <= a else arb(a) * (arb(k * c / a) - 1).exp()
        bound = arb(k * (v0 - 1)).exp() + arb(T) * drift * arb(-k).exp()
        return bool(bound <= arb(p))
