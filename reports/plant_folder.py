"""The folder that ``takagi design`` leaves for a plant: gains, certificate, report, figures."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.design.plant.design import PlantDesign

__all__ = ["plant_files"]

Files = dict[str, bytes | str]


def plant_files(design: PlantDesign, *, tell: Callable[[str], None] | None = None) -> Files:
    """Return relative name -> content, ready for ``takagi.reports.output.write_folder``.

    Names: ``gains.json`` (not for an analysis), ``certificate.json``, ``report.html``,
    ``figures/<name>.svg`` and the numbers beside them, ``figures/<name>.csv``.
    """
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.gains_file.plant import plant_gain_file
    from takagi.reports.gains_file.turbine import dump_gains
    from takagi.reports.sections.plant.page import plant_report_files

    report = plant_report_files(design, tell=tell)
    found: Files = {}
    if design.gains is not None:
        found["gains.json"] = dump_gains(plant_gain_file(design))
    found["certificate.json"] = dumps(design.document)
    found["report.html"] = report.html
    return found | {f"figures/{name}": content for name, content in report.figures.items()}
