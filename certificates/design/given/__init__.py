"""Existing gains: the law of a gain file is read, to certify it or to run it.

turbine_law     a certificate for a turbine's gains
plant_gains     a plant's gains, for the same plant
kept_model      a plant's gains after the plant has changed
runnable_law    the law to run: the same commands, bit for bit
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.design.given.turbine_law import certify_law as certify_law
    from takagi.certificates.design.given.turbine_law import (
        effort_sharing_law_from_data as effort_sharing_law_from_data,
    )
    from takagi.certificates.design.given.turbine_law import read_law as read_law
    from takagi.certificates.design.given.turbine_law import read_observer as read_observer

__getattr__, __dir__ = lazy_names(__name__)
