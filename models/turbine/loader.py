"""Turbine files: TOML with value, unit and source beside each figure -> ``Turbine``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Literal

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.csv_table import CoefficientTable, read_coefficient_table
from takagi.models.files.library import Document, read_document, resolve_model
from takagi.models.splines.spline import Surface, interpolate
from takagi.models.turbine.data import (
    BaselineController,
    DiscWake,
    Figure,
    FlapMode,
    FrozenWake,
    TorsionMode,
    Turbine,
)
from takagi.models.turbine.file_figures import (
    WAKE,
    FileFigure,
    figure_at,
    figures_of,
    read_figure,
    read_frozen_wake,
    require_entries,
    text_at,
)

# Path, attribute, unit, range, and what it is, for a file that lacks it.
FIELDS = figures_of("""
rotor.radius rotor_radius m 0.1 500 rotor apex to blade tip
rotor.hub_height hub_height m 0.1 1000 hub over ground
rotor.inertia rotor_inertia kg*m^2 0.001 1e12 blades and hub, about the shaft
rotor.rated_speed rated_rotor_speed rad/s 0.01 1000 of the rotor
rotor.air_density air_density kg/m^3 0.1 10 that of the coefficient tables
drivetrain.gear_ratio gear_ratio - 1 1000 generator speed over rotor speed, 1 without a gearbox
drivetrain.shaft_stiffness shaft_stiffness N*m/rad 1 1e15 torsion, low-speed side
drivetrain.shaft_damping shaft_damping N*m*s/rad 0 1e15 torsion, low-speed side
generator.inertia generator_inertia kg*m^2 0 1e12 about the high-speed shaft
generator.efficiency generator_efficiency - 0.1 1 electrical over mechanical power, all losses
generator.minimum_speed minimum_generator_speed rad/s 0.001 10000 least speed in operation, \
high-speed shaft
generator.rated_torque rated_torque N*m 0.01 1e9 rated power / (efficiency * rated speed), \
high-speed shaft
generator.maximum_torque maximum_torque N*m 0.01 1e9 above rated_torque, often 110 % of it
generator.torque_rate_limit torque_rate_limit N*m/s 0.01 1e12 of the converter, high-speed shaft
generator.speed_filter speed_filter rad/s 0.001 10000 corner of the low-pass on the measured speed
pitch.minimum pitch_min rad -1 1 fine pitch; no smaller angle is commanded
pitch.maximum pitch_max rad 0 2 of the drive, often 90 deg
pitch.rate_limit pitch_rate_limit rad/s 0.001 10 of the drive
pitch.time_constant pitch_time_constant s 0.001 10 of the drive as a first-order lag
pitch.drive_frequency pitch_drive_frequency rad/s 0.1 1000 of the drive as a second-order lag, \
in simulations
pitch.drive_damping pitch_drive_damping - 0.01 10 of the drive as a second-order lag, in simulations
tower.mass tower_mass kg 0.001 1e9 first fore-aft mode, equivalent mass at the top
tower.damping tower_damping N*s/m 0 1e12 of this mode: 2 zeta sqrt(stiffness * mass)
tower.stiffness tower_stiffness N/m 0.001 1e12 of this mode: mass * (2 pi frequency)^2
operation.cut_in cut_in m/s 0.1 20 least wind in operation
operation.cut_out cut_out m/s 1 60 largest wind in operation
""")
_BASELINE = figures_of("""
baseline.proportional_gain proportional_gain s 0 1000
baseline.integral_gain integral_gain - 0 1000
baseline.schedule_pitch schedule_pitch rad 0.001 2
baseline.optimal_torque_constant optimal_torque_constant N*m*s^2/rad^2 0 1e9
baseline.region_15_speed region_15_speed rad/s 0.001 10000
baseline.region_2_speed region_2_speed rad/s 0.001 10000
baseline.region_25_speed region_25_speed rad/s 0.001 10000
baseline.region_3_speed region_3_speed rad/s 0.001 10000
""")
# Of the validation plant, each group whole or not at all; what holds without it: ``Turbine``.
_GROUPS = [
    figures_of(group)
    for group in """
wake.induction induction - 0 3
wake.time_share time_share - 0.05 5

blade.flap_frequency frequency rad/s 0.1 1000
blade.flap_damping damping - 0 1
blade.flap_compliance compliance m/N 0 1
blade.flap_velocity_share velocity_share - 0 1

drivetrain.torsion_frequency frequency rad/s 0.1 10000
drivetrain.torsion_damping damping - 0 1

tower.velocity_share tower_share - 0.5 2

generator.torque_lag torque_lag s 0.0001 10
""".split("\n\n")
]
_TOP = ("format", "kind", "name", "description")
_FREE_SECTION = "reference"
_TABLES = ("power", "thrust")
_FURTHER_PATHS = (
    "frozen_wake.source",
    *(spec.path for spec in WAKE),
    "coefficients.power",
    "coefficients.thrust",
)
# attribute pairs of which the first must be the smaller, with the fields to name
_ORDERED = (
    ("pitch_min", "pitch_max", "pitch.minimum", "pitch.maximum"),
    ("cut_in", "cut_out", "operation.cut_in", "operation.cut_out"),
    ("minimum_rotor_speed", "rated_rotor_speed", "generator.minimum_speed", "rotor.rated_speed"),
    ("rated_torque", "maximum_torque", "generator.rated_torque", "generator.maximum_torque"),
)


def load_turbine(path_or_name: str | Path) -> Turbine:
    """Return the turbine of a built-in name (``"nrel5mw"``) or of a TOML file.

    Every figure of the file is a table ``{ value = ..., unit = "...", source = "..." }``; the
    units accepted are those of ``takagi.models.files.units``.

    Raises
    ------
    ModelError : unknown name, unreadable file, or a field that is missing, unknown, of the wrong
        type, in an unknown unit or out of range; the message names file, line and field.
    """
    return _turbine(read_document(resolve_model(path_or_name)))


def _turbine(document: Document) -> Turbine:
    _check_kind(document)
    _check_known(document)
    _require_all(document)
    figures: dict[str, Figure] = {}
    values = {f.attribute: figure_at(document, f, figures) for f in FIELDS}
    values["minimum_rotor_speed"] = values.pop("minimum_generator_speed") / values["gear_ratio"]
    _check_order(document, values)
    baseline = None
    if "baseline" in document.data:
        numbers = {f.attribute: figure_at(document, f, figures) for f in _BASELINE}
        baseline = BaselineController(**numbers)
        _check_baseline(document, baseline)
    for key in document.data.get(_FREE_SECTION, {}):
        path = f"{_FREE_SECTION}.{key}"
        figures[path] = read_figure(document, path)
    tables = _coefficients(document, values["pitch_min"])
    power, thrust = tables["power"], tables["thrust"]
    fields: dict[str, Any] = {
        **values,
        "power": _surface("c_P", power, power.values),
        "thrust": _surface("c_T", thrust, thrust.values),
        "torque": _surface("c_Q", power, power.values / power.tip_speed_ratio[:, None]),
    }
    turbine = Turbine(
        name=text_at(document, "name"),
        baseline=baseline,
        frozen_wake=FrozenWake((), (), (), ""),
        **_validation_figures(document, figures),
        figures=MappingProxyType(figures),
        **fields,
    )
    # It may follow from the tables' slopes at the trim, so that it needs a turbine.
    try:
        wake = read_frozen_wake(document, turbine, thrust)
    except ModelError as error:
        if str(error).startswith(str(document.path)):
            raise
        raise ModelError(f"{document.path}: {error}") from error
    return replace(turbine, frozen_wake=wake)


def _require_all(document: Document) -> None:
    """Refuse a file that lacks entries; optional groups are needed whole or not at all."""
    groups: list[tuple[FileFigure, ...]] = [FIELDS]
    for group in (*_GROUPS, _BASELINE):
        paths = [f.path.partition(".") for f in group]
        if any(key in document.data.get(section, {}) for section, _, key in paths):
            groups.append(group)
    needed = [(f.path, f.example, f.meaning) for group in groups for f in group]
    needed += [
        (f"coefficients.{key}", f'"<file>_c{key[0]}.csv"', f"table of c_{key[0].upper()}")
        for key in _TABLES
    ]
    require_entries(document, [("name", '"..."', "of the turbine"), *needed])


def model_files(path_or_name: str | Path) -> list[Path]:
    """Return the files that ``load_turbine`` reads: the TOML file, then its coefficient tables.

    Raises
    ------
    ModelError : as ``load_turbine`` does for the name, the file, or a table that is not named.
    """
    return TurbineFile(path_or_name, read_document(resolve_model(path_or_name))).files


@dataclass(frozen=True, eq=False)
class TurbineFile:
    """A turbine's file, read once.

    Attributes
    ----------
    name : the built-in name or the path, as it was given.
    """

    kind: ClassVar[Literal["turbine"]] = "turbine"
    name: str | Path
    document: Document

    @cached_property
    def model(self) -> Turbine:
        """The turbine, as ``load_turbine`` returns it."""
        return _turbine(self.document)

    @property
    def files(self) -> list[Path]:
        """The file and its coefficient tables, as ``model_files`` returns them."""
        names = [text_at(self.document, f"coefficients.{key}") for key in _TABLES]
        folder = self.document.path.parent
        return [self.document.path, *(folder / name for name in names)]


@lru_cache(maxsize=1)
def nrel5mw() -> Turbine:
    """Return the NREL 5-MW reference turbine; read once, then the same object."""
    return load_turbine("nrel5mw")


def _validation_figures(document: Document, figures: dict[str, Figure]) -> dict[str, Any]:
    """Return what the file says of the validation plant alone, without groups that it has not."""
    optional: dict[str, Any] = {}
    for group, maker in zip(_GROUPS, ("wake", "flap", "torsion", None, None), strict=True):
        paths = [f.path.partition(".") for f in group]
        if not any(key in document.data.get(section, {}) for section, _, key in paths):
            continue
        values = {f.attribute: figure_at(document, f, figures) for f in group}
        kinds = {"wake": DiscWake, "flap": FlapMode, "torsion": TorsionMode}
        optional |= values if maker is None else {maker: kinds[maker](**values)}
    return optional


def _check_kind(document: Document) -> None:
    kind = document.data.get("kind")
    if kind != "turbine":
        raise document.error(
            "kind",
            f'{kind!r} was given; a turbine file says kind = "turbine" (a plant is read by '
            "takagi.models.load_model and derived by sector_model)",
        )
    version = document.data.get("format")
    if version != 1:
        found = "is missing" if version is None else f"{version!r} was given"
        raise document.error(
            "format", f"{found}; this takagi knows format = 1: write it so, or use a newer takagi"
        )


def _check_known(document: Document) -> None:
    """Refuse fields that no reader uses: they are misspelt more often than superfluous."""
    optional = [f for group in _GROUPS for f in group]
    known_paths = [f.path for f in (*FIELDS, *optional, *_BASELINE)] + list(_FURTHER_PATHS)
    sections = list(dict.fromkeys(path.partition(".")[0] for path in known_paths)) + [_FREE_SECTION]
    for section, content in document.data.items():
        if section in _TOP:
            continue
        if section not in sections:
            suggestion = did_you_mean(section, sections)
            raise document.error(
                section, f"is not known{suggestion}; sections: {', '.join(sections)}"
            )
        if not isinstance(content, dict):
            raise document.error(section, f"{content!r} was given; a section [{section}] is needed")
        if section == _FREE_SECTION:
            continue
        keys = [path.partition(".")[2] for path in known_paths if path.startswith(f"{section}.")]
        for key in content:
            if key not in keys:
                raise document.error(
                    f"{section}.{key}",
                    f"is not known{did_you_mean(key, keys)}; [{section}] has {', '.join(keys)}",
                )


def _check_order(document: Document, values: dict[str, float]) -> None:
    for first, second, first_path, second_path in _ORDERED:
        if not values[first] < values[second]:
            raise document.error(
                first_path,
                f"gives {first} = {values[first]:.9g}, not below {second} = {values[second]:.9g} "
                f"(from {second_path!r}), SI units; correct one of the two",
            )


def _check_baseline(document: Document, baseline: BaselineController) -> None:
    names = ("region_15_speed", "region_2_speed", "region_25_speed", "region_3_speed")
    for first, second in zip(names, names[1:], strict=False):
        if not getattr(baseline, first) < getattr(baseline, second):
            raise document.error(f"baseline.{second}", f"must exceed {first}; sort the regions")


def _coefficients(document: Document, pitch_min: float) -> dict[str, CoefficientTable]:
    """Return the tables of c_P and c_T beside the file."""
    tables: dict[str, CoefficientTable] = {}
    for key in _TABLES:
        path = f"coefficients.{key}"
        name = text_at(document, path)
        with document.at(path):
            tables[key] = read_coefficient_table(document.path.parent / name)
        if not tables[key].pitch[0] <= pitch_min < tables[key].pitch[-1]:
            raise document.error(
                path,
                f"{name} does not cover the smallest pitch, {pitch_min:.9g} rad; extend the table",
            )
    return tables


def _surface(name: str, table: CoefficientTable, values: Any) -> Surface:
    return interpolate(
        table.tip_speed_ratio,
        table.pitch,
        values,
        name=name,
        x_name="tip-speed ratio [-]",
        y_name="pitch [rad]",
    )
