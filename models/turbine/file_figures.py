"""Figures of a turbine file, and the frozen wake from its tables.

The frozen wake from the coefficient tables, for a turbine of which nothing is published.

Momentum theory slows the wind at the rotor by the induction: u = v (1 - k_a a(c_T)).  Pitch acts
first at constant u, and the wake answers later.  The table's slopes are those with the wake in
equilibrium; the slope at constant u follows from them:

    dP/dbeta = omega (T_beta - T_v u_beta / u_v)              [W/rad]
    u_beta   = -k_a a' v c_T,beta
    u_v      = 1 - k_a a + k_a a' lambda c_T,lambda           lambda = omega R / v

at rated speed omega and the trim pitch, with the slopes T_beta, T_v of the torque at constant
pitch and speed.  k_a is the file's ``wake.induction`` or that of ``DiscWake``, and

    a(c_T) = (1 - sqrt(1 - c_T)) / 2, beyond c_T = 8/9 its tangent there.

c_T is linear between the table's entries, in tip-speed ratio and in pitch, and held at its edges;
its slopes are differences over +-1/4 and +-1/50 rad.  The winds are the multiples of 1/2 m/s above
rated wind, and cut-out.  With k_a of its file the rule meets the published column of the NREL 5-MW
turbine within 4 % from 13 m/s on, and within 10 % below.

``takagi.certificates.checker.files.turbine_file`` computes the same in exact numbers.

Source: momentum theory of the actuator disc, Burton et al. (2011), Wind Energy Handbook, ch. 3.

One figure of a turbine file: found, its unit converted, its range checked; [frozen_wake].

Every function takes the document and the path of a field, ``"section.key"``, and raises
``ModelError`` with file, line and field.

The section [frozen_wake] says what pitch does before the wake has answered, in one of two forms; a
file without it has the column of ``frozen_wake_by_tables``.  Published sensitivities, each with the
trim pitch that it belongs to:

    wind, pitch, power_sensitivity    S(v) = dP/dbeta with the induction held [W/rad]

or, where nothing is published, a factor kappa that is stated over wind:

    wind, factor                      S(v) = kappa(v) omega_rated dT_r/dbeta(omega_rated, beta*, v)

with beta* the trim pitch and dT_r/dbeta the slope of the coefficient table, which is that of the
wake in equilibrium.  kappa is at least 1: held induction makes pitch act more.  Where the slope
vanishes, as it may at rated wind, no factor helps: the column begins above, and its first entry
holds below, with the square of wind.  Pitch acts from rated wind on, so that a column may begin
at most ``LATEST_BEGIN`` above it.  ``source`` says where the columns were read, or why the factor
was chosen.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import floor, isfinite, sqrt
from typing import Any, NamedTuple

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.files.csv_table import CoefficientTable
from takagi.models.files.library import Document
from takagi.models.files.units import accepted_units, to_si
from takagi.models.turbine.data import Figure, FrozenWake, Turbine, rotor_torque_gradient
from takagi.models.turbine.trim import rated_wind, trim

WIND_STEP = 0.5
RATIO_STEP, PITCH_STEP = 0.25, 0.02
LAST_MOMENTUM = 8 / 9


def frozen_wake_by_tables(turbine: Turbine, thrust: CoefficientTable) -> FrozenWake:
    """Return the column of dP/dbeta with the induction held, by the rule of this module.

    The turbine's own frozen wake is not read; ``thrust`` is the table of c_T as its file has it.

    Raises
    ------
    ModelError : no trim, or a wind at which pitching up does not lower power by this rule.
    """
    first, last = rated_wind(turbine), turbine.cut_out
    steps = range(floor(first / WIND_STEP) + 1, floor(last / WIND_STEP) + 1)
    winds = sorted({*(WIND_STEP * step for step in steps), last})
    points = [_point(turbine, thrust, wind) for wind in winds]
    pitch, sensitivity = zip(*points, strict=True)
    source = (
        "computed from the tables by momentum theory with the induction held, k_a = "
        f"{turbine.wake.induction:g}: nothing was stated"
    )
    return FrozenWake(tuple(winds), pitch, sensitivity, source)


def _point(turbine: Turbine, thrust: CoefficientTable, wind: float) -> tuple[float, float]:
    """Return trim pitch [rad] and dP/dbeta [W/rad] at one wind."""
    speed, pitch, wake = turbine.rated_rotor_speed, trim(turbine, wind).pitch, turbine.wake
    ratio = speed * turbine.rotor_radius / wind
    _, by_pitch, by_wind = (float(s) for s in rotor_torque_gradient(turbine, speed, pitch, wind))
    a, slope = _induction(_thrust(thrust, ratio, pitch))
    loss = wake.induction * slope
    flow = 1 - wake.induction * a + loss * ratio * _slope(thrust, ratio, pitch, RATIO_STEP, 0)
    slowed = loss * wind * _slope(thrust, ratio, pitch, 0, PITCH_STEP)
    sensitivity = speed * (by_pitch + by_wind * slowed / flow) if flow > 0 else 0.0
    if sensitivity >= 0:
        raise ModelError(
            f"{turbine.name}: no frozen wake was stated, and the tables give none at {wind:.6g} "
            f"m/s (dP/dpitch {sensitivity:.4g} W/rad, 1 - k_a a {flow:.4g}; both signs must be the "
            "other): state [frozen_wake] with wind and factor, or correct c_T there"
        )
    return pitch, sensitivity


def _thrust(table: CoefficientTable, ratio: float, pitch: float) -> float:
    along = [np.interp(pitch, table.pitch, row) for row in table.values]
    return float(np.interp(ratio, table.tip_speed_ratio, along))


def _slope(
    table: CoefficientTable, ratio: float, pitch: float, by_ratio: float, by_pitch: float
) -> float:
    above = _thrust(table, ratio + by_ratio, pitch + by_pitch)
    below = _thrust(table, ratio - by_ratio, pitch - by_pitch)
    return (above - below) / (2 * (by_ratio + by_pitch))


def _induction(thrust_coefficient: float) -> tuple[float, float]:
    """Return a(c_T) and its slope."""
    if thrust_coefficient > LAST_MOMENTUM:
        return 1 / 3 + 0.75 * (thrust_coefficient - LAST_MOMENTUM), 0.75
    root = sqrt(1 - thrust_coefficient)
    return (1 - root) / 2, 0.25 / root


class FileFigure(NamedTuple):
    """Where a figure is in the file, which attribute it fills, and the range accepted in SI.

    The ranges are wide: they are there to catch a wrong unit, not an unusual turbine.
    """

    path: str
    attribute: str
    unit: str
    low: float
    high: float
    meaning: str = ""

    @property
    def example(self) -> str:
        """What to write behind ``key =``."""
        unit = accepted_units(self.unit)[0]
        return f'{{ value = <number>, unit = "{unit}", source = "<where from>" }}'


def figures_of(table: str) -> tuple[FileFigure, ...]:
    """Return the figures of a table, a line each, with its members in their order."""
    rows = (line.split(maxsplit=5) for line in table.strip().split("\n"))
    return tuple(
        FileFigure(path, attribute, unit.replace("*", " "), float(low), float(high), *meaning)
        for path, attribute, unit, low, high, *meaning in rows
    )


def require_entries(document: Document, needed: Iterable[tuple[str, str, str]]) -> None:
    """Refuse a document that lacks entries, all at once.

    ``needed`` : path, what to write behind ``key =``, and what the entry means.

    Raises
    ------
    ModelError : names every entry that is missing, in the form in which it is to be added.
    """
    lines: dict[str, list[str]] = {}
    for path, example, meaning in needed:
        section, _, key = path.rpartition(".")
        content = document.data.get(section, {}) if section else document.data
        if not isinstance(content, dict) or key not in content:
            note = f"  # {meaning}" if meaning else ""
            lines.setdefault(section, []).append(f"{key} = {example}{note}")
    if not lines:
        return
    first = next(iter(lines))
    path = f"{first}.{lines[first][0].partition(' ')[0]}".lstrip(".")
    further = sum(map(len, lines.values())) - 1
    text = "\n".join("\n".join([f"[{name}]"] * bool(name) + lines[name]) for name in lines)
    raise document.error(
        path, f"is missing{f', and {further} more' if further else ''}; add\n{text}"
    )


def _entry(document: Document, path: str, example: str) -> Any:
    section, _, key = path.rpartition(".")
    content = document.data.get(section, {}) if section else document.data
    if key not in content:
        raise document.error(path, f"is missing; add {key} = {example} under [{section}]")
    return content[key]


def text_at(document: Document, path: str) -> str:
    """Return the text at a path; it must not be empty."""
    value = _entry(document, path, '"..."')
    if not isinstance(value, str) or not value.strip():
        raise document.error(path, f"{value!r} was given; text in quotes is needed")
    return value


def _table(document: Document, path: str, keys: Iterable[str], example: str) -> dict[str, Any]:
    """Return the inline table at a path, with exactly these keys."""
    entry = _entry(document, path, example)
    if not isinstance(entry, dict) or set(entry) != set(keys):
        raise document.error(path, f"{entry!r} was given; expected {example}")
    for key in keys:
        if key in ("unit", "source") and not (isinstance(entry[key], str) and entry[key].strip()):
            raise document.error(path, f"{key} is {entry[key]!r}; text in quotes is needed")
    return entry


def read_figure(document: Document, path: str, unit: str = "m") -> Figure:
    """Return ``{ value = ..., unit = "...", source = "..." }`` as the file has it."""
    example = f'{{ value = <number>, unit = "{unit}", source = "<where from>" }}'
    entry = _table(document, path, ("value", "unit", "source"), example)
    return Figure(_number(document, path, entry["value"]), entry["unit"], entry["source"])


def _number(document: Document, path: str, value: object) -> float:
    # bool is an int in Python, not in a turbine file
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise document.error(path, f"value {value!r} was given; a finite number is needed")
    return float(value)


def figure_at(document: Document, spec: FileFigure, figures: dict[str, Figure]) -> float:
    """Return a figure in SI and file it under its path."""
    figure = read_figure(document, spec.path, accepted_units(spec.unit)[0])
    figures[spec.path] = figure
    return _in_range(document, spec, figure.value, figure.unit)


def _in_range(document: Document, spec: FileFigure, value: float, unit: str) -> float:
    with document.at(spec.path):
        converted = to_si(value, unit, spec.unit)
    if not spec.low <= converted <= spec.high:
        raise document.error(
            spec.path,
            f"{value:.9g} {unit} = {converted:.9g} {spec.unit} was given; expected "
            f"{spec.low:.9g} to {spec.high:.9g} {spec.unit}; check value and unit",
        )
    return converted


def _columns(spec: FileFigure) -> str:
    return f'{{ unit = "{accepted_units(spec.unit)[0]}", values = [<numbers>] }}'


def column_at(document: Document, spec: FileFigure) -> tuple[float, ...]:
    """Return a list ``{ unit = "...", values = [...] }`` in SI, at least two numbers."""
    entry = _table(document, spec.path, ("unit", "values"), _columns(spec))
    if not isinstance(entry["values"], list) or len(entry["values"]) < 2:
        raise document.error(spec.path, "values must be a list of at least 2 numbers")
    numbers = [_number(document, spec.path, value) for value in entry["values"]]
    return tuple(_in_range(document, spec, number, entry["unit"]) for number in numbers)


_WIND = FileFigure("frozen_wake.wind", "wind", "m/s", 0.1, 60)
_PITCH = FileFigure("frozen_wake.pitch", "pitch", "rad", -1, 2)
_SENSITIVITY = FileFigure("frozen_wake.power_sensitivity", "power_sensitivity", "W/rad", -1e12, 0)
_FACTOR = FileFigure("frozen_wake.factor", "factor", "-", 1, 100)
LATEST_BEGIN = 1.05
"""The largest first wind of a column, over rated wind."""
WAKE = (_WIND, _PITCH, _SENSITIVITY, _FACTOR)
"""The columns that the section may have."""


def read_frozen_wake(document: Document, turbine: Turbine, thrust: CoefficientTable) -> FrozenWake:
    """Return the frozen wake: published, from the factor that is stated, or from the tables.

    Parameters
    ----------
    turbine : the file's turbine; its own frozen wake is not read.
    thrust : its table of c_T.

    Raises
    ------
    ModelError : both forms at once, a column that is missing, winds that do not increase, columns
        of different length, a first wind too far above rated wind; with a factor: a wind outside
        rated wind to cut-out, or one at which the table's torque does not fall with pitch; without
        the section: see ``frozen_wake_by_tables``.
    """
    if "frozen_wake" not in document.data:
        return frozen_wake_by_tables(turbine, thrust)
    section = document.data["frozen_wake"]
    stated = "factor" in section
    if stated and not {"pitch", "power_sensitivity"}.isdisjoint(section):
        raise document.error(
            "frozen_wake.factor",
            "is given beside published columns; keep pitch and power_sensitivity, or factor alone",
        )
    specs = (_WIND, _FACTOR) if stated else (_WIND, _PITCH, _SENSITIVITY)
    needed = [(spec.path, _columns(spec), "") for spec in specs]
    require_entries(document, [*needed, ("frozen_wake.source", '"<where from>"', "")])
    columns = {spec.attribute: column_at(document, spec) for spec in specs}
    _check(document, columns)
    source = text_at(document, "frozen_wake.source")
    first, rated = columns["wind"][0], rated_wind(turbine)
    if first > LATEST_BEGIN * rated:
        raise document.error(
            "frozen_wake.wind",
            f"begins at {first:.6g} m/s; rated wind is {rated:.4g} m/s by the tables, and pitch "
            f"acts from there: let the column begin at {LATEST_BEGIN * rated:.4g} m/s or below, or "
            "leave the section [frozen_wake] out, and the column is computed from the tables",
        )
    if not stated:
        return FrozenWake(**columns, source=source)
    points = [
        _scaled(document, turbine, wind, factor)
        for wind, factor in zip(columns["wind"], columns["factor"], strict=True)
    ]
    pitch, sensitivity = zip(*points, strict=True)
    return FrozenWake(columns["wind"], pitch, sensitivity, source)


def _check(document: Document, columns: dict[str, tuple[float, ...]]) -> None:
    wind = columns["wind"]
    if any(following <= previous for previous, following in zip(wind, wind[1:], strict=False)):
        raise document.error("frozen_wake.wind", "must increase; sort the table by wind")
    for name, column in columns.items():
        if len(column) != len(wind):
            raise document.error(
                f"frozen_wake.{name}", f"has {len(column)} values, but wind has {len(wind)}"
            )


def _scaled(
    document: Document, turbine: Turbine, wind: float, factor: float
) -> tuple[float, float]:
    """Return (trim pitch [rad], kappa omega_rated dT_r/dbeta [W/rad]) at one wind."""
    first = rated_wind(turbine)
    if not first <= wind <= turbine.cut_out:
        raise document.error(
            "frozen_wake.wind",
            f"{wind:.6g} m/s was given; a factor is stated from rated wind, {first:.6g} m/s, to "
            f"cut-out, {turbine.cut_out:.6g} m/s; below rated the first one holds, with the "
            "square of wind",
        )
    pitch = trim(turbine, wind).pitch
    slope = float(rotor_torque_gradient(turbine, turbine.rated_rotor_speed, pitch, wind)[1])
    if slope >= 0:
        raise document.error(
            "frozen_wake.factor",
            f"at {wind:.6g} m/s the table's dT_r/dbeta is {slope:.6g} N m/rad, not negative, and "
            "no factor makes it so; leave this wind out",
        )
    return pitch, factor * turbine.rated_rotor_speed * slope
