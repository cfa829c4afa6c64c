"""The sentence of a proved claim of kind ``observed-loop``."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.observer_law import states_at_start
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.ellipsoid_size import LARGEST, square_root_below
from takagi.certificates.checker.words.loop_words import deviations, granted, undisturbed
from takagi.certificates.checker.words.rounded import at_least, exactly
from takagi.certificates.checker.words.sentences.decay import falling


def said(
    name: str,
    loop: PolytopicLoop,
    P: Matrix,
    level: Fraction,
    alpha: Fraction,
    limits: Sequence[Fraction],
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    P : of V = z'Pz, twice the order of the plant.
    limits : the claim's bounds on |u_k|; empty if there are none.
    """
    law = loop.observer
    assert law is not None  # the kind asks for it
    first, weights = "x", "weights of the plant, which its measured outputs tell"
    if loop.scheduled_by is None and loop.rules > 1:
        weights = "weights of the plant, which it is assumed to know"
    if law.at_estimate:
        first, weights = "xhat", "weights at the estimate"
    boxed = any(side is not None for side in loop.box) or bool(loop.other_box)
    held = granted(loop, disturbances_too=False)
    shown = ", ".join(exactly(one) for one in limits)
    most = f", with |u_k| <= {shown}" if limits else ""
    lies = f", in which x{' and xhat stay' if law.at_estimate else ' stays'} in the model's box"
    return name, (
        f"V = z'Pz with z = ({first}, x - xhat), for u = -K xhat of an observer with {weights}, "
        f"{falling(alpha)}{undisturbed(loop)}; {{V <= {exactly(level)}}} is never left"
        f"{lies + held if boxed else ''}{most}; exact outputs, no time for computing"
        f"{_starts(loop, P, level)}{deviations(loop, 'xu')}"
    )


def starts(loop: PolytopicLoop) -> Matrix:
    """Return N of z = N x for an estimate that starts at the measured states, elsewhere at rest."""
    law, n = loop.observer, loop.order
    assert law is not None  # the kind asks for it
    seen = states_at_start(loop.C, loop.D, n)
    first = Matrix([[int(seen[i] and i == j) for j in range(n)] for i in range(n)])
    one = Matrix.identity(n)
    return Matrix.blocks([[first if law.at_estimate else one], [one - first]])


def _starts(loop: PolytopicLoop, P: Matrix, level: Fraction) -> str:
    """Return how far each state alone may start off rest."""
    if loop.order > LARGEST:
        return ""
    N = starts(loop)
    S = N.T @ P @ N
    reach = ", ".join(
        f"{at_least(square_root_below(level / S[k, k]), 4)} in {name}"
        for k, name in enumerate(loop.states)
    )
    seen = any(states_at_start(loop.C, loop.D, loop.order))
    how = "at the measured states and else at rest" if seen else "at rest"
    return f"; where the estimate starts {how}, a state alone may start up to {reach}"
