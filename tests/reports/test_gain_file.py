"""The gain file: the certificate's law number by number, within its schema, the same every time."""

from __future__ import annotations

import copy
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from pydantic import ValidationError

from takagi.certificates import TurbineDesign
from takagi.certificates.checker import check
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.turbine.effort_sharing_gains import EffortSharingGainDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.lmi.turbine.one_step.design import OneStepDesign, ReachedValues
from takagi.lmi.turbine.one_step.loop_of_gains import LoopFunctions
from takagi.models import Interval, Plant, Variable
from takagi.models.turbine.trim import trim
from takagi.reports.gains_file.envelope import (
    GainFile,
    PlantGainFile,
    dump_gains,
    gain_file,
    gain_file_schema,
    plant_gain_file,
    plant_gain_file_schema,
)
from takagi.reports.loops.plant_claims import synthesis_words
from takagi.reports.simulation.plant import simulate_plant, simulation_data
from tests.reports.plant_designs import design_of


def test_schema_round_trip(turbine_design: TurbineDesign) -> None:
    written = json.loads(dump_gains(gain_file(turbine_design)))

    read = GainFile.model_validate(written)

    assert read.model_dump(mode="json", exclude_unset=True) == written


def test_every_number_of_the_law_has_a_unit(turbine_design: TurbineDesign) -> None:
    content = gain_file(turbine_design)

    columns = {f"law.{name}" for name in content["law"] if name != "name"}

    assert columns <= set(content["units"])


def test_one_sample_is_written_out(turbine_design: TurbineDesign) -> None:
    """Filter and integral: in words, beside the programs of ``test_gain_file_alone``."""
    content = gain_file(turbine_design)
    execution = content["execution"]

    parts = {"every", "rates", "schedule wind", "integral", "measured speed"}
    assert set(execution) == parts
    assert "v_hat + (v_s - v_hat) exp(-T / wind_filter)" in execution["schedule wind"]
    assert "x - T integral_rate e" in execution["integral"]


def test_trim_table_is_the_turbines(turbine_design: TurbineDesign) -> None:
    table = gain_file(turbine_design)["trim"]

    for k, wind in enumerate(table["wind"]):
        point = trim(turbine_design.turbine, wind)
        assert table["pitch"][k] == pytest.approx(point.pitch, abs=1e-9)
        assert table["torque"][k] == pytest.approx(point.torque, abs=1e-6)
        assert table["region"][k] == point.region


def test_the_observer_has_inertia_and_torque_table(turbine_design: TurbineDesign) -> None:
    """J, n_g, 1/2 rho pi R^3 and c_Q as a spline: the turbine's own."""
    rotor, turbine = gain_file(turbine_design)["rotor"], turbine_design.turbine
    table = rotor["torque_coefficient"]

    assert rotor["inertia"] == pytest.approx(turbine.inertia, rel=1e-15)
    assert rotor["torque_constant"] == turbine.torque_constant
    assert table["knots"][0] == turbine.torque.x_knots.tolist()
    assert table["coefficients"] == turbine.torque.coefficients.tolist()


@pytest.mark.parametrize(
    ("field", "value"), [("version", 1), ("unheard", 1), ("turbine", float("nan"))]
)
def test_schema_refuses_what_it_does_not_know(
    turbine_design: TurbineDesign, field: str, value: object
) -> None:
    content = gain_file(turbine_design) | {field: value}

    with pytest.raises(ValidationError):
        GainFile.model_validate(content)


def test_schema_refuses_a_column_of_another_length(turbine_design: TurbineDesign) -> None:
    content = copy.deepcopy(gain_file(turbine_design))
    content["law"]["proportional"].pop()

    with pytest.raises(ValidationError, match="proportional"):
        GainFile.model_validate(content)


def test_json_schema_names_the_law_and_its_units() -> None:
    schema = json.loads(json.dumps(gain_file_schema()))

    assert schema["$schema"].endswith("2020-12/schema")
    assert "proportional" in schema["$defs"]["CoherentLawTables"]["properties"]
    assert schema["additionalProperties"] is False


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
    content = plant_gain_file(design)
    certificate, gains = tmp_path / "c.json", tmp_path / "g.json"
    certificate.write_text(dumps(design.document), encoding="utf-8")
    gains.write_text(dump_gains(content), encoding="utf-8")

    assert content["law"] == design.document["gains"]
    assert check(certificate, gains=gains).verdict is design.verdict


def test_schema_round_trip_of_a_plant(design: PlantDesign) -> None:
    written = json.loads(dump_gains(plant_gain_file(design)))

    assert PlantGainFile.model_validate(written).model_dump(mode="json") == written
    with pytest.raises(ValidationError):
        PlantGainFile.model_validate(written | {"more": 1})
    assert plant_gain_file_schema()["title"] == "takagi gain file of a plant"


def test_every_gain_has_its_unit(design: PlantDesign) -> None:
    units = plant_gain_file(design)["units"]

    assert units["K, F per x"] == "N/m" and units["K, F per v"] == "N/(m/s)"


def test_an_analysis_has_no_gain_file() -> None:
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


@pytest.fixture
def joint(turbine_design: TurbineDesign) -> TurbineDesign:
    law, candidate = turbine_design.effort_sharing_law, turbine_design.candidate
    assert law is not None and candidate is not None
    before = ReachedValues(0.1894, 0.04, 0.01695)
    middle, after = replace(before, wind_error=0.2), replace(before, wind_error=0.2075)
    none = np.zeros(3)
    found = OneStepDesign(
        law,
        LoopFunctions(np.eye(3), none, none, np.eye(3), 0.026),
        before,
        replace(after, decay_rate=0.0261),
        (before, middle, after),
        0,
    )
    return replace(turbine_design, synthesis=EffortSharingGainDesign(law, candidate, found, ""))


def test_the_summary_tells_both(joint: TurbineDesign) -> None:
    words = synthesis_words(joint)
    assert "0.1894 to 0.2075 m/s" in words and "0.0169 to 0.0261 1/s" in words
    assert "balanced, 2 joint steps" in words


def test_two_step_gains_are_not_compared_but_the_reason_is_told(
    turbine_design: TurbineDesign,
) -> None:
    assert turbine_design.synthesis is not None
    failed = replace(turbine_design.synthesis, kept="none of 3 joint steps was better")
    words = synthesis_words(replace(turbine_design, synthesis=failed))
    assert words.endswith("for none of 3 joint steps was better")
    assert synthesis_words(replace(turbine_design, synthesis=None)) == ""
