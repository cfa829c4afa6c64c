"""The options of the command line, and their translation into settings.

given                  which options were given, and as they would be typed
design_options         what may be asked of a turbine's design
law_options            of its law: set-points, schedule, ramps
synthesis_options      of the search for its gains
uncertainty_options    of its certificate: inertia, power coefficient, wake
plant_options          what may be asked for a plant, over its file's ``[design]``
time_budget            how long a search for a plant's gains may take
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.cli.options.plant_options import plant_settings

__all__ = [
    "plant_settings",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
