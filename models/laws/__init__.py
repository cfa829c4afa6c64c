"""Controller laws as values: the protocol that they share, and the laws.

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
    from takagi.models.laws.effort_sharing.feedforward import (
        Feedforward,
        known_rate_feedforward,
        no_feedforward,
    )
    from takagi.models.laws.effort_sharing.law import CoherentLaw, EffortGains, EffortSharingLaw
    from takagi.models.laws.effort_sharing.schedule import EffortSchedule, effort_schedule
    from takagi.models.laws.output_feedback import OutputFeedback
    from takagi.models.laws.pdc import PdcLaw
    from takagi.models.laws.protocol import Command, Law, Measurement
    from takagi.models.laws.published.coupling_filter import CouplingFilter
    from takagi.models.laws.published.law import (
        PaperLaw,
        PaperRule,
        PublishedLaw,
        PublishedRule,
        paper_law,
        published_law,
    )
    from takagi.models.laws.published.reference_filter import FilteredReferenceLaw, ReferenceFilter
    from takagi.models.laws.sampled import SampledLaw

# ``coupling_filter`` is imported from its module: function and module share the name.
__all__ = [
    "CoherentLaw",
    "Command",
    "CouplingFilter",
    "EffortGains",
    "EffortSchedule",
    "EffortSharingLaw",
    "Feedforward",
    "FilteredReferenceLaw",
    "Law",
    "Measurement",
    "OutputFeedback",
    "PaperLaw",
    "PaperRule",
    "PdcLaw",
    "PublishedLaw",
    "PublishedRule",
    "ReferenceFilter",
    "SampledLaw",
    "effort_schedule",
    "known_rate_feedforward",
    "no_feedforward",
    "paper_law",
    "published_law",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
