"""The program of a design's gain file, or of a recorded certificate."""

from __future__ import annotations

import json
from collections.abc import Collection
from decimal import Decimal

from takagi.certificates import TurbineDesign
from takagi.certificates.checker import read_text
from takagi.certificates.checker.controller.content import file_content
from takagi.certificates.checker.kernel.reader import Number, canonical
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.certificates.recorded.answers import recorded


def program_of(design: TurbineDesign) -> ControllerProgram:
    text = dump_gains(gain_file(design))
    return controller_program(json.loads(text, parse_float=Decimal, parse_int=Decimal))


def recorded_program(
    *, without: Collection[str] = (), setpoints: bool = False
) -> ControllerProgram:
    """Return the default law of the NREL 5-MW turbine, from a recorded certificate: quickly."""
    document = json.loads(recorded_file(setpoints), parse_float=Decimal, parse_int=Decimal)
    return controller_program(document, without=without)


def recorded_file(setpoints: bool = False) -> str:
    """Return the text of its gain file; with set-points from 1.05 rad/s and 90 % of torque on."""
    data = read_text(json.dumps(json.loads(next(recorded("running-loop"))[1])), "certificate")
    law = data["gains"]
    if setpoints:
        lowest = {"lowest_speed": Number("1.05"), "lowest_torque": Number("38784.195")}
        column = [Number(f"-0.{30 + 10 * k:03d}") for k in range(len(law["wind"]))]
        factor = Number(repr(0.944 * 97))
        law["setpoints"] = {**lowest, "power_per_torque": factor, "speed_effort": column}
    trim = {"wind": law["wind"], "rotor_speed": law["rotor_speed"], "pitch": [law["pitch_min"]]}
    own = {**data["controller"], "name": "trial", "turbine": "NREL 5-MW", "trim": trim}
    own["certificate"] = {"verdict": "none", "sha256": {}}
    return canonical(file_content(data["model"], law, own))
