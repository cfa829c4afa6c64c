"""What a verdict takes for granted about the model's box and its disturbance, in words."""

from __future__ import annotations

from takagi.certificates.checker.kernel.family import Family

__all__ = ["granted", "undisturbed", "while_valid"]


def granted(family: Family, *, disturbances_too: bool = True) -> str:
    """Return which ranges of the box nothing shows to be kept; empty for none."""
    known = set(family.inputs)
    if not disturbances_too:
        # Imported here: no kind that grants everything needs it.
        from takagi.certificates.checker.kinds.box_of_validity import pushing

        known |= pushing(family)
    names = [name for name in family.other_box or {} if name not in known]
    return f", while {', '.join(names)} {_stay(len(names))} in the model's box" if names else ""


def while_valid(family: Family) -> str:
    """Return that the model is its plant on a box alone; empty where there is no box.

    That matrices alone contain a plant is shown by no claim: of them it is an assumption.
    """
    bounded = any(side is not None for side in family.box) or family.other_box
    plant = "a plant that the model contains" if family.scheduled_by is None else "its plant"
    return f"; of {plant}, as long as that stays in the model's box" if bounded else ""


def undisturbed(family: Family) -> str:
    """Return that the model's disturbance is taken to be zero; empty without one."""
    return " without disturbance" if family.E else ""


def _stay(count: int) -> str:
    return "stays" if count == 1 else "stay"
