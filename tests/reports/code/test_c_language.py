"""Names that C takes, every function of the language, and no warning of any compiler."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import pytest

from takagi.models import ModelError
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code import program_reading
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.c import source
from takagi.reports.code.c.expressions import literal
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import ExportSettings, Precision
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
from tests.reports.test_gain_file_alone import PLANTS, plant_file


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return baseline_program(load_turbine("nrel5mw"))


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
    program = program_reading.controller_program(document)
    for precision in ("double", "float"):
        clean(program, tmp_path / precision, precision)
    law = Compiled(program, tmp_path)
    law.init(0.1)
    sent = law.step({word: 2.0**k for k, word in enumerate(words)})
    assert sent["return"] == 2.0 ** len(words) - 1 + 2 * 2.5


def test_every_function_of_the_language(tmp_path: Path) -> None:
    program = program_reading.controller_program(every_function())
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
        assert (
            source.c_source(program_reading.controller_program(document), ExportSettings()).word
            == word
        )
    document["plant"] = "math"
    clean(program_reading.controller_program(document), tmp_path, "double")
