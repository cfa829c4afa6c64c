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


_PAPER = ("takagi.certificates.sweep.published_map", "takagi.reports.maps.published_pages")
_COHERENT = "takagi.reports.maps.effort_sharing_pages"

LAWS = (
    SweptLaw("paper", *_PAPER),
    SweptLaw("paper-two-integrators", *_PAPER),
    SweptLaw("coherent", "takagi.certificates.sweep.effort_sharing_map", _COHERENT),
)

# The effort-sharing law's ready-made set: its module also names axes, ``READY_MADE``.
TRADE_OFF = SweptLaw("coherent", "takagi.certificates.sweep.trade_off", _COHERENT)
