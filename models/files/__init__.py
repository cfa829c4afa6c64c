"""What model files have in common.

toml_document        a TOML file that can say where in it something is wrong
units                    units as text: of any plant, of a turbine file
csv_table, coefficient_table    tables from CSV
library              the models that come with the package, by name
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.files.library import built_in_kinds as built_in_kinds
    from takagi.models.files.library import data_folder as data_folder
    from takagi.models.files.library import resolve_model as resolve_model
    from takagi.models.files.units import parse_unit as parse_unit
    from takagi.models.files.units import to_si as to_si

__getattr__, __dir__ = lazy_names(__name__)
