"""Reading a plant file: from TOML entries to a Plant.

loader             the file as a whole
table_entry        a table that it names
blending_section, design_section    its sections ``[blending]`` and ``[design]``
derived_numbers    parameters and rests that are expressions
entry_problem messages about wrong fields
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.plant_files.loader import PlantFile as PlantFile
    from takagi.models.plant_files.loader import load_plant as load_plant
    from takagi.models.plant_files.loader import plant_files as plant_files

__getattr__, __dir__ = lazy_names(__name__)
