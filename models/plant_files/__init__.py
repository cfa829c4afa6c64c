"""Reading a plant file: from TOML entries to a Plant.

loader             the file as a whole
table_entry        a coefficient table that the file names
measured_section, reference_section, blending_section, design_section    sections and fields
derived_numbers    parameters and rests that are expressions
uncertain_parameters    parameters with a range
written_time       times with their unit
entry_problem      messages about wrong fields
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.plant_files.loader import PlantFile as PlantFile
    from takagi.models.plant_files.loader import load_plant as load_plant
    from takagi.models.plant_files.loader import plant_files as plant_files

__getattr__, __dir__ = lazy_names(__name__)
