"""What a proved claim of kind ``invariant-ellipsoid`` says."""

from __future__ import annotations

from takagi.certificates.checker.kinds.invariant_set import InvariantSet
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.ellipsoid_size import rounded_size
from takagi.certificates.checker.words.invariant_set import (
    letters,
    motion,
    rounded_level,
    where_valid,
)
from takagi.certificates.checker.words.loop_words import about, deviations


def said(name: str, loop: PolytopicLoop, held: InvariantSet) -> tuple[str, str]:
    """Return name and sentence."""
    return name, (
        f"{{x'Px <= {rounded_level(held)}}} is invariant{where_valid(loop)}, along "
        f"{about(loop)}; {motion(held, loop)}"
        f"{rounded_size(held.P, held.level, loop.states)}"
        f"{deviations(loop, 'x' + letters(held))}"
    )
