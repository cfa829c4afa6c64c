"""The folder that ``takagi design`` leaves: gains, certificate, report and its figures."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.design import TurbineDesign

__all__ = ["design_files"]


def design_files(
    design: TurbineDesign, *, tell: Callable[[str], None] | None = None
) -> dict[str, bytes | str]:
    """Return relative name -> content, ready for ``takagi.reports.output.write_folder``.

    Names: ``gains.json``, ``certificate.json``, ``report.html``, ``figures/<name>.svg``.
    """
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.gains_file.turbine import dump_gains, gain_file
    from takagi.reports.sections.turbine import report_html

    report = report_html(design, tell=tell)
    return {
        "gains.json": dump_gains(gain_file(design)),
        "certificate.json": dumps(design.document),
        "report.html": report.html,
        **{f"figures/{name}": content for name, content in report.figures.items()},
    }
