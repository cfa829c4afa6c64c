"""The Bladed-style library of a turbine's law: sources, input file, Makefile and README.

The law is the source of the target `c`, once with the observer and once without it.  The input file
chooses between the observer and a wind that the simulator gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from takagi.models.errors import ModelError
from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.c.words import comment
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
from takagi.reports.code.proof_words import as_list, proof_lines
from takagi.reports.code.targets import Exported, ExportSettings
from takagi.reports.code.templates import filled

TEMPLATES = ("discon.h", "discon.c", "discon_files.c", "DISCON.IN", "Makefile", "README.md")
READ = ("speed", "measured_speed", "pitch", "wind_guess", "wind_estimate")
USUAL_DRIVE_TIME = "0.2"  # s


@dataclass(frozen=True, slots=True)
class _Variant:
    """A law in C, and the word of ``wind_source`` in the input file that selects it."""

    source: str
    meaning: str
    law: CSource

    def members(self) -> dict[str, Any]:
        """Return the names that the templates use for this law."""
        word, out = self.law.word, self.law.outputs
        observed = out.get("wind_estimate")
        wind_value = f"(double)out.{observed}" if observed else "wind"
        return {
            "source": self.source,
            "meaning": self.meaning,
            "word": word,
            "long_bit": self.law.status_bits.get("SAMPLE_TIME_LONG"),
            "inputs": list(self.law.inputs.items()),
            "torque": out["torque_sent"],
            "pitch": out["pitch_sent"],
            "wind": wind_value,
        }


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the sources of the library, ``DISCON.IN``, ``Makefile`` and ``README.md``.

    Raises
    ------
    ModelError : the law of a plant, a law without rate limits, or one that C cannot hold.
    """
    _require_turbine(program)
    variants = tuple(_variants(program, settings))
    context = _context(program, variants, settings)
    files: dict[str, bytes | str] = {}
    for variant in variants:
        files[f"{variant.law.word}.h"], files[f"{variant.law.word}.c"] = (
            variant.law.header,
            variant.law.source,
        )
    files |= {name: filled("discon.templates", name, context) for name in TEMPLATES}
    use = {
        "Makefile": f"make: gives {context['library']}",
        "DISCON.IN": "settings, each explained; the simulator's DLL_InFile",
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
    limits = [stage.name for stage in program.stages]
    left_out = [
        entry["name"] for entry in program.document["programs"] if entry["name"] not in limits
    ]
    without = controller_program(program.document, without=["observer", *left_out])
    named = replace(without, plant=f"{program.plant} wind given")
    yield _Variant("record27", measured_wind, c_source(named, settings))


def _context(
    program: ControllerProgram, variants: tuple[_Variant, ...], settings: ExportSettings
) -> dict[str, Any]:
    document, word = program.document, variants[0].law.word
    limits, law = document["limits"], document["law"]
    lead = law.get("pitch_lead", 0)
    drive_time = str(lead) if lead > 0 else USUAL_DRIVE_TIME
    return {
        "title": comment(program.name),
        "word": word,
        "library": f"lib{word}_discon.so",
        "variants": [variant.members() for variant in variants],
        "version": document["version"],
        "sha256": program.hashes.get("gains", "none"),
        "proof": as_list(proof_lines(program)),
        "has_lead": lead > 0,
        "gear_ratio": _double(document.get("rotor", law)["gear_ratio"]),
        "torque": [_double(end) for end in limits["torque"]],
        "pitch": [_double(end) for end in limits["pitch"]],
        "pitch_rate": limits["pitch_rate"],
        "usual_step": _double(variants[0].law.sample_time),
        "sample_time": repr(settings.sample_time or 0),
        "own_filter": _own_filter(program),
        "drive_time": drive_time,
        "drive_time_from": "law.pitch_lead of the gain file" if lead > 0 else "a usual one",
        "simulations": 16,
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


def _double(number: Any) -> str:
    """Return a number as a literal of type double."""
    return repr(float(number))
