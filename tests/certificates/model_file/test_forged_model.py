"""With --model the plant in a certificate is the turbine file's, number by number."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, check, read_text
from takagi.certificates.checker.files.turbine_file import compare_turbine
from takagi.certificates.document.certificate_file import content_of
from takagi.models.turbine.loader import model_files
from tests.certificates.kinds.claims import resealed

Document = dict[str, Any]
TURBINE = next(file for file in model_files("nrel5mw") if file.suffix == ".toml")


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
