r"""A law that runs every T seconds and holds its command, on a plant in continuous time.

Let z = (x, u).  Between samples z' = M z, with M = [[A, B], [0, 0]] of any rule; right after a
sample z = (x, -K x).  The claim has the Bernstein coefficients P_0 ... P_d of a function Q(s),
where s in [0, 1] is the elapsed share of the interval.  Here Q is expanded in powers of s; then

    F_i(s) = -Q'(s) - T (Q(s) M_i + M_i'Q(s)) = sum_k s^k F_ik

is formed power by power.  F_i is semidefinite on [0, 1] if its own Bernstein coefficients

    f_l = sum_{k <= l} binom(l, k) / binom(d, k) F_ik

are semidefinite.  Then z'Qz does not grow within the interval.  With Q(1) >= [[P, 0], [0, 0]],
x'Px at the end is at most z'Q(0)z at the beginning, which is below e^(-2 alpha T) x'Px there.
Source: derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb
from typing import Any

from flint import fmpq, fmpq_mat

from tests.certificates.oracle.decay import exponential
from tests.certificates.oracle.disturbed import (
    disturbances_in_box,
    largest_extent,
    within_box,
)
from tests.certificates.oracle.exact import (
    Definite,
    Obligations,
    blocks,
    identity,
    negative,
    scaled,
    transposed,
    zeros,
)
from tests.certificates.oracle.loop import VertexLoop, pick
from tests.certificates.oracle.reading import Refusal, rational, stack, table

HIGHEST = 20  # degree of Q


def sampled_loop(claim: Any, loop: VertexLoop) -> Obligations:
    """V decays from sample to sample, and between samples the state stays in the box."""
    if loop.step is not None or not loop.K or not loop.B:
        raise Refusal("a sampled law is about inputs and gains in continuous time")
    n, m = loop.n, loop.K[0].nrows()
    T, c, a = (rational(claim, key) for key in ("sample_time", "level", "decay_rate"))
    P, nodes = table(claim, "P", (n, n)), stack(claim, "functions")
    sizes = (nodes[0].nrows(), nodes[0].ncols()) == (n + m, n + m)
    if not sizes or not 2 <= len(nodes) <= HIGHEST + 1 or T <= 0 or c <= 0 or a < 0:
        raise Refusal("sample_time, level, decay_rate or functions are none")
    yield Definite("P", P)
    yield Definite("the function at a sample", nodes[0], strict=False)
    state = blocks([[P, zeros(n, m)], [zeros(m, n), zeros(m, m)]])
    yield Definite("the end of the interval", nodes[-1] - state, strict=False)
    share = exponential(2 * a * T, up=False) if a else fmpq(1)
    for j, K in enumerate(loop.K):
        begun = blocks([[identity(n)], [negative(K)]])
        after = transposed(begun) * nodes[0] * begun
        yield Definite(f"the sample with gain {j + 1}", scaled(share, P) - after)
    powers = _powers(nodes)
    for i in range(loop.rules):
        M = blocks([[pick(loop.A, i), pick(loop.B, i)], [zeros(m, n), zeros(m, m)]])
        for k, coefficient in enumerate(_bernstein(_fall(powers, scaled(T, M)))):
            yield Definite(f"rule {i + 1} between samples, {k + 1}", coefficient, strict=False)
    yield from disturbances_in_box(loop, "", [])
    yield from within_box(loop, P, c)
    for k, side in enumerate(loop.sides):
        if side is not None:
            row = fmpq_mat(1, n + m, [int(i == k) for i in range(n + m)])
            for node in nodes:
                yield from largest_extent(
                    node, c, row, min(-side[0], side[1]), f"state {k + 1} between samples"
                )


def _powers(nodes: Sequence[fmpq_mat]) -> list[fmpq_mat]:
    """Return Q_k of Q(s) = sum_k s^k Q_k: binom(d, k) times the k-th difference of the nodes."""
    d, powers, differences = len(nodes) - 1, [], list(nodes)
    for k in range(d + 1):
        powers.append(scaled(comb(d, k), differences[0]))
        differences = [
            after - before for before, after in zip(differences, differences[1:], strict=False)
        ]
    return powers


def _fall(powers: Sequence[fmpq_mat], M: fmpq_mat) -> list[fmpq_mat]:
    """Return the F_ik; M is T M_i, since s measures time in whole intervals."""
    coefficients = []
    for k, power in enumerate(powers):
        product = power * M
        total = product + transposed(product)
        if k + 1 < len(powers):
            total = total + scaled(k + 1, powers[k + 1])
        coefficients.append(negative(total))
    return coefficients


def _bernstein(powers: Sequence[fmpq_mat]) -> list[fmpq_mat]:
    """Return the Bernstein coefficients f_l of a polynomial by its powers of s."""
    d = len(powers) - 1
    coefficients = []
    for place in range(d + 1):
        total = powers[0]
        for k in range(1, place + 1):
            total = total + scaled(fmpq(comb(place, k), comb(d, k)), powers[k])
        coefficients.append(total)
    return coefficients
