"""`check --model` compares what a turbine file and its tables say."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline, insert
from scipy.linalg import null_space

from takagi.certificates.checker import CertificateError, check, read_text
from takagi.certificates.checker.files import model_content, turbine_file
from takagi.certificates.checker.files.given_files import EARLIER, compare_model
from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.files.turbine_file import compare_turbine
from takagi.certificates.checker.kernel import reader
from takagi.certificates.document.certificate_file import content_of
from takagi.models.laws.effort_sharing.schedule import frozen_wake_effectiveness
from takagi.models.turbine.loader import load_turbine, model_files
from tests.certificates.kinds.claims import resealed
from tests.certificates.model_file.rewrites import Rewrite, all_of, replaced, reversed_sections

Document = dict[str, Any]
TURBINE = model_files("nrel5mw")[0]


@pytest.fixture
def rotor(short: Document) -> Document:
    short["model"] |= content_of(model_files("nrel5mw"))
    return read_text(json.dumps(short), "certificate")


@pytest.fixture
def turbine(tmp_path: Path) -> Callable[[Rewrite], Path]:
    def write(rewrite: Rewrite) -> Path:
        for file in model_files("nrel5mw"):
            (tmp_path / file.name).write_bytes(file.read_bytes())
        path = tmp_path / TURBINE.name
        path.write_bytes(rewrite(TURBINE.read_text(encoding="utf-8")).encode())
        return path

    return write


# The table's 936 entries take a second: cases share a file where all of its differences are told.
TURBINES: dict[str, tuple[Rewrite, tuple[str, ...]]] = {
    "layout": (
        all_of(
            reversed_sections,
            replaced("63.0,", "63.00,"),
            replaced("12.1, unit", "121e-1, unit"),
            replaced("OpenFAST 5-MW deck", "a deck"),
            lambda text: "\ufeff# mine\n" + text.replace("\n", "\r\n"),
        ),
        (),
    ),
    "radius": (replaced("63.0,", "63.1,"), ("rotor.radius.value is 63.1 there, 63 in",)),
    "unit": (replaced('unit = "rpm"', 'unit = "furlong"'), ("unit is furlong there, rpm in",)),
    "rate": (replaced("15000.0", "14000.0"), ("rate_limit.value is 14000 there, 15000 in",)),
    "wake": (replaced("-28.24", "-28.25"), ("sensitivity.values[0] is -28.25 there, -28.24 in",)),
    "no rotor": (replaced("[rotor]", "[other]"), ("rotor.radius is missing",)),
    "beside the loop": (
        all_of(
            replaced("value = 90.0", "value = 91.0"),
            replaced('radius = { value = 63.0, unit = "m"', 'radius = { value = 63.0, unit = "s"'),
            replaced("4.3675e5", "4.4e5"),
        ),
        (
            "rotor.hub_height.value is 91 there, 90 in",
            "tower.mass.value is 440000 there, 436750 in",
            "rotor.radius.unit is s there, m in",
        ),
    ),
    "beside the law": (
        all_of(
            replaced("43093.55", "50000"),
            replaced("0.01882681", "0.02"),
            replaced("nrel5mw_ct.csv", "nrel5mw_cp.csv"),
        ),
        (
            "generator.rated_torque.value is 50000 there, 43093.55 in",
            "baseline.proportional_gain.value is 0.02 there, 0.01882681 in",
            "coefficients.thrust is numbers with SHA-256",
        ),
    ),
}


@pytest.mark.parametrize("what", TURBINES)
def test_a_turbine_file_by_content(
    what: str, rotor: Document, turbine: Callable[[Rewrite], Path]
) -> None:
    rewrite, words = TURBINES[what]
    path = turbine(rewrite)

    if not words:
        assert compare_model(rotor, path.rename(path.with_name("mine.txt"))) == ""
        return
    with pytest.raises(OtherModel) as refused:
        compare_model(rotor, path)
    assert all(word in str(refused.value) for word in words)


def test_other_entries_of_a_turbines_tables(
    rotor: Document, turbine: Callable[[Rewrite], Path]
) -> None:
    """Power by entry, thrust, of which no claim speaks, by all of its numbers."""
    for name, words in (("cp", "c_P at tip-speed ratio 2"), ("ct", "coefficients.thrust")):
        path = turbine(lambda text: text)
        table = path.with_name(f"nrel5mw_{name}.csv")
        lines = table.read_text(encoding="utf-8").splitlines()
        k = next(k for k, line in enumerate(lines) if line.startswith("2"))
        first, _, rest = lines[k].split(",", 2)
        table.write_text("\n".join([*lines[:k], f"{first},0.09,{rest}", *lines[k + 1 :]]))
        with pytest.raises(OtherModel, match=words):
            compare_model(rotor, path)


def test_certificates_from_before_are_read(
    short: Document, turbine: Callable[[Rewrite], Path]
) -> None:
    """They hold the hashes of bytes alone: only what the claims are about is compared, and told."""
    short["model"]["files_sha256"] = {
        file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in model_files("nrel5mw")
    }
    read = read_text(json.dumps(short), "certificate")

    assert compare_model(read, TURBINE) == ""
    assert EARLIER in compare_model(read, turbine(lambda text: text + "# mine\n"))
    assert EARLIER in compare_model(read, turbine(replaced("4.3675e5", "4.4e5")))
    with pytest.raises(OtherModel, match=r"rotor_radius is 63.1 there, 63 in the certificate"):
        compare_model(read, turbine(replaced("63.0,", "63.1,")))


def test_a_model_with_a_mark_of_byte_order_is_loaded(
    turbine: Callable[[Rewrite], Path],
) -> None:
    """As editors of some systems write it."""
    assert load_turbine(turbine(lambda text: "\ufeff" + text)).name == "NREL 5-MW"


def test_a_surface_with_more_knots_than_the_table_gives_is_another(
    rotor: Document, turbine: Callable[[Rewrite], Path]
) -> None:
    """It goes through every entry, and falls and rises again between two of them.

    Of the turbine of the file, with one rest at 15 m/s, the second checker proved several.
    """
    path, surface = turbine(lambda text: text), rotor["model"]["torque_surface"]
    assert compare_model(rotor, path) == ""
    knots = np.array(surface["pitch_knots"], dtype=float)
    rows = np.array(surface["coefficients"], dtype=float)
    entries = np.unique([*knots, *np.radians([-4, 29])])
    one_more = float(np.radians(10.45))
    more = np.sort(np.append(knots, one_more))
    (none,) = null_space(BSpline.design_matrix(entries, more, 3).toarray()).T
    wave = none / np.abs(BSpline(more, none, 3)(np.linspace(knots[0], knots[-1], 4000))).max()
    wider = np.array([insert(one_more, (knots, row, 3))[1][: len(more) - 4] for row in rows])
    wider[4:9] += 0.03 * wave
    surface["pitch_knots"] = [*surface["pitch_knots"], reader.Number(repr(one_more))]
    surface["pitch_knots"].sort(key=float)
    surface["coefficients"] = [[reader.Number(f"{c:.15f}") for c in row] for row in wider]
    with pytest.raises(OtherModel, match="entries in pitch are not those of the certificate's"):
        compare_model(rotor, path)


@pytest.mark.parametrize("names", ["tip-speed ratio", "pitch"])
def test_a_table_with_fewer_entries_is_another(
    names: str, rotor: Document, turbine: Callable[[Rewrite], Path]
) -> None:
    """Also where the certificate says that it is of this file: they have another spline."""
    path = turbine(lambda text: text)
    table = path.with_name("nrel5mw_cp.csv")
    lines = table.read_text(encoding="utf-8").splitlines()
    if names == "pitch":
        lines = [line if line[0] == "#" else line.rpartition(",")[0] for line in lines]
    table.write_text("\n".join(lines if names == "pitch" else lines[:-1]), encoding="utf-8")
    rotor["model"]["model_file"] = model_content.model_content(path)
    with pytest.raises(OtherModel, match=f"entries in {names} are not those"):
        compare_model(rotor, path)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (["t,0,1", "2,0.1,0.2", "2,0.1,0.2"], "must increase|stands twice"),
        (["t,1,0", "2,0.1,0.2"], "must increase"),
        (["t,0,1"], "not a coefficient table|stands twice"),
    ],
)
def test_a_table_that_is_none_is_refused(
    rows: list[str], words: str, rotor: Document, turbine: Callable[[Rewrite], Path]
) -> None:
    path = turbine(lambda text: text)
    path.with_name("nrel5mw_cp.csv").write_text("\n".join(rows), encoding="utf-8")
    with pytest.raises(CertificateError, match=words):
        compare_model(rotor, path)


@pytest.mark.parametrize(
    ("winds", "below"), [((11.4, 12.0, 13.0), False), ((11.4, 12.15, 13.0), False),
                         ((11.4, 12.17, 13.0), True), ((11.4, 13.0), True),
                         ((10.0, 11.4, 13.0), True)]
)  # fmt: skip
def test_the_wake_between_the_winds_of_a_law(
    winds: tuple[float, ...], below: bool, rotor: Document
) -> None:
    """At 12 m/s a line from 11.4 m/s to 12.15 is 4.9 % below the file's column, to 12.17 5.4 %."""
    machine = load_turbine(TURBINE)
    limits = [f"{frozen_wake_effectiveness(machine, v):.7f}" for v in winds]
    law = {
        "rated_torque": rotor["gains"]["rated_torque"],
        "wind": [reader.Number(repr(v)) for v in winds],
        "effectiveness_limit": [*map(reader.Number, limits)],
    }
    if not below:
        assert turbine_file.compare_turbine(rotor["model"], law, TURBINE) == ""
        return
    with pytest.raises(OtherModel, match="pitch effectiveness at 12 m/s"):
        turbine_file.compare_turbine(rotor["model"], law, TURBINE)


@pytest.mark.parametrize("wind", ["3", "4", "4.5", "6", "7.9", "8", "9"])
def test_a_column_is_linear_between_its_winds_and_constant_beyond(wind: str) -> None:
    winds, values = [4, 6, 8], [1, -3, 5]
    columns = [list(map(Fraction, column)) for column in (winds, values)]

    found = turbine_file._between(Fraction(wind), *columns)
    assert float(found) == pytest.approx(np.interp(float(wind), winds, values), abs=1e-12)


@pytest.mark.parametrize("off", ["-1e-13", "0", "1e-13"])
def test_an_entry_at_an_edge_of_the_table_lies_inside(off: str) -> None:
    """Knots are rounded: the entry they were made from may lie beyond them by 1e-12."""
    breaks = list(map(Fraction, (3, 4, 5)))
    low, high = (turbine_file._held(end + Fraction(off), breaks) for end in (breaks[0], breaks[-1]))

    assert breaks[0] < low < breaks[0] + Fraction("1e-15")
    assert breaks[-1] - Fraction("1e-15") < high < breaks[-1]
    for inside in ("3.0000001", "4", "4.9999999"):
        assert turbine_file._held(Fraction(inside), breaks) == Fraction(inside)


def compared(document: Document, path: Path = TURBINE) -> None:
    read = read_text(json.dumps(document), "document")
    compare_turbine(read["model"], read["gains"], path)


def test_the_certificates_plant_is_the_files(short: Document) -> None:
    """Figures, torque constant, 936 table entries and frozen wake: all found again."""
    compared(short)


def first_coefficient(document: Document) -> None:
    document["model"]["torque_surface"]["coefficients"][10][12] += 1e-6


def wake(document: Document) -> None:
    document["gains"]["effectiveness_limit"][2] -= 3e-6


FORGERIES: dict[str, Callable[[Document], None]] = {
    "rotor_radius": lambda d: d["model"].update(rotor_radius=63.0001),
    "inertia": lambda d: d["model"].update(rotor_inertia=38759229.0),
    "generator": lambda d: d["model"].update(generator_inertia=534.117),
    "gear_ratio": lambda d: d["model"].update(gear_ratio=97.001),
    "torque_constant": lambda d: d["model"].update(torque_constant=153084.0),
    "rated_rotor_speed": lambda d: d["model"].update(rated_rotor_speed=1.2672),
    "pitch_rate_limit": lambda d: d["model"].update(pitch_rate_limit=0.14),
    "pitch_time_constant": lambda d: d["model"].update(pitch_time_constant=0.19),
    "pitch_max": lambda d: d["model"].update(pitch_max=1.6),
    "rated_torque": lambda d: d["gains"].update(rated_torque=43093.56),
    "c_P at": first_coefficient,
    "frozen wake": wake,
}


@pytest.mark.parametrize("what", FORGERIES)
def test_a_plant_that_is_not_the_files_is_refused(what: str, short: Document) -> None:
    """One number changed, and the message says which: hashes would not have shown it."""
    FORGERIES[what](short)

    with pytest.raises(CertificateError, match=what):
        compared(short)


def test_matching_hashes_do_not_help_a_forger(whole: Document, tmp_path: Path) -> None:
    """A lighter rotor beside the true content of the file is refused with --model alone."""
    whole["model"]["rotor_inertia"] *= 0.9999
    whole["model"] |= content_of(model_files("nrel5mw"))
    forged = tmp_path / "certificate.json"
    forged.write_text(json.dumps(resealed(whole)), encoding="utf-8")

    check(forged)
    with pytest.raises(CertificateError, match="rotor_inertia"):
        check(forged, model=TURBINE)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[rotor]", "[other]"), "rotor.radius is missing"),
        (('unit = "rpm"', 'unit = "furlong"'), "not one the checker converts"),
        (("nrel5mw_cp.csv", "../nrel5mw_cp.csv"), "beside the file"),
        (("[frozen_wake]", "[other_wake]"), "pitch effectiveness at 11.25"),
        (("[rotor]", "[rotor"), "not a turbine file"),
    ],
)
def test_a_damaged_turbine_file_is_refused(
    change: tuple[str, str], message: str, short: Document, tmp_path: Path
) -> None:
    """Each defect is named; nothing is a traceback."""
    for file in model_files("nrel5mw"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    path = tmp_path / TURBINE.name
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")

    with pytest.raises(CertificateError, match=message):
        compared(short, path)


def test_a_damaged_table_is_refused(short: Document, tmp_path: Path) -> None:
    for file in model_files("nrel5mw"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    table, path = tmp_path / "nrel5mw_cp.csv", tmp_path / TURBINE.name
    good = table.read_text(encoding="utf-8")

    for bad in (good.rsplit(",", 1)[0], good.replace("2,0.006673", "2,power"), ""):
        table.write_text(bad, encoding="utf-8")
        with pytest.raises(CertificateError, match="nrel5mw_cp.csv"):
            compared(short, path)
    table.unlink()
    with pytest.raises(CertificateError, match="cannot be read"):
        compared(short, path)
