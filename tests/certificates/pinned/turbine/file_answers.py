"""What the checker says of a model's file or a gain file, changed in each part.

``files.json`` holds three plants (a cart with tables and a mass matrix, a plant with a sample time,
one with a blend) and a turbine, each as its files and as its certificate has it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from copy import deepcopy
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from takagi.certificates.checker.controller.content import file_content
from takagi.certificates.checker.controller.numbers import exact, short
from takagi.certificates.checker.files import (
    differing,
    file_blend,
    model_content,
    turbine_file,
)
from takagi.certificates.checker.files.companions import compare_model, unconnected
from takagi.certificates.checker.files.gain_file import compare_gains, expected_file
from takagi.certificates.checker.files.plant_units import in_si
from takagi.certificates.checker.files.table_file import compare_table
from takagi.certificates.checker.files.toml_file import read_toml
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.plant.table import read_table
from tests.certificates.pinned.turbine.inputs import CELLS, Document, as_read, document
from tests.certificates.pinned.turbine.values import Named, said

FILES = Path(__file__).with_name("files.json")
PLANTS, TURBINES = ("cart", "step", "room"), ("turbine", "factor")
F = Fraction
# Changes in one group.
TOGETHER = 12


@cache
def _recorded() -> Document:
    found: Document = json.loads(FILES.read_text(encoding="utf-8"))
    return found


def texts_of(name: str) -> dict[str, str]:
    """Return the files of a model, the model's own first."""
    found: dict[str, str] = dict(_recorded()[name]["files"])
    return found


def certificate(name: str) -> Document:
    """Return model, gains, claims and controller as the checker reads them."""
    found = {key: deepcopy(part) for key, part in _recorded()[name].items() if key != "files"}
    found["provenance"] = {"sha256": {"model": "m", "gains": "g", "claims": "c"}}
    return as_read(found)


def answer(data: Document, texts: dict[str, str], work: Callable[..., Any] = compare_model) -> Any:
    """Return what is said of these files, the first of them the model's, without its folder."""
    with TemporaryDirectory() as folder:
        for file, text in texts.items():
            (Path(folder) / file).write_bytes(text.encode())
        found = said(work, data, Path(folder) / next(iter(texts)))
        return found.replace(folder, "") if isinstance(found, str) else found


# ------------------------------------------------------------------ a model's file, field by field

NUMBER = re.compile(r"(?<![\w^.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
TEXT = re.compile(r'"[^"]*"')
ENTRY = re.compile(r"(?m)^\w+ = .*\n|, \w+ = (?:\[[^\]]*\]|\{[^}]*\}|[^,}\]]+)(?=[,} ])")


def rewrites(text: str) -> Iterator[tuple[str, str]]:
    """Yield the text with a number larger or of another kind, another word, or an entry less."""
    for pattern, others in (
        (NUMBER, lambda found: [str(round(float(found) * 1.01 + 0.001, 6)), '"word"']),
        (TEXT, lambda found: ['"word"', "1"]),
        (ENTRY, lambda found: [""]),
    ):
        for number, match in enumerate(pattern.finditer(text)):
            for other in others(match[0]):
                line = text.count("\n", 0, match.start()) + 1
                name = f"line {line}, {match[0].strip()[:24]} {number} to {other or 'nothing'}"
                yield name, f"{text[: match.start()]}{other}{text[match.end() :]}"


def of_rewrites(name: str, file: str, first: int, step: int) -> Named:
    """Yield the answers to some of the rewrites of one file."""
    data, texts = certificate(name), texts_of(name)
    listed = list(rewrites(texts[file]))[first::step]
    for what, text in listed:
        yield what, answer(data, texts | {file: text})


# The same in other words, and parts that only one of the two has.
REPLACED: dict[str, tuple[tuple[str, str], ...]] = {
    "cart": (
        ("", ""),
        ('value = 1.5, unit = "kg"', 'value = 1500, unit = "g"'),
        ('value = 1.5, unit = "kg"', 'value = 1500, unit = "kg"'),
        ("F + w - k*x", "w - k*x + F"),
        ("F + w - k*x", "F + w + x*(l - l) - k*x"),
        ("F + w - k*x", "F + w - k*x + rub(v) - rub(v)"),
        ("F + w - k*x", "F + w - k*x + x/x - 1"),
        ("F + w - k*x", "F + w - k*x + log(x) - log(x)"),
        ("m + m*x^2/l^2", "m*(1 + x^2/l^2)"),
        ("m + m*x^2/l^2", "m"),
        ("[mass]\n", "[mass]\nx = { x = 1 }\n"),
        ("[mass]\n", "[mass]\nx = { x = 2 }\n"),
        ("[mass]\n", "[mass]\nx = 1\n"),
        ('v = { v = "m', 'v = { x = 0, v = "m'),
        ('v = { v = "m', 'v = { x = "l", v = "m'),
        ('[mass]\nv = { v = "m + m*x^2/l^2" }\n', ""),
        ('[mass]\nv = { v = "m + m*x^2/l^2" }\n', '[mass]\nx = { x = 1 }\n'),
        ("2*x", "x + x"),
        ("[outputs]", "[outputs]\nmore = { expression = \"x\" }"),
        (', range = [-1, 1.0]', ""),
        ("[-1, 1.0]", "[-1.0, 1]"),
        ("[-1, 1.0]", "[-1]"),
        ("[-1, 1.0]", "[-1, 1, 2]"),
        ("[-1, 1.0]", "1"),
        ('unit = "mm", range', 'unit = "m", range'),
        ("[-500, 500]", "[-500, 1e101]"),
        ("[-500, 500]", "[-500, inf]"),
        ("rest = 0 }", "rest = 1 }"),
        ("[inputs]\nF =", "[inputs]\nG ="),
        ("[parameters]", "[parameters]\nmore = { value = 1 }"),
        ("[states]\nx = ", "[states]\nz = "),
        ("sin", "sin"),
        ("name = \"place\", unit = \"mm\"", "name = \"place\", unit = \"m\""),
        ("unit = \"N s/m\" }", "unit = \"kN s/m\" }"),
        ("file = \"rub.csv\"", "file = \"../rub.csv\""),
        ("file = \"rub.csv\"", "file = \"none.csv\""),
        ("file = \"rub.csv\"", "file = \"pull.csv\""),
        ("file = \"rub.csv\"", "file = 1"),
        ("[tables]\nrub", "[tables]\nrob"),
        ("[disturbances]", "[scheduling]"),
        ("[disturbances]\nw", "[scheduling]\nh = { range = [0, 1] }\n[disturbances]\nw"),
        ("[design]\ndecay_rate = 0.1", "[design]\ndecay_rate = 0.10"),
        ("[design]\ndecay_rate = 0.1", "[design]\ndecay_rate = 0.2"),
        ("source = \"chosen\"", "source = \"other\""),
        ("description = \"place\"", "description = 1"),
        ("kind = \"plant\"", "kind = \"turbine\""),
        ("format = 1", "format = 1\nsample_time = 1"),
        ("format = 1", "format = 2"),
        ("format = 1", "format = 1\nstates = 1\n[more]"),
        ("format = 1", "format = 1\noutputs = [1]\n[more]"),
        ("format = 1", "format = 1\ntables = 1\n[more]"),
        ("format = 1", "format = 1\nday = 2026-01-01"),
        ("format = 1", "format = 1\nbig = 123456789012345678901234567890"),
        ("format = 1", "# mine\r\nformat = 1"),
        ("[equations]", "[[equations]]"),
        ("[parameters]\n", "parameters = 1\n[more]\n"),
        ("x = \"v\"\nv", "x = \"v\"\nx = \"v\"\nv"),
        ("x = \"v\"\nv", "x = \"v + (\"\nv"),
        ("x = \"v\"\nv", "x = 1\nv"),
    ),
    "step": (
        ("", ""),
        ("sample_time = 0.1", "sample_time = 0.2"),
        ("sample_time = 0.1", "sample_time = 1e-1"),
        ("sample_time = 0.1", "sample_time = true"),
        ("sample_time = 0.1\n", ""),
        ("rest = 2", "rest = 2.5"),
        ("rest = 1", "rest = 1.5"),
        ("range = [0, 4], rest = 2", "range = [0, 4.5], rest = 2"),
        ("range = [0, 4], rest = 2", "rest = 2"),
        ("0.1*sin(x)", "sin(x)/10"),
        ("0.2*(2 - y)", "0.4 - y/5"),
        ("[parameters]", "[blending]\neffort = {}\n[parameters]"),
        ("[parameters]", "[mass]\nx = { x = 2 }\n[parameters]"),
        ("[parameters]", "[outputs]\nx = { expression = \"x\" }\n[parameters]"),
    ),
    "room": (
        ("", ""),
        ("overlap = 0.5", "overlap = 0.50"),
        ("overlap = 0.5", "overlap = 0.25"),
        ("rate = 20", "rate = 2e1"),
        (", rate = 20", ""),
        ("direction = -1", "direction = 1"),
        ("direction = 1,", "direction = 1.0,"),
        ('effectiveness = "2"', 'effectiveness = "4/2"'),
        ('effectiveness = "2"', 'effectiveness = "3"'),
        ('"2 + c*x"', '"c*x + 2"'),
        ('"2 + c*x"', '"2 + x"'),
        (", error = 0.1", ""),
        ("error = 0.1", "error = 0"),
        ("error = 0.1", "error = true"),
        ("error = 0.1", "error = 0.15"),
        ("error = 0.1", 'error = "0.1"'),
        ('input = "cooling"', 'input = "heating"'),
        ('input = "cooling"', 'input = "none"'),
        ("range = [0, 1.5]", "range = [0, 1.6]"),
        ("range = [0, 1.5]", "range = [0]"),
        ("range = [0, 1.5]", "range = 1"),
        (', range = [0, 1.5]', ""),
        ("range = [0, 1.5]", "range = [0, 1.5], rest = 0.1"),
        ("2*cooling", "cooling*2"),
        ("2*cooling", "3*cooling"),
        ("a*x - 2*cooling", "x/2 - 2*cooling"),
        ("\nlow = ", "\nlower = "),
        ("\nhigh = ", "\nhigher = "),
        ("\neffort = ", "\nother = "),
        ('effort = { unit = "m/s", range = [-3, 3]', 'effort = { unit = "m/s", range = [-3, 4]'),
        ('effort = { unit = "m/s"', 'effort = { unit = "mm/s"'),
        ('effort = { unit = "m/s", range = [-3, 3], ', 'effort = { unit = "m/s", '),
        ("a = { value = 0.5", "a = { value = 0.6"),
        ("a = { value = 0.5", "cooling_rest = { value = 1 }\na = { value = 0.5"),
        ("a = { value = 0.5", "effort_rest = { value = 1 }\na = { value = 0.5"),
        ("[blending]", "[blended]"),
    ),
    "turbine": (
        ("", ""),
        ('63.0, unit = "m"', '63, unit = "m"'),
        ('12.1, unit = "rpm"', '1.2671090369478832, unit = "rad/s"'),
        ('43.09355, unit = "kN m"', '43093.55, unit = "N m"'),
        ('43.09355, unit = "kN m"', '50000, unit = "N m"'),
        ('43.09355, unit = "kN m"', '43, unit = "kN m"'),
        ('43.09355, unit = "kN m"', '43.09355000000001, unit = "kN m"'),
        ("15000.0", "14000"),
        ("[rotor]", "[other]"),
        ("[rotor]", "rotor = 1\n[other]"),
        ("radius = { value = 63.0, unit = \"m\", source = \"chosen\" }", "radius = 63"),
        ("value = 63.0", "value = true"),
        ("value = 63.0", "value = 1e39"),
        ("value = 63.0", "value = 1e41"),
        ("value = 63.0", "value = inf"),
        ("value = 63.0", "value = 63." + 99 * "0"),
        ("value = 63.0", "value = 10000000000000000000000000000000000000000000"),
        ('unit = "m",', 'unit = "furlong",'),
        ('unit = "m",', "unit = 1,"),
        ("14.0, 17.0, 20.0, 25.0", "14.0, 17.0, 20.0"),
        ("14.0, 17.0, 20.0, 25.0", "14.0, 17.0, 17.0, 25.0"),
        ("14.0, 17.0, 20.0, 25.0", "0, 17.0, 20.0, 25.0"),
        ("14.0, 17.0, 20.0, 25.0", ""),
        ("-76.5", "-76.6"),
        ("-76.5", "-76.50001"),
        ("[frozen_wake]", "[wake]"),
        ("[frozen_wake]", "[frozen_wake]\nfactor = { unit = \"-\", values = [1, 1, 1, 1] }"),
        ("\"cp.csv\"", "\"none.csv\""),
        ("\"cp.csv\"", "\"./cp.csv\""),
        ("\"cp.csv\"", "1"),
        ("name = \"small\"", "name = \"other\""),
        ("[pitch]", "[tower]\nmass = 1\n[pitch]"),
        ('value = 20.0, unit = "deg"', 'value = 0.3490658503988659, unit = "rad"'),
        ("value = 1.225", "value = 1.225000000001"),
        ("value = 1.225", "value = 1.22500000001"),
    ),
    "factor": (
        ("", ""),
        ("1.25, 1.0", "1.25, 1.01"),
        ("1.5, 1.25, 1.0, 1]", "1.5, 1.25, 1.0]"),
        ("1.5, 1.25, 1.0, 1]", "]"),
        ("14.0, 17.0, 20.0, 25.0", "8.0, 17.0, 20.0, 25.0"),
        ("14.0, 17.0, 20.0, 25.0", "15.0, 17.0, 20.0, 25.0"),
        ('factor = { unit = "-"', 'factor = { unit = "m"'),
    ),
}  # fmt: skip


def of_replaced(name: str, first: int) -> Named:
    data, texts = certificate(name), texts_of(name)
    file = next(iter(texts))
    for number, (old, new) in enumerate(REPLACED[name]):
        if number % 4 == first:
            assert old in texts[file] or old == "sin", old
            changed = texts | {file: texts[file].replace(old, new, 1)}
            yield f"{number}: {old[:40]!r} to {new[:60]!r}", answer(data, changed)


def of_certificate(name: str, first: int) -> Named:
    """Yield the answers where the certificate's model or law is changed instead."""
    texts = texts_of(name)
    for number, (path, value) in enumerate(_places(_recorded()[name]["model"])):
        if number % 4 != first:
            continue
        data = certificate(name)
        holder: Any = data["model"]
        for step in path[:-1]:
            holder = holder[step]
        if value is None:
            del holder[path[-1]]
        else:
            holder[path[-1]] = value
        yield f"{path} to {value}", answer(data, texts)


def _places(model: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    for key, part in model.items():
        if key not in ("model_file", "kind"):
            yield (key,), None
            if isinstance(part, (int, float)) and not isinstance(part, bool):
                yield (key,), Number(repr(part * 1.0001 + 1e-9))
    for path, value in (
        (("states", 0, "rest"), Number("1")),
        (("states", 0, "range"), None),
        (("inputs", 0, "rest"), Number("7")),
        (("inputs", 0, "range", 1), Number("7")),
        (("parameters", "a"), "1/2"),
        (("parameters", "a"), Number("0.51")),
        (("parameters", "m"), "3/2"),
        (("tables", "rub", "coefficients", 2), Number("-0.04")),
        (("tables", "rub", "coefficients", 2), Number("-0.0500001")),
        (("tables", "rub", "knots", 0, 4), Number("0.001")),
        (("tables", "pull", "knots", 1, 4), Number("0.1")),
        (("blending", "overlap"), Number("0.4")),
        (("blending", "low", "idle"), Number("0.4")),
        (("blending", "low", "error"), None),
        (("blending", "high", "range"), None),
        (("blending", "equations"), None),
        (("blending", "equations"), []),
        (("torque_surface", "coefficients", 1, 1), Number("0.09")),
        (("torque_surface", "coefficients", 1, 1), Number("0.1000000001")),
        (("model_file", "name"), "another"),
    ):
        holder: Any = model
        for step in path[:-1]:
            inside = isinstance(holder, list) or step in holder
            holder = holder[step] if inside else None  # type: ignore[index]
            if holder is None:
                break
        if isinstance(holder, list) or (isinstance(holder, dict) and path[-1] in holder):
            yield path, value


# ------------------------------------------------------------------ tables and figures


def of_tables() -> Named:
    """Yield the answers to other points and values of a table, or another form of it."""
    data = certificate("cart")
    texts = texts_of("cart")
    units = {"rub": ["m/s", "N s/m"], "pull": ["mm", "m/s", "N"]}
    for name, changes in (
        ("rub", (
            ("", ""), ("0.4", "0.40000001"), ("0.4", "0.4001"), ("0.5", "0.5001"), ("-1,", "-1.1,"),
            ("-2,", "-2.000001,"), ("-2,", "-2.1,"), ("2, 0.5", "2, 0.5, 1"), ("2, 0.5", "2"),
            ("2, 0.5", "2, nan"), ("2, 0.5", "2, word"), ("2, 0.5", "2, 1e101"),
            ("2, 0.5", "2, " + "0" * 60 + "1"), ("\n0, 0.1", "\n\n  # mine\n0, 0.1"),
            ("\n1, 0.2\n2, 0.5", ""), ("# speed", "x, 1\n# speed"), ("0, 0.1", "0, -0.1"),
            ("\n-1, 0.2\n0, 0.1\n1, 0.2\n2, 0.5", ""),
        )),
        ("pull", (
            ("", ""), ("1.5", "1.6"), ("0.21", "0.22"), ("0.14", "0.1400001"), ("200,", "210,"),
            ("x,-2", "-2"), ("x,-2", "y,-2"), (",2\n", "\n"), ("-600", "-601"),
        )),
    ):  # fmt: skip
        table = read_table(data["model"]["tables"], name, "tables")
        for old, new in changes:
            text = texts[f"{name}.csv"].replace(old, new, 1)
            for own in (
                (units[name], units[name][:-1], ["m", *units[name][1:]])
                if not old
                else (units[name],)
            ):
                yield (
                    f"{name}: {old!r} to {new!r}, {own}",
                    answer(
                        data,
                        {f"{name}.csv": text},
                        lambda _, path, table=table, own=own: compare_table(path, table, own),
                    ),
                )


def of_coefficient_tables() -> Named:
    """Yield the answers to other rows of a turbine's coefficient table."""
    data, texts = certificate("turbine"), texts_of("turbine")
    own = texts["cp.csv"]
    rows = own.splitlines()
    for name, text in (
        ("a longer row", own.replace(rows[2], f"{rows[2]},1")),
        ("a shorter row", own.replace(rows[3], rows[3].rpartition(",")[0])),
        ("no row", rows[0]),
        ("no angles", "tsr\n5.0\n"),
        ("empty lines", own.replace("\n", "\n\n")),
        ("a comment", own.replace(rows[2], f"# mine\n{rows[2]}")),
        ("a word", own.replace("5.0,", "five,")),
        ("no number", own.replace("5.0,", "nan,")),
        ("beyond the angles", own.replace("20.0", "21.0")),
        ("beyond the ratios", own.replace("12.0,", "13.0,")),
        ("before the ratios", own.replace("2.0,", "1.0,", 1)),
        ("within 1e-9", own.replace(rows[3], _moved(rows[3], 5e-10))),
        ("beyond 1e-9", own.replace(rows[3], _moved(rows[3], 5e-9))),
        ("below 1e-9", own.replace(rows[3], _moved(rows[3], -5e-9))),
    ):
        yield name, answer(data, texts | {"cp.csv": text})
    for unit in ("-", "m/s", "m/(s s)", "K", "kW/K", "rad"):
        yield f"per second {unit}", file_blend._per_second(unit)


def _moved(row: str, by: float) -> str:
    first, _, last = row.rpartition(",")
    return f"{first},{float(last) + by:.12f}"


def of_units() -> Named:
    """Yield figures in SI, and units that are none."""
    for unit in (
        *("-", " - ", "m", "mm", "km/h", "rpm", "deg", "deg/s", "rad/deg", "%", "min", "1/min"),
        *("kg m^2", "kg*m", "kg m**2/s^2", "kN m", "1/(m s)", "m/(s s)", "J/(kg K)", "bar", "mbar"),
        *("kW", "GW", "uF", "ng", "L", "mL", "h", "t", "cm^3", "s^-1", "Ohm", "deg^2", "rpm/deg"),
        *("", "/", "1", "1/", "/s", "m/", "m/s/s", "kkg", "mcd", "cd", "kmin", "stone", "m^123"),
        *("m^1.5", "2 m", "m,", "kt", "Mt", "degC", "m * s", "1/1", "(m)", "m/(s", "k", "m^-2/s"),
    ):  # fmt: skip
        yield f"unit {unit!r}", said(in_si, F(7, 3), unit)


def of_figures() -> Named:
    """Yield decimals of turbine files, columns, and values between winds."""
    for written in (
        *("1", "-2.5", "1e3", "1e40", "1e41", "1e-40", "1e-41", "0e999", "inf", "nan", "0"),
        *("1" * 100, "1" * 101, "1." + "0" * 99, "1." + "0" * 100, "1e-39", "0.00"),
    ):
        yield f"decimal {written[:12]} {len(written)}", _refused(turbine_file._decimal, written)
    winds, values = [F(1), F(2), F(4)], [F(5), F(-1), F(3)]
    for v in (F(0), F(1), F(3, 2), F(2), F(3), F(4), F(9)):
        yield f"between {v}", turbine_file._between(v, winds, values)
    for value in (F(1), 1, True, "1", None, 10**40, 10**41, F(-(10**41))):
        yield f"figure {value}", said(turbine_file._si, value, "kN m", "here")
    for unit in turbine_file.FACTORS:
        yield f"unit {unit}", turbine_file._si(F(7), unit, "here")
    breaks = [F(1), F(3, 2), F(2)]
    for off in (F(0), F(1, 10**12), F(-1, 10**12), F(2, 10**12), F(-2, 10**12), F(1, 4)):
        yield (
            f"held {off}",
            [turbine_file._held(end + off, breaks) for end in (breaks[0], breaks[-1])],
        )
    for stated, there in ((1, 1), (10**12 + 1, 10**12), (10**12 + 2, 10**12), (-1, 1), (0, 0)):
        found = said(turbine_file._same, F(stated), F(there), "it", Path("file"))
        yield f"same {stated} {there}", found
    for held in (F(0), F(-1), F(99), F(100), F(101), 100 - F(1, 10**9), 100 - F(1, 10**11)):
        yield f"held torque {held}", said(turbine_file._derated, held, F(100), Path("file"))


def _refused(work: Callable[..., Any], *given: Any) -> Any:
    try:
        return said(work, *given)
    except ValueError as error:
        return f"ValueError: {error}"


def of_differences() -> Named:
    """Yield which parts of two values differ, and how values are told."""
    one = as_read({"a": [1, 2.0, {"b": "x"}], "c": True, "d": None, "e": {"f": 1e1}})
    for name, other in (
        ("same", {"a": [1.0, 2, {"b": "x"}], "c": True, "d": None, "e": {"f": 10}}),
        ("number", {"a": [1, 2.5, {"b": "x"}], "c": True, "d": None, "e": {"f": 10}}),
        ("text", {"a": [1, 2, {"b": "y"}], "c": False, "d": 0, "e": {"f": "10"}}),
        ("length", {"a": [1, 2], "c": 1, "d": {}, "e": []}),
        ("keys", {"e": {"g": 1}, "h": [1], "d\u00e9 \n": 1}),
        ("none", {}),
    ):
        read = as_read(other)
        found = [*differing.differing(one, read), *differing.differing(read, one)]
        yield name, [(d.place, differing.in_words(d.first), differing.in_words(d.second))
                     for d in found]  # fmt: skip
    for value in (
        *(None, "text", "\u00e9\n", True, Number("1.50"), {}, {"a": Number("1")}),
        *([], [Number("1")] * 3, [Number("1")] * 4, "x" * 60, "x" * 61, {"k": "y" * 99}),
    ):
        yield f"told {value!r:.30}", differing.in_words(value)


def of_contents(name: str) -> Named:
    """Yield what a model's file says, part by part."""
    texts = texts_of(name)
    more = "day = 2026-01-01\nbig = 9007199254740993\nmost = 9007199254740992\nx = 1e2\n"
    content = answer({}, {k: more * (k.endswith("toml")) + t for k, t in texts.items()},
                     lambda _, path: model_content.model_content(path))  # fmt: skip
    for key, part in content.items():
        yield key, json.dumps(part)


def of_owners() -> Named:
    """Yield which differences are beside the claims."""
    content = {"a": {"unit": "m", "value": "1"}, "b": {"unit": "m", "range": ["1"]}}
    model = {"kind": "plant", "model_file": {"a": {"unit": "s", "value": "1"}, "b": {"unit": "s"}}}
    values = ((None, "-"), ("-", None), ("1", "2"), (None, "2"), ("1", None))
    for path in (
        ("sample_time",), ("a", "unit"), ("b", "unit"), ("inputs", "u", "rest"),
        ("states", "x", "rest"), ("states", "x", "range", 0), ("states", "x", "more"),
        ("parameters", "k", "value"), ("parameters", "k"), ("equations", "x"),
        ("equations", "x", "unit"), ("mass", "x", "x"), ("outputs", "y", "unit"),
        ("outputs", "y", "expression"), ("blending", "effort", "rate"), ("blending", "effort", "x"),
        ("blending", "low", "error"), ("blending", "low", "x"), ("blending", "mid", "error"),
        ("design", "rate"), ("name",), ("rotor", "radius", "value"), ("rotor", "mass", "value"),
        ("generator", "torque_rate_limit", "value"), ("generator", "inertia"),
        ("frozen_wake", "wind", "values"), ("frozen_wake", "pitch", "values"),
    ):  # fmt: skip
        for kind, more, gains in (
            ("plant", {}, {}), ("turbine", {}, {}), ("turbine", {}, {"effectiveness_limit": 1}),
            ("turbine", {"torque_rate_limit": 1}, None),
        ):  # fmt: skip
            told = [
                model_content.beside_the_claims(
                    differing.Difference(path, *pair), content, model | more | {"kind": kind}, gains
                )
                for pair in values
            ]
            yield f"{path} {kind} {sorted(more)} {gains}", told
    for name in (
        *("a.csv", "a/b.csv", "../a", "/a", "", ".", "a\\b", "c:d", "a\nb", 1, None, "a/../b"),
    ):
        yield f"inside {name!r}", said(_inside, name)
    for cell in ("1", " 2.50", "word", "", "1e3", "nan"):
        yield f"cell {cell!r}", model_content._cell(cell)


def _inside(name: Any) -> str:
    return model_content.inside_folder(Path("/nowhere/model.toml"), name).as_posix()


def of_sizes() -> Named:
    """Yield how files are read that are no TOML, or too large."""
    for name, text in (
        ("deep", "a = " + "[" * 2000 + "]" * 2000),
        ("no TOML", "a = "),
        ("64 parts", ".".join(["a"] * 64) + " = 1"),
        ("65 parts", ".".join(["a"] * 65) + " = 1"),
        ("large", "#" * 4_000_000),
        ("larger", "#" * 4_000_001),
        ("BOM", "\ufeffa = 1.5"),
        ("number", "a = 1e9999999"),
    ):
        found = answer({}, {"file.toml": text}, lambda _, p: read_toml(p, Decimal, what="file"))
        yield name, str(found)[:200]
    yield "no file", said(read_toml, Path("/nowhere/at/all"), Decimal, what="file")
    yield "a folder", said(read_toml, Path("/"), Decimal, what="file")


def of_companions() -> Named:
    """Yield what is said of other kinds of models, and of certificates of earlier versions."""
    data, texts = certificate("cart"), texts_of("cart")
    for name, model in (
        ("no kind", {}),
        ("hashes", {"files_sha256": {"cart.toml": "0"}}),
        ("other files", {"files_sha256": {"a": "0", "b": "0", "c": "0", "d": "0"}}),
        ("no hashes", {"files_sha256": 1}),
        ("a text", "model"),
    ):
        yield name, answer({**data, "model": model}, texts)
    yield "no model", answer({"claims": []}, texts)
    earlier = {**data, "model": {k: v for k, v in data["model"].items() if k != "model_file"}}
    yield "earlier", answer(earlier, texts)
    for owner in ("provenance", "model"):
        import hashlib

        digest = hashlib.sha256(texts["cart.toml"].encode()).hexdigest()
        own = {**earlier[owner], "files_sha256": {"cart.toml": digest}}
        yield f"earlier, with its hash in {owner}", answer({**earlier, owner: own}, texts)
        own = {"files_sha256": {"cart.toml": digest}}
        if owner == "model":
            yield "by its hash", answer({**data, "model": own}, texts)
    room = certificate("room")
    yield "no blend claim", answer({**room, "claims": room["claims"][:1]}, texts_of("room"))
    for kinds in (("decay",), ("quadratic-decay", "decay", "no-common-quadratic"), ()):
        yield f"unconnected {kinds}", unconnected({"claims": [{"kind": k} for k in kinds]})


# ------------------------------------------------------------------ gain files


def documents() -> Iterator[tuple[str, Document]]:
    """Yield every recorded certificate with a controller."""
    for name in PLANTS:
        yield name, certificate(name)
    own = {
        "observer": {"l1": Number("2.5"), "wind_limits": [Number("1.5"), Number("37.5")]},
        "start": {"wind": [Number("3")], "integrals": [[Number("0")], [Number("1")]]},
        "certificate": {"verdict": "PROVED"},
        "name": "a law",
    }
    for cell in (*CELLS, "paper", "paper-two-integrators"):
        data = as_read(document(cell))
        yield cell, data | {"controller": own}
    data = as_read(document("torque"))
    data["gains"]["wind_filter"] = Number("0")
    yield "torque without a filter", data | {"controller": own}
    data = as_read(document("paper"))
    data["gains"]["coupling"]["speed_ramp_shape"] = "linear"
    data["gains"]["full"]["premises"]["d"] = [Number("1"), Number("1.0")]
    yield "paper, linear", data | {"controller": own}


def of_gain_files(name: str) -> Named:
    """Yield the whole gain file that follows from model and law, part by part."""
    data = dict(documents())[name]
    content = said(expected_file, data)
    if isinstance(content, str):
        yield "refused", content
        return
    for key, part in content.items():
        for number, entry in enumerate(part) if key == "programs" else [(0, part)]:
            yield f"{key} {number}", json.dumps(entry, ensure_ascii=True)


def told_of(about: Document, content: Any) -> Any:
    """Return what is said of a gain file with this content."""
    text = content if isinstance(content, str) else json.dumps(content)
    return answer(about, {"gains.json": text}, compare_gains)


def of_gain_members(name: str) -> Named:
    """Yield what is said of a gain file without one of its members, or with another."""
    data = dict(documents())[name]
    own = json.loads(json.dumps(expected_file(data)))
    for key in own:
        yield f"without {key}", told_of(data, {k: v for k, v in own.items() if k != key})
        yield f"{key} is 1", told_of(data, {**own, key: 1})


def of_gain_changes(name: str) -> Named:
    """Yield what is said of a gain file that differs, or of another certificate."""
    data = dict(documents())[name]
    own = json.loads(json.dumps(expected_file(data)))

    def told(content: Any, about: Document = data) -> Any:
        return told_of(about, content)

    yield "itself", told(own)
    yield "law alone", told({"law": own["law"]})
    yield "more", told({**own, "remark": "x", "note\n": 1})
    yield "much", told({**own, **{f"k{k}": k for k in range(1200)}})
    yield "no law", told({"format": "takagi-gains"})
    yield "no object", told("[]")
    law = {k: v for k, v in data.items() if k != "controller"}
    yield "without a controller", told(own, law)
    yield "its law alone", told({"law": own["law"]}, law)
    yield "another law", told({"law": {**own["law"], "name": "other"}}, law)
    earlier = {**data, "controller": {"version": Number("2"), "states": []}}
    yield "earlier", told({"format": "takagi-gains", "version": 2, "law": own["law"]}, earlier)
    yield "earlier, another", told({"version": 1, "law": own["law"]}, earlier)
    for what, broken in (
        ("no hashes", {**data, "provenance": {}}),
        ("no model", {**data, "model": {}}),
        ("model is a text", {**data, "model": "x"}),
        ("no premises", {**data, "gains": {"name": "pdc"}}),
        ("another name", {**data, "gains": {**data["gains"], "name": "paper"}}),
    ):
        yield what, told(own, broken)


def of_programs() -> Named:
    """Yield programs of other laws and models: no weights, measured premises, odd names."""
    data = certificate("cart")
    law, model, own = data["gains"], data["model"], data["controller"]

    def content(**changes: Any) -> str:
        parts = {"model": model, "law": law, "own": own, **changes}
        found = said(file_content, parts["model"], parts["law"], parts["own"])
        return found if isinstance(found, str) else json.dumps(found)

    yield "no premises", content(law={**law, "premises": []})
    flat = [{**p, "upper": p["lower"]} for p in law["premises"]]
    yield "flat premises", content(law={**law, "premises": flat})
    named = [{k: v for k, v in p.items() if k != "expression"} for p in law["premises"]]
    yield "measured premises", content(law={**law, "premises": named})
    with_signal = [{**law["premises"][0], "expression": "w + F + x"}, *law["premises"][1:]]
    yield "premises of signals", content(law={**law, "premises": with_signal})
    for key, symbol in (("disturbances", "dw"), ("states", "dx"), ("inputs", "dF")):
        listed = [{**v, "symbol": symbol} for v in model[key][:1]] + model[key][1:]
        premises = [{**law["premises"][0], "expression": f"{symbol} + x"}]
        changed = {**law, "premises": premises}
        yield f"symbols of {key}", content(model={**model, key: listed}, law=changed)
    free = [{**v, "range": None} for v in model["inputs"]]
    yield "free input", content(model={**model, "inputs": free})
    taken = {**model["parameters"], "rules": Number("1"), "x_rest": Number("2")}
    yield "taken names", content(model={**model, "parameters": taken})
    matrices = {"state_names": ["a [m]", "b"], "input_names": ["u [N]"]}
    two = {**law, **matrices}
    yield "no plant", content(model=matrices, law=two, own={**own, "states": [], "inputs": []})
    room = certificate("room")
    for side, other in (("low", Number("1")), ("high", Number("-1"))):
        blending = deepcopy(room["gains"]["blending"])
        blending[side]["direction"] = other
        blending[side]["range"] = None
        turned = {**room["gains"], "blending": blending}
        yield f"{side} turned", content(model=room["model"], law=turned, own=room["controller"])
    blending = deepcopy(room["gains"]["blending"])
    blending["low"]["error"] = blending["high"]["error"] = None
    turned = {**room["gains"], "blending": blending}
    yield "no errors", content(model=room["model"], law=turned, own=room["controller"])
    for value in (Number("1.5"), "sqrt(2)", 0.1, 3, "2/3"):
        yield f"number {value!r}", (exact(value), short(exact(value)))


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    found: dict[str, Any] = {
        "tables": of_tables, "coefficient tables": of_coefficient_tables,
        "units": of_units, "figures": of_figures,
        "differences": of_differences, "beside the claims": of_owners, "sizes": of_sizes,
        "companions": of_companions, "programs": of_programs,
    }  # fmt: skip
    for name in (*PLANTS, *TURBINES):
        found[f"content of {name}"] = lambda name=name: of_contents(name)
        for first in range(4):
            found[f"{name} replaced, {first}"] = lambda n=name, f=first: of_replaced(n, f)
            if name != "factor":
                found[f"certificate of {name}, {first}"] = lambda n=name, f=first: of_certificate(
                    n, f
                )
        if name == "factor":
            continue
        for file, text in texts_of(name).items():
            if file == "pull.csv":
                continue
            step = -(-sum(1 for _ in rewrites(text)) // TOGETHER)
            for first in range(step):
                found[f"{name}, {file}, {first}"] = lambda n=name, file=file, f=first, s=step: (
                    of_rewrites(n, file, f, s)
                )
    for name, _ in documents():
        found[f"gain file, {name}"] = lambda name=name: of_gain_files(name)
    for name in ("step", "torque"):
        found[f"gain file of {name} changed"] = lambda name=name: of_gain_changes(name)
    for name in ("step", "room"):
        found[f"members of {name}"] = lambda name=name: of_gain_members(name)
    return found
