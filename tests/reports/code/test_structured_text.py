"""The function block: parsed by blark, run by a small interpreter, equal to the program."""

from __future__ import annotations

import math
from decimal import Decimal
from pathlib import Path
from random import Random
from typing import Any

import pytest

from takagi.certificates import TurbineDesign
from takagi.models import ModelError
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program, read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.structured_text.block import export, function_block
from takagi.reports.code.targets import ExportSettings
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.reports.code.language_document import every_function
from tests.reports.code.structured_text import FunctionBlock
from tests.reports.test_gain_file_alone import PLANTS, plant_file, plant_law, states_of

NAN = math.nan


def block_of(program: ControllerProgram) -> FunctionBlock:
    return FunctionBlock(function_block(program, ExportSettings()))


def without_erf() -> dict[str, Any]:
    document = every_function()
    for step in document["programs"][0]["steps"]:
        step["formula"] = step["formula"].replace(" + erf(x)", "")
    return document


def same(block: FunctionBlock, run: ProgramRun, time: float, given: dict[str, float]) -> None:
    sent, wanted = block.call(sample_time=time, **given), run.sample(time, given)
    for name, value in wanted.items():
        assert sent[name.upper()] == pytest.approx(value, rel=1e-12, abs=1e-12), name


@pytest.mark.parametrize("name", PLANTS)
def test_the_law_of_every_plant(name: str, tmp_path: Path) -> None:
    """At rest, near points where a premise is 0/0, in the box, outside it, at saturation."""
    program = read_controller(plant_file(name, tmp_path))
    plant, law = plant_law(name)
    block, run = block_of(program), ProgramRun(program)
    labels, inputs = [one.name for one in plant.states], {one.name for one in program.inputs}
    time = float(program.sample_time or 0.1)
    for state in states_of(law):
        seen = dict(zip(labels, map(float, state), strict=True))
        same(block, run, time, {name: value for name, value in seen.items() if name in inputs})


def run_of_a_turbine(program: ControllerProgram, samples: int) -> int:
    """Compare a walk of speeds, pitches and winds; return the largest status."""
    block, run, rng = block_of(program), ProgramRun(program), Random(3)
    speed, pitch, worst = 1.1, 0.05, 0
    for _ in range(samples):
        given = {"speed": speed, "measured_speed": speed, "pitch": pitch}
        given |= {"wind_guess": 12.0, "wind_estimate": 11.0}
        same(block, run, 0.02, {one.name: given[one.name] for one in program.inputs})
        worst = max(worst, block.values["STATUS"])
        speed = min(max(speed + rng.uniform(-0.03, 0.03), 0.6), 1.5)
        pitch = min(max(pitch + rng.uniform(-0.02, 0.02), 0.0), 0.4)
    return worst


def test_the_law_of_a_turbine(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    path = tmp_path / "gains.json"
    path.write_text(dump_gains(gain_file(turbine_design)), encoding="utf-8")

    assert run_of_a_turbine(read_controller(path), 120) == 0
    assert run_of_a_turbine(read_controller(path, without=("observer",)), 30) == 0


def test_the_published_baseline() -> None:
    run_of_a_turbine(baseline_program(load_turbine("nrel5mw")), 60)


def test_every_function_but_one(tmp_path: Path) -> None:
    program = controller_program(without_erf())
    block, run = block_of(program), ProgramRun(program)
    for k in range(100):
        given = {"x": -2.5 + k * 0.05, "y": 2.25 - k * 0.045}
        if k == 7:
            given = {"x": 0.0, "y": 1.0}
        same(block, run, 0.125, given)


def test_what_the_language_cannot_hold_is_refused() -> None:
    with pytest.raises(ModelError, match="function erf is not in Structured Text"):
        function_block(controller_program(every_function()), ExportSettings())
    program = controller_program(without_erf())
    with pytest.raises(ModelError, match="computes in LREAL"):
        export(program, ExportSettings(precision="float"))
    document = without_erf()
    document["values"] = [Decimal(k) for k in range(9000)]
    with pytest.raises(ModelError, match=r"values .* has 9000 numbers; a function block holds"):
        function_block(controller_program(document), ExportSettings())


def test_a_law_with_a_time_of_its_own_refuses_another(tmp_path: Path) -> None:
    program = read_controller(plant_file("truck_trailer", tmp_path))
    with pytest.raises(ModelError, match="discrete time with 2"):
        function_block(program, ExportSettings(sample_time=0.1))
    block = block_of(program)
    rest = {one.name: 0.1 for one in program.inputs}
    assert block.call(sample_time=2.0, **rest)["STATUS"] == 0
    assert block.call(sample_time=0.1, **rest)["STATUS"] == 16


@pytest.mark.parametrize("name", ["cart_pole", "boost_throttle"])
def test_bad_inputs_leave_finite_commands(name: str, tmp_path: Path) -> None:
    program = read_controller(plant_file(name, tmp_path))
    rest = {one.name: float(one.rest or 0) for one in program.inputs}
    first, command = program.inputs[0].name, program.outputs[0].name.upper()

    at_rest = block_of(program).call(**rest)
    for bad in (NAN, math.inf, -math.inf, 1e31):
        block = block_of(program)
        sent = block.call(**(rest | {first: bad}))
        assert sent[command] == at_rest[command]
        assert sent["STATUS"] == 1
    block = block_of(program)
    side = program.inputs[0].range
    assert side is not None
    inside = rest | {first: rest[first] + 0.3 * (float(side[1]) - rest[first])}
    good = block.call(**inside)
    held = block.call(**(inside | {first: NAN}))
    if not program.kept:
        assert held[command] == good[command]
    assert block.call(**(rest | {first: 1.01 * float(side[1])}))["STATUS"] == 2
    for time in (0.0, -1.0, NAN, math.inf):
        assert block.call(**rest, sample_time=time)["STATUS"] == 16


def test_a_result_that_is_no_number_changes_nothing() -> None:
    """1/x at 0 stops a PLC or gives infinity; here it gives one, by a number out of all range."""
    document = without_erf()
    document["programs"][0]["steps"].append(
        {"set": "huge", "unit": "-", "meaning": "", "formula": "x*scale*exp(600)"}
    )
    document["programs"][0]["send"].append(
        {"name": "out_huge", "unit": "-", "meaning": "", "formula": "huge"}
    )
    block = block_of(controller_program(document))
    before = block.call(x=0.0, y=0.5)
    kept = block.values["SUM"]
    after = block.call(x=0.5, y=0.5)
    assert before["STATUS"] == 0
    assert after == before | {"STATUS": 4}
    assert block.values["SUM"] == kept


def test_reset_starts_again(tmp_path: Path) -> None:
    program = read_controller(plant_file("boost_throttle", tmp_path))
    given = {one.name: 1.01 * float(one.rest or 0) for one in program.inputs}
    block = block_of(program)
    first = block.call(**given)
    assert block.call(**given) != first
    assert block.call(**given, reset=True) == first


def test_keywords_as_names(tmp_path: Path) -> None:
    document = without_erf()
    program = document["programs"][0]
    for old, new in (("x", "real"), ("y", "sin_")):
        for one in program["read"]:
            one["name"] = new if one["name"] == old else one["name"]
        program["steps"].insert(
            0, {"set": old, "unit": "-", "meaning": 'it\'s (* "odd" *)', "formula": new}
        )
    program["keep"][0]["start"] = "mix(rules, gains, real, sin_)"
    program["steps"].insert(0, {"set": "X", "unit": "-", "meaning": "", "formula": "real + 1"})
    found = controller_program(document)
    block, run = block_of(found), ProgramRun(found)
    wanted = run.sample(0.01, {"real": 0.5, "sin_": 0.25})
    sent = block.call(real_=0.5, sin_=0.25)
    assert sent["OUT_F_MATH"] == pytest.approx(wanted["out_f_math"], rel=1e-13)
    assert "X_" in block.values


@pytest.mark.parametrize("name", ["truck_trailer", "cart_pole", "every function"])
@pytest.mark.slow
def test_an_independent_parser_reads_it(name: str, tmp_path: Path, reduced: bool) -> None:
    """With blark, which takes minutes for the tables of a turbine: these have every statement."""
    if reduced and name == "cart_pole":
        pytest.skip("reduced: it has no statement that the others have not")
    blark = pytest.importorskip("blark.parse")
    if name == "every function":
        program = controller_program(without_erf())
    else:
        program = read_controller(plant_file(name, tmp_path))
    text = function_block(program, ExportSettings())
    found = list(blark.parse_source_code(text).transform().items)
    assert len(found) == 1
    assert found[0].name == FunctionBlock(text).name or str(found[0].name).startswith("FB_")


def test_the_page_names_every_signal(tmp_path: Path) -> None:
    program = read_controller(plant_file("cart_pole", tmp_path))
    files = export(program, ExportSettings()).files
    page = str(files["README.md"])
    for one in (*program.inputs, *program.outputs):
        assert f"| `{one.name}` |" in page
        assert one.unit in page
