"""The law of a gain file, to run: its commands are exactly those of the written law."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.reader import (
    Number,
    member,
    number,
    numbers,
    read_json,
    text,
)
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.claims.turbine.published import published_law_data
from takagi.certificates.design.given.turbine_law import effort_sharing_law_from_data
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.published.coupling_filter import CouplingFilter
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.ramps import Ramp
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated

if TYPE_CHECKING:
    from takagi.models.laws.published.regional_schedule import RegionalSchedule

FORMAT, VERSIONS = "takagi-gains", (1, 2, 3)
EFFORT_SHARING, PUBLISHED = "coherent", ("paper", "paper-two-integrators")
# Members that an effort-sharing law of version 1 lacked, which had no feed-forward.
SINCE_2 = ("inertia_feedforward", "feedforward_limit")


def law_from_gains(path: Path, turbine: Turbine | None = None) -> EffortSharingLaw | PublishedLaw:
    """Return the law of a gain file of a wind turbine.

    Parameters
    ----------
    path : ``gains.json``, version 1 to 3; a law of version 1 feeds nothing forward.
    turbine : the turbine of the file.  A published law needs it, because its premises are computed
        from the coefficient table at run time.  The file contains the whole effort-sharing law.

    Raises
    ------
    CertificateError : no such file, another format or version, a member missing, or a law of the
        paper whose tables are not the turbine's.
    ModelError : a published law without a turbine, or tables that do not make a law.
    """
    document = read_json(Path(path))
    _require_format(document, path)
    data = member(document, "law", str(path))
    name = text(data, "name", f"{path}: law")
    if name not in (EFFORT_SHARING, *PUBLISHED):
        raise CertificateError(
            f"{path}: the law is {name!r}, not a wind turbine's; give the gains.json of a "
            "turbine's design"
        )
    if name not in PUBLISHED:
        return effort_sharing_law_from_data(_completed(data, document), source=f"{path}: law")
    if turbine is None:
        raise ModelError(
            f"{path}: law {name!r} computes its premises from a turbine's coefficient table; give "
            "the turbine too, law_from_gains(path, load_turbine(...))"
        )
    return _published_law(turbine, name, data, path)


def _require_format(document: Any, path: Path) -> None:
    known = isinstance(document, Mapping) and document.get("format") == FORMAT
    if not known:
        raise CertificateError(
            f"{path}: not a gain file of a turbine: its 'format' must be {FORMAT!r}"
        )
    version = document.get("version")
    if str(version) not in map(str, VERSIONS):
        raise CertificateError(
            f"{path}: gain file of version {version}; versions 1 to 3 are read here: write it "
            "again with `takagi design`"
        )


def _completed(data: Any, document: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the law's data; a law of version 1 that has no feed-forward gets one of zero."""
    if str(document["version"]) != "1" or not isinstance(data, Mapping):
        return data  # type: ignore[no-any-return]
    intervals = len(numbers(data, "wind", "law")) - 1
    none = Number("0")
    return {**{key: [none] * intervals for key in SINCE_2}, "pitch_lead": none, **data}


def _published_law(turbine: Turbine, name: str, data: Any, path: Path) -> PublishedLaw:
    where = f"{path}: law"
    setpoint = float(number(data, "speed_setpoint", where))
    asked = None if setpoint == turbine.rated_rotor_speed else setpoint
    held = derated(turbine, float(number(data, "rated_torque", where)), speed_setpoint=asked)
    tracking = None if name == "paper" else float(number(data, "tracking_time", where))
    partial, full = _schedules(held, asked, data, where)
    law = PublishedLaw(
        "paper" if name == "paper" else "paper-two-integrators",
        held,
        _coupling(data, where),
        partial,
        full,
        tracking,
        setpoint,
    )
    _require_same(published_law_data(law), data, path)
    return law


def _coupling(data: Any, where: str) -> CouplingFilter:
    stated, place = member(data, "coupling", where), f"{where}.coupling"
    one = {
        key: float(number(stated, key, place))
        for key in (
            "speed_ramp_start",
            "speed_overlap",
            "torque_overlap",
            "minimum_torque",
            "top_torque",
        )
    }
    ramp = Ramp(
        one["speed_ramp_start"],
        one["speed_overlap"],
        text(stated, "speed_ramp_shape", place),  # type: ignore[arg-type]
    )
    return CouplingFilter(
        ramp,
        text(stated, "variant", place),  # type: ignore[arg-type]
        float(number(data, "rated_torque", where)),
        one["torque_overlap"],
        one["minimum_torque"],
        one["top_torque"],
    )


def _schedules(
    turbine: Turbine, setpoint: float | None, data: Any, where: str
) -> list[RegionalSchedule]:
    """Return the regional schedules: the turbine's models, the file's gains."""
    from takagi.models.laws.published.regional_schedule import regional_schedule
    from takagi.models.turbine.full_load import full_load_model
    from takagi.models.turbine.partial_load import partial_load_model

    models = {
        "partial": partial_load_model(turbine, speed_setpoint=setpoint),
        "full": full_load_model(turbine, speed_setpoint=setpoint),
    }
    found = []
    for key, model in models.items():
        stated, place = member(data, key, where), f"{where}.{key}"
        count = len(model.rules)
        columns = [
            [float(value) for value in numbers(stated, kind, place, count)]
            for kind in ("k_speed", "k_pitch", "k_integral")
        ]
        found.append(
            regional_schedule(
                turbine,
                model,
                k_x=np.array(columns[:2]).T,
                k_I=np.array(columns[2]),
                speed_setpoint=setpoint,
            )
        )
    return found


def _require_same(made: Mapping[str, Any], stated: Any, path: Path) -> None:
    """Refuse a file whose tables are another turbine's, or another version's."""
    from takagi.certificates.checker.files.differences import differences_between, shown
    from takagi.certificates.checker.kernel.reader import read_text

    read = read_text(json.dumps({"law": made}), "law")["law"]
    for one in differences_between(read, stated):
        own, there = shown(one)
        raise CertificateError(
            f"{path}: the law was not made for this turbine: {one.place} is {own} for it, {there} "
            "in the file; give the turbine of the design"
        )
