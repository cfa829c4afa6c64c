"""Verbs that design a plant, without drawing its report: that is tested in ``tests/reports``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def undrawn() -> Iterator[None]:
    """Let a plant's report and appendix be one word, and its one figure be empty."""
    from takagi.reports.appendix import design_files as latex
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.plant import page

    files = ReportFiles("<!doctype html><title>report</title>", {"phase.svg": b"<svg/>"})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "plant_report_files", lambda *_, **__: files)
        patch.setattr(latex, "plant_appendix", lambda *_, **__: {"appendix.tex": "%"})
        yield
