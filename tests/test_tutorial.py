"""docs/tutorial.md does what it says: every command in its order, in an empty folder."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.docs_pages import fenced, text_of

PAGE = text_of("tutorial.md")
PART = re.compile(r"```(sh|text|toml)\n(.*?)```", re.DOTALL)
NUMBER = re.compile(r"\d+\.?\d*")
# Of a number whose last digits depend on the processor.
NEAR = 0.05


def ran(command: str, folder: Path) -> str:
    """Return what a line of the shell prints, with the checkout's ``takagi``."""
    tools = folder / "tools"
    tools.mkdir(exist_ok=True)
    script = tools / "takagi"
    script.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -c '
        '"import sys; from takagi.cli.main import main; sys.exit(main(sys.argv[1:]))" "$@"\n',
        encoding="utf-8",
    )
    script.chmod(0o755)
    env = {**os.environ, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "100"}
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=env,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def assert_shows(shown: str, printed: str) -> None:
    """The shown words stand in what is printed, in one piece, and numbers are near."""
    wanted, words = shown.split(), printed.split()
    masked = [NUMBER.sub("#", word) for word in words]
    pattern = [NUMBER.sub("#", word) for word in wanted]
    places = range(len(words) - len(wanted) + 1)
    at = next((k for k in places if masked[k : k + len(wanted)] == pattern), None)
    assert at is not None, printed
    for one, other in zip(wanted, words[at:], strict=False):
        for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True):
            assert math.isclose(float(a), float(b), rel_tol=NEAR), f"{one} is {other}"


@pytest.mark.slow
def test_every_command_works_and_prints_what_is_shown(tmp_path: Path) -> None:
    printed, counted = "", 0
    for kind, text in PART.findall(PAGE):
        if kind == "sh":
            printed = "".join(ran(line, tmp_path) for line in text.splitlines())
            counted += 1
        elif kind == "text":
            assert_shows(text, printed)

    assert counted == len(fenced(PAGE, "sh")) >= 7


def test_the_file_that_is_shown_is_the_template(tmp_path: Path) -> None:
    ran(fenced(PAGE, "sh")[0], tmp_path)
    written = tomllib.loads((tmp_path / "pendulum.toml").read_text(encoding="utf-8"))

    (shown,) = fenced(PAGE, "toml")
    assert tomllib.loads(shown).items() <= written.items()
