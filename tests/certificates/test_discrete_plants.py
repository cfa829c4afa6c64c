"""Plants in discrete time and one of twelve states, from their files to their motions."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from takagi.certificates import CertificateError
from takagi.certificates.checker import check
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.models import ModelError, Plant, load_model, sector_model
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


Floats = NDArray[np.float64]


def cart_chain(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Newton's law for six carts of 1 kg: springs of 10 N/m, dampers of 0.5 N s/m."""
    place, speed = x[0::2], x[1::2]
    springs = [-10 * place[0] * (1 + 2 * place[0] ** 2) - 0.5 * speed[0]]
    springs += [10 * (place[k] - place[k + 1]) + 0.5 * (speed[k] - speed[k + 1]) for k in range(5)]
    forces = [springs[k] - (springs[k + 1] if k < 5 else -u[0]) for k in range(6)]
    return [value for pair in zip(speed, forces, strict=True) for value in pair]


def test_the_model_is_the_chain_by_newton() -> None:
    """At random points of the box, with equations that are written again."""
    plant = load_model("cart_chain")
    assert isinstance(plant, Plant)
    model, draw = sector_model(plant), np.random.default_rng(2)
    (premise,) = model.premises
    assert float(premise.lower) == pytest.approx(0, abs=2e-3)
    assert float(premise.upper) == pytest.approx(1, abs=2e-3)
    for _ in range(20):
        x, u = draw.uniform(-1, 1, 12) * np.array([1.0, 2.0] * 6), draw.uniform(-10, 10, 1)
        now = model.blend([x[0] ** 2])
        expected = cart_chain(x, u, np.zeros(0))
        np.testing.assert_allclose(now.A @ x + now.B @ u, expected, atol=1e-9)


@pytest.mark.slow
def test_the_chain_of_six_carts_is_proved_and_settles() -> None:
    """And by equations that are written again, from the edge of the set."""
    plant = load_model("cart_chain")
    assert isinstance(plant, Plant)
    design = design_plant(plant)
    assert isinstance(design, PlantDesign)

    assert design.proved
    assert len(plant.states) == 12

    claim = next(c for c in design.document["claims"] if c["kind"] == "input-limits")
    P = np.array(claim["P"], dtype=float)
    inverse, law = np.linalg.inv(P), design.law
    assert law is not None
    start = np.sqrt(0.99 * claim["level"]) * inverse[0] / np.sqrt(inverse[0, 0])

    def slope(_: float, x: Floats) -> list[float]:
        u = law.command(x)
        assert abs(u[0]) <= 10
        return cart_chain(x, np.asarray(u), np.zeros(0))

    found = solve_ivp(slope, (0, 60), start, rtol=1e-7, atol=1e-9)
    assert np.abs(found.y[:, -1]).max() < 0.02 * np.abs(start).max()
    half = np.array([1.0, 2.0] * 6)
    assert np.all(np.abs(found.y).max(axis=1) <= half)
