"""The law in MATLAB's language, run by Octave where it is installed; its struct read by scipy."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from takagi.certificates import TurbineDesign
from takagi.certificates.document.certificate_file import dumps
from takagi.cli.main import main
from takagi.models import ModelError, nrel5mw
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram, file_word
from takagi.reports.code.matlab.target import export, words_of
from takagi.reports.code.program_reading import controller_program, read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import ExportSettings, certified
from takagi.reports.gains_file.envelope import dump_gains, gain_file, plant_gain_file
from tests.plant_files import written
from tests.reports.code.language_document import every_function
from tests.reports.plant_designs import design_of
from tests.reports.test_gain_file_alone import PLANTS, plant_file, plant_law, states_of

# Each row of `given` is one sample; a row of `sent` is its outputs and its status.
DRIVER = """
load given.mat
state = {word}_start();
names = fieldnames(state.inputs);
sent = [];
for k = 1:size(given, 1)
    for j = 1:numel(names), inputs.(names{{j}}) = given(k, j); end
    [outputs, state, status] = {word}_step(state, inputs, T);
    sent(k, :) = [cell2mat(struct2cell(outputs))' status];
end
save -v6 sent.mat sent
"""


def octave(
    program: ControllerProgram, rows: Sequence[dict[str, float]], time: float, folder: Path
) -> np.ndarray:
    command = shutil.which("octave-cli")
    if command is None:
        pytest.skip("Octave is not installed")
    word = file_word(program.plant)
    for name, content in export(program, ExportSettings()).files.items():
        data = content if isinstance(content, bytes) else content.encode()
        (folder / name).write_bytes(data)
    table = [[row[one.name] for one in program.inputs] for row in rows]
    savemat(folder / "given.mat", {"given": np.array(table, dtype=float), "T": time})
    (folder / "drive.m").write_text(DRIVER.format(word=word), encoding="utf-8")
    done = subprocess.run(
        [command, "--no-gui", "--quiet", "--eval", "drive"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "error: '" not in done.stderr, done.stderr
    return np.atleast_2d(np.asarray(loadmat(folder / "sent.mat")["sent"], dtype=float))


def compared(
    program: ControllerProgram, rows: Sequence[dict[str, float]], time: float, folder: Path
) -> None:
    run = ProgramRun(program)
    sent = octave(program, rows, time, folder)
    assert len(sent) == len(rows)
    for row, found in zip(rows, sent, strict=True):
        wanted = [*run.sample(time, row).values()]
        assert found[:-1] == pytest.approx(wanted, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", PLANTS)
def test_the_law_of_a_plant(name: str, tmp_path: Path) -> None:
    program = read_controller(plant_file(name, tmp_path))
    plant, law = plant_law(name)
    labels = [one.name for one in plant.states]
    rows = [dict(zip(labels, map(float, state), strict=True)) for state in states_of(law)]
    compared(program, rows, float(program.sample_time or 0.1), tmp_path)


def test_the_law_of_a_turbine(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    path, rng = tmp_path / "gains.json", Random(3)
    path.write_text(dump_gains(gain_file(turbine_design)), encoding="utf-8")
    rows, speed, pitch = [], 1.1, 0.05
    for _ in range(100):
        rows.append({"measured_speed": speed, "pitch": pitch, "wind_guess": 12.0})
        speed = min(max(speed + rng.uniform(-0.03, 0.03), 0.6), 1.5)
        pitch = min(max(pitch + rng.uniform(-0.02, 0.02), 0.0), 0.4)
    compared(read_controller(path), rows, 0.02, tmp_path)


def test_every_function_of_the_language(tmp_path: Path) -> None:
    rows = [{"x": -2.5 + k * 0.05, "y": 2.25 - k * 0.045} for k in range(100)]
    rows[7] = {"x": 0.0, "y": 1.0}
    compared(controller_program(every_function()), rows, 0.125, tmp_path)


def test_bad_inputs_leave_finite_commands(tmp_path: Path) -> None:
    """Bit 1 for what is not a number, 2 for what is out of range, 16 for a time that is none."""
    program = read_controller(plant_file("cart_pole", tmp_path))
    rest = {one.name: float(one.rest or 0) for one in program.inputs}
    first = program.inputs[0].name
    rows = [rest, rest | {first: math.nan}, rest | {first: math.inf}, rest | {first: 1.6}, rest]
    sent = octave(program, rows, 0.01, tmp_path)
    assert sent[:, -1].tolist() == [0, 1, 1, 2, 0]
    assert sent[1, 0] == sent[2, 0] == sent[0, 0]
    assert octave(program, [rest], math.nan, tmp_path)[:, -1].tolist() == [16]


def test_the_struct_has_what_the_file_and_the_certificate_have(
    duffing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mat"
    assert main(["export", str(duffing / "gains.json"), "--to", "mat", "--out", str(out)]) == 0
    assert "duffing" in capsys.readouterr().out.lower()
    program = read_controller(duffing / "gains.json")
    file = out / f"{file_word(program.plant)}.mat"
    found = loadmat(file, simplify_cells=True)["takagi"]
    law = program.document["law"]
    r = len(law["K"])
    n, m = len(law["state_names"]), len(law["input_names"])
    assert np.reshape(found["K"], (m, n, r))[0, 0, -1] == float(law["K"][-1][0][0])
    assert np.reshape(found["A"], (n, n, r)).shape == (n, n, r)
    assert np.reshape(found["B"], (n, m, r)).shape == (n, m, r)
    assert any(np.shape(P) == (n, n) for P in found["P"].values())
    assert found["verdict"] == "PROVED"
    assert set(found["constants"]) == {words_of(program)[one.name] for one in program.constants}
    again = tmp_path / "again"
    assert main(["export", str(duffing / "gains.json"), "--to", "mat", "--out", str(again)]) == 0
    assert (again / file.name).read_bytes() == file.read_bytes()


def test_another_certificate_gives_no_matrices(tmp_path: Path) -> None:
    """Claims of a file that the gain file does not name are not written beside its gains."""
    document = dict(design_of("duffing").document)
    first = filed(tmp_path / "first", {**document, "claims": document["claims"][:-1]})
    out = tmp_path / "mat"
    assert main(["export", str(first / "gains.json"), "--to", "mat", "--out", str(out)]) == 0
    found = loadmat(next(out.glob("*.mat")), simplify_cells=True)["takagi"]
    assert "P" not in found


def test_another_model_s_certificate_is_not_taken(tmp_path: Path) -> None:
    gains = plant_file("tora", tmp_path)
    path = tmp_path / "certificate.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    document["model"]["parameters"]["eps"] = 0.2
    path.write_text(json.dumps(document), encoding="utf-8")
    program = read_controller(gains)

    assert certified(gains, None, program)[0] is None
    with pytest.raises(ModelError, match="another model"):
        certified(gains, path, program)


def test_a_law_that_is_not_proved_has_no_certificate(tmp_path: Path) -> None:
    program = baseline_program(nrel5mw())
    gains, path = Path("nrel5mw"), tmp_path / "certificate.json"
    path.write_text(json.dumps({"model": {"name": "NREL 5-MW"}}), encoding="utf-8")

    assert certified(gains, None, program)[0] is None
    with pytest.raises(ModelError, match="the law is not proved"):
        certified(gains, path, program)


def filed(folder: Path, document: dict[str, Any] | None = None) -> Path:
    """Write gain file and certificate of the shared design, or another certificate beside it."""
    design = design_of("duffing")
    folder.mkdir()
    written(folder, dump_gains(plant_gain_file(design)), "gains.json")
    written(folder, dumps(document or design.document), "certificate.json")
    return folder


@pytest.fixture(scope="module")
def duffing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return filed(tmp_path_factory.mktemp("duffing") / "built")


def test_vertices_are_the_model_s(duffing: Path, tmp_path: Path) -> None:
    out = tmp_path / "mat"
    assert main(["export", str(duffing / "gains.json"), "--to", "mat", "--out", str(out)]) == 0
    found = loadmat(next(out.glob("*.mat")), simplify_cells=True)["takagi"]
    _, law = plant_law("duffing")
    # The gain file's premises are rounded outward to seven decimals.
    np.testing.assert_allclose(np.moveaxis(found["A"], 2, 0), law.model.A, atol=1e-5)
    r, n, m = law.model.B.shape
    B = np.moveaxis(np.reshape(found["B"], (n, m, r)), 2, 0)
    np.testing.assert_allclose(B, law.model.B, atol=1e-5)


def test_what_makes_no_sense_is_refused(tmp_path: Path) -> None:
    program = read_controller(plant_file("truck_trailer", tmp_path))
    with pytest.raises(ModelError, match="computes in double"):
        export(program, ExportSettings(precision="float"))
    with pytest.raises(ModelError, match="discrete time with 2"):
        export(program, ExportSettings(sample_time=0.1))
