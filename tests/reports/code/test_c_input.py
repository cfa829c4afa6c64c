"""Bad inputs, times and states; names that C takes; every function; clean under all warnings."""

from __future__ import annotations

import math
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

from takagi.models import ModelError
from takagi.models.turbine import load_turbine
from takagi.reports.code import (
    ControllerProgram,
    ExportSettings,
    Precision,
    ProgramRun,
    baseline_program,
    read_controller,
)
from takagi.reports.code.c.expressions import literal
from takagi.reports.code.c.source import c_source
from takagi.reports.code.program_reading import controller_program
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
from tests.reports.test_gain_file_alone import PLANTS, plant_file

BAD = (math.nan, math.inf, -math.inf)


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return baseline_program(load_turbine("nrel5mw"))


@pytest.fixture(scope="module")
def compiled(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    """The law, compiled once: all that it remembers is in its state."""
    return Compiled(program, tmp_path_factory.mktemp("law"))


@pytest.fixture
def law(compiled: Compiled) -> Compiled:
    """The law with a state that was never touched."""
    compiled.zeroed()
    compiled.status = 0
    return compiled


# ------------------------------------------------------------------ what comes in


@pytest.mark.parametrize("bad", BAD)
def test_the_last_good_input_stands_in(law: Compiled, bad: float) -> None:
    good = {"speed": 1.1, "pitch": 0.1}
    law.init(0.01)
    law.step(good)
    law.step(good)
    other = law.state.__class__.from_buffer_copy(law.state)
    sent = law.step({"speed": 1.1, "pitch": bad})
    assert law.bit("INPUT_NOT_FINITE")
    law.state = other
    assert law.step(good) == sent
    assert not law.bit("INPUT_NOT_FINITE")


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_first_sample_starts_from_rest(
    law: Compiled, program: ControllerProgram, bad: float
) -> None:
    """What is sent is finite, and later samples move from it no faster than the actuators."""
    rest = {one.name: float(one.rest or 0) for one in program.inputs}
    T, limits = 0.01, load_turbine("nrel5mw")
    law.init(T)
    first = law.step(dict.fromkeys(rest, bad))
    assert law.bit("INPUT_NOT_FINITE")
    law.init(T)
    assert law.step(rest) == first
    for _ in range(50):
        then = law.step({"speed": 1.4, "pitch": 0.3})
        assert (
            abs(then["torque_sent"] - first["torque_sent"]) <= T * limits.torque_rate_limit * 1.001
        )
        assert abs(then["pitch_sent"] - first["pitch_sent"]) <= T * limits.pitch_rate_limit * 1.001
        first = then


@pytest.mark.parametrize("pitch", [-1.4e-45, -4.9e-324, -1e-6])
def test_a_pitch_a_hair_below_its_limit_is_not_reported(law: Compiled, pitch: float) -> None:
    """Noise of a measurement, or what a float leaves of 0; the law gets it as it is."""
    law.init(0.01)
    wanted = law.step({"speed": 1.1, "pitch": 0.0})
    law.init(0.01)
    assert law.step({"speed": 1.1, "pitch": pitch}) == pytest.approx(wanted, rel=1e-5)
    assert not law.bit("INPUT_OUTSIDE")


@pytest.mark.parametrize("pitch", [-1e-4, -0.1])
def test_a_pitch_below_that_is_told(law: Compiled, pitch: float) -> None:
    law.init(0.01)
    law.step({"speed": 1.1, "pitch": pitch})
    assert law.bit("INPUT_OUTSIDE")


def test_inputs_out_of_range_and_too_large(law: Compiled) -> None:
    """Used as they are, and told; where a result is not finite what was sent last is kept."""
    law.init(0.01)
    before = law.step({"speed": 1.1, "pitch": 0.1})
    assert law.status & ~law.c.status_bits["AT_LIMIT"] == 0
    law.step({"speed": 50.0, "pitch": 0.1})
    assert law.bit("INPUT_OUTSIDE")
    sent = law.step({"speed": 1.7e308, "pitch": 1.7e308})
    assert law.bit("RESULT_NOT_FINITE")
    assert all(map(math.isfinite, (*sent.values(), *law.kept().values())))
    assert abs(sent["torque_sent"] - before["torque_sent"]) <= 2 * 0.01 * 15001
    law.init(0.01)
    first = law.step({"speed": 1.7e308, "pitch": -1.7e308})
    assert law.bit("RESULT_NOT_FINITE")
    assert all(map(math.isfinite, first.values()))


def test_a_command_at_a_limit_is_told(law: Compiled) -> None:
    law.init(0.01)
    law.step({"speed": 1.0, "pitch": 0.0})
    law.keep({"w_f": 170.0, "x": 1e6, "pitch_before": 0.2, "torque_before": 40000.0})
    law.step({"speed": 1.4, "pitch": 0.3})
    assert law.bit("AT_LIMIT")
    assert law.message(law.status) == "a command is held at a limit"


# ------------------------------------------------------------------ calls and times


def test_a_step_before_init(law: Compiled) -> None:
    """A zeroed state starts with the usual time; it is told once."""
    given = {"speed": 1.1, "pitch": 0.1}
    law.zeroed()
    sent = law.step(given)
    assert law.bit("NOT_STARTED")
    assert law.state.sample_time == float(law.c.sample_time)
    law.step(given)
    assert not law.bit("NOT_STARTED")
    law.init(float(law.c.sample_time))
    assert law.step(given) == sent


@pytest.mark.parametrize("time", [*BAD, 0.0, -0.01])
def test_a_time_that_is_none_is_refused(law: Compiled, time: float) -> None:
    refused = law.c.status_bits["SAMPLE_TIME_REFUSED"]
    assert law.init(0.02) == 0
    law.step({"speed": 1.1, "pitch": 0.1})
    assert law.set_sample_time(time) == refused
    assert law.state.sample_time == 0.02
    assert law.set_sample_time(0.05) == 0
    assert law.state.sample_time == 0.05
    assert law.init(time) == refused
    assert law.message(refused) == "a sample time was refused; the one before is kept"
    assert all(map(math.isfinite, law.step({"speed": 1.1, "pitch": 0.1}).values()))


def test_a_damaged_state_starts_anew(law: Compiled) -> None:
    given = {"speed": 1.1, "pitch": 0.1}
    for member in ("w_f", "torque_before"):
        law.init(0.01)
        law.step(given)
        setattr(law.state.kept, member, math.nan)
        assert all(map(math.isfinite, law.step(given).values()))
        assert law.bit("NOT_STARTED")
    law.state.sample_time = -1.0
    law.step(given)
    assert law.bit("NOT_STARTED")


def test_a_stored_state_goes_on_where_it_was(law: Compiled) -> None:
    law.init(0.01)
    law.step({"speed": 1.1, "pitch": 0.1})
    stored = bytes(law.state)
    then = law.step({"speed": 1.2, "pitch": 0.12})
    law.state = type(law.state).from_buffer_copy(stored)
    assert law.step({"speed": 1.2, "pitch": 0.12}) == then


def test_a_law_with_a_time_of_its_own_refuses_another(tmp_path: Path) -> None:
    document = every_function()
    document["law"]["sample_time"] = Decimal("0.05")
    law = Compiled(controller_program(document), tmp_path)
    assert law.init(0.05) == 0
    assert law.init(0.01) == law.c.status_bits["SAMPLE_TIME_REFUSED"]
    assert law.state.sample_time == 0.05
    with pytest.raises(ModelError, match=r"the law is one in discrete time with 0\.05 s"):
        c_source(controller_program(document), ExportSettings(sample_time=0.01))


# ------------------------------------------------------------------ names and functions


def test_names_that_c_takes(tmp_path: Path) -> None:
    """A plant whose states are keywords, macros and functions of C."""
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
    program = controller_program(document)
    for precision in ("double", "float"):
        clean(program, tmp_path / precision, precision)
    law = Compiled(program, tmp_path)
    law.init(0.1)
    sent = law.step({word: 2.0**k for k, word in enumerate(words)})
    assert sent["return"] == 2.0 ** len(words) - 1 + 2 * 2.5


def every_function() -> dict[str, Any]:
    """Return a document like a gain file, with a formula for every function of the language."""
    x, half = "(x/3)", "(x/3)^2"
    formulas = {
        "f_math": "abs(x) + sqrt(abs(x)) + exp(x) + log(x^2 + 1) + sin(x) + cos(x) + tan(x/4)",
        "f_arcs": f"asin({x}) + acos({x}) + atan(x) + atanh(x/4) + asinh(x) + acosh(1 + x^2)",
        "f_more": "sinh(x) + cosh(x) + tanh(x) + erf(x)",
        "f_power": "x^2 + x^3 - x^4 + x^5 + 2^x + -x^2 + 2^3^2 + abs(x)^0.3 + (x^2 + 1)^-2",
        "f_signs": "x - (y - 2) - y/(x^2 + 1)/2 - -x + (x - y)*-2 + 1/(2/(y^2 + 3)) - 1e-7",
        "f_choice": "choose(x - y, min(x, y), max(x, 2)) + limit(y, -1, 1) + choose(x, 1, 2)*y",
        "f_rows": "first(nodes) + last(values) + line(x, nodes, values) + slope(y, nodes, values)",
        "f_hold": "hold(x, nodes, values) + hold(y, nodes, steps) + pi*scale",
        "f_spline": "spline(x, curve) + spline(x, y, surface)",
        "f_mix": f"mix(rules, gains, {half}, {half}/2) + mix(one_rule, one_gain, x)",
    }
    row = [Decimal(str(k)) for k in (-2, -1, 0, 1, 2)]
    values = [Decimal(text) for text in ("0.1", "-2.5", "1e-3", "7", "-0.25")]
    knots = [Decimal(k) for k in (-2, -2, -2, -2, 0, 2, 2, 2, 2)]
    places = ("nodes", "values", "steps", "curve", "surface", "rules", "gains", "one_rule",
              "one_gain", "scale")  # fmt: skip
    return {
        "format": "takagi-gains",
        "version": Decimal(3),
        "name": "Own law of every function",
        "plant": "own law",
        "law": {"sample_time": None},
        "nodes": row,
        "values": values,
        "steps": values[:-1],
        "curve": {"knots": [knots], "coefficients": values},
        "surface": {
            "knots": [knots, knots],
            "coefficients": [[v * k for v in values] for k in (1, 2, -1, 3, 5)],
        },
        "rules": [[Decimal(0), Decimal(0)], [Decimal(0), Decimal(1)], [Decimal(1), Decimal(0)],
                  [Decimal(1), Decimal(1)]],
        "gains": values[:4],
        "one_rule": [[Decimal(1)]],
        "one_gain": [Decimal("3.5")],
        "scale": "pi/6",
        "one": Decimal("2.5"),
        "states": [],
        "certificate": {"verdict": "PROVED", "sha256": {"gains": "0"}},
        "programs": [
            {
                "name": "law",
                "names": {name: {"value": name, "unit": "-"} for name in places},
                "read": [
                    {"name": name, "unit": "-", "meaning": "measured"} for name in ("x", "y")
                ],
                "keep": [
                    {"name": "sum", "unit": "-", "meaning": "", "start": "mix(rules, gains, x, y)",
                     "next": "sum + sample_time*f_near"}
                ],
                "steps": [
                    *(
                        {"set": name, "unit": "-", "meaning": "", "formula": formula}
                        for name, formula in formulas.items()
                    ),
                    {"set": "f_near", "unit": "-", "meaning": "",
                     "formula": "sin(x)/x + sin(y - 1)/(y - 1)",
                     "near": [
                         {"of": "x", "within": Decimal("1e-4"), "formula": "2 - x^2/6"},
                         {"of": "y - 1", "within": Decimal(0), "formula": "3"},
                     ]},
                ],
                "send": [
                    *(
                        {"name": f"out_{name}", "unit": "-", "meaning": "", "formula": name}
                        for name in (*formulas, "f_near")
                    ),
                    {"name": "out_sum", "unit": "-", "meaning": "", "formula": "sum"},
                ],
            }
        ],
    }  # fmt: skip


def test_every_function_of_the_language(tmp_path: Path) -> None:
    program = controller_program(every_function())
    for precision in ("double", "float"):
        clean(program, tmp_path / precision, precision)
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
        c_source(controller_program(document), ExportSettings())


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
    """Compile as C99 and C++ with all warnings as errors; run self-test and example."""
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
    """clang, where it is installed, and the analyzer of gcc."""
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
        assert c_source(controller_program(document), ExportSettings()).word == word
    document["plant"] = "math"
    clean(controller_program(document), tmp_path, "double")
