"""The fuzzer of the checker: it finds nothing, and would find something if there were something."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


def fuzzed(program: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", program, "--small", *options]
    environment = os.environ | {"PYTHONPATH": str(BENCHMARKS)}
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


RUN = """
import signal, sys
import fuzz_checker
signal.signal(signal.SIGALRM, fuzz_checker.too_long)
{change}
sys.exit(fuzz_checker.main())
"""
# A reader that takes whatever stands in a file for a number; kinds are loaded after it.
BROKEN = """
from takagi.certificates.checker.kernel import reader
reader.number = lambda owner, key, where: __import__("fractions").Fraction(owner[key])
"""


@pytest.mark.slow
def test_no_damage_crashes_the_checker(reduced: bool, tmp_path: Path) -> None:
    """20 s in the reduced form; ``benchmarks/fuzz_checker.py`` itself runs as long as is wanted."""
    seconds = "20" if reduced else "120"

    found = fuzzed(RUN.format(change=""), "--seconds", seconds, "--keep", str(tmp_path))

    assert found.returncode == 0, found.stdout + found.stderr
    assert " 0 crashes" in found.stdout


@pytest.mark.slow
def test_a_crash_that_is_there_is_found_and_kept(tmp_path: Path) -> None:
    """A checker that reads one number without looking at it fails within seconds."""
    found = fuzzed(RUN.format(change=BROKEN), "--seconds", "15", "--keep", str(tmp_path))

    assert found.returncode == 1, found.stdout
    kept: list[Any] = list(tmp_path.glob("*/certificate.json"))
    assert kept and all((file.parent / "why.txt").read_text() for file in kept)
