"""What a claim of kind ``no-common-decay`` says that disproves a common function."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import about
from takagi.certificates.checker.words.rounded import at_most

MOST_NAMED = 4


def said(
    name: str, loop: PolytopicLoop, alpha: Fraction, blends: Sequence[Sequence[Fraction]]
) -> tuple[str, str]:
    """Return name and sentence; ``blends`` are the weights of the rules in each."""
    listed = ", ".join(map(blend_name, blends[:MOST_NAMED]))
    more = f" and {len(blends) - MOST_NAMED} more" if len(blends) > MOST_NAMED else ""
    at_once = "falls in each sample" if loop.is_discrete else "has V' < 0"
    falls_so = f"decays at {at_most(alpha, 6)} 1/s" if alpha else f"{at_once} wherever x is not 0"
    return name, (
        f"no common quadratic function {falls_so} along {about(loop)}: "
        f"none does along {listed}{more}"
    )


def blend_name(h: Sequence[Fraction]) -> str:
    """Return a blend by its rules, with their shares where these are few."""
    used = [i for i, share in enumerate(h) if share]
    if len(used) == 1:
        return f"rule {used[0] + 1} alone"
    if len(used) > MOST_NAMED:
        return f"a blend of {len(used)} rules"
    return " + ".join(f"{h[i]} rule {i + 1}" for i in used)
