"""Designs without what takes long and is tested in ``tests/reports``: drawing, margins, runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from takagi.certificates import TurbineDesign
from takagi.reports.margins.running_loop import NOMINAL, RunningLoops
from takagi.reports.margins.running_over_wind import SearchedMargins, running_margins
from takagi.reports.simulation import measured_loop
from takagi.reports.simulation.measured_loop import MeasuredLoop

WIND = 8.0


def few_margins(patch: pytest.MonkeyPatch) -> None:
    """Let a turbine's pages have the margins at one wind alone, and no runs: all take a minute."""

    def at_one_wind(design: TurbineDesign) -> MeasuredLoop:
        observer, speed_filter = design.observer.observer, design.speed_filter
        loops = RunningLoops.of(design.turbine, design.law, observer, speed_filter=speed_filter)
        rows = running_margins(loops, [WIND], plants=[NOMINAL])
        return MeasuredLoop(SearchedMargins(tuple(rows), (WIND,), (), ()), ())

    patch.setattr(measured_loop, "_measured_now", at_one_wind)


@contextmanager
def undrawn() -> Iterator[None]:
    """Let a plant's report and appendix be one word, and its one figure be empty."""
    from takagi.reports.appendix import plant as latex
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.plant import page

    files = ReportFiles("<!doctype html><title>report</title>", {"phase.svg": b"<svg/>"})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "plant_report_files", lambda *_, **__: files)
        patch.setattr(latex, "plant_appendix", lambda *_, **__: {"appendix.tex": "%"})
        yield


@contextmanager
def blank_figures() -> Iterator[None]:
    """Let every figure of a page be empty: ``tests/reports/test_figures`` looks at them."""
    from takagi.reports.figures import style
    from takagi.reports.simulation import plant, tables

    with pytest.MonkeyPatch.context() as patch:
        for place in (style, tables, plant):
            patch.setattr(place, "figure_to_svg", lambda *_, **__: "<svg/>")
        patch.setattr(tables, "figure_to_png", lambda *_, **__: b"PNG")
        patch.setattr(style, "figure_to_pdf", lambda _: b"%PDF")
        yield


def unmeasured(patch: pytest.MonkeyPatch) -> None:
    """Let the summary of a turbine have neither margins nor simulated runs."""
    patch.setattr(measured_loop, "_measured_now", lambda _: measured_loop.NOTHING)
