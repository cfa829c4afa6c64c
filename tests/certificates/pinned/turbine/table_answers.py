"""What is said of tables, units and figures of files."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

from takagi.certificates.checker.files import (
    file_blend,
    turbine_file,
)
from takagi.certificates.checker.files.plant_units import in_si
from takagi.certificates.checker.files.table_file import compare_table
from takagi.certificates.checker.plant.table import read_table
from tests.certificates.pinned.turbine.recorded_files import (
    answer,
    certificate,
    texts_of,
)
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


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
            ("\n0, 0.1\n1, 0.2\n2, 0.5", ""), ("\n1, 0.2", "\n" + 200_001 * "1,"),
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


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    return {
        "tables": of_tables,
        "coefficient tables": of_coefficient_tables,
        "units": of_units,
        "figures": of_figures,
    }
