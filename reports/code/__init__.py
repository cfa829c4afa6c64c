"""The law of a gain file as code that other tools run; every number is a decimal of the file.

formula             a formula of a program as a tree
controller_program  the programs of a gain file as one value, which every target reads
program_reading     reading a gain file as this value
limit_order         limits that are numbers of the file are in order
node_order          nodes of a table increase in the floats of the code
run                 this value, run in Python: known answers for the tests of targets
identifiers         names that are valid in a target's language
certified_model     the model and the claims of a gain file's certificate
baseline            a turbine's published controller as a program, for comparison
targets             the table of the targets of `takagi export`
c                   C99
discon              a Bladed-style library around the law in C
fmu                 the law, and its closed loop, as functional mock-up units
structured_text     a function block for PLCs
matlab              functions and a struct for MATLAB, Simulink and Octave
tables              CSV
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.code.baseline import baseline_program as baseline_program
    from takagi.reports.code.controller_program import ControllerProgram as ControllerProgram
    from takagi.reports.code.program_reading import read_controller as read_controller
    from takagi.reports.code.run import ProgramRun as ProgramRun
    from takagi.reports.code.targets import ExportSettings as ExportSettings
    from takagi.reports.code.targets import Precision as Precision

__getattr__, __dir__ = lazy_names(__name__)
