"""The files that a design leaves: gains, certificate, report and figures; the LaTeX appendix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from takagi.certificates.design.design import Design

Files = dict[str, bytes | str]
Tell = Callable[[str], None]
# Kind of model -> what makes its gain file, report and appendix: module and function.
_MADE_BY: Mapping[str, Mapping[str, str]] = {
    "turbine": {
        "gains": "gains_file.turbine:gain_file",
        "report": "sections.turbine.page:report_html",
        "appendix": "appendix.design_files:appendix_files",
    },
    "plant": {
        "gains": "gains_file.plant:plant_gain_file",
        "report": "sections.plant.page:plant_report_files",
        "appendix": "appendix.design_files:plant_appendix",
    },
}


def design_files(design: Design, *, tell: Tell | None = None) -> Files:
    """Return relative name -> content, ready for ``takagi.reports.output.write_folder``.

    Names: ``gains.json`` (not for an analysis), ``certificate.json``, ``report.html``,
    ``figures/<name>.svg``, and of a plant the numbers beside them, ``figures/<name>.csv``.
    """
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.gains_file.envelope import dump_gains

    report = _made("report", design, tell=tell)
    found: Files = {}
    if "controller" in design.document:
        found["gains.json"] = dump_gains(_made("gains", design))
    found["certificate.json"] = dumps(design.document)
    found["report.html"] = report.html
    return found | {f"figures/{name}": content for name, content in report.figures.items()}


def appendix_files(design: Design, *, tell: Tell | None = None) -> Files:
    """Return relative name -> content of the LaTeX appendix: two texts, and figures as PDF."""
    files: Files = _made("appendix", design, tell=tell)
    return files


def _made(what: str, design: Design, **options: Any) -> Any:
    module, _, name = _MADE_BY[design.kind][what].partition(":")
    return getattr(import_module(f"takagi.reports.{module}"), name)(design, **options)
