"""A plant as the user writes it: equations, and variables with units and ranges, as values.

variables         Variable, Parameter, Output, with their units
plant             Plant, the value: M(x) x' = f(x, u, w), y = g(x, u, w), on a box
file_units        figures in SI in the units that the file is written in
dimensions        the unit of an expression, where its parts fit
table_coverage    the arguments of tables must stay inside them on the box
entries, schema   what a plant file may contain; its JSON Schema, printed
entry_values      what a single field of it may be
design_settings the requirements on a design

Plant files are read in ``plant_files``; text, units and tables in ``expressions`` and ``files``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings as PlantSettings
    from takagi.models.plant.file_units import file_unit as file_unit
    from takagi.models.plant.file_units import time_in_file_units as time_in_file_units

__getattr__, __dir__ = lazy_names(__name__)
