"""What claims about the loop that runs state of the gain file: observer and filters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop.inputs import STATED
from takagi.models.errors import ModelError

ABSENT = {
    ("observer", "measurement"): "no observer, or no low-pass on the measured speed",
    ("measurement",): "no low-pass on the measured speed",
}


def stated_controller(
    controller: Mapping[str, Any], gains: Mapping[str, Any], *parts: str
) -> dict[str, dict[str, Any]]:
    """Return the numbers of parts of a gain file that a claim repeats.

    Parameters
    ----------
    controller : the gain file's members ``observer`` and ``measurement``; others are not used.
    gains : the law.
    parts : of ``controller``; nothing for both.

    Raises
    ------
    Refused : a part is missing, or the law has no filter of the wind estimate.
    ModelError : a part is no object.
    """
    names = parts or tuple(STATED)
    if any(part not in controller for part in names):
        raise Refused(f"the gain file has {ABSENT[names]}")
    for part in names:
        if not isinstance(controller[part], Mapping):
            raise ModelError(
                f"controller[{part!r}] is {controller[part]!r}; an object with "
                f"{', '.join(STATED[part])} is needed, as gains.json has it: give that one, or "
                "leave the member out for a law without it"
            )
    if not gains["wind_filter"] > 0:
        raise Refused("the law has no filter of the wind estimate")
    return {
        part: {name: controller[part][name] for name in STATED[part] if name in controller[part]}
        for part in names
    }
