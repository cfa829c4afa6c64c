"""The certificate file: model, law and claims as decimals, with hashes and provenance."""

from __future__ import annotations

import hashlib
import json
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.files.model_content import model_content
from takagi.certificates.checker.kernel.reader import Number, digest
from takagi.certificates.checker.replay.certificate import FORMAT, VERSION
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.laws.published.law import PublishedLaw
    from takagi.models.laws.published.regional_schedule import RegionalSchedule
    from takagi.models.splines.spline import Surface
    from takagi.models.turbine.data import Turbine

TURBINE_FIGURES = (
    *("torque_constant", "rotor_radius", "rotor_inertia", "generator_inertia", "gear_ratio"),
    *("rated_rotor_speed", "pitch_time_constant", "pitch_rate_limit", "pitch_min", "pitch_max"),
    "torque_rate_limit",
)
STRING_OR_SEAM = re.compile(r'"(?:[^"\\]|\\.)*"|\},\{')


def certificate_document(
    *,
    model: Mapping[str, Any],
    gains: Mapping[str, Any] | None,
    claims: Sequence[Mapping[str, Any]],
    provenance: Mapping[str, Any],
    files: Sequence[Path] = (),
) -> dict[str, Any]:
    """Return the whole certificate; its hashes are those of its own parts.

    ``files`` : of the model; the provenance records the SHA-256 of their bytes. No verdict depends
    on it.
    """
    if files:
        provenance = {**provenance, "files_sha256": files_sha256(files)}
    members = {"model": dict(model), "gains": gains, "claims": list(claims)}
    read_back = {key: as_read(value) for key, value in members.items()}
    hashes = {key: digest(value) for key, value in read_back.items()}
    return {
        "format": FORMAT,
        "version": VERSION,
        **members,
        "provenance": {**provenance, "sha256": hashes},
    }


def as_read(value: Any) -> Any:
    """Return the value as the strict reader reads it: numbers as their text."""
    return json.loads(json.dumps(value), parse_float=Number, parse_int=Number)


def dumps(document: Mapping[str, Any]) -> str:
    """Return the file's text: one line per cell or row, so that differences are readable."""
    written = json.dumps(document, allow_nan=False, separators=(",", ":"))
    # Strings are matched first, so that no line break is put into a text that contains "},{".
    return STRING_OR_SEAM.sub(lambda m: "},\n{" if m[0] == "},{" else m[0], written) + "\n"


def files_sha256(files: Sequence[Path]) -> dict[str, str]:
    """Return SHA-256 by name: the model's file, then its tables in its folder or below."""
    folder = files[0].parent
    return {
        file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in files
    }


def content_of(files: Sequence[Path]) -> dict[str, Any]:
    """Return the member with the content of the model's file; {} if there is none."""
    return {"model_file": model_content(files[0])} if files else {}


def turbine_data(turbine: Turbine, files: Sequence[Path]) -> dict[str, Any]:
    """Return the plant's numbers as the certificate states them.

    ``files`` : the data files of the plant; their content is recorded (``model_content``).
    """
    return {
        "kind": "turbine",
        "name": turbine.name,
        "units": "SI, angles in rad, generator inertia on the high-speed shaft",
        **{name: float(getattr(turbine, name)) for name in TURBINE_FIGURES},
        "torque_surface": _surface(turbine.torque),
        **content_of(files),
    }


def _surface(surface: Surface) -> dict[str, Any]:
    return {
        "formula": "c_Q(lambda, beta) = sum_ij c_ij N_i(lambda) N_j(beta), cubic B-splines",
        "tip_speed_ratio_knots": surface.x_knots.tolist(),
        "pitch_knots": surface.y_knots.tolist(),
        "coefficients": surface.coefficients.tolist(),
    }


def effort_sharing_law_data(law: EffortSharingLaw) -> dict[str, Any]:
    """Return the law as plain data, the same in gain file and certificate."""
    columns = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
    limits = ("rated_torque", "effort_torque", "pitch_min", "pitch_max", "wind_filter")
    setpoints = {}
    if (inputs := law.setpoints) is not None:
        setpoints["setpoints"] = {
            "lowest_speed": inputs.lowest_speed,
            "lowest_torque": inputs.lowest_torque,
            "power_per_torque": inputs.power_per_torque,
            "speed_effort": inputs.speed_effort.tolist(),
        }
    return {
        "name": law.name,
        **{name: getattr(law.schedule, name).tolist() for name in columns},
        "overlap": law.schedule.overlap,
        "proportional": law.gains.proportional.tolist(),
        "integral_rate": law.gains.integral_rate.tolist(),
        **{name: getattr(law, name) for name in (*limits, "integral_limit")},
        **setpoints,
    }


LIBRARIES = ("takagi", "numpy", "scipy", "sympy", "clarabel", "python-flint")


def published_law_data(law: PublishedLaw) -> dict[str, Any]:
    """Return the law as plain data, the same in gain file and certificate.

    ``partial`` and ``full`` hold the trim table that the premises refer to, the premises' bounds,
    the rules as corners of the premises, and the gains per rule with the published signs.
    """
    from takagi.models.turbine.trim import TABLE_SHARE, optimal_tip_speed_ratio

    turbine, coupling = law.turbine, law.coupling
    data: dict[str, Any] = {
        "name": law.name,
        "states": 3,
        "speed_setpoint": law.speed_setpoint,
        "minimum_rotor_speed": turbine.minimum_rotor_speed,
        "optimal_tip_speed_ratio": optimal_tip_speed_ratio(turbine),
        "largest_tip_speed_ratio": TABLE_SHARE * turbine.torque.x_range[1],
        "cut_in": turbine.cut_in,
        "cut_out": turbine.cut_out,
        "rated_torque": coupling.rated_torque,
        "pitch_min": turbine.pitch_min,
        "pitch_max": turbine.pitch_max,
        "coupling": {
            "variant": coupling.variant,
            "speed_ramp_start": coupling.speed_ramp.start,
            "speed_overlap": coupling.speed_ramp.width,
            "speed_ramp_shape": coupling.speed_ramp.shape,
            "torque_overlap": coupling.torque_overlap,
            "minimum_torque": coupling.minimum_torque,
            "top_torque": coupling.top_torque,
        },
        "partial": _region(law, law.partial),
        "full": _region(law, law.full),
    }
    return data


def _region(law: PublishedLaw, schedule: RegionalSchedule) -> dict[str, Any]:
    from takagi.models.laws.published.law import schedule_band

    band, model = schedule_band(law, schedule), schedule.model
    return {
        "wind": band.wind.tolist(),
        "rotor_speed": band.rotor_speed.tolist(),
        "pitch": band.pitch.tolist(),
        "premises": {p.name: [float(p.lower), float(p.upper)] for p in model.premises},
        "rules": [list(rule) for rule in model.rules],
        "k_speed": schedule.k_x[:, 0].tolist(),
        "k_pitch": schedule.k_x[:, 1].tolist(),
        "k_integral": schedule.k_I.tolist(),
    }


def provenance(settings: object, solver_words: Mapping[str, str]) -> dict[str, Any]:
    """Return configuration, versions and the solver's messages as plain data.

    No time stamp: the same inputs give the same file.
    """
    return {
        "configuration": plain(settings),
        "solver": dict(solver_words),
        "versions": {"python": platform.python_version(), **dict(_versions())},
    }


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    """Return (library, version); read once, since each is a file to be parsed."""
    return tuple((name, _version(name)) for name in LIBRARIES)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        # A source tree that is imported without installation has no metadata.
        return "not installed"


def plain(value: object) -> Any:
    """Return dataclasses, intervals and rationals as JSON values."""
    if isinstance(value, Interval):
        return [float(value.lower), float(value.upper)]
    if isinstance(value, Fraction):
        return float(value)
    if is_dataclass(value) and not isinstance(value, type):
        return {member.name: plain(getattr(value, member.name)) for member in fields(value)}
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value
