r"""``box-enlargement``: the claim ``decay`` for premise ranges that are theta times as wide.

Weights that are products, h_i = prod_k w_k,c_ik with w_k1 = (z_k - lower_k)/(upper_k - lower_k),
make the loop affine in each single premise z_k.  If every range is enlarged about its middle by the
factor theta the vertices become

    A_i(theta) = sum_j prod_k s(c_ik, c_jk) A_j,   s = (1 + theta)/2 for equal corners, else
                                                   (1 - theta)/2,

and B_i(theta) likewise.  Where the model does not state that weights are products,
A_i(theta) = A_0 + theta (A_i - A_0) about the mean A_0 of all vertices.  ``decay`` is then shown
for every A_i(theta) - B_i(theta) K_j.  It holds for any blend of the gains, independently of the
premises; so it also holds for a law that keeps its weights at the ends of its own ranges.  The
vertices of every smaller theta >= 0 lie in the hull, so that the claim covers them.

Evidence: ``P``, ``decay_rate``, ``enlargement`` theta.

The claim does not say that the plant is affine in its premises outside its box.  In a sector model
only the matrices are affine, and the claim enlarges the ranges of the premises, not of the states.

Source: derived here.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, mean
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.decay import check_decay
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

Stack = tuple[Matrix, ...]


def check_box_enlargement(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED when ``decay`` is for the enlarged vertices, else UNDECIDED."""
    name = text(claim, "name", where)
    theta = number(claim, "enlargement", where)
    if theta < 0:
        return Claim(name, Verdict.UNDECIDED, "the enlargement is negative")
    if theta < 1:  # These are vertices of a part of the model: nothing is claimed about the plant.
        loop = replace(loop, box=(), other_box=None)
    wider = replace(
        loop,
        A=enlarged(loop.A, loop, theta),
        B=enlarged(loop.B, loop, theta),
        corners=None,
        shared_weights=False,
    )
    found = check_decay(claim, wider, where)
    if found.verdict is not Verdict.PROVED:
        return found
    what = "vertices moved from their mean" if loop.corners is None else "premises' ranges"
    said = {"what": what, "theta": theta, "decay": found}
    return Found(found.verdict, "box_enlargement", said)


def enlarged(stack: Stack, loop: PolytopicLoop, theta: Fraction) -> Stack:
    """Return A_i(theta), or B_i(theta), of the module's formula."""
    if len(stack) <= 1:
        return stack
    if loop.corners is None:
        middle = mean(stack)
        return tuple((middle + theta * (one - middle)).reduced() for one in stack)
    corners = loop.corners
    sizes = [len(set(column)) for column in zip(*corners, strict=True)]
    near, far = (1 + theta) / 2, (1 - theta) / 2
    values = dict(zip(corners, stack, strict=True))
    for k, size in enumerate(sizes):
        if size == 2:
            values = {
                c: (near * values[c] + far * values[(*c[:k], 1 - c[k], *c[k + 1 :])]).reduced()
                for c in corners
            }
    return tuple(values[c] for c in corners)
