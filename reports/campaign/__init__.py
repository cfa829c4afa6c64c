"""Campaigns of random runs as tables, figures and files.

    tables, summary    numbers as rows, JSON and CSV; a page in Markdown
    figures            use of the bounds inside; runs that leave the set outside
    folder             all files of a campaign, by file name
    boundary           the published laws, compared with the proved winds

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.campaign.folder import CampaignReport, campaign_files

__all__ = ["CampaignReport", "campaign_files"]

_HOME = {
    "CampaignReport": "folder",
    "campaign_files": "folder",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.reports.campaign.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
