"""Controller laws as values: the protocol that they share, and the laws.

protocol           Law, Measurement, Command
sampled            a law as the discrete program that a controller runs
pdc                one gain a rule: u = u* - sum h_i K_i (x - x*), for any plant
effort_sharing/    one effort shared by torque and pitch: the law, its tables, its feed-forward
published/         the published multi-region law and its parts; its equilibria, its linearisation
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.laws.effort_sharing.feedforward import (
        Feedforward,
        known_rate_feedforward,
        no_feedforward,
    )
    from takagi.models.laws.effort_sharing.law import CoherentLaw, EffortGains, EffortSharingLaw
    from takagi.models.laws.effort_sharing.schedule import EffortSchedule, effort_schedule
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

# ``coupling_filter`` is imported from its module: function and module share the name.
_HOME = {
    "CoherentLaw": "effort_sharing.law",
    "Command": "protocol",
    "CouplingFilter": "published.coupling_filter",
    "EffortGains": "effort_sharing.law",
    "EffortSchedule": "effort_sharing.schedule",
    "EffortSharingLaw": "effort_sharing.law",
    "Feedforward": "effort_sharing.feedforward",
    "FilteredReferenceLaw": "published.reference_filter",
    "Law": "protocol",
    "Measurement": "protocol",
    "PaperLaw": "published.law",
    "PaperRule": "published.law",
    "PdcLaw": "pdc",
    "PublishedLaw": "published.law",
    "PublishedRule": "published.law",
    "ReferenceFilter": "published.reference_filter",
    "SampledLaw": "sampled",
    "effort_schedule": "effort_sharing.schedule",
    "known_rate_feedforward": "effort_sharing.feedforward",
    "no_feedforward": "effort_sharing.feedforward",
    "paper_law": "published.law",
    "published_law": "published.law",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.models.laws.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
