"""Campaigns of random runs as tables, figures and files.

    tables, summary    numbers as rows, JSON and CSV; a page in Markdown
    figures            use of the bounds inside; runs that leave the set outside
    folder             all files of a campaign, by file name

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.campaign.folder import CampaignReport as CampaignReport
    from takagi.reports.campaign.folder import campaign_files as campaign_files

__getattr__, __dir__ = lazy_names(__name__)
