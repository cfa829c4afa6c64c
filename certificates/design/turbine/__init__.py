"""The design of a turbine's controller.

settings, result        the requirements; the finished design
design                  makes the design: models, gains, law, observer, certificate
gain_file_members       contents of the gain file that model and law do not determine
regions                 the model and the gains of each region
effort_sharing_gains    gains of the effort-sharing law and the candidate of its claim
published_law           a design with a published law
scale                   settings for a turbine of another size
limits                  checks of the settings before the long work begins
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.effort_sharing_gains import (
        EffortSharingGainDesign as EffortSharingGainDesign,
    )
    from takagi.certificates.design.turbine.published_law import designed_law as designed_law
    from takagi.certificates.design.turbine.result import speed_filter as speed_filter
    from takagi.certificates.design.turbine.scale import default_settings as default_settings
    from takagi.certificates.design.turbine.settings import LAWS as LAWS
    from takagi.certificates.design.turbine.wind_by_wind import wind_by_wind_law as wind_by_wind_law
    from takagi.certificates.design.turbine.wind_by_wind import (
        wind_observer_design as wind_observer_design,
    )

__getattr__, __dir__ = lazy_names(__name__)
