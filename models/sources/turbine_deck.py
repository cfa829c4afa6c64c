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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import degrees, pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.csv_table import FIRST_LINE, ROWS
from takagi.models.files.units import to_si, typed_figure
from takagi.models.turbine.loader import FIELDS, load_turbine

# Path in the turbine's file, and where a figure is read: a file's kind, its key, which of several
# numbers, and a factor.  What follows from others, or has no place at all, is not here.
PLACES = """
rotor.radius  elastodyn:TipRad  discon:WE_BladeRadius
rotor.inertia  yaml:rotor_inertia
rotor.rated_speed  yaml:rated_rotor_speed
rotor.air_density  fst:AirDens  discon:WE_RhoAir
drivetrain.gear_ratio  elastodyn:GBRatio  discon:WE_GearboxRatio
drivetrain.shaft_stiffness  elastodyn:DTTorSpr
drivetrain.shaft_damping  elastodyn:DTTorDmp
generator.inertia  elastodyn:GenIner
generator.efficiency  discon:VS_GenEff:0:0.01  servodyn:GenEff:0:0.01
generator.minimum_speed  discon:VS_MinOMSpd
generator.rated_torque  discon:VS_RtTq  servodyn:VS_RtTq
generator.maximum_torque  discon:VS_MaxTq
generator.torque_rate_limit  discon:VS_MaxRat  yaml:max_torque_rate
generator.speed_filter  discon:F_LPFCornerFreq
pitch.minimum  discon:PC_FinePit  yaml:min_pitch
pitch.maximum  discon:PC_MaxPit  yaml:max_pitch
pitch.rate_limit  discon:PC_MaxRat  yaml:max_pitch_rate
operation.cut_in  yaml:v_min  discon:WE_FOPoles_v:0
operation.cut_out  yaml:v_max  discon:WE_FOPoles_v:-1
"""
UNITS = {figure.path: figure.unit for figure in FIELDS}
MAY_BE_ZERO = ("pitch.minimum", "generator.inertia", "drivetrain.shaft_damping")
UNUSED = 9999.9  # ServoDyn's figure of a model that is switched off
GRAVITY = 9.80665
# Kind of file -> the files that it names: what they are, the key, and the key of their folder.
REFERENCES: dict[str, tuple[tuple[str, str, str], ...]] = {
    "yaml": (
        ("fst", "FAST_InputFile", "FAST_directory"),
        ("table", "rotor_performance_filename", ""),
    ),
    "fst": (("elastodyn", "EDFile", ""), ("servodyn", "ServoFile", "")),
    "elastodyn": (("blade", "BldFile(1)", ""), ("tower", "TwrFile", "")),
    "servodyn": (("discon", "DLL_InFile", ""),),
    "discon": (("table", "PerfFileName", ""),),
}


class DeckFigure(NamedTuple):
    """A figure in the unit of its path, where it was read, and whether it is ours."""

    value: float
    source: str
    assumed: bool = False


Figures = dict[str, DeckFigure]


@dataclass(frozen=True, slots=True)
class Deck:
    """The files of a turbine by what they are: yaml, discon, fst, elastodyn, blade, table, ...

    ``absent`` : files that others name and that are not there.
    """

    paths: Mapping[str, Path]
    texts: Mapping[str, str]
    absent: Sequence[str]

    def number(self, kind: str, key: str, place: int | str = 0) -> float | None:
        """Return one of the numbers that a file has for a key; None without any."""
        text = _entry(self.texts.get(kind, ""), key, yaml=kind == "yaml") or ""
        try:
            return float(text.split()[int(place)].lower().replace("d", "e"))
        except (ValueError, IndexError):
            return None

    def numbers(self, kind: str, keys: str) -> list[float] | None:
        """Return the numbers of a file for keys with spaces between them; None where one lacks."""
        values = [self.number(kind, key) for key in keys.split()]
        there = [value for value in values if value is not None]
        return there if len(there) == len(values) else None

    def name(self, kind: str) -> str:
        """Return the name of a file."""
        return self.paths[kind].name


def turbine_files(
    places: Mapping[str, Path], *, stem: str, table: Path | None = None, stated: Sequence[str] = ()
) -> tuple[dict[str, str], list[str]]:
    """Return name -> text of the turbine's file and its tables, and the figures that are ours.

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
    figures = _figures(deck, dict(map(_stated, stated)))
    read = ", ".join(str(path) for path in deck.paths.values())
    missing = [path for path in UNITS if path not in figures]
    if missing:
        raise ModelError(
            f"no file has {', '.join(missing)} (read were {read}"
            + f"; named and not there: {', '.join(deck.absent)}" * bool(deck.absent)
            + "); give the place of the deck too (--from-openfast), or each as --figure "
            f'"{missing[0]} = NUMBER UNIT"'
        )
    if "table" not in deck.paths:
        raise ModelError(
            f"no Cp_Ct_Cq table is named by {read}, and none lies beside them; give it by --table "
            "(ROSCO's toolbox writes one, by write_rotor_performance)"
        )
    files = {f"{stem}.toml": _toml(deck, figures, stem), **_tables(deck, stem)}
    smallest_pitch = _least_pitch(files)
    if smallest_pitch is not None and not figures["pitch.minimum"].source.startswith("given"):
        fine = figures["pitch.minimum"]
        why = (
            f"chosen: {degrees(smallest_pitch):.4g} deg; with {fine.value:.4g} rad "
            f"({fine.source}) the rotor"
        )
        figures["pitch.minimum"] = DeckFigure(
            smallest_pitch, f"{why} does not shed torque by pitch at rated wind", True
        )
        files[f"{stem}.toml"] = _toml(deck, figures, stem)
        smallest_pitch = _least_pitch(files)
    if smallest_pitch is not None:
        _least_pitch(files, final=True)
    assumed = [
        f"{path} = {figures[path].value:.6g} {unit}, {figures[path].source}"
        for path, unit in UNITS.items()
        if figures[path].assumed
    ]
    return files, assumed


def _least_pitch(files: Mapping[str, str], *, final: bool = False) -> float | None:
    """Return None for the files of a turbine, else a smallest pitch [rad] that makes them one."""
    with TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        try:
            load_turbine(Path(folder) / next(iter(files)))
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
        file = _only(place, kind) if place.is_dir() else place
        paths[{".yaml": "yaml", ".fst": "fst"}.get(file.suffix, "discon")] = file
        tables = list(file.parent.glob("*Cp_Ct_Cq*"))
        if len(tables) == 1:
            paths.setdefault("table", tables[0])
    absent: list[str] = []
    # What names other files comes first.
    for kind, followed in REFERENCES.items():
        text = _text(paths[kind]) if kind in paths else ""
        for role, key, folder_key in followed:
            yaml = kind == "yaml"
            names = [_entry(text, k, yaml=yaml) for k in (folder_key, key) if k]
            inner = Path(*(name.strip("\"' ").replace("\\", "/") for name in names if name))
            if text and all(names) and (paths[kind].parent / inner).is_file():
                paths.setdefault(role, paths[kind].parent / inner)
            elif text and all(names) and inner.name.lower() != "unused":
                absent.append(str(inner))
    if table is not None:
        if not table.is_file():
            raise ModelError(f"{table}: no such file; --table is a Cp_Ct_Cq table of ROSCO's form")
        paths["table"] = table
    return Deck(paths, {kind: _text(path) for kind, path in paths.items()}, absent)


def _only(folder: Path, kind: str) -> Path:
    """Return the file of a folder that leads to the others."""
    for end in {"rosco": ("yaml", "IN"), "openfast": ("fst",)}[kind]:
        files = sorted(folder.glob(f"*.{end}"))
        if end == "IN":
            files = [path for path in files if "VS_RtTq" in _text(path)]
        if len(files) > 1:
            names = ", ".join(path.name for path in files)
            raise ModelError(
                f"{folder}: has {len(files)} files .{end} ({names}); name one: --from-{kind} "
                f"{files[0]}"
            )
        if files:
            return files[0]
    needed = {"rosco": "tuning file (.yaml) and no DISCON.IN", "openfast": ".fst file"}[kind]
    raise ModelError(f"{folder}: has no {needed}; give the folder of one, or the file itself")


def _text(path: Path) -> str:
    """Return the text of a file whose comments may be in any encoding."""
    return path.read_text(encoding="latin-1")


def _entry(text: str, key: str, *, yaml: bool = False) -> str | None:
    """Return what stands before ``key`` in OpenFAST's files, or behind ``key:`` in a yaml file."""
    if yaml:
        match = re.search(rf"(?:^|[{{,\s]){key}:[ \t]*(\"[^\"]*\"|'[^']*'|[^,}}\n#]*)", text)
        return match[1].strip() if match else None
    written = re.escape(key).replace(r"\(1\)", r"\(?1\)?")
    number = r"[-+\d.eEdD]+"
    value = rf"\"[^\"]*\"|'[^']*'|{number}(?:[ \t]+{number})*|\S+"
    match = re.search(rf"^[ \t]*({value})[ \t]+!?[ \t]*{written}(?=\s|$)", text, flags=re.M)
    return match[1] if match else None


def _columns(text: str, names: str) -> Floats | None:
    """Return columns of the table below a line with their names, (columns, rows)."""
    columns, lines = names.split(), iter(text.splitlines())
    header = next((line.split() for line in lines if set(columns) <= set(line.split())), None)
    if header is None:
        return None
    rows: list[list[float]] = []
    for line in lines:
        try:
            rows.append([float(cell) for cell in line.split()[: len(header)]])
        except ValueError:
            if rows:
                break
    return np.array([[row[header.index(name)] for row in rows if row] for name in columns])


def _figures(deck: Deck, stated: Figures) -> Figures:
    """Return the figures that are stated, those of the files, and those that are assumed."""
    figures = dict(stated)
    for path, *places in (line.split() for line in PLACES.strip().split("\n")):
        for place in places:
            kind, key, *rest = place.split(":")
            value = deck.number(kind, key, *rest[:1])
            # 0 and 9999.9 stand for what is not used.
            if value is not None and value != UNUSED and (value or path in MAY_BE_ZERO):
                scaled = value * float(rest[1] if len(rest) > 1 else 1)
                figures.setdefault(path, DeckFigure(scaled, f"{key} of {deck.name(kind)}"))
    _add_structure(deck, figures)
    for path, source, formula, *needed in _derived(deck):
        values = [figures[n].value if n in figures else None for n in needed]
        if path not in figures and None not in values:
            value = formula(*values)
            if value is not None:
                figures[path] = DeckFigure(value, source, source.startswith("assumed"))
    return figures


RATED, GEAR = "rotor.rated_speed", "drivetrain.gear_ratio"
TORQUE, EFFICIENCY = "generator.rated_torque", "generator.efficiency"
_Derived = tuple[str, str, Callable[..., float | None], *tuple[str, ...]]


def _derived(deck: Deck) -> list[_Derived]:
    """Return path, source, formula and the figures that it needs; the first that can be used is."""

    def times(number: float | None, factor: float) -> float | None:
        return number * factor if number and number != UNUSED else None

    fast, rpm = deck.number("discon", "PC_RefSpd"), deck.number("servodyn", "VS_RtGnSp")
    power, least = deck.number("yaml", "rated_power"), deck.number("yaml", "vs_minspd")
    total = deck.number("discon", "WE_Jtot")
    drive = deck.numbers("discon", "PA_Mode PA_CornerFreq PA_Damping")
    mode, corner, zeta = drive or (0, 1, 1)
    ratio = zeta if mode == 2 else 0.5
    actuator = f"PA_CornerFreq of the DISCON.IN, PA_Mode {mode:g}"
    none = "assumed: no pitch drive in the files"
    return [
        (RATED, "PC_RefSpd, over the gear ratio", lambda n: times(fast, 1 / n), GEAR),
        (RATED, "VS_RtGnSp, over the gear ratio", lambda n: times(rpm, pi / 30 / n), GEAR),
        (
            TORQUE,
            "rated_power of the tuning file, over efficiency and rated speed",
            lambda n, speed, efficiency: times(power, 1 / (n * speed * efficiency)),
            *(GEAR, RATED, EFFICIENCY),
        ),
        (
            "rotor.inertia",
            "WE_Jtot of the DISCON.IN, less the generator's",
            lambda n, J: None if total is None else total - J * n**2,
            *(GEAR, "generator.inertia"),
        ),
        ("generator.minimum_speed", "vs_minspd of the tuning file, times the gear ratio",
         lambda n: times(least, n), GEAR),
        ("pitch.time_constant", actuator, lambda: 2 * ratio / corner if mode else None),
        ("pitch.drive_frequency", actuator, lambda: corner if mode else None),
        ("pitch.drive_damping", actuator, lambda: zeta if mode == 2 else 1 if mode else None),
        ("rotor.air_density", "assumed: standard air", lambda: 1.225),
        ("generator.minimum_speed", "assumed: half of rated", lambda n, w: n * w / 2, GEAR, RATED),
        ("generator.maximum_torque", "assumed: 110 % of rated", lambda T: 1.1 * T, TORQUE),
        ("generator.torque_rate_limit", "assumed: a quarter of rated a second", lambda T: T / 4,
         TORQUE),
        ("generator.speed_filter", "assumed: that of the NREL 5-MW turbine", lambda: 1.570796),
        ("pitch.minimum", "assumed", lambda: 0.0),
        ("pitch.maximum", "assumed: 90 deg", lambda: 1.57),
        ("pitch.rate_limit", "assumed: 5 deg/s", lambda: 0.0873),
        ("pitch.time_constant", f"{none}; that of the NREL 5-MW turbine", lambda: 0.2),
        ("pitch.drive_frequency", f"{none}; 1 Hz", lambda: 2 * pi),
        ("pitch.drive_damping", none, lambda: 0.7),
        ("operation.cut_in", "assumed", lambda: 3.0),
        ("operation.cut_out", "assumed", lambda: 25.0),
    ]  # fmt: skip


def _add_structure(deck: Deck, figures: Figures) -> None:
    """Add hub height, the rotor's inertia and the tower's first mode from ElastoDyn's files."""
    rotor = deck.numbers("elastodyn", "TipRad HubRad PreCone(1) NumBl HubIner HubMass")
    nacelle = deck.numbers(
        "elastodyn", "TowerHt TowerBsHt Twr2Shft OverHang ShftTilt NacMass YawBrMass"
    )
    if rotor is None or nacelle is None:
        return
    height, foot, shaft, overhang, tilt, *masses = nacelle
    hub_height = height + shaft + overhang * np.sin(np.radians(tilt))
    source = f"TowerHt + Twr2Shft + OverHang sin(ShftTilt) of {deck.name('elastodyn')}"
    figures.setdefault("rotor.hub_height", DeckFigure(float(hub_height), source))
    blade, adjusted = (
        _columns(deck.texts.get("blade", ""), "BlFract BMassDen"),
        deck.number("blade", "AdjBlMs"),
    )
    if blade is None or adjusted is None:
        return
    tip, root, cone, count, hub_inertia, hub_mass = rotor
    r, mu = root + blade[0] * (tip - root), blade[1] * adjusted * count
    inertia = np.trapezoid(mu * r**2, r) * np.cos(np.radians(cone)) ** 2 + hub_inertia
    figures.setdefault(
        "rotor.inertia", DeckFigure(float(inertia), f"blades and hub, by {deck.name('blade')}")
    )
    top = float(np.trapezoid(mu, r)) + hub_mass + sum(masses)
    for path, figure in _tower(deck, height - foot, top).items():
        figures.setdefault(path, figure)


def _tower(deck: Deck, height: float, top: float) -> Figures:
    """Return mass, damping and stiffness of the first fore-aft mode; nothing without its file."""
    columns = _columns(deck.texts.get("tower", ""), "HtFract TMassDen TwFAStif")
    shape = deck.numbers("tower", " ".join(f"TwFAM1Sh({power})" for power in range(2, 7)))
    factors = deck.numbers("tower", "AdjTwMa AdjFASt FAStTunr(1) TwrFADmp(1)")
    if columns is None or shape is None or factors is None:
        return {}
    phi = np.polynomial.Polynomial([0, 0, *shape]) / sum(shape)
    x = np.linspace(0, 1, 1001)
    mu = np.interp(x, columns[0], columns[1]) * factors[0]
    bending = np.interp(x, columns[0], columns[2]) * factors[1] * factors[2]
    pieces = np.diff(x) * height * (mu[1:] + mu[:-1]) / 2
    above = top + np.append(np.cumsum(pieces[::-1])[::-1], 0)
    mass = top + np.trapezoid(mu * phi(x) ** 2, x) * height
    spring = bending * phi.deriv(2)(x) ** 2 / height**3
    stiffness = np.trapezoid(spring - GRAVITY * above * phi.deriv()(x) ** 2 / height, x)
    damping = 2 * factors[3] / 100 * np.sqrt(max(stiffness, 0) * mass)
    source = f"first fore-aft mode by {deck.name('tower')}, clamped at its foot"
    values = {"mass": mass, "damping": damping, "stiffness": stiffness}
    return {f"tower.{key}": DeckFigure(float(value), source) for key, value in values.items()}


def _stated(text: str) -> tuple[str, DeckFigure]:
    """Return path and figure of ``pitch.minimum = 2 deg``."""
    path, equals, figure = (part.strip() for part in text.partition("="))
    if not equals or path not in UNITS:
        raise ModelError(
            f"--figure {text!r} was given; PATH = NUMBER UNIT is needed{did_you_mean(path, UNITS)}"
            f", with a path of {', '.join(UNITS)}"
        )
    value, unit = typed_figure(figure)
    try:
        return path, DeckFigure(to_si(value, unit or "-", UNITS[path]), f"given, {figure}")
    except ModelError as error:
        raise ModelError(f"--figure {text!r} was given: {error}") from error


def _tables(deck: Deck, stem: str) -> dict[str, str]:
    """Return name -> text of the tables of c_P and c_T."""
    path, blocks, title = deck.paths["table"], {"": [[0.0]]}, ""
    for number, line in enumerate(deck.texts["table"].splitlines(), start=1):
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
    texts = {}
    for word, letter in (("power", "P"), ("thrust", "T")):
        rows = block(word)
        if len(rows) != len(ratios) or {len(row) for row in rows} != {len(pitch)}:
            raise ModelError(
                f"{path}: the {word} coefficient has {len(rows)} rows of "
                f"{sorted({len(row) for row in rows})} numbers; {len(ratios)} tip-speed ratios and "
                f"{len(pitch)} pitch angles are given above it"
            )
        lines = [
            f"# {FIRST_LINE}",
            f"# quantity: {word} coefficient c_{letter} [-]",
            f"# rows: {ROWS}",
            "# columns: collective pitch [deg]",
            f"# source: {path.name}, converted by takagi new",
            f"# licence: that of {path.name}",
            ",".join(["tip_speed_ratio", *(f"{angle:.12g}" for angle in pitch)]),
        ]
        lines += [
            ",".join(f"{number:.12g}" for number in (ratio, *row))
            for ratio, row in zip(ratios, rows, strict=True)
        ]
        texts[f"{stem}_c{letter.lower()}.csv"] = "\n".join(lines) + "\n"
    return texts


def _toml(deck: Deck, figures: Figures, stem: str) -> str:
    """Return the turbine's file."""
    lines = [
        f"# Written by takagi new from {', '.join(path.name for path in deck.paths.values())}.",
        "# Every figure has its unit and where it was read; check those that are assumed.",
        "# [frozen_wake] is left out, and computed from the tables; [baseline] is not needed.",
        "format = 1",
        'kind = "turbine"',
        f"name = {json.dumps(stem)}",
    ]
    last = ""
    for path, unit in UNITS.items():
        section, _, key = path.partition(".")
        lines += [] if section == last else ["", f"[{section}]"]
        last, figure = section, figures[path]
        lines.append(
            f"{key} = {{ value = {figure.value:.12g}, unit = {json.dumps(unit)}, "
            f"source = {json.dumps(figure.source, ensure_ascii=False)} }}"
        )
    lines += ["", "[coefficients]", f'power = "{stem}_cp.csv"', f'thrust = "{stem}_ct.csv"']
    return "\n".join(lines) + "\n"
