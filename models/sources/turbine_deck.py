r"""A turbine's file from ROSCO's and OpenFAST's: tuning file, DISCON.IN, deck, ``Cp_Ct_Cq`` table.

One place leads to the others: a tuning file (.yaml) names the deck and the table, the deck's .fst
names ElastoDyn, ServoDyn and their files, ServoDyn may name a DISCON.IN, which names a table.
Every figure is taken from the first of its places that has it, and says which.

The tower's first fore-aft mode phi(h), with phi = 1 at the top, is one mass on one spring there:

    M = M_top + int mu phi^2 dh,   K = int EI phi''^2 dh - g int (M_top + int_h^H mu) phi'^2 dh,

with the second derivatives of ElastoDyn's polynomial, clamped at its foot.  The rotor's inertia
about the shaft is that of the hub and sum int mu r^2 dr cos^2(cone) over the blades.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, degrees, pi, radians, sin, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.csv_table import FIRST_LINE, ROWS
from takagi.models.files.units import typed_figure
from takagi.models.turbine.loader import load_turbine

UNUSED = 9999.9  # ServoDyn's figure of a model that is switched off
GRAVITY = 9.80665
SECTIONS = {
    "rotor": "radius hub_height inertia rated_speed air_density",
    "drivetrain": "gear_ratio shaft_stiffness shaft_damping",
    "generator": "inertia efficiency minimum_speed rated_torque maximum_torque torque_rate_limit "
    "speed_filter",
    "pitch": "minimum maximum rate_limit time_constant drive_frequency drive_damping",
    "tower": "mass damping stiffness",
    "operation": "cut_in cut_out",
}
PATHS = [f"{section}.{key}" for section, keys in SECTIONS.items() for key in keys.split()]


class DeckFigure(NamedTuple):
    """A figure, its unit, where it was read, and whether no file has it."""

    value: float
    unit: str
    source: str
    assumed: bool = False


@dataclass(frozen=True, slots=True)
class Deck:
    """The files of a turbine by what they are: yaml, discon, fst, elastodyn, blade, table, ..."""

    paths: Mapping[str, Path]
    texts: Mapping[str, str]

    def number(
        self, kind: str, key: str, factor: float = 1.0, number: int = 0
    ) -> DeckFigure | None:
        """Return one of the numbers that a file has for a key, without unit; None without any."""
        text = _entry(self.texts.get(kind, ""), key, yaml=kind == "yaml") or ""
        try:
            value = float(text.split()[number].lower().replace("d", "e")) * factor
        except (ValueError, IndexError):
            return None
        return DeckFigure(value, "", f"{key} of {self.paths[kind].name}")


def turbine_files(
    places: Mapping[str, Path],
    *,
    stem: str,
    table: Path | None = None,
    stated: Sequence[str] = (),
) -> tuple[dict[str, str], list[str]]:
    """Return name -> text of the turbine's file and its tables, and the figures that were assumed.

    Parameters
    ----------
    places : ``"rosco"`` and ``"openfast"`` -> folder or file, one of them or both.
    stem : name of the file without its end.
    table : the ``Cp_Ct_Cq`` table, where no file names it.
    stated : figures in place of those of the files, ``"pitch.minimum = 2 deg"``.

    Raises
    ------
    ModelError : a place without such files, or with several to choose from; no table; figures that
        no file has; figures that are no turbine.
    """
    deck = _deck(places, table)
    figures = _figures(deck)
    for text in stated:
        path, given = _stated(text)
        figures[path] = given
    missing = [path for path in PATHS if path not in figures]
    if missing:
        read = ", ".join(str(path) for path in deck.paths.values())
        raise ModelError(
            f"no file has {', '.join(missing)} (read were {read}); give the place of the deck too "
            '(--from-openfast), or each as --figure "' + missing[0] + ' = NUMBER UNIT"'
        )
    if "table" not in deck.paths:
        raise ModelError(
            f"no Cp_Ct_Cq table is named by {', '.join(str(p) for p in deck.paths.values())}, and "
            "none lies beside them; give it by --table (ROSCO's toolbox writes one, by "
            "write_rotor_performance)"
        )
    tables = _tables(deck)
    files = {f"{stem}_c{letter}.csv": text for letter, text in zip("pt", tables, strict=True)}
    name = f"{stem}.toml"
    files = {name: _toml(deck, figures, stem), **files}
    fine = figures["pitch.minimum"]
    least = _accepted(files, name)
    if least is not None and not any("pitch.minimum" in text for text in stated):
        figures["pitch.minimum"] = DeckFigure(
            round(degrees(least), 6),
            "deg",
            f"chosen: with {fine.value:.4g} {fine.unit} ({fine.source}) the rotor does not shed "
            "torque by pitch at rated wind",
            True,
        )
        files[name] = _toml(deck, figures, stem)
        least = _accepted(files, name)
    if least is not None:
        _accepted(files, name, final=True)
    assumed = [
        f"{path} = {figures[path].value:.6g} {figures[path].unit}, {figures[path].source}"
        for path in PATHS
        if figures[path].assumed
    ]
    return files, assumed


def _accepted(files: Mapping[str, str], name: str, *, final: bool = False) -> float | None:
    """Return None where the files are a turbine, else a smallest pitch [rad] with which they are.

    Raises
    ------
    ModelError : they are none, or ``final`` and another smallest pitch is needed.
    """
    with TemporaryDirectory() as folder:
        for file, text in files.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        try:
            load_turbine(Path(folder) / name)
        except ModelError as error:
            pitch = getattr(error.__cause__, "least_pitch", None)
            if pitch is not None and not final:
                return float(pitch)
            raise ModelError(str(error).replace(f"{folder}/", "")) from error
    return None


def _deck(places: Mapping[str, Path], table: Path | None) -> Deck:
    """Return the files that the places lead to."""
    paths: dict[str, Path] = {}
    for kind, place in places.items():
        if not place.exists():
            raise ModelError(f"{place}: no such file or folder; check the path")
        folder = place if place.is_dir() else place.parent
        if place.is_dir():
            ends = {"rosco": ("yaml", "yml", "IN"), "openfast": ("fst",)}[kind]
            paths |= _only(place, ends, kind)
        else:
            role = {".yaml": "yaml", ".yml": "yaml", ".fst": "fst"}.get(place.suffix, "discon")
            paths[role] = place
        tables = sorted(folder.glob("*Cp_Ct_Cq*"))
        if len(tables) == 1:
            paths.setdefault("table", tables[0])
    texts: dict[str, str] = {}
    # What names other files comes first.
    for kind, followed in _REFERENCES.items():
        if kind not in paths:
            continue
        texts[kind] = _latin(paths[kind])
        for role, key, folder_key in followed:
            name = (_entry(texts[kind], key, yaml=kind == "yaml") or "").strip("\"' ")
            inside = _entry(texts[kind], folder_key, yaml=True) if folder_key else ""
            path = paths[kind].parent / (inside or "").strip("\"' ") / name.replace("\\", "/")
            if name and path.is_file():
                paths.setdefault(role, path)
    if table is not None:
        if not table.is_file():
            raise ModelError(f"{table}: no such file; --table is a Cp_Ct_Cq table of ROSCO's form")
        paths["table"] = table
    for kind, path in paths.items():
        texts.setdefault(kind, _latin(path))
    return Deck(paths, texts)


# Kind of file -> the files that it names: what they are, the key, and the key of their folder.
_REFERENCES: dict[str, tuple[tuple[str, str, str], ...]] = {
    "yaml": (
        ("fst", "FAST_InputFile", "FAST_directory"),
        ("table", "rotor_performance_filename", ""),
    ),
    "fst": (("elastodyn", "EDFile", ""), ("servodyn", "ServoFile", "")),
    "elastodyn": (
        ("blade", "BldFile(1)", ""),
        ("blade", "BldFile1", ""),
        ("tower", "TwrFile", ""),
    ),
    "servodyn": (("discon", "DLL_InFile", ""),),
    "discon": (("table", "PerfFileName", ""),),
}


def _only(folder: Path, ends: Sequence[str], kind: str) -> dict[str, Path]:
    """Return the file of a folder that leads to the others."""
    for end in ends:
        files = sorted(folder.glob(f"*.{end}"))
        if end == "IN":
            files = [path for path in files if "VS_RtTq" in _latin(path)]
        if len(files) > 1:
            names = ", ".join(path.name for path in files)
            raise ModelError(
                f"{folder}: has {len(files)} files .{end} ({names}); name one: --from-{kind} "
                f"{files[0]}"
            )
        if files:
            return {{"fst": "fst", "IN": "discon"}.get(end, "yaml"): files[0]}
    needed = {"rosco": "tuning file (.yaml) and no DISCON.IN", "openfast": ".fst file"}[kind]
    raise ModelError(f"{folder}: has no {needed}; give the folder of one, or the file itself")


def _latin(path: Path) -> str:
    """Return the text of a file whose comments may be in any encoding."""
    return path.read_text(encoding="latin-1")


def _entry(text: str, key: str, *, yaml: bool = False) -> str | None:
    """Return what stands before ``key`` in OpenFAST's files, or behind ``key:`` in a yaml file."""
    if yaml:
        found = re.search(rf"(?:^|[{{,\s]){key}:[ \t]*(\"[^\"]*\"|'[^']*'|[^,}}\n#]*)", text)
        return found[1].strip() if found else None
    written = re.escape(key).replace(r"\(1\)", r"\(?1\)?")
    number = r"[-+\d.eEdD]+"
    value = rf"\"[^\"]*\"|'[^']*'|{number}(?:[ \t]+{number})*|\S+"
    found = re.search(rf"^[ \t]*({value})[ \t]+!?[ \t]*{written}(?=\s|$)", text, flags=re.M)
    return found[1] if found else None


def _columns(text: str, names: Sequence[str]) -> Floats | None:
    """Return columns of the table below a line with their names, (columns, rows)."""
    lines = iter(text.splitlines())
    header = next((line.split() for line in lines if set(names) <= set(line.split())), None)
    if header is None:
        return None
    rows: list[list[float]] = []
    for line in lines:
        try:
            rows.append([float(cell) for cell in line.split()[: len(header)]])
        except ValueError:
            if rows:
                break
    places = [header.index(name) for name in names]
    return np.array([[row[place] for row in rows if len(row) == len(header)] for place in places])


class _Place(NamedTuple):
    """Where a figure may stand: the file, the key, which of several numbers, and its factor."""

    kind: str
    key: str
    factor: float = 1.0
    number: int = 0


_RPM = pi / 30
# Path -> unit and places, the first of which that has the figure is taken.
_DIRECT: dict[str, tuple[str, tuple[_Place, ...]]] = {
    "drivetrain.gear_ratio": (
        "-",
        (_Place("elastodyn", "GBRatio"), _Place("discon", "WE_GearboxRatio")),
    ),
    "drivetrain.shaft_stiffness": ("N m/rad", (_Place("elastodyn", "DTTorSpr"),)),
    "drivetrain.shaft_damping": ("N m s/rad", (_Place("elastodyn", "DTTorDmp"),)),
    "rotor.radius": ("m", (_Place("elastodyn", "TipRad"), _Place("discon", "WE_BladeRadius"))),
    "rotor.inertia": ("kg m^2", (_Place("yaml", "rotor_inertia"),)),
    "rotor.rated_speed": ("rad/s", (_Place("yaml", "rated_rotor_speed"),)),
    "rotor.air_density": ("kg/m^3", (_Place("fst", "AirDens"), _Place("discon", "WE_RhoAir"))),
    "generator.inertia": ("kg m^2", (_Place("elastodyn", "GenIner"),)),
    "generator.efficiency": (
        "-",
        (_Place("discon", "VS_GenEff", 0.01), _Place("servodyn", "GenEff", 0.01)),
    ),
    "generator.minimum_speed": ("rad/s", (_Place("discon", "VS_MinOMSpd"),)),
    "generator.rated_torque": ("N m", (_Place("discon", "VS_RtTq"), _Place("servodyn", "VS_RtTq"))),
    "generator.maximum_torque": ("N m", (_Place("discon", "VS_MaxTq"),)),
    "generator.torque_rate_limit": (
        "N m/s",
        (_Place("discon", "VS_MaxRat"), _Place("yaml", "max_torque_rate")),
    ),
    "generator.speed_filter": ("rad/s", (_Place("discon", "F_LPFCornerFreq"),)),
    "pitch.minimum": ("rad", (_Place("discon", "PC_FinePit"), _Place("yaml", "min_pitch"))),
    "pitch.maximum": ("rad", (_Place("discon", "PC_MaxPit"), _Place("yaml", "max_pitch"))),
    "pitch.rate_limit": (
        "rad/s",
        (_Place("discon", "PC_MaxRat"), _Place("yaml", "max_pitch_rate")),
    ),
    "operation.cut_in": ("m/s", (_Place("yaml", "v_min"), _Place("discon", "WE_FOPoles_v"))),
    "operation.cut_out": (
        "m/s",
        (_Place("yaml", "v_max"), _Place("discon", "WE_FOPoles_v", number=-1)),
    ),
}
# Path -> figure, for those that may be left to the reader of the file; asked for in this order.
_ASSUMED: dict[str, tuple[float, str, str]] = {
    "rotor.air_density": (1.225, "kg/m^3", "standard air"),
    "generator.torque_rate_limit": (0.25, "N m/s", "a quarter of rated torque a second"),
    "generator.maximum_torque": (1.1, "N m", "110 % of rated"),
    "generator.minimum_speed": (0.5, "rad/s", "half of rated speed"),
    "generator.speed_filter": (1.570796, "rad/s", "0.25 Hz, that of the NREL 5-MW turbine"),
    "pitch.minimum": (0.0, "rad", "0 deg"),
    "pitch.maximum": (1.57, "rad", "90 deg"),
    "pitch.rate_limit": (0.0873, "rad/s", "5 deg/s"),
    "pitch.time_constant": (0.2, "s", "no pitch drive in the files; that of the NREL 5-MW turbine"),
    "pitch.drive_frequency": (2 * pi, "rad/s", "no pitch drive in the files; 1 Hz"),
    "pitch.drive_damping": (0.7, "-", "no pitch drive in the files"),
    "operation.cut_in": (3.0, "m/s", "3 m/s"),
    "operation.cut_out": (25.0, "m/s", "25 m/s"),
}


def _figures(deck: Deck) -> dict[str, DeckFigure]:
    """Return the figures that the files have, and those that are assumed, by their paths."""
    figures: dict[str, DeckFigure] = {}
    for path, (unit, places) in _DIRECT.items():
        read = [deck.number(*place) for place in places]
        # 0 and 9999.9 stand for what is not used.
        there = [f for f in read if f and f.value != UNUSED and (f.value or path in _MAY_BE_ZERO)]
        if there:
            figures[path] = there[0]._replace(unit=unit)
    _from_speeds(deck, figures)
    _from_structure(deck, figures)
    _pitch_drive(deck, figures)
    scales = {
        "generator.torque_rate_limit": figures.get("generator.rated_torque"),
        "generator.maximum_torque": figures.get("generator.rated_torque"),
        "generator.minimum_speed": _rated_generator_speed(figures),
    }
    for path, (value, unit, why) in _ASSUMED.items():
        scale = scales.get(path, DeckFigure(1.0, "", ""))
        if path not in figures and scale is not None:
            figures[path] = DeckFigure(value * scale.value, unit, f"assumed: {why}", True)
    return figures


_MAY_BE_ZERO = ("pitch.minimum", "generator.inertia", "drivetrain.shaft_damping")


def _rated_generator_speed(figures: Mapping[str, DeckFigure]) -> DeckFigure | None:
    rotor, gear = figures.get("rotor.rated_speed"), figures.get("drivetrain.gear_ratio")
    return rotor._replace(value=rotor.value * gear.value) if rotor and gear else None


def _from_speeds(deck: Deck, figures: dict[str, DeckFigure]) -> None:
    """Add rated speed, minimum speed and rated torque, as far as they follow from others."""
    gear = figures.get("drivetrain.gear_ratio")
    if gear is None:
        return
    servodyn = deck.number("servodyn", "VS_RtGnSp")
    if servodyn and servodyn.value != UNUSED:
        servodyn = servodyn._replace(value=servodyn.value * _RPM)
    else:
        servodyn = None
    high_speed = deck.number("discon", "PC_RefSpd") or servodyn
    if "rotor.rated_speed" not in figures and high_speed:
        figures["rotor.rated_speed"] = DeckFigure(
            high_speed.value / gear.value, "rad/s", f"{high_speed.source}, over the gear ratio"
        )
    least = deck.number("yaml", "vs_minspd", gear.value)
    if "generator.minimum_speed" not in figures and least and least.value:
        figures["generator.minimum_speed"] = least._replace(
            unit="rad/s", source=f"{least.source}, times the gear ratio"
        )
    speed, power = _rated_generator_speed(figures), deck.number("yaml", "rated_power")
    efficiency = figures.get("generator.efficiency")
    if "generator.rated_torque" not in figures and speed and power and efficiency:
        figures["generator.rated_torque"] = DeckFigure(
            power.value / (efficiency.value * speed.value),
            "N m",
            f"{power.source}, over efficiency and rated speed",
        )


def _pitch_drive(deck: Deck, figures: dict[str, DeckFigure]) -> None:
    """Add the pitch actuator of the DISCON.IN, where it is switched on (PA_Mode 1 or 2)."""
    mode, corner = deck.number("discon", "PA_Mode"), deck.number("discon", "PA_CornerFreq")
    damping = deck.number("discon", "PA_Damping")
    if not (mode and corner and damping and mode.value):
        return
    zeta = damping.value if mode.value == 2 else 1.0
    lag = 2 * zeta / corner.value if mode.value == 2 else 1 / corner.value
    source = f"PA_Mode {mode.value:g}, {corner.source}"
    figures["pitch.time_constant"] = DeckFigure(lag, "s", source)
    figures["pitch.drive_frequency"] = DeckFigure(corner.value, "rad/s", source)
    figures["pitch.drive_damping"] = DeckFigure(zeta, "-", source)


_ELASTODYN = (
    "TowerHt TowerBsHt Twr2Shft OverHang ShftTilt TipRad HubRad PreCone(1) NumBl HubIner HubMass "
    "NacMass YawBrMass"
).split()


def _from_structure(deck: Deck, figures: dict[str, DeckFigure]) -> None:
    """Add hub height, the rotor's inertia and the tower's first mode from ElastoDyn's files."""
    numbers = {key: deck.number("elastodyn", key) for key in _ELASTODYN}
    total = deck.number("discon", "WE_Jtot")
    gear, generator = figures.get("drivetrain.gear_ratio"), figures.get("generator.inertia")
    if all(figure is not None for figure in numbers.values()):
        elastic = {key: figure.value for key, figure in numbers.items() if figure is not None}
        overhang = elastic["OverHang"] * sin(radians(elastic["ShftTilt"]))
        figures["rotor.hub_height"] = DeckFigure(
            elastic["TowerHt"] + elastic["Twr2Shft"] + overhang,
            "m",
            f"TowerHt + Twr2Shft + OverHang sin(ShftTilt) of {deck.paths['elastodyn'].name}",
        )
        blades = _blades(deck, elastic)
        if blades is not None:
            mass, inertia = blades
            source = f"blades and hub, by {deck.paths['blade'].name}"
            figures.setdefault("rotor.inertia", DeckFigure(inertia, "kg m^2", source))
            figures |= _tower(deck, elastic, mass)
    if "rotor.inertia" not in figures and total and gear and generator:
        figures["rotor.inertia"] = DeckFigure(
            total.value - generator.value * gear.value**2,
            "kg m^2",
            f"{total.source}, less the generator's",
        )


def _blades(deck: Deck, elastic: Mapping[str, float]) -> tuple[float, float] | None:
    """Return mass [kg] and inertia about the shaft [kg m^2] of blades and hub."""
    columns = _columns(deck.texts.get("blade", ""), ("BlFract", "BMassDen"))
    factor = deck.number("blade", "AdjBlMs")
    if columns is None or factor is None:
        return None
    length = elastic["TipRad"] - elastic["HubRad"]
    radius, density = elastic["HubRad"] + columns[0] * length, columns[1] * factor.value
    cone = cos(radians(elastic["PreCone(1)"]))
    mass = elastic["NumBl"] * np.trapezoid(density, radius)
    inertia = elastic["NumBl"] * np.trapezoid(density * radius**2, radius) * cone**2
    return float(mass + elastic["HubMass"]), float(inertia + elastic["HubIner"])


def _tower(deck: Deck, elastic: Mapping[str, float], rotor_mass: float) -> dict[str, DeckFigure]:
    """Return mass, damping and stiffness of the first fore-aft mode; nothing without its files."""
    columns = _columns(deck.texts.get("tower", ""), ("HtFract", "TMassDen", "TwFAStif"))
    shape = [deck.number("tower", f"TwFAM1Sh({power})") for power in range(2, 7)]
    factors = [deck.number("tower", key) for key in ("AdjTwMa", "AdjFASt", "FAStTunr(1)")]
    damping = deck.number("tower", "TwrFADmp(1)")
    if columns is None or damping is None or None in shape or None in factors:
        return {}
    adjusted = [figure.value for figure in factors if figure is not None]
    polynomial = np.polynomial.Polynomial([0, 0, *(f.value for f in shape if f is not None)])
    height = elastic["TowerHt"] - elastic["TowerBsHt"]
    share = np.linspace(0, 1, 1001)
    h = share * height
    density = np.interp(share, columns[0], columns[1]) * adjusted[0]
    bending = np.interp(share, columns[0], columns[2]) * adjusted[1] * adjusted[2]
    mode = polynomial(share) / polynomial(1)
    slope = polynomial.deriv()(share) / polynomial(1) / height
    curvature = polynomial.deriv(2)(share) / polynomial(1) / height**2
    top = rotor_mass + elastic["NacMass"] + elastic["YawBrMass"]
    steps = np.diff(h) * (density[1:] + density[:-1]) / 2
    above = top + np.concatenate([np.cumsum(steps[::-1])[::-1], [0]])
    mass = top + float(np.trapezoid(density * mode**2, h))
    stiffness = float(np.trapezoid(bending * curvature**2 - GRAVITY * above * slope**2, h))
    ratio = damping.value / 100
    source = f"first fore-aft mode by {deck.paths['tower'].name}, clamped at its foot"
    made = {
        "mass": (mass, "kg"),
        "damping": (2 * ratio * sqrt(max(stiffness, 0) * mass), "N s/m"),
        "stiffness": (stiffness, "N/m"),
    }
    return {f"tower.{key}": DeckFigure(*value, source) for key, value in made.items()}


def _stated(text: str) -> tuple[str, DeckFigure]:
    """Return path and figure of ``pitch.minimum = 2 deg``."""
    path, equals, figure = (part.strip() for part in text.partition("="))
    if not equals or path not in PATHS:
        raise ModelError(
            f"--figure {text!r} was given; PATH = NUMBER UNIT is needed"
            f"{did_you_mean(path, PATHS)}, with a path of {', '.join(PATHS)}"
        )
    value, unit = typed_figure(figure)
    return path, DeckFigure(value, unit or "-", "given by --figure")


def _tables(deck: Deck) -> tuple[str, str]:
    """Return the texts of the tables of c_P and c_T."""
    path, lines = deck.paths["table"], deck.texts["table"].splitlines()
    blocks: dict[str, list[list[float]]] = {}
    title = ""
    for number, line in enumerate(lines, start=1):
        if line.lstrip().startswith("#"):
            title = line.strip("# \t").lower()
        elif line.strip():
            try:
                blocks.setdefault(title, []).append([float(cell) for cell in line.split()])
            except ValueError as error:
                raise ModelError(f"{path}:{number}: {error}; numbers are needed there") from error

    def block(word: str) -> list[list[float]]:
        for name, rows in blocks.items():
            if name.startswith(word):
                return rows
        raise ModelError(
            f"{path}: has no '# {word}'; a table of ROSCO's form is needed, with pitch angle "
            "vector, TSR vector, power coefficient and thrust coefficient"
        )

    # Long vectors may be broken into several lines.
    pitch, ratios = (np.concatenate(block(word)) for word in ("pitch angle", "tsr"))
    texts = []
    for word, letter in (("power", "P"), ("thrust", "T")):
        rows = block(word)
        if len(rows) != len(ratios) or {len(row) for row in rows} != {len(pitch)}:
            raise ModelError(
                f"{path}: the {word} coefficient has {len(rows)} rows of "
                f"{sorted({len(row) for row in rows})} numbers; {len(ratios)} tip-speed ratios and "
                f"{len(pitch)} pitch angles are given above it"
            )
        heading = {
            "quantity": f"{word} coefficient c_{letter} [-]",
            "rows": ROWS,
            "columns": "collective pitch [deg]",
            "source": f"{path.name}, converted by takagi new",
            "licence": f"that of {path.name}",
        }
        texts.append(
            "\n".join(
                [
                    f"# {FIRST_LINE}",
                    *(f"# {key}: {value}" for key, value in heading.items()),
                    ",".join(["tip_speed_ratio", *(f"{angle:.12g}" for angle in pitch)]),
                    *(
                        ",".join(f"{number:.12g}" for number in (ratio, *row))
                        for ratio, row in zip(ratios, rows, strict=True)
                    ),
                ]
            )
            + "\n"
        )
    return texts[0], texts[1]


def _toml(deck: Deck, figures: Mapping[str, DeckFigure], stem: str) -> str:
    """Return the turbine's file."""
    lines = [
        f"# Written by takagi new from {', '.join(path.name for path in deck.paths.values())}.",
        "# Every figure has its unit and where it was read; check those that are assumed.",
        "# [frozen_wake] is left out, and computed from the tables; [baseline] is not needed.",
        "format = 1",
        'kind = "turbine"',
        f"name = {json.dumps(stem)}",
    ]
    for section, keys in SECTIONS.items():
        lines += ["", f"[{section}]"]
        for key in keys.split():
            figure = figures[f"{section}.{key}"]
            lines.append(
                f"{key} = {{ value = {figure.value:.12g}, unit = {json.dumps(figure.unit)}, "
                f"source = {json.dumps(figure.source, ensure_ascii=False)} }}"
            )
    lines += ["", "[coefficients]", f'power = "{stem}_cp.csv"', f'thrust = "{stem}_ct.csv"']
    return "\n".join(lines) + "\n"
