"""What a proof for every blend of a loop is about, in words."""

from __future__ import annotations

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def about(loop: PolytopicLoop) -> str:
    """Return e.g. ``every blend of 4 rules with their gains``."""
    if not loop.K:
        several = loop.rules > 1
        return f"every blend of the {loop.rules} vertices" if several else "the loop"
    law = "with their gains" if loop.shared_weights else f"and any of {len(loop.K)} gains"
    return f"every blend of {loop.rules} rules {law}"
