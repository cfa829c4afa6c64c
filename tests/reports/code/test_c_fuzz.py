"""The law in C with random bytes for inputs, times and states: finite, and nothing undefined."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import cast

import pytest

from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.targets import ExportSettings, Precision
from tests.reports.code.compiled import C99, SANITIZED, STRICT, compiler, only_half, run, written
from tests.reports.test_gain_file_alone import PLANTS, plant_file

HARNESS = Path(__file__).with_name("fuzz.c")
CALLS = 10_000_000


def build(
    program: ControllerProgram, folder: Path, precision: str, *flags: str, by: str = "cc"
) -> Path:
    """Compile the harness with a law; warnings are errors in it too."""
    word = written(program, folder, ExportSettings(precision=cast(Precision, precision)))
    shutil.copy(HARNESS, folder / "fuzz.c")
    names = f"-DW={word}", f'-DHEADER="{word}.h"'
    run([compiler(by), *C99, *STRICT, "-Wno-missing-prototypes", *flags, *names, f"{word}.c",
         "fuzz.c", "-o", "fuzz", "-lm"], folder)  # fmt: skip
    return folder / "fuzz"


def program_of(name: str, folder: Path) -> ControllerProgram:
    if name == "baseline":
        return baseline_program(load_turbine("nrel5mw"))
    return read_controller(plant_file(name, folder))


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["baseline", "split_range", "cart_pole"])
def test_random_bytes_under_the_sanitizers(name: str, precision: str, tmp_path: Path) -> None:
    """50 000 calls under the sanitizers of addresses and of undefined behaviour."""
    fuzz = build(program_of(name, tmp_path), tmp_path / "c", precision, *SANITIZED)

    assert run([str(fuzz), "50000"], tmp_path) == "50000 calls\n"


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["baseline", *PLANTS])
def test_many_random_bytes(name: str, precision: str, tmp_path: Path, reduced: bool) -> None:
    """10^7 calls over all laws and both types: for each its part; reduced, each law in one type."""
    if reduced:
        only_half(["baseline", *PLANTS], name, precision, 0)
    fuzz = build(program_of(name, tmp_path), tmp_path / "c", precision, *SANITIZED)
    calls = CALLS // (2 * (len(PLANTS) + 1)) // (10 if reduced else 1)

    assert run([str(fuzz), str(calls)], tmp_path) == f"{calls} calls\n"


@pytest.mark.slow
def test_a_fuzzer_that_looks_for_paths(tmp_path: Path, reduced: bool) -> None:
    """libFuzzer, where clang is installed: it looks for inputs that reach new code."""
    empty = tmp_path / "empty.c"
    empty.write_text("int LLVMFuzzerTestOneInput(const char *b, unsigned long n);\n"
                     "int LLVMFuzzerTestOneInput(const char *b, unsigned long n)\n"
                     "{ return b == 0 && n > 0; }\n", encoding="utf-8")  # fmt: skip
    tried = [compiler("clang"), "-fsanitize=fuzzer,address", str(empty), "-o", "empty"]
    if subprocess.run(tried, cwd=tmp_path, capture_output=True, check=False).returncode:
        pytest.skip("clang is here without its fuzzer")
    program = program_of("split_range", tmp_path)
    flags = ("-g", "-O1", "-DLIBFUZZER", "-fsanitize=fuzzer,address,undefined",
             "-fno-sanitize-recover=all")  # fmt: skip
    fuzz = build(program, tmp_path / "c", "double", *flags, by="clang")

    run([str(fuzz), f"-runs={20_000 if reduced else 1_000_000}", "-seed=1"], tmp_path)
