"""The gain file of a plant: within its schema, the certificate's law, every gain with its unit."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from pydantic import ValidationError

from takagi.certificates.checker import check
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.models import Interval, Plant, Variable
from takagi.reports.gains_file.envelope import dump_gains
from takagi.reports.gains_file.plant import PlantGainFile, plant_gain_file, plant_gain_file_schema
from takagi.reports.simulation.plant import simulate_plant, simulation_data
from tests.reports.plant_designs import design_of

X, V, F = sp.symbols("x v F", real=True)


def cart() -> Plant:
    """A cart on a hardening spring; half-lives in seconds."""
    return Plant(
        equations=(V, -X - X**3 + F),
        states=(
            Variable(X, "m", Interval.of(-1, 1), description="place"),
            Variable(V, "m/s", Interval.of(-2, 2), description="speed"),
        ),
        inputs=(Variable(F, "N", description="force"),),
        name="cart",
    )


@pytest.fixture(scope="module")
def design() -> PlantDesign:
    found = design_plant(cart())
    assert isinstance(found, PlantDesign)
    return found


def test_law_is_the_certificates(design: PlantDesign, tmp_path: Path) -> None:
    """The very object that is proved, and the checker takes the pair."""
    content = plant_gain_file(design)
    certificate, gains = tmp_path / "c.json", tmp_path / "g.json"
    certificate.write_text(dumps(design.document), encoding="utf-8")
    gains.write_text(dump_gains(content), encoding="utf-8")

    assert content["law"] == design.document["gains"]
    assert check(certificate, gains=gains).verdict is design.verdict


def test_schema_round_trip(design: PlantDesign) -> None:
    """What is written is read back by the schema; an unknown member is refused."""
    written = json.loads(dump_gains(plant_gain_file(design)))

    assert PlantGainFile.model_validate(written).model_dump(mode="json") == written
    with pytest.raises(ValidationError):
        PlantGainFile.model_validate(written | {"more": 1})
    assert plant_gain_file_schema()["title"] == "takagi gain file of a plant"


def test_every_gain_has_its_unit(design: PlantDesign) -> None:
    """Force per place and per speed."""
    units = plant_gain_file(design)["units"]

    assert units["K, F per x"] == "N/m" and units["K, F per v"] == "N/(m/s)"


def test_an_analysis_has_no_gain_file() -> None:
    """A plant without inputs."""
    plant = Plant(equations=(-X,), states=(Variable(X, "m"),), name="still")
    found = design_plant(plant)
    assert isinstance(found, PlantDesign)

    with pytest.raises(ValueError, match="no gains to write"):
        plant_gain_file(found)


def test_motions_from_the_proved_set_stay_in_the_box(design: PlantDesign) -> None:
    """Corners drawn in: none leaves, all settle; a start of one's own is where it was put."""
    data = simulation_data(simulate_plant(design))

    assert 0 < data["scale"] < 1 and len(data["runs"]) == 4
    assert not any(run["left_the_box"] or run["diverged"] for run in data["runs"])
    (run,) = simulation_data(simulate_plant(design, starts=[{"x": 0.25}], duration=1.0))["runs"]
    assert run["start"] == {"x": 0.25, "v": 0.0} and run["duration"] == 1.0


def test_the_largest_command_is_that_of_the_law(design: PlantDesign) -> None:
    """At the start it is -K(h) x with the law's own memberships; later ones are smaller here."""
    assert design.law is not None
    start = np.array([0.5, 0.0])
    (run,) = simulation_data(simulate_plant(design, starts=[{"x": 0.5}]))["runs"]

    first = abs(float(design.law.command(start)[0]))
    assert run["largest_input"]["F"] >= first * (1 - 1e-9)


@pytest.mark.slow
def test_order_in_the_file_does_not_depend_on_the_hash_seed(tmp_path: Path) -> None:
    """Names of a blend's parameters were taken from a set: two runs wrote two files."""
    certificate = tmp_path / "c.json"
    certificate.write_text(dumps(design_of("split_range").document), encoding="utf-8")
    program = (
        "import json, sys; "
        "from takagi.certificates.checker.files.gain_file import expected_file; "
        "print(json.dumps(expected_file(json.load(open(sys.argv[1])))))"
    )

    written = {
        subprocess.run(
            [sys.executable, "-c", program, str(certificate)],
            env={**os.environ, "PYTHONHASHSEED": seed},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for seed in ("0", "1", "2", "3")
    }

    assert len(written) == 1
