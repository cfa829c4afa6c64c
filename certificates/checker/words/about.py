"""What a proof for every blend of a loop is about, in words."""

from __future__ import annotations

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def about(family: PolytopicLoop) -> str:
    """Return e.g. ``every blend of 4 rules with their gains``."""
    if not family.K:
        several = family.rules > 1
        return f"every blend of the {family.rules} vertices" if several else "the loop"
    law = "with their gains" if family.shared_weights else f"and any of {len(family.K)} gains"
    return f"every blend of {family.rules} rules {law}"
