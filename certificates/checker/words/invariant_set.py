"""Texts about an invariant ellipsoid: its level, the motion of V, its location."""

from __future__ import annotations

from takagi.certificates.checker.kinds.invariant_set import InvariantSet
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import granted
from takagi.certificates.checker.words.rounded import at_least, exactly


def motion(held: InvariantSet, loop: PolytopicLoop) -> str:
    """Return how V moves outside the set, and for which disturbances."""
    unit = "(1 - {})^k" if loop.is_discrete else "exp(-{} t)"
    speed = unit.format(at_least(held.multiplier, 6))
    if held.bounds is None:
        undisturbed = " without disturbance" if loop.E else ""
        return f"from inside V = x'Px falls as {speed}{undisturbed}"
    alone = ", without the model's disturbance," if loop.E else ""
    what = "the model's disturbance" if held.way == "disturbances" else f"w added to u{alone}"
    shown = [at_least(b, 6) for b in held.bounds]
    size = f"|w|_2 <= {shown[0]}" if held.is_ball else f"|w_k| <= {', '.join(shown)}"
    outside = "from outside, but within the box," if _boxed(loop) else "from outside"
    return f"for {what} with {size}; {outside} V - level falls as {speed}"


def where_valid(loop: PolytopicLoop) -> str:
    """Return where the set lies, and the assumptions."""
    held = granted(loop, disturbances_too=False)
    return f" and lies in the model's box{held}" if _boxed(loop) else ""


def rounded_level(held: InvariantSet) -> str:
    """Return the level: a larger or smaller set need be neither in the box nor invariant."""
    return exactly(held.level)


def letters(held: InvariantSet) -> str:
    """Return ``w`` where that is the model's own disturbance; one added to u is no deviation."""
    return "w" if held.way == "disturbances" else ""


def _boxed(loop: PolytopicLoop) -> bool:
    return any(side is not None for side in loop.box) or bool(loop.other_box)
