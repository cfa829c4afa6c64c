"""A Bladed-style library, compiled by the system's compiler and called as a simulator would."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.discon.library import export
from takagi.reports.code.targets import ExportSettings
from tests.reports.code.compiled import STRICT, compiler, run

GEAR_RATIO = 97.0


def built(program: ControllerProgram, folder: Path) -> Path:
    """Write the library's files, compile them with all warnings as errors; return the library."""
    cc = compiler()
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in export(program, ExportSettings()).files.items():
        assert isinstance(text, str)
        (folder / name).write_text(text, encoding="utf-8")
    # The records are of blades that take a command at once, whatever the file is written for.
    run(["make", f"CC={cc}", f"CFLAGS={' '.join(STRICT)}"], folder)
    (library,) = folder.glob("lib*_discon.so")
    file = input_file(library)
    edited(file, file, pitch_drive="off")
    return library


def input_file(library: Path) -> Path:
    (file,) = library.parent.glob("*_discon.IN")
    return file


def edited(source: Path, to: Path, **values: object) -> Path:
    lines = source.read_text(encoding="utf-8").splitlines()
    for key, value in values.items():
        (at,) = (k for k, line in enumerate(lines) if line.split("=")[0].strip() == key)
        lines[at] = f"{key} = {value}"
    to.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return to


class Answer(NamedTuple):
    """What a call gives: torque [N m], pitch [rad], aviFAIL and the message."""

    torque: float
    pitch: float
    fail: int
    message: str


class Simulator:
    """One simulation that calls a library; record k is ``swap[k - 1]``."""

    def __init__(self, library: Path, input_file: Path, name: str = "run", step: float = 0.02):
        self._function = ctypes.CDLL(str(library)).DISCON
        self._function.restype = None
        self.file, self.name, self.room = str(input_file).encode(), name.encode(), 512
        self.swap: NDArray[np.float32] = np.zeros(3300, np.float32)
        self.records({3: step, 61: 3, 20: 1.2 * GEAR_RATIO, 21: 1.2, 27: 10, 23: 2e4})

    def records(self, values: Mapping[int, float]) -> None:
        for record, value in values.items():
            self.swap[record - 1] = value

    def pitch(self, value: float) -> None:
        self.records(dict.fromkeys((4, 33, 34), value))

    def call(self, status: int, time: float, file: bytes | None = None) -> Answer:
        file = self.file if file is None else file
        message = ctypes.create_string_buffer(b"\x7f" * 600, 601)
        lengths = {49: self.room, 50: len(file) + 1, 51: len(self.name) + 1}
        self.records({1: status, 2: time, **lengths})
        fail = ctypes.c_int(77)
        self._function(
            self.swap.ctypes.data_as(ctypes.POINTER(ctypes.c_float)),
            ctypes.byref(fail), file, self.name, message,
        )  # fmt: skip
        pitches = {float(self.swap[k]) for k in (41, 42, 43, 44)}
        assert len(pitches) == 1
        assert [float(self.swap[k - 1]) for k in (35, 36, 41, 46, 48, 55, 56, 65)] == [1] + [0] * 7
        assert message.raw[self.room :] == b"\x7f" * (600 - self.room) + b"\x00"
        text = message.value.decode() if self.room else ""
        return Answer(float(self.swap[46]), pitches.pop(), fail.value, text)
