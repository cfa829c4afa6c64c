"""The target `mat`: two functions, a struct file, and a README."""

from __future__ import annotations

from decimal import Decimal

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.identifiers import file_word
from takagi.reports.code.matlab.step_function import (
    LONG_SAMPLE,
    STATUS,
    start_function,
    step_function,
    words_of,
)
from takagi.reports.code.matlab.struct_file import struct_file
from takagi.reports.code.sampling import start_sample_time, with_long_sample
from takagi.reports.code.targets import Exported, ExportSettings


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W_step.m``, ``W_start.m``, ``W.mat`` and ``README.md``.

    Raises
    ------
    ModelError : single precision, or a sample time that is not the law's own.
    """
    if settings.precision != "double":
        raise ModelError("--to mat computes in double; leave --precision out, or take --to c")
    word, time = file_word(program.plant), start_sample_time(program, settings.sample_time)
    return Exported(
        {
            f"{word}_step.m": step_function(program, word),
            f"{word}_start.m": start_function(program, word, time),
            f"{word}.mat": struct_file(program, settings.model, settings.claims),
            "README.md": _page(program, word, time),
        },
        {
            f"{word}_step.m": "one sample of the law; runs in MATLAB, Simulink and Octave",
            f"{word}_start.m": "its state before the first sample",
            f"{word}.mat": f"struct of gains, tables and matrices: load {word}.mat",
            "README.md": "inputs, outputs, units, an example and a Simulink block",
        },
    )


def _page(program: ControllerProgram, word: str, time: Decimal) -> str:
    names = words_of(program)
    rows = [
        f"| `{kind}.{names[one.name]}` | {one.unit} | {one.meaning} |"
        for kind, signals in (("inputs", program.inputs), ("outputs", program.outputs))
        for one in signals
    ]
    members = ", ".join(f"'{names[one.name]}', {one.rest or 0}" for one in program.inputs)
    arguments = ", ".join(f"{names[one.name]}" for one in program.inputs)
    given = ", ".join(f"'{names[one.name]}', {names[one.name]}" for one in program.inputs)
    return "\n".join(
        [
            f"# {program.name} in MATLAB",
            "",
            f"Verdict that the gain file names: {program.verdict}.",
            "The numbers are those of the gain file.",
            "",
            "```matlab",
            f"state = {word}_start();",
            f"inputs = struct({members});",
            f"[outputs, state, status] = {word}_step(state, inputs, {time})",
            "```",
            "",
            "In Simulink, a MATLAB Function block with this sample time:",
            "",
            "```matlab",
            f"function outputs = law({arguments})",
            "persistent state",
            f"if isempty(state), state = {word}_start(); end",
            f"inputs = struct({given});",
            f"[outputs, state] = {word}_step(state, inputs, {time});",
            "end",
            "```",
            "",
            "| | unit | meaning |",
            "|---|---|---|",
            *rows,
            "",
            "`status` is 0 or a sum of:",
            "",
            "| | |",
            "|---|---|",
            *(
                f"| {number} | {text} |"
                for number, text in with_long_sample(STATUS, LONG_SAMPLE, program)
            ),
            "",
        ]
    )
