"""The law in C against the law in Python, at random and in sequence."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from random import Random

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.models import ModelError
from takagi.models.laws.protocol import Law, Measurement, sampled
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.turbine.loader import load_turbine
from takagi.models.turbine.trim import trim
from takagi.reports.code import program_reading
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.c import source
from takagi.reports.code.c.expressions import literal
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import ExportSettings, Precision
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.reports.code.compiled import (
    C99,
    NO_DIVISION_BY_ZERO,
    SANITIZED,
    STRICT,
    Compiled,
    compiler,
    only_half,
    run,
    written,
)
from tests.reports.code.language_document import every_function
from tests.reports.python_law import PythonLaw
from tests.reports.test_gain_file_alone import (
    LAWS,
    PLANTS,
    VARIANTS,
    law_walks,
    laws_of,
    plant_file,
    plant_law,
    states_of,
    turbine_file,
)

EXACT = 1e-12
# All laws together: 10^6.
MANY = 60_000
# A premise of a published law is a difference of two splines over 1e-4 rad/s, whose last digits the
# law in Python rounds in another order.  The program itself is met to EXACT.
PUBLISHED = 1e-9


def count_of(many: bool, reduced: bool) -> int:
    return 100 if not many else MANY // 20 if reduced else MANY


def close(found: float, wanted: float, largest: float, within: float = EXACT) -> bool:
    """Whether two commands are equal to so much of the larger of this and the largest one."""
    return abs(found - wanted) <= within * max(abs(wanted), largest)


def long_too(*names: str) -> list[object]:
    """Return each name for the fast suite, and once more for the slow one."""
    return [
        *(pytest.param(name, False, id=name) for name in names),
        *(pytest.param(name, True, id=f"{name}, many", marks=pytest.mark.slow) for name in names),
    ]


# ------------------------------------------------------------------ plants


def require_run_alike(compiled: Compiled, program: ControllerProgram) -> None:
    run = ProgramRun(program)
    compiled.init(0.05)
    for given in _near_rest(program):
        sent, same = compiled.step(given), run.sample(0.05, given)
        for signal, value in same.items():
            assert sent[signal] == pytest.approx(value, rel=EXACT, abs=1e-15)


@pytest.mark.parametrize(("name", "many"), long_too(*PLANTS))
def test_the_law_of_a_plant(name: str, many: bool, tmp_path: Path, reduced: bool) -> None:
    """At rest, near 0/0, in the box, outside it, at saturation: as the program in Python."""
    plant, law = plant_law(name)
    program = read_controller(plant_file(name, tmp_path))
    compiled = Compiled(program, tmp_path)
    labels = [one.name for one in plant.states]
    rng = np.random.default_rng(5)
    sides = [law.model.box.get(one, (1, 1)) for one in law.model.states]
    half = np.array([max(abs(float(end)) for end in side) for side in sides])
    random = (
        law.state_rest + rng.uniform(-1.1, 1.1, len(half)) * half
        for _ in range(count_of(many, reduced))
    )
    found: list[tuple[str, float, float]] = []
    compiled.init(0.1)
    for state in (*states_of(law), *random):
        seen = dict(zip(labels, map(float, state), strict=True))
        if law.blend is not None:
            compiled.keep({labels[-1]: seen.pop(labels[-1])})
        sent = compiled.step(seen)
        wanted = dict(zip((v.name for v in plant.inputs), law.sent(state), strict=True))
        if law.blend is not None:
            actuators = (one.name for one in law.blend.blending.actuators)
            wanted |= dict(zip(actuators, law.blend.sent(state), strict=True))
        found += [(signal, sent[signal], float(value)) for signal, value in wanted.items()]
    for signal in wanted:
        largest = max(abs(value) for one, _, value in found if one == signal)
        assert all(close(ours, value, largest) for one, ours, value in found if one == signal)
    require_run_alike(compiled, program)


# ------------------------------------------------------------------ turbines


@pytest.fixture(scope="module")
def laws(turbine_design: TurbineDesign) -> Mapping[str, Law]:
    return laws_of(turbine_design)


@pytest.mark.parametrize(("name", "many"), long_too(*(x for x in LAWS if x not in VARIANTS)))
def test_the_law_of_a_turbine(
    name: str,
    many: bool,
    laws: Mapping[str, Law],
    turbine_design: TurbineDesign,
    tmp_path: Path,
    reduced: bool,
) -> None:
    """Against the program to 1e-12, and against the law in Python, states running on."""
    law, T, top = laws[name], 0.02, turbine_design.turbine.rated_torque
    path = turbine_file(turbine_design, law, tmp_path)
    program = read_controller(path, without=("speed filter", "observer", "rate limits"))
    compiled, run = Compiled(program, tmp_path), ProgramRun(program)
    within = EXACT if name == "coherent" else PUBLISHED
    kept = [one.name for one in program.kept]
    for walk in law_walks(law, count_of(many, reduced) // 25, Random(5)):
        compiled.init(T)
        run.kept = {}
        if walk[0].start:
            run.kept = dict(zip(kept, walk[0].start, strict=True))
            compiled.keep(run.kept)
        for seen in walk:
            given = {one.name: seen.measured[one.name] for one in program.inputs}
            sent, same = compiled.step(given), run.sample(T, given)
            for signal, largest in (("torque", top), ("pitch_reference", 1.0)):
                assert close(sent[signal], same[signal], largest)
            assert close(sent["torque"], seen.command.torque, top, within)
            assert close(sent["pitch_reference"], seen.command.pitch, 1.0, within)
            for one, value in zip(kept, seen.later, strict=False):
                assert close(compiled.kept()[one], run.kept[one], 1.0)
                assert close(compiled.kept()[one], float(value), 1.0, within)


@pytest.mark.parametrize("many", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_whole_controller_in_its_order(
    many: bool, turbine_design: TurbineDesign, tmp_path: Path, reduced: bool
) -> None:
    """Observer, law, rate limits: as ``takagi simulate`` runs them, sample by sample."""
    T, rng = 0.01, Random(7)
    path = tmp_path / "gains.json"
    path.write_text(dump_gains(gain_file(turbine_design)), encoding="utf-8")
    compiled, top = Compiled(read_controller(path), tmp_path), turbine_design.turbine.rated_torque
    for _ in range(max(1, count_of(many, reduced) // 150)):
        speed, pitch, guess = rng.uniform(0.8, 1.3), 0.05, rng.uniform(4, 22)
        compiled.init(T)
        law = PythonLaw(turbine_design, T)
        for _ in range(150):
            command = law.sample(speed, pitch, guess)
            sent = compiled.step({"measured_speed": speed, "pitch": pitch, "wind_guess": guess})
            # 150 samples in a loop: the rounding of the observer's spline goes round.
            assert close(sent["wind_estimate"], law.estimate, 25.0, 1e-11)
            assert close(sent["torque_sent"], command.torque, top, 1e-11)
            assert close(sent["pitch_sent"], command.pitch, 1.0, 1e-11)
            speed = min(max(speed + rng.uniform(-0.03, 0.03), 0.5), 1.6)
            pitch = max(0.0, pitch + rng.uniform(-1, 1) / 50)


@pytest.mark.parametrize(("name", "many"), long_too("nrel5mw", "iea15mw"))
def test_the_baseline_law(name: str, many: bool, tmp_path: Path, reduced: bool) -> None:
    turbine = load_turbine(name)
    law, T, rng = BaselineLaw(turbine), 0.0125, Random(3)
    program = baseline_program(turbine, without=("rate limits",))
    compiled = Compiled(program, tmp_path)
    for wind in (8.0, 15.0):
        point = trim(turbine, wind)
        compiled.init(T)
        compiled.step({"speed": point.rotor_speed, "pitch": point.pitch})
        wanted = law.initial_state(wind)
        later = wanted + T * law.state_rate(wanted, Measurement(point.rotor_speed, point.pitch, 0))
        assert compiled.kept()["w_f"] == pytest.approx(later[0], rel=EXACT)
        assert compiled.kept()["x"] == pytest.approx(later[1], rel=1e-9, abs=1e-9)
    state = law.initial_state(12.0)
    top, ends, rated = turbine.maximum_torque, set(), turbine.gear_ratio * turbine.rated_rotor_speed
    for k in range(max(2_000, count_of(many, reduced))):
        if k % 20 == 0:
            # Around every range's end of the integral, and in every region of the speed.
            state = np.array([rng.uniform(0.3, 1.2) * rated, rng.uniform(-40, 250)])
            compiled.init(T)
            compiled.step({"speed": 1.0, "pitch": 0.0})
            compiled.keep(dict(zip(("w_f", "x"), state.tolist(), strict=True)))
        measured = Measurement(
            rng.uniform(0.3, 1.3) * turbine.rated_rotor_speed,
            rng.choice([0.0, rng.uniform(-0.02, 0.5)]),
            0,
        )
        command, later = sampled(law, state, measured, T)
        sent = compiled.step({"speed": measured.rotor_speed, "pitch": measured.pitch})
        ends.add((later[1] == state[1], command.torque == 0.0))
        assert close(sent["torque"], command.torque, top)
        assert close(sent["pitch_reference"], command.pitch, 1.0)
        assert close(compiled.kept()["w_f"], later[0], rated)
        assert close(compiled.kept()["x"], later[1], 250.0)
        state = later
    assert len(ends) >= 3


@pytest.mark.parametrize("law", ["coherent", "paper"])
def test_numbers_of_one_type_are_as_good_as_the_type(
    law: str, laws: Mapping[str, Law], turbine_design: TurbineDesign, tmp_path: Path
) -> None:
    """Float: to 2e-4 of rated torque; the published law's premises lose more, 2e-2."""
    program = read_controller(turbine_file(turbine_design, laws[law], tmp_path))
    narrow = Compiled(program, tmp_path / "float", precision="float")
    wide = Compiled(program, tmp_path / "double")
    rng, top = Random(2), turbine_design.turbine.rated_torque
    within = 2e-4 if law == "coherent" else 2e-2
    for _ in range(10):
        narrow.init(0.02)
        wide.init(0.02)
        guess = rng.uniform(4, 24)
        for _ in range(20):
            given = {"speed": rng.uniform(0.8, 1.3), "pitch": rng.uniform(0, 0.3)}
            given = {one.name: given.get(one.name, guess) for one in program.inputs}
            ours, theirs = narrow.step(given), wide.step(given)
            assert ours["torque_sent"] == pytest.approx(theirs["torque_sent"], abs=within * top)
            assert ours["pitch_sent"] == pytest.approx(theirs["pitch_sent"], abs=within)


def test_near_zero_over_zero_in_float(tmp_path: Path) -> None:
    """What the gain file's distances are for is computed in double, or a float has no digits."""
    program = read_controller(plant_file("tora", tmp_path))
    narrow = Compiled(program, tmp_path / "float", precision="float")
    wide = Compiled(program, tmp_path / "double")
    narrow.init(0.1)
    wide.init(0.1)
    for size in (0.0, 1e-9, 9e-5, 1.1e-4, 1e-3, 0.1):
        given = {one.name: 0.0 for one in program.inputs} | {"theta": size, "x": 0.5}
        assert narrow.step(given)["u"] == pytest.approx(wide.step(given)["u"], rel=1e-4)


def _near_rest(program: ControllerProgram) -> list[dict[str, float]]:
    """Return inputs from a hair off rest to the whole range, along each input and all together."""
    rng = Random(17)
    found = []
    for size in (0.0, 1e-12, 1e-8, 1e-5, 1.4e-4, 1e-3, 0.03, 0.3, 1.0):
        for _ in range(3):
            one = {}
            for signal in program.inputs:
                rest, (low, high) = float(signal.rest or 0), signal.range or (-1, 1)
                side = rng.uniform(-1, 1) * size
                one[signal.name] = rest + side * float(high - low) / 2
            found.append(one)
    return found


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return baseline_program(load_turbine("nrel5mw"))


# ------------------------------------------------------------------ names and functions


def test_names_that_c_takes(tmp_path: Path) -> None:
    document = every_function()
    words = ("double", "I", "int", "y0", "sin_", "NAN", "state", "min", "own_law_real")
    document["programs"][0]["read"] = [
        {"name": word, "unit": '*/ \\ "m" ??/', "meaning": "/* a\nnasty µ one"} for word in words
    ]
    document["programs"][0]["steps"] = [
        {"set": "gamma", "unit": "-", "meaning": "", "formula": " + ".join(words)},
        {"set": "main", "unit": "-", "meaning": "", "formula": "gamma + table + rules_"},
    ]
    document["programs"][0]["keep"] = []
    document["programs"][0]["names"] = {
        "table": {"value": "one", "unit": "-"},
        "rules_": {"value": "one", "unit": "-"},
    }
    document["programs"][0]["send"] = [
        {"name": "return", "unit": "-", "meaning": "", "formula": "main"}
    ]
    program = program_reading.controller_program(document)
    clean(program, tmp_path / "clean", "double")
    law = Compiled(program, tmp_path)
    law.init(0.1)
    sent = law.step({word: 2.0**k for k, word in enumerate(words)})
    assert sent["return"] == 2.0 ** len(words) - 1 + 2 * 2.5


def test_every_function_of_the_language(tmp_path: Path) -> None:
    program = program_reading.controller_program(every_function())
    clean(program, tmp_path / "clean", "float")
    law, wide = Compiled(program, tmp_path), ProgramRun(program)
    narrow = Compiled(program, tmp_path / "narrow", precision="float")
    law.init(0.125)
    narrow.init(0.125)
    for k in range(200):
        given = {"x": -2.5 + k * 0.025, "y": 2.25 - k * 0.0225}
        if k == 7:
            given = {"x": 0.0, "y": 0.0}
        if k == 8:
            given = {"x": 0.5, "y": 1.0}
        wanted = wide.sample(0.125, given)
        for found, within in ((law.step(given), 1e-13), (narrow.step(given), 1e-4)):
            for name, value in wanted.items():
                assert found[name] == pytest.approx(value, rel=within, abs=within), (name, given)


@pytest.mark.parametrize(
    ("formula", "told"),
    [
        ("nodes + 1", "'nodes' is a row or table; a formula needs a number there"),
        ("line(x, nodes, steps)", "line has 5 nodes and 4 values"),
        ("first(scale)", "'scale' is no row of numbers"),
        ("mix(rules, values, x, y)", "mix has 5 values, and rules of another size"),
        ("spline(x, surface)", "'surface' is no spline of 1 arguments"),
        ("line(x, x, nodes)", "a row or table of the file is needed in a formula, by its name"),
    ],
)
def test_what_the_file_cannot_mean_is_refused(formula: str, told: str) -> None:
    document = every_function()
    document["programs"][0]["steps"][0]["formula"] = formula
    with pytest.raises(ModelError, match=told.replace("'", ".")):
        source.c_source(program_reading.controller_program(document), ExportSettings())


def test_numbers_that_a_type_cannot_hold_are_refused() -> None:
    assert literal(Decimal("1e-7"), "F") == "1E-7F"
    assert literal(Decimal("5"), "") == "5.0"
    assert literal(Decimal("0.1000"), "") == "0.1000"
    for number in ("1e39", "-1e39", "1e-39"):
        with pytest.raises(ModelError, match="does not fit a float; give --precision double"):
            literal(Decimal(number), "F")
    for number in ("1e309", "NaN", "Infinity"):
        with pytest.raises(ModelError):
            literal(Decimal(number), "")


# ------------------------------------------------------------------ compilers


def clean(program: ControllerProgram, folder: Path, precision: str) -> None:
    word = written(program, folder, ExportSettings(precision=_precision(precision)))
    law, test = f"{word}.c", f"{word}_test.c"
    run([compiler(), *C99, *STRICT, *SANITIZED, *NO_DIVISION_BY_ZERO, law, test, "-lm",
         "-o", "try"], folder)  # fmt: skip
    assert "0 values off" in run([str(folder / "try")], folder)
    run([compiler(), *C99, *STRICT, "-O2", law, f"{word}_example.c", "-lm", "-o", "show"], folder)
    assert run([str(folder / "show")], folder).count("\n") == 5
    strict = [flag for flag in STRICT if "prototypes" not in flag]
    run([compiler("c++"), "-x", "c++", "-std=c++17", *strict, law, test, "-o", "try"], folder)
    assert "0 values off" in run([str(folder / "try")], folder)


def _precision(word: str) -> Precision:
    return "float" if word == "float" else "double"


@pytest.mark.parametrize(
    ("name", "precision"),
    [
        ("baseline", "double"),
        ("boost_throttle", "float"),
        # The plants in both precisions are below.
        pytest.param("baseline", "float", marks=pytest.mark.slow),
    ],
)
def test_no_warning_and_a_self_test_that_passes(name: str, precision: str, tmp_path: Path) -> None:
    program = (
        baseline_program(load_turbine("nrel5mw"))
        if name == "baseline"
        else read_controller(plant_file(name, tmp_path))
    )
    clean(program, tmp_path / "c", precision)


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", PLANTS)
def test_no_warning_for_any_plant(name: str, precision: str, tmp_path: Path, reduced: bool) -> None:
    """Reduced: each plant in the precision in which ``test_many_random_bytes`` leaves it out."""
    if reduced:
        only_half(["baseline", *PLANTS], name, precision, 1)
    clean(read_controller(plant_file(name, tmp_path)), tmp_path / "c", precision)


@pytest.mark.slow
def test_other_tools_have_nothing_to_say(tmp_path: Path, program: ControllerProgram) -> None:
    word = written(program, tmp_path)
    run([compiler("gcc"), *C99, *STRICT, "-fanalyzer", "-c", f"{word}.c"], tmp_path)
    run([compiler("clang"), *C99, *STRICT, "-Weverything", "-Wno-declaration-after-statement",
         "-Wno-padded", "-Wno-unsafe-buffer-usage", "-Wno-unknown-warning-option", "-c",
         f"{word}.c"], tmp_path)  # fmt: skip


def test_fast_math_is_refused(tmp_path: Path, program: ControllerProgram) -> None:
    word = written(program, tmp_path)
    with pytest.raises(AssertionError, match="compile without -ffast-math"):
        run([compiler(), *C99, "-ffast-math", "-c", f"{word}.c"], tmp_path)


def test_a_plant_whose_word_is_a_header_s(tmp_path: Path) -> None:
    document = every_function()
    for plant, word in (("Math", "law_math"), ("Double", "law_double"), ("5 MW", "law_5_mw")):
        document["plant"] = plant
        assert (
            source.c_source(program_reading.controller_program(document), ExportSettings()).word
            == word
        )
    document["plant"] = "math"
    clean(program_reading.controller_program(document), tmp_path, "double")
