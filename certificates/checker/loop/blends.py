"""The blends on which a claim is proved: those of its loop, or of each piece of its weights."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import Blend, PolytopicLoop


def blends_of(loop: PolytopicLoop, claim: Any, where: str) -> list[Blend]:
    """Return the groups of the loop, on every piece of the weights that the claim has.

    Raises
    ------
    CertificateError : pieces that are not those of the loop's weights.
    """
    if "halvings" in claim:
        # Imported here: few claims cut their weights into pieces.
        from takagi.certificates.checker.loop.halvings import pieces

        return [blend for loop_piece in pieces(claim, loop, where) for blend in loop_piece.blends()]
    return loop.blends()
