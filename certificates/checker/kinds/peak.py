r"""``peak``: |y| <= gamma b at all times, from rest, for every disturbance with |w|_2 <= b.

The conditions are an invariant set of ``invariant_set`` for |w|_2 <= b (the Euclidean norm at each
instant), and, for y = C x + D w of every blend with a share 0 <= t <= 1,

    gamma^2 b^2 [ (1 - t) P / c   0         ]
                [ 0               t I / b^2 ]  -  [C D]'[C D]  >= 0,

Then |y|^2 <= gamma^2 b^2 ((1 - t) V / c + t |w|^2 / b^2) <= gamma^2 b^2 on the set.  Where D = 0
the second block is left out, and t = 0 is best.  From rest V starts at 0, inside the set.

Evidence: that of ``invariant_set`` with ``disturbance_norm`` = b; ``gain`` = gamma;
``share`` = t (0 when left out); the channel of ``disturbance_channel``.

Source: Abedor, Nagpal, Poolla (1996); Scherer, Gahinet, Chilali (1997).
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.disturbance_channel import (
    DisturbanceChannel,
    disturbance_channels,
    scaled_identity,
    zero,
)
from takagi.certificates.checker.kinds.invariant_set import InvariantSet, read_invariant_set
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_peak(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with the module's evidence."""
    name = text(claim, "name", where)
    held = read_invariant_set(claim, loop, where)
    if held.bounds is None or not held.is_ball or held.bounds[0] == 0:
        raise CertificateError(f"{where}.disturbance_norm: a positive bound on |w|_2 is needed")
    gain = number(claim, "gain", where)
    share = number(claim, "share", where) if "share" in claim else Fraction(0)
    if gain <= 0 or not 0 <= share <= 1:
        raise CertificateError(f"{where}: gain > 0 and 0 <= share <= 1 are needed")
    why = held.why_not(loop)
    if why:
        return Claim(name, Verdict.UNDECIDED, why)
    for path in disturbance_channels(claim, loop, where):
        if not _left(path, held, gain, share).is_positive_semidefinite:
            return Claim(name, Verdict.UNDECIDED, f"the output exceeds its bound at {path.label}")
    said = {"name": name, "claim": claim, "loop": loop, "held": held, "gain": gain}
    return Found(Verdict.PROVED, "peak", said | {"bound": held.bounds[0]})


def _left(path: DisturbanceChannel, held: InvariantSet, gain: Fraction, share: Fraction) -> Matrix:
    assert held.bounds is not None
    bound, C = held.bounds[0], path.C
    left = gain**2 * bound**2 * (1 - share) / held.level * held.P - C.T @ C
    if path.D is None or not any(any(row) for row in path.D.rows):
        return left
    D = path.D
    rest = scaled_identity(D.shape[1], gain**2 * share) - D.T @ D
    side = zero(C.shape[1], D.shape[1]) - C.T @ D
    return Matrix.blocks([[left, side], [side.T, rest]])
