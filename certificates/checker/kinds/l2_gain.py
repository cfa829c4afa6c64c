r"""``l2-gain``: the energy of y is at most gamma^2 times that of w, from rest, along every blend.

Let V = x'Px with P > 0, gamma > 0, and V' (or V(x+) - V) = -x'Fx + 2 x'Gw + w'Hw.  The condition
for every blend is

    [ F - C'C / gamma    -G - C'D / gamma             ]
    [ .                  gamma I - H - D'D / gamma    ]  > 0,

that is, V' < gamma |w|^2 - |y|^2 / gamma for (x, w) != 0.  The left-hand side is concave in
(A, B, C, D), so that the condition holds along the loop, however fast the weights change.  The
integral over time gives |y|_2 <= gamma |w|_2 from x(0) = 0, and V(x(t)) <= gamma |w|_2^2.

With ``energy_bound`` W the claim also states that {V <= gamma W^2} lies in the model's box: for
|w|_2 <= W the state never leaves the box.  Without it the claim is about the vertices; for a plant
it holds as long as the state stays in the model's box.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2 (bounded real lemma).
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.disturbance_channel import (
    disturbance_channels,
    quadratic_change,
    scaled_identity,
)
from takagi.certificates.checker.loop.box_of_validity import bounded_inputs, outside_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_l2_gain(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with ``P``, ``gain`` and a ``disturbance_channel``."""
    name = text(claim, "name", where)
    gain, n = number(claim, "gain", where), loop.order
    P = read_matrix(claim, "P", where, (n, n))
    if gain <= 0:
        raise CertificateError(f"{where}.gain: a positive number is needed")
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    for path in disturbance_channels(claim, loop, where):
        F, G, H = quadratic_change(path.A, path.B, P, discrete=loop.is_discrete)
        C, D = path.C, path.through
        side = -(G + 1 / gain * (C.T @ D))
        corner = scaled_identity(D.shape[1], gain) - H - 1 / gain * (D.T @ D)
        whole = Matrix.blocks([[F - 1 / gain * (C.T @ C), side], [side.T, corner]])
        if not whole.is_positive_definite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {path.label}")
    energy = None
    if "energy_bound" in claim:
        energy = number(claim, "energy_bound", where)
        if energy <= 0:
            raise CertificateError(f"{where}.energy_bound: a positive number is needed")
        if claim["disturbance"] == "inputs" and bounded_inputs(loop):
            return Claim(name, Verdict.UNDECIDED, "no bound of energy keeps an input in its range")
        why = outside_of(loop, P, gain * energy**2)
        if why:
            return Claim(name, Verdict.UNDECIDED, why)
    said = {"name": name, "claim": claim, "loop": loop, "gain": gain, "energy": energy}
    return Found(Verdict.PROVED, "l2_gain", said)
