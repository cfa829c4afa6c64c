"""Designs without what takes long and is tested in ``tests/reports``: drawing, margins, runs."""

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


def unmeasured(patch: pytest.MonkeyPatch) -> None:
    """Let the summary of a turbine have neither margins nor simulated runs."""
    from takagi.reports.margins.running_search import SearchedMargins
    from takagi.reports.sections.turbine import summary, verdict

    patch.setattr(summary, "design_margins", lambda _: SearchedMargins((), (), (), ()))
    patch.setattr(verdict, "step_and_gust_runs", lambda _: {})
    for runs in ("every_run", "step_and_gust_runs", "turbulent_runs"):
        patch.setattr(summary, runs, lambda _: {})
