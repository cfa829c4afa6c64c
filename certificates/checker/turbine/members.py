"""Members that no checker reads: a claim about a turbine's loop that has one is refused.

A checker reads members by their names.  A further one would be passed over: an uncertainty that no
condition has, or a filter of another form, would stand in a claim that is PROVED.  Every kind lists
its members, and the ``inputs`` of the two laws those of the laws.  Here are those of turbine and
observer.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any, TypeAlias

from takagi.certificates.checker.kernel.refusal import CertificateError

# By name, what an object may have: nothing where the member is no object, None for any names.
Members: TypeAlias = "Mapping[str, Members | None]"


def plain(names: str) -> dict[str, Members | None]:
    """Return members that are no objects."""
    return {name: {} for name in names.split()}


# What takagi writes of a turbine.  ``name`` and ``formula`` are words for the reader; the contents
# and hashes of the model's files are compared with the files.
MODEL: Members = {
    **plain(
        "kind name units torque_constant rotor_radius rotor_inertia generator_inertia gear_ratio "
        "rated_rotor_speed pitch_time_constant pitch_rate_limit pitch_min pitch_max "
        "torque_rate_limit"
    ),
    "torque_surface": plain("formula tip_speed_ratio_knots pitch_knots coefficients"),
    "model_file": None,
    "files_sha256": None,
}
UNITS = "SI, angles in rad, generator inertia on the high-speed shaft"
# ``decay_rate`` is that of the observer's design, and ``equations`` are words.
OBSERVER = plain("l1 l2 wind_limits decay_rate equations")


def refuse_unread(members: Mapping[str, Members | None], claim: Any, data: Any, where: str) -> None:
    """Refuse a claim, a turbine, a law or an observer with a further member, and other units.

    Parameters
    ----------
    members : what claims of this kind have.
    data : the whole file; the claim has been read, so that it has a turbine and a turbine's law.
    """
    refuse_further(members, claim, where)
    _refuse(data["model"], MODEL, "model")
    if data["model"].get("units", UNITS) != UNITS:
        raise CertificateError(f"model.units: {UNITS!r} is needed")
    room = "effort_sharing" if data["gains"]["name"] == "coherent" else "published"
    # Imported here: only one of the two laws is needed.
    law = import_module(f"takagi.certificates.checker.turbine.{room}.inputs").MEMBERS
    _refuse(data["gains"], law, "gains")
    controller = data.get("controller")
    if isinstance(controller, dict):
        _refuse(controller.get("observer"), OBSERVER, "controller.observer")


def refuse_further(members: Mapping[str, Members | None], claim: Any, where: str) -> None:
    """Refuse a claim that has, or whose objects have, a further member."""
    _refuse(claim, {**plain("kind name"), **members}, where)


def _refuse(stated: Any, known: Members, where: str) -> None:
    if isinstance(stated, list):
        for i, one in enumerate(stated):
            _refuse(one, known, f"{where}[{i}]")
    elif isinstance(stated, dict):
        for name in sorted(stated):
            if name not in known:
                raise CertificateError(f"{where}: {name!a:.60} is not known; leave it out")
            if (inner := known[name]) is not None:
                _refuse(stated[name], inner, f"{where}.{name}")
