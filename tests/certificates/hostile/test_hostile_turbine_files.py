"""Turbine files made to harm: `takagi check --model` refuses them, and says which number it was."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, read_text
from takagi.certificates.checker.files.turbine_file import compare_turbine
from takagi.certificates.checker.kernel import reader
from takagi.certificates.document.certificate_file import dumps, turbine_data
from takagi.models import nrel5mw
from takagi.models.turbine.loader import model_files


@pytest.fixture(scope="module")
def model() -> Any:
    return read_text(dumps({"model": turbine_data(nrel5mw(), [])}), "test")["model"]


@pytest.fixture
def files(tmp_path: Path) -> Path:
    for file in model_files("nrel5mw"):
        shutil.copy(file, tmp_path / file.name)
    return tmp_path / "nrel5mw.toml"


def refusal(model: Any, file: Path) -> str:
    with pytest.raises(CertificateError) as caught:
        compare_turbine(model, {}, file)
    assert len(str(caught.value)) < 500
    return str(caught.value)


def edited(file: Path, section: str, key: str, value: str) -> None:
    lines, inside = [], ""
    for line in file.read_text(encoding="utf-8").splitlines():
        inside = line.strip(" []") if line.startswith("[") else inside
        if inside == section and line.replace(" ", "").startswith(f"{key}="):
            line = f'{key} = {{ value = {value}, unit = "m" }}'
        lines.append(line)
    file.write_text("\n".join(lines), encoding="utf-8")


@pytest.mark.parametrize(
    ("section", "why"),
    [
        ("coefficients", "coefficients.power must name a table beside the file"),
        ("frozen_wake", "frozen_wake.wind is missing"),
    ],
)
def test_a_number_in_the_place_of_a_section(
    model: Any, files: Path, section: str, why: str
) -> None:
    """The law's torque is below rated, which is allowed, so that the section is reached."""
    lines, inside = [f"{section} = 1"], ""
    for line in files.read_text(encoding="utf-8").splitlines():
        inside = line.strip(" []").split(".")[0] if line.startswith("[") else inside
        if inside != section:
            lines.append(line)
    files.write_text("\n".join(lines), encoding="utf-8")

    with pytest.raises(CertificateError, match=why):
        compare_turbine(
            model, {"rated_torque": reader.Number("1"), "effectiveness_limit": []}, files
        )


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("1e999999999", "beyond 1e40"),
        ("1e-999999999", "beyond 1e40"),
        ("1e41", "beyond 1e40"),
        ("1" + "0" * 4000, "numbers go to 1e40"),
        ("1" + "0" * 10**6, "not a turbine file"),
        ("0." + "1" * 10**6, "digits"),
        ("inf", "beyond 1e40"),
        ("nan", "beyond 1e40"),
        ("true", "a number is needed"),
        ("[1]", "a number is needed"),
        ("64", "rotor_radius is 64 there, 63 in the certificate"),
        ("0", "rotor_radius is 0 there"),
    ],
)
def test_a_figure(model: Any, files: Path, value: str, why: str) -> None:
    edited(files, "rotor", "radius", value)

    assert why in refusal(model, files)


@pytest.mark.parametrize(
    "cell", ["1e999999999", "-1e-999999999", "1/0", "nan", "1" * 10**5, "", "x"]
)
def test_a_cell_of_the_table(model: Any, files: Path, cell: str) -> None:
    """An exponent in a table must not be written out either."""
    model = {**model}
    table = next(file for file in files.parent.iterdir() if file.name.endswith("cp.csv"))
    rows = table.read_text(encoding="utf-8").splitlines()
    last = rows[-1].split(",")
    table.write_text("\n".join([*rows[:-1], ",".join([*last[:-1], cell])]), encoding="utf-8")

    with pytest.raises(CertificateError):
        compare_turbine(model, rated(files), files)


def rated(file: Path) -> Any:
    import tomllib

    entry = tomllib.loads(file.read_text(encoding="utf-8"))["generator"]["rated_torque"]
    scale = 1000 if entry["unit"] == "kN m" else 1
    written = dumps({"gains": {"rated_torque": entry["value"] * scale}})
    return read_text(written, "test")["gains"]


def test_the_files_they_are_made_from_pass(model: Any, files: Path) -> None:
    """What is refused above is refused for the number that was put in."""
    compare_turbine(model, rated(files), files)


@pytest.mark.parametrize("target", ["/dev/zero", "folder"])
def test_a_table_that_is_no_file(model: Any, files: Path, target: str) -> None:
    table = next(file for file in files.parent.iterdir() if file.name.endswith("cp.csv"))
    table.unlink()
    (files.parent / "folder").mkdir()
    table.symlink_to(target)

    with pytest.raises(CertificateError, match="not a file|out of the model's folder"):
        compare_turbine(model, rated(files), files)


@pytest.mark.parametrize(
    "text",
    [
        "a" + ".a" * 10**6 + " = 1",
        "[a" + " . a" * 10**6 + "]",
        "b = {a" + ".a" * 10**6 + " = 1}",
        '"a"' + '."a"' * 10**6 + " = 1",
        "a = " + "[" * 10**6,
        "a = " + "{a=" * 10**6,
        "a" * 3_900_000,
        "a." * 1_900_000,
        "#" * 5_000_000,
        "a = 1\na = 2",
        "\x00",
    ],
    ids=lambda text: text[:12],
)
def test_a_file_that_takes_long_to_parse(model: Any, files: Path, text: str) -> None:
    """The standard library's reader would take hours for some of them."""
    files.write_text(text, encoding="utf-8")

    refusal(model, files)
