"""The Bladed-style library of a turbine's law: sources, input file, Makefile and README.

The law is the source of the target `c`, once with the observer and once without it.  The input file
chooses between the observer and a wind that the simulator gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

from takagi.models.errors import ModelError
from takagi.reports.code.c.expressions import comment
from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
from takagi.reports.code.targets import (
    Exported,
    ExportSettings,
    as_list,
    filled,
    proof_lines,
    reported_range,
)

TEMPLATES = ("discon.h", "discon.c", "discon_files.c", "Makefile", "README.md")
READ = ("speed", "measured_speed", "pitch", "wind_guess", "wind_estimate", "speed_setpoint",
        "power_setpoint")  # fmt: skip
USUAL_DRIVE_TIME = "0.2"  # s


class _Variant(NamedTuple):
    """A law in C, and the word of ``wind_source`` in the input file that selects it."""

    source: str
    meaning: str
    law: CSource


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the sources of the library, its input file, ``Makefile`` and ``README.md``.

    The input file is not called DISCON.IN, as those that come with turbines are.

    Raises
    ------
    ModelError : the law of a plant, a law without rate limits, or one that C cannot hold.
    """
    _require_turbine(program)
    variants = tuple(_variants(program, settings))
    context = _context(program, variants, settings)
    files: dict[str, bytes | str] = {}
    for *_, law in variants:
        files |= {f"{law.word}.h": law.header, f"{law.word}.c": law.source}
    files |= {name: filled("discon.templates", name, context) for name in TEMPLATES}
    input_file = context["input_file"]
    files[input_file] = filled("discon.templates", "input_file", context)
    use = {
        "Makefile": f"make: gives {context['library']}",
        input_file: "settings, each explained; the simulator's DLL_InFile",
        "README.md": "how to build and use it, records and messages",
        "discon.c": "the calls of the interface, around the law",
        "discon_files.c": "input file and checkpoints",
    }
    return Exported(files, use | {f"{v.law.word}.c": f"the law, {v.meaning}" for v in variants})


def _require_turbine(program: ControllerProgram) -> None:
    if program.kind != "turbine":
        raise ModelError(
            f"--to discon was given for {program.plant}, which is no turbine: the interface has "
            "records for torque and pitch alone; take --to c or --to fmu"
        )
    sent = {signal.name for signal in program.outputs}
    if not {"torque_sent", "pitch_sent"} <= sent:
        raise ModelError(
            "--to discon needs the program 'rate limits', for simulators may have none; leave out "
            "--without 'rate limits'"
        )
    unknown = [signal.name for signal in program.inputs if signal.name not in READ]
    if unknown:
        raise ModelError(
            f"--to discon has no record for {unknown[0]!r}, which the law reads; take --to c"
        )


def _variants(program: ControllerProgram, settings: ExportSettings) -> Iterator[_Variant]:
    """Yield the laws; the first is the default."""
    read = {signal.name for signal in program.inputs}
    measured_wind = "the wind of record 27, as the simulator gives it"
    if "wind_estimate" in read:
        yield _Variant("record27", measured_wind, c_source(program, settings))
        return
    if "wind_guess" not in read:
        yield _Variant("none", "the law reads no wind", c_source(program, settings))
        return
    guess = "the estimate from speed, pitch and torque; record 27 is its first guess alone"
    yield _Variant("observer", guess, c_source(program, settings))
    kept = [stage.name for stage in program.stages]
    names = (entry["name"] for entry in program.document["programs"])
    without = ["observer", *(name for name in names if name not in kept)]
    wind_given = controller_program(program.document, without=without)
    named = replace(wind_given, plant=f"{program.plant} wind given")
    yield _Variant("record27", measured_wind, c_source(named, settings))


def _context(
    program: ControllerProgram, variants: tuple[_Variant, ...], settings: ExportSettings
) -> dict[str, Any]:
    document, word = program.document, variants[0].law.word
    law, drive_time = document["law"], document["limits"].get("pitch_time_constant")
    return {
        "title": comment(program.name),
        "word": word,
        "library": f"lib{word}_discon.so",
        "input_file": f"{word}_discon.IN",
        "variants": variants,
        "setpoints": {signal.name: signal for signal in program.inputs if signal.optional},
        "reported_range": reported_range,
        "version": document["version"],
        "sha256": program.hashes.get("gains", "none"),
        "proof": as_list(proof_lines(program)),
        "has_drive": drive_time is not None,
        "gear_ratio": document.get("rotor", law)["gear_ratio"],
        "limits": document["limits"],
        "sample_time": repr(settings.sample_time or 0),
        "own_filter": _own_filter(program),
        "drive_time": drive_time or USUAL_DRIVE_TIME,
        "drive_time_from": "limits.pitch_time_constant of the gain file" if drive_time else "usual",
    }


def _own_filter(program: ControllerProgram) -> str:
    """Return the sentence of the input file on the low-pass inside the law."""
    if not any(stage.name == "speed filter" for stage in program.stages):
        return "The law is proved without one."
    stated = program.document["measurement"]
    corner, stop = stated["speed_filter"], stated.get("torsion_filter")
    band_stop = f" and a band-stop at {stop['frequency']} rad/s" if stop else ""
    return (
        f"The law has one of {corner} rad/s{band_stop} of its own, so that this one would be a "
        "second."
    )
