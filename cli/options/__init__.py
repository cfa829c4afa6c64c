"""The options of the command line, and their translation into settings.

given                  which options were given, and their text on a command line
design_options         all options of a turbine's design
law_names              names of the laws as they are typed, and in files
law_options            options of its law: set-points, schedule, ramps
filter_options         options of its filters on the measured rotor speed
synthesis_options      options of the search for its gains
uncertainty_options    options of its certificate: inertia, power coefficient, wake
plant_options          options of a plant's design, which replace its file's ``[design]``
time_budget            the time that a search for a plant's gains may take
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.cli.options.law_options import IN_FILES as IN_FILES
    from takagi.cli.options.law_options import law_in_files as law_in_files
    from takagi.cli.options.law_options import typed_name as typed_name
    from takagi.cli.options.plant_options import plant_settings as plant_settings

__getattr__, __dir__ = lazy_names(__name__)
