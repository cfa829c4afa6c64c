"""The maps that `takagi sweep` can make: one line a law."""

from __future__ import annotations

from typing import NamedTuple


class SweptLaw(NamedTuple):
    """A law with a map.

    Attributes
    ----------
    law : as ``--law`` names it.
    map : the module with ``AXES`` and ``build``.
    pages : the module with ``pages``; both as ``takagi.certificates.sweep`` describes them.
    """

    law: str
    map: str
    pages: str


_PUBLISHED = ("takagi.certificates.sweep.published_map", "takagi.reports.maps.published_pages")
_EFFORT_SHARING = "takagi.reports.maps.effort_sharing_pages"

LAWS = (
    SweptLaw("paper", *_PUBLISHED),
    SweptLaw("paper-two-integrators", *_PUBLISHED),
    SweptLaw("coherent", "takagi.certificates.sweep.effort_sharing_map", _EFFORT_SHARING),
)

# The effort-sharing law's ready-made set: its module also names axes, ``READY_MADE``.
TRADE_OFF = SweptLaw("coherent", "takagi.certificates.sweep.trade_off", _EFFORT_SHARING)
