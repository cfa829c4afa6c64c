"""The gain file: the certificate's law number by number, within its schema, the same every time."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest
from pydantic import ValidationError

from takagi.certificates import TurbineDesign
from takagi.certificates.checker import CertificateError, check
from takagi.certificates.document.certificate_file import dumps
from takagi.models.turbine.trim import trim
from takagi.reports.gains_file.envelope import dump_gains
from takagi.reports.gains_file.turbine import GainFile, gain_file, gain_file_schema


def test_checker_accepts_the_pair(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    """Written side by side, certificate and gains compare equal and the verdict is the design's."""
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(dumps(turbine_design.document))
    gains.write_text(dump_gains(gain_file(turbine_design)))

    checked = check(certificate, gains=gains)

    assert checked.verdict is turbine_design.checked.verdict
    assert not any("gain file" in message for message in checked.messages)


def test_checker_refuses_another_gain(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    """One changed proportional gain is enough for the checker to refuse the pair."""
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    content = copy.deepcopy(gain_file(turbine_design))
    content["law"]["proportional"][3] += 0.00001
    certificate.write_text(dumps(turbine_design.document))
    gains.write_text(dump_gains(content))

    with pytest.raises(CertificateError, match="proportional"):
        check(certificate, gains=gains)


def test_schema_round_trip(turbine_design: TurbineDesign) -> None:
    """What is written is read back by the schema, and printed again it is the same data."""
    written = json.loads(dump_gains(gain_file(turbine_design)))

    read = GainFile.model_validate(written)

    assert read.model_dump(mode="json") == written


def test_every_number_of_the_law_has_a_unit(turbine_design: TurbineDesign) -> None:
    """No column of the law stands without a unit."""
    content = gain_file(turbine_design)

    columns = {f"law.{name}" for name in content["law"] if name != "name"}

    assert columns <= set(content["units"])


def test_one_sample_is_written_out(turbine_design: TurbineDesign) -> None:
    """Filter, its rate, integral: in words, beside the programs of ``test_gain_file_alone``."""
    content = gain_file(turbine_design)
    execution = content["execution"]

    assert set(execution) == {"every", "rates", "schedule wind", "its rate", "integral"}
    assert "v_hat + (v_s - v_hat) exp(-T / wind_filter)" in execution["schedule wind"]
    assert "v_s' = (v_s after - v_s) / T" in execution["its rate"]
    assert "x - T integral_rate e" in execution["integral"]
    words = " ".join([*content["schedule"].values(), *execution.values()])
    # No other formula of the rate stands beside it.
    assert words.count("v_s' =") == execution["its rate"].count("v_s' =")


def test_trim_table_is_the_turbines(turbine_design: TurbineDesign) -> None:
    """The emitted trim equals the turbine's trim at each wind, to the emitted decimals."""
    table = gain_file(turbine_design)["trim"]

    for k, wind in enumerate(table["wind"]):
        point = trim(turbine_design.turbine, wind)
        assert table["pitch"][k] == pytest.approx(point.pitch, abs=1e-9)
        assert table["torque"][k] == pytest.approx(point.torque, abs=1e-6)
        assert table["region"][k] == point.region


def test_no_gains_of_a_law_that_is_not_run(turbine_design: TurbineDesign) -> None:
    """The regions' gains, which the effort-sharing law does not use, are not in its file."""
    content = gain_file(turbine_design)

    assert "regional" not in content and "filter" not in content
    assert not any("k_x" in key or "k_I" in key for key in content["units"])


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
    """Another version, an unknown field, and a number for a name are refused."""
    content = gain_file(turbine_design) | {field: value}

    with pytest.raises(ValidationError):
        GainFile.model_validate(content)


def test_schema_refuses_a_column_of_another_length(turbine_design: TurbineDesign) -> None:
    """A law whose table misses a node is refused as an effort-sharing law."""
    content = copy.deepcopy(gain_file(turbine_design))
    content["law"]["proportional"].pop()

    with pytest.raises(ValidationError, match="proportional"):
        GainFile.model_validate(content)


def test_json_schema_names_the_law_and_its_units() -> None:
    """The JSON Schema is plain data and describes the law's columns."""
    schema = json.loads(json.dumps(gain_file_schema()))

    assert schema["$schema"].endswith("2020-12/schema")
    assert "proportional" in schema["$defs"]["CoherentLawTables"]["properties"]
    assert schema["additionalProperties"] is False
