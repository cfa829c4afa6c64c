"""The gain file ``gains.json``: one envelope, two bodies.

envelope   what every gain file has, its text, and its JSON Schema
turbine    the body of a turbine's file
plant      the body of a plant's file
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.gains_file.envelope import dump_gains as dump_gains
    from takagi.reports.gains_file.plant import PlantGainFile as PlantGainFile
    from takagi.reports.gains_file.plant import plant_gain_file as plant_gain_file
    from takagi.reports.gains_file.plant import plant_gain_file_schema as plant_gain_file_schema
    from takagi.reports.gains_file.turbine import GainFile as GainFile
    from takagi.reports.gains_file.turbine import gain_file as gain_file
    from takagi.reports.gains_file.turbine import gain_file_schema as gain_file_schema

__getattr__, __dir__ = lazy_names(__name__)
