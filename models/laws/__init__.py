"""Controller laws as values: the protocol that they share, and the laws.

law_words          what the laws are called in sentences
protocol           Law, Measurement, Command
sampled            a law as the discrete program that a controller runs
pdc                one gain a rule: u = u* - sum h_i K_i (x - x*), for any plant
output_feedback    the same of an estimate, with the observer that makes it
effort_sharing/    one effort shared by torque and pitch: the law, its tables, its feed-forward
published/         the published multi-region law and its parts; its equilibria, its linearisation
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.laws.effort_sharing.feedforward import Feedforward as Feedforward
    from takagi.models.laws.effort_sharing.feedforward import (
        known_rate_feedforward as known_rate_feedforward,
    )
    from takagi.models.laws.effort_sharing.feedforward import no_feedforward as no_feedforward
    from takagi.models.laws.effort_sharing.law import EffortGains as EffortGains
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw as EffortSharingLaw
    from takagi.models.laws.effort_sharing.schedule import EffortSchedule as EffortSchedule
    from takagi.models.laws.effort_sharing.schedule import effort_schedule as effort_schedule
    from takagi.models.laws.pdc import PdcLaw as PdcLaw
    from takagi.models.laws.protocol import Command as Command
    from takagi.models.laws.protocol import Law as Law
    from takagi.models.laws.protocol import Measurement as Measurement
    from takagi.models.laws.published.coupling_filter import CouplingFilter as CouplingFilter
    from takagi.models.laws.published.law import PublishedLaw as PublishedLaw
    from takagi.models.laws.published.law import published_law as published_law
    from takagi.models.laws.published.reference_filter import (
        FilteredReferenceLaw as FilteredReferenceLaw,
    )
    from takagi.models.laws.published.reference_filter import ReferenceFilter as ReferenceFilter
    from takagi.models.laws.sampled import SampledLaw as SampledLaw

__getattr__, __dir__ = lazy_names(__name__)
