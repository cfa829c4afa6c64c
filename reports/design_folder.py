"""The files that a design leaves: gains, certificate, report and figures; the LaTeX appendix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from takagi.certificates.design.design import Design

__all__ = ["appendix_files", "design_files"]

Files = dict[str, bytes | str]
Tell = Callable[[str], None]
# Kind of model -> what its pages are made by, module and function.
_GAINS: Mapping[str, tuple[str, str]] = {
    "turbine": ("gains_file.turbine", "gain_file"),
    "plant": ("gains_file.plant", "plant_gain_file"),
}
_REPORT: Mapping[str, tuple[str, str]] = {
    "turbine": ("sections.turbine.page", "report_html"),
    "plant": ("sections.plant.page", "plant_report_files"),
}
_APPENDIX: Mapping[str, tuple[str, str]] = {
    "turbine": ("appendix.turbine_files", "appendix_files"),
    "plant": ("appendix.plant_files", "plant_appendix"),
}


def design_files(design: Design, *, tell: Tell | None = None) -> Files:
    """Return relative name -> content, ready for ``takagi.reports.output.write_folder``.

    Names: ``gains.json`` (not for an analysis), ``certificate.json``, ``report.html``,
    ``figures/<name>.svg``, and of a plant the numbers beside them, ``figures/<name>.csv``.
    """
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.gains_file.turbine import dump_gains

    report = _maker(_REPORT, design)(design, tell=tell)
    found: Files = {}
    if "controller" in design.document:
        found["gains.json"] = dump_gains(_maker(_GAINS, design)(design))
    found["certificate.json"] = dumps(design.document)
    found["report.html"] = report.html
    return found | {f"figures/{name}": content for name, content in report.figures.items()}


def appendix_files(design: Design, *, tell: Tell | None = None) -> Files:
    """Return relative name -> content of the LaTeX appendix: two texts, and figures as PDF."""
    files: Files = _maker(_APPENDIX, design)(design, tell=tell)
    return files


def _maker(table: Mapping[str, tuple[str, str]], design: Design) -> Callable[..., Any]:
    module, name = table[design.kind]
    found: Callable[..., Any] = getattr(import_module(f"takagi.reports.{module}"), name)
    return found
