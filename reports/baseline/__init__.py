"""Comparison of a certificate with an earlier one: worse figures, lost claims, changed inputs.

    claim_figures    the numbers by which a claim is stronger or weaker, kind by kind
    comparison       two certificates: every figure of the old one that the new one does not keep
    changes          the parameters, gains and options that differ
    words            what it means that a figure is better or worse
    formats          the comparison as a table, Markdown, or plain data

Names are looked up when they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.baseline.changes import listed_changes as listed_changes
    from takagi.reports.baseline.comparison import CertificateComparison as CertificateComparison
    from takagi.reports.baseline.comparison import Moved as Moved
    from takagi.reports.baseline.comparison import compare_certificates as compare_certificates
    from takagi.reports.baseline.comparison import gain_sizes as gain_sizes
    from takagi.reports.baseline.words import as_data as as_data
    from takagi.reports.baseline.words import as_markdown as as_markdown
    from takagi.reports.baseline.words import as_text as as_text
    from takagi.reports.baseline.words import gain_words as gain_words
    from takagi.reports.baseline.words import word_of as word_of

__getattr__, __dir__ = lazy_names(__name__)
