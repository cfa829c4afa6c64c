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
    from takagi.models.plant_files.loader import PlantFile, load_plant, plant_files

__all__ = [
    "PlantFile",
    "load_plant",
    "plant_files",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
