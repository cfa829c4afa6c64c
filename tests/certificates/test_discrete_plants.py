"""Plants in discrete time from their files: sample times with units, designs, and their motions."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import check
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.models import ModelError
from takagi.models.files.library import data_folder
from takagi.models.plant_files.loader import PlantFile
from takagi.reports.simulation.plant import simulate_plant, simulation_data

FILE = data_folder() / "henon.toml"


def designed(path: Path) -> PlantDesign:
    source = PlantFile.of(path)
    found = design_plant(source.model, source.settings, files=source.files)
    assert isinstance(found, PlantDesign), found
    return found


def iterated(x: Any, u: float) -> Any:
    file = tomllib.loads(FILE.read_text(encoding="utf-8"))
    a, b = (file["parameters"][name]["value"] for name in "ab")
    return np.array([1 - a * x[0] ** 2 + x[1] + u, b * x[0]])


REST, HELD = np.array([0.6, 0.18]), -0.076


def test_starts_at_the_edge_of_the_proved_set_settle_in_another_simulation() -> None:
    """The map by hand, the law from the certificate's numbers."""
    document = designed(FILE).document
    law = document["gains"]
    K = np.array(law["K"], dtype=float)
    (premise,) = law["premises"]
    assert premise["expression"].replace(" ", "") == "delta_x"
    low, high = float(premise["lower"]), float(premise["upper"])
    claim = next(c for c in document["claims"] if c["kind"] == "input-limits")
    P, level = np.array(claim["P"], dtype=float), float(claim["level"])

    sizes, axes = np.linalg.eigh(P)
    for size, axis in zip(sizes, axes.T, strict=True):
        for sign in (1, -1):
            x = REST + sign * 0.999 * np.sqrt(level / size) * axis
            value = level
            for _ in range(40):
                d = x - REST
                assert d @ P @ d <= value + 1e-12
                value = float(d @ P @ d)
                h = (d[0] - low) / (high - low)
                u = HELD - float(((1 - h) * K[0] + h * K[1])[0] @ d)
                assert -1 <= u <= 1 and -0.4 <= x[0] <= 1.6 and -0.4 <= x[1] <= 0.8
                x = iterated(x, u)
            assert x == pytest.approx(REST, abs=1e-6)


def test_certificate_and_file_agree(tmp_path: Path) -> None:
    found = designed(FILE)
    path = tmp_path / "certificate.json"
    path.write_text(dumps(found.document), encoding="utf-8")

    assert found.proved
    assert check(path, model=FILE).verdict.name == "PROVED"
    other = tmp_path / "henon.toml"
    other.write_text(FILE.read_text(encoding="utf-8").replace('"1 s"', '"2 s"'), encoding="utf-8")
    with pytest.raises(CertificateError, match="sample_time"):
        check(path, model=other)


@pytest.mark.parametrize(
    ("written", "seconds"),
    [('"10 ms"', 0.01), ('"2 min"', 120.0), ("0.5", 0.5), ('"0.25"', 0.25), ("3", 3.0)],
)
def test_a_sample_time_has_a_unit(tmp_path: Path, written: str, seconds: float) -> None:
    path = tmp_path / "map.toml"
    path.write_text(FILE.read_text(encoding="utf-8").replace('"1 s"', written), encoding="utf-8")

    assert PlantFile.of(path).model.sample_time == seconds


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ('"10 m"', "no unit of time"),
        ('"-1 s"', "a time above 0"),
        ("0", "a time above 0"),
        ('"soon"', "a time above 0"),
        ("true", "number"),
        ("[1]", "number"),
        ('"1 Hz"', "Hz"),
    ],
)
def test_a_wrong_sample_time_is_refused_with_its_place(
    tmp_path: Path, written: str, words: str
) -> None:
    path = tmp_path / "map.toml"
    path.write_text(FILE.read_text(encoding="utf-8").replace('"1 s"', written), encoding="utf-8")

    with pytest.raises(ModelError, match=words) as error:
        PlantFile.of(path).model  # noqa: B018

    assert "sample_time" in str(error.value)


def test_output_feedback_in_discrete_time(tmp_path: Path) -> None:
    """x alone is measured: the premise is, and y comes from the observer."""
    path = tmp_path / "map.toml"
    text = FILE.read_text(encoding="utf-8")
    path.write_text(text.replace("sample_time", 'measured = ["x"]\nsample_time'), encoding="utf-8")
    found = designed(path)

    assert found.proved and found.output_law is not None and not found.output_law.at_estimate
    certificate = tmp_path / "certificate.json"
    certificate.write_text(dumps(found.document), encoding="utf-8")
    assert check(certificate, model=path).verdict.name == "PROVED"
    runs = simulation_data(simulate_plant(found))["runs"]
    assert all(run["settled_after"] is not None and not run["left_the_box"] for run in runs)
    other = tmp_path / "other.toml"
    other.write_text(text.replace("sample_time", 'measured = ["y"]\nsample_time'), encoding="utf-8")
    with pytest.raises(CertificateError, match="outputs"):
        check(certificate, model=other)
