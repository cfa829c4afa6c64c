"""The sentence of a proved claim of kind ``observed-loop``."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.observer_law import states_at_start
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.deviations import deviations
from takagi.certificates.checker.words.ellipsoid_size import LARGEST, square_root_below
from takagi.certificates.checker.words.rounded import at_least, exactly
from takagi.certificates.checker.words.sentences.decay import falling
from takagi.certificates.checker.words.validity import granted, undisturbed


def said(
    name: str,
    family: PolytopicLoop,
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
    law = family.observer
    assert law is not None  # the kind asks for it
    first, weights = "x", "weights of the plant, which its measured outputs tell"
    if family.scheduled_by is None and family.rules > 1:
        weights = "weights of the plant, which it is assumed to know"
    if law.at_estimate:
        first, weights = "xhat", "weights at the estimate"
    boxed = any(side is not None for side in family.box) or bool(family.other_box)
    held = granted(family, disturbances_too=False)
    shown = ", ".join(exactly(one) for one in limits)
    most = f", with |u_k| <= {shown}" if limits else ""
    lies = f", in which x{' and xhat stay' if law.at_estimate else ' stays'} in the model's box"
    return name, (
        f"V = z'Pz with z = ({first}, x - xhat), for u = -K xhat of an observer with {weights}, "
        f"{falling(alpha)}{undisturbed(family)}; {{V <= {exactly(level)}}} is never left"
        f"{lies + held if boxed else ''}{most}; exact outputs, no time for computing"
        f"{_starts(family, P, level)}{deviations(family, 'xu')}"
    )


def starts(family: PolytopicLoop) -> Matrix:
    """Return N of z = N x for an estimate that starts at the measured states, elsewhere at rest."""
    law, n = family.observer, family.order
    assert law is not None  # the kind asks for it
    seen = states_at_start(family.C, family.D, n)
    first = Matrix([[int(seen[i] and i == j) for j in range(n)] for i in range(n)])
    one = Matrix.identity(n)
    return Matrix.blocks([[first if law.at_estimate else one], [one - first]])


def _starts(family: PolytopicLoop, P: Matrix, level: Fraction) -> str:
    """Return how far each state alone may start off rest."""
    if family.order > LARGEST:
        return ""
    N = starts(family)
    S = N.T @ P @ N
    reach = ", ".join(
        f"{at_least(square_root_below(level / S[k, k]), 4)} in {name}"
        for k, name in enumerate(family.states)
    )
    seen = any(states_at_start(family.C, family.D, family.order))
    how = "at the measured states and else at rest" if seen else "at rest"
    return f"; where the estimate starts {how}, a state alone may start up to {reach}"
