"""Existing gains of a turbine: the law of a gain file, to run unchanged or to certify."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.reader import member, number, numbers, read_json, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.checker.turbine.running_loop.inputs import STATED
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_UNCERTAINTY,
    effort_sharing_candidate,
    failing_winds,
)
from takagi.certificates.claims.turbine.loop_claims import loop_document
from takagi.certificates.controller.content import plain, read_gain_file
from takagi.certificates.design.design import Tell
from takagi.certificates.design.turbine.effort_sharing_gains import widened
from takagi.certificates.design.turbine.scale import scaled_box
from takagi.certificates.document.certificate_file import published_law_data
from takagi.certificates.document.model_data import as_read
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import (
    EffortGains,
    EffortSharingLaw,
    LoopUncertainty,
    SetpointInputs,
)
from takagi.models.laws.effort_sharing.schedule import EffortSchedule, frozen_wake_effectiveness
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.laws.published.regional_schedule import CouplingFilter
from takagi.models.ramps import Ramp
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated

if TYPE_CHECKING:
    from takagi.models.laws.published.regional_schedule import RegionalSchedule


def read_law(path: Path) -> Mapping[str, Any]:
    """Return the ``law`` of a gain file, its numbers as they are written.

    Raises
    ------
    CertificateError : unreadable, of a later version, or without a law.
    """
    law = member(read_gain_file(path), "law", str(path))
    if not isinstance(law, Mapping):
        raise CertificateError(f"{path}: 'law' must be an object, as in a gain file of takagi")
    return law


def read_observer(path: Path) -> dict[str, Any]:
    """Return the members ``observer`` and ``measurement`` of a gain file, where it has them.

    Raises
    ------
    CertificateError : unreadable, or not strict JSON.
    """
    file = read_json(path)
    return {key: plain(file[key]) for key in STATED if file.get(key) is not None}


def effort_sharing_law_from_data(
    data: Mapping[str, Any], *, source: str = "gains"
) -> EffortSharingLaw:
    """Return the law that ``effort_sharing_law_data`` wrote.

    Parameters
    ----------
    data : the law as ``read_law`` returns it.
    source : its name in messages.

    Raises
    ------
    CertificateError : another law, or a member that is missing or not a number.
    ModelError : tables that do not make a law.
    """
    name = text(data, "name", source)
    if name != "coherent":
        raise CertificateError(
            f"{source}.name: {name!r} was given; a gain file is certified for the "
            "effort-sharing law ('coherent'), Schulte's law by designing it anew, without --gains"
        )
    unknown = sorted(set(data) - {"name", "setpoints", *_SINGLE, *(key for key, _ in _ROWS)})
    if unknown:
        raise CertificateError(
            f"{source} has members that this law does not have: {', '.join(unknown)}. Earlier "
            "versions fed the wind's rate forward by some of them; write the file again with "
            "`takagi design`"
        )
    nodes = len(numbers(data, "wind", source))
    row = {
        key: [float(value) for value in numbers(data, key, source, nodes - less)]
        for key, less in _ROWS
    }
    single: dict[str, Any] = {key: float(number(data, key, source)) for key in _SINGLE}
    schedule = EffortSchedule(**_part(row, _SCHEDULE), overlap=single.pop("overlap"))
    if "setpoints" in data:
        single["setpoints"] = _setpoint_inputs(data["setpoints"], f"{source}.setpoints", nodes)
    return EffortSharingLaw(schedule, EffortGains(**_part(row, _GAINS)), **single)


def _setpoint_inputs(stated: Any, where: str, nodes: int) -> SetpointInputs:
    names = ("lowest_speed", "lowest_torque", "power_per_torque")
    speed, torque, factor = (float(number(stated, name, where)) for name in names)
    column = [float(value) for value in numbers(stated, "speed_effort", where, nodes)]
    return SetpointInputs(speed, torque, factor, np.array(column))


_SCHEDULE = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
_GAINS = ("proportional", "integral_rate")
# How many entries a row has fewer than there are wind nodes: 1 for values per cell.
_ROWS = tuple((key, int(key == "integral_rate")) for key in (*_SCHEDULE, *_GAINS))
_SINGLE = (
    "overlap",
    "rated_torque",
    "effort_torque",
    "pitch_min",
    "pitch_max",
    "wind_filter",
    "integral_limit",
)


def _part(rows: Mapping[str, list[float]], keys: Sequence[str]) -> dict[str, Any]:
    return {key: rows[key] for key in keys}


# The last decimal that the table is written with.
WAKE_DECIMAL = 1e-6


def _require_the_turbines_wake(turbine: Turbine, schedule: EffortSchedule) -> None:
    """Refuse a frozen-wake table that is not the turbine's, because the claim would use it."""
    pairs = zip(schedule.wind.tolist(), schedule.effectiveness_limit.tolist(), strict=True)
    for wind, stated in pairs:
        effectiveness = frozen_wake_effectiveness(turbine, wind)
        if abs(stated - effectiveness) > WAKE_DECIMAL:
            raise ModelError(
                f"effectiveness_limit is {stated:.7g} rad/s^2 per rad at {wind:.6g} m/s; a claim "
                f"with the frozen wake of {turbine.name} needs {effectiveness:.7g} there, from the "
                "turbine's own file. Take the table as 'takagi design' wrote it, or leave the "
                "frozen wake out of the claim (--equilibrium-wake)"
            )


def certify_law(
    turbine: Turbine,
    law: EffortSharingLaw,
    *,
    uncertainty: LoopUncertainty = DEFAULT_UNCERTAINTY,
    files: Sequence[Path] = (),
    controller: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
) -> tuple[dict[str, Any], Checked]:
    """Return the certificate of a given law on a turbine, and the checker's verdict.

    Parameters
    ----------
    files : the turbine's data files; the certificate records their SHA-256.
    controller : the gain file's observer and filters, for the claim about the loop with them; None
        makes no such claim.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : no common quadratic function was found, or the box leaves what is enclosed; names
        the condition and what to relax.  Or the law's table of the frozen wake is not the
        turbine's, although that wake is to be covered; names the wind.
    """
    if uncertainty.frozen_wake:
        _require_the_turbines_wake(turbine, law.schedule)
    box = scaled_box(turbine)
    candidate = effort_sharing_candidate(turbine, law, box=box, uncertainty=uncertainty, tell=tell)
    if candidate.P is None:
        raise ModelError(
            f"no common quadratic function; {failing_winds(candidate.cells)}. Reduce the "
            "uncertainty, or change the gains there"
        )
    candidate = widened(turbine, law, candidate, tell=tell)
    if tell is not None:
        tell("exact proof")
    settings = {"law": law.name, "box": box, "uncertainty": uncertainty}
    document = loop_document(
        turbine, law, candidate, settings, files=files, controller=controller, tell=tell
    )
    return document, check_document(document)


FORMAT, VERSIONS = "takagi-gains", (1, 2, 3)
EFFORT_SHARING, PUBLISHED = "coherent", "paper"


def law_from_gains(path: Path, turbine: Turbine | None = None) -> EffortSharingLaw | PublishedLaw:
    """Return the law of a gain file of a wind turbine.

    Parameters
    ----------
    path : ``gains.json``, version 1 to 3; a law that fed the wind's rate forward is refused.
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
    if name not in (EFFORT_SHARING, PUBLISHED):
        raise CertificateError(
            f"{path}: the law is {name!r}, not a wind turbine's; give the gains.json of a "
            "turbine's design"
        )
    if name == EFFORT_SHARING:
        return effort_sharing_law_from_data(data, source=f"{path}: law")
    if turbine is None:
        raise ModelError(
            f"{path}: law {name!r} computes its premises from a turbine's coefficient table; give "
            "the turbine too, law_from_gains(path, load_turbine(...))"
        )
    return _published_law(turbine, data, path)


def _require_format(document: Any, path: Path) -> None:
    is_gain_file = isinstance(document, Mapping) and document.get("format") == FORMAT
    if not is_gain_file:
        raise CertificateError(
            f"{path}: not a gain file of a turbine: its 'format' must be {FORMAT!r}"
        )
    version = document.get("version")
    if str(version) not in map(str, VERSIONS):
        raise CertificateError(
            f"{path}: gain file of version {version}; versions 1 to 3 are read here: write it "
            "again with `takagi design`"
        )


def _published_law(turbine: Turbine, data: Any, path: Path) -> PublishedLaw:
    where = f"{path}: law"
    setpoint = float(number(data, "speed_setpoint", where))
    other_setpoint = None if setpoint == turbine.rated_rotor_speed else setpoint
    torque = float(number(data, "rated_torque", where))
    derated_turbine = derated(turbine, torque, speed_setpoint=other_setpoint)
    partial, full = _schedules(derated_turbine, other_setpoint, data, where)
    law = PublishedLaw(derated_turbine, _coupling(data, where), partial, full, setpoint)
    _require_same(published_law_data(law), data, path)
    return law


def _coupling(data: Any, where: str) -> CouplingFilter:
    stated, location = member(data, "coupling", where), f"{where}.coupling"
    values = {
        key: float(number(stated, key, location))
        for key in (
            "speed_ramp_start",
            "speed_overlap",
            "torque_overlap",
            "minimum_torque",
            "top_torque",
        )
    }
    ramp = Ramp(
        values["speed_ramp_start"],
        values["speed_overlap"],
        text(stated, "speed_ramp_shape", location),  # type: ignore[arg-type]
    )
    return CouplingFilter(
        ramp,
        text(stated, "variant", location),  # type: ignore[arg-type]
        float(number(data, "rated_torque", where)),
        values["torque_overlap"],
        values["minimum_torque"],
        values["top_torque"],
    )


def _schedules(
    turbine: Turbine, setpoint: float | None, data: Any, where: str
) -> list[RegionalSchedule]:
    """Return the regional schedules: the turbine's models, the file's gains."""
    from takagi.models.laws.published.regional_schedule import regional_schedule
    from takagi.models.turbine.region_models import full_load_model, partial_load_model

    models = {
        "partial": partial_load_model(turbine, speed_setpoint=setpoint),
        "full": full_load_model(turbine, speed_setpoint=setpoint),
    }
    schedules = []
    for key, model in models.items():
        stated, location = member(data, key, where), f"{where}.{key}"
        count = len(model.rules)
        columns = [
            [float(value) for value in numbers(stated, kind, location, count)]
            for kind in ("k_speed", "k_pitch", "k_integral")
        ]
        schedules.append(
            regional_schedule(
                turbine,
                model,
                k_x=np.array(columns[:2]).T,
                k_I=np.array(columns[2]),
                speed_setpoint=setpoint,
            )
        )
    return schedules


def _require_same(law: Mapping[str, Any], stated: Any, path: Path) -> None:
    """Refuse a file whose tables are another turbine's, or another version's."""
    from takagi.certificates.checker.files.differences import differences_between, shown

    read = as_read({"law": law}, "law")["law"]
    for difference in differences_between(read, stated):
        expected, there = shown(difference)
        raise CertificateError(
            f"{path}: the law was not made for this turbine: {difference.place} is {expected} for "
            f"it, {there} in the file; give the turbine of the design"
        )
