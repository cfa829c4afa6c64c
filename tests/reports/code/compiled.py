"""A law in C, compiled by the system's compiler and called sample by sample."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from takagi.reports.code.c.source import c_source, export
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.targets import ExportSettings, Precision

C99 = ("-std=c99", "-ffp-contract=off")
STRICT = (
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wstrict-prototypes",
    "-Wmissing-prototypes", "-Werror",
)  # fmt: skip
SANITIZED = ("-g", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
# For inputs within their ranges; outside them a premise may be 1/0, which the step then catches.
NO_DIVISION_BY_ZERO = ("-fsanitize=float-divide-by-zero",)


def compiler(word: str = "cc") -> str:
    """Return a compiler; where there is none the test is skipped."""
    found = shutil.which(word)
    if found is None:
        pytest.skip(f"no {word} on this machine")
    return found


def run(command: Sequence[str], folder: Path) -> str:
    """Run a command that must succeed; return what it prints."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout[-2000:]}{done.stderr[-6000:]}"
    return done.stdout


def written(
    program: ControllerProgram, folder: Path, settings: ExportSettings | None = None
) -> str:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in export(program, settings or ExportSettings()).files.items():
        assert isinstance(text, str)
        (folder / name).write_text(text, encoding="utf-8")
    return c_source(program, settings or ExportSettings()).word


def only_half(names: Sequence[str], name: str, precision: str, which: int) -> None:
    """Skip a law in one precision unless it is in a half: 0, or 1; each half has every law once."""
    if (names.index(name) + (precision == "float")) % 2 != which:
        pytest.skip("reduced: the other precision is compiled, and this one by another test")


class Compiled:
    """A compiled law with a C structure as its ``state``, and the bits of the last ``status``."""

    def __init__(
        self,
        program: ControllerProgram,
        folder: Path,
        *,
        precision: Precision = "double",
        flags: Sequence[str] = ("-O0",),
    ) -> None:
        settings = ExportSettings(precision=precision)
        self.c = c_source(program, settings)
        folder.mkdir(parents=True, exist_ok=True)
        word = self.c.word
        (folder / f"{word}.h").write_text(self.c.header, encoding="utf-8")
        (folder / f"{word}.c").write_text(self.c.source, encoding="utf-8")
        run([compiler(), *C99, *flags, "-shared", "-fPIC", f"{word}.c", "-o", "law.so", "-lm"],
            folder)  # fmt: skip
        library = ctypes.CDLL(str(folder / "law.so"))
        real = ctypes.c_float if precision == "float" else ctypes.c_double
        self._inputs = _struct(list(self.c.inputs.values()), real)
        self._outputs = _struct(list(self.c.outputs.values()), real)
        members = [
            ("ready", ctypes.c_uint),
            ("samples", ctypes.c_uint),
            ("sample_time", real),
            ("inputs", self._inputs),
            ("outputs", self._outputs),
        ]
        if self.c.kept:
            members.append(("kept", _struct(list(self.c.kept.values()), real)))
        self._state = type("State", (ctypes.Structure,), {"_fields_": members})
        self.state: Any = self._state()
        self.status = 0
        self._init, self._step = library[f"{word}_init"], library[f"{word}_step"]
        self._time, self._message = library[f"{word}_set_sample_time"], library[f"{word}_message"]
        for function in (self._init, self._time):
            function.argtypes = [ctypes.POINTER(self._state), real]
        self._message.restype = ctypes.c_char_p

    def zeroed(self) -> None:
        self.state = self._state()

    def init(self, sample_time: float) -> int:
        return int(self._init(ctypes.byref(self.state), sample_time))

    def set_sample_time(self, sample_time: float) -> int:
        return int(self._time(ctypes.byref(self.state), sample_time))

    def message(self, status: int) -> str:
        return str(self._message(status).decode())

    def step(self, inputs: Mapping[str, float]) -> dict[str, float]:
        given = self._inputs(**{self.c.inputs[name]: value for name, value in inputs.items()})
        sent = self._outputs()
        self.status = self._step(ctypes.byref(self.state), ctypes.byref(given), ctypes.byref(sent))
        return {name: getattr(sent, member) for name, member in self.c.outputs.items()}

    def kept(self) -> dict[str, float]:
        return {name: getattr(self.state.kept, member) for name, member in self.c.kept.items()}

    def keep(self, values: Mapping[str, float]) -> None:
        self.state.samples = 1
        for name, value in values.items():
            setattr(self.state.kept, self.c.kept[name], value)

    def bit(self, word: str) -> bool:
        return bool(self.status & self.c.status_bits[word])


def _struct(names: Sequence[str], real: Any) -> Any:
    fields = [(name, real) for name in names]
    return type("Struct", (ctypes.Structure,), {"_fields_": fields})
