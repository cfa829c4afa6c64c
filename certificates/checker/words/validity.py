"""The assumptions of a verdict about the model's box and its disturbance, in words."""

from __future__ import annotations

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def granted(loop: PolytopicLoop, *, disturbances_too: bool = True) -> str:
    """Return the ranges of the box that are assumed and not proved; empty for none."""
    known = set(loop.inputs)
    if not disturbances_too:
        # Imported here: a kind that assumes all ranges does not need it.
        from takagi.certificates.checker.loop.box_of_validity import pushing

        known |= pushing(loop)
    names = [name for name in loop.other_box or {} if name not in known]
    return f", while {', '.join(names)} {_stay(len(names))} in the model's box" if names else ""


def while_valid(loop: PolytopicLoop) -> str:
    """Return the statement that the model equals its plant only on a box; empty without a box.

    For matrices alone no claim proves that they contain a plant, so this is an assumption.
    """
    bounded = any(side is not None for side in loop.box) or loop.other_box
    plant = "a plant that the model contains" if loop.scheduled_by is None else "its plant"
    return f"; of {plant}, as long as that stays in the model's box" if bounded else ""


def undisturbed(loop: PolytopicLoop) -> str:
    """Return the assumption that the model's disturbance is zero; empty without one."""
    return " without disturbance" if loop.E else ""


def _stay(count: int) -> str:
    return "stays" if count == 1 else "stay"
