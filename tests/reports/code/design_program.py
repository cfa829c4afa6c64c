"""The program of a design's gain file."""

from __future__ import annotations

import json
from decimal import Decimal

from takagi.certificates import TurbineDesign
from takagi.reports.code import ControllerProgram
from takagi.reports.code.controller_program import controller_program
from takagi.reports.gains_file import dump_gains, gain_file


def program_of(design: TurbineDesign) -> ControllerProgram:
    """Return it as `takagi export` reads it from the file."""
    text = dump_gains(gain_file(design))
    return controller_program(json.loads(text, parse_float=Decimal, parse_int=Decimal))
