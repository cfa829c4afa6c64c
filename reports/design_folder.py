"""The files that a design leaves, and the design that they are read as; the LaTeX appendix.

Imports the standard library and the checker's errors alone, since `takagi check` reads folders.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.design.design import Design
from takagi.certificates.document.certificate_file import dumps

if TYPE_CHECKING:
    from takagi.models.loading import ModelFile
    from takagi.reports.sections.plant.summary import SummaryRow

GAINS, CERTIFICATE, REPORT, RECORD = "gains.json", "certificate.json", "report.html", "design.json"
FIGURES, MODEL = "figures", "model"

Files = dict[str, bytes | str]
Tell = Callable[[str], None]
# Kind of model -> what makes its gain file, report, summary and appendix: module and function.
_MADE_BY: Mapping[str, Mapping[str, str]] = {
    "turbine": {
        "gains": "gains_file.envelope:gain_file",
        "report": "sections.turbine.page:report_html",
        "summary": "sections.turbine.summary:summary_rows",
        "appendix": "appendix.design_files:appendix_files",
    },
    "plant": {
        "gains": "gains_file.envelope:plant_gain_file",
        "report": "sections.plant.page:plant_report_files",
        "summary": "sections.plant.summary:summary_rows",
        "appendix": "appendix.design_files:plant_appendix",
    },
}


def design_files(
    design: Design, *, source: ModelFile | None = None, tell: Tell | None = None
) -> Files:
    """Return relative name -> content, ready for ``takagi.reports.output.write_folder``.

    Names: those of ``law_files``, then those of ``drawn_files``.

    Parameters
    ----------
    source : the model's file;  tell : called with a word before each step.
    """
    return law_files(design, source=source) | drawn_files(design, source=source, tell=tell)


def law_files(design: Design, *, source: ModelFile | None = None) -> Files:
    """Return relative name -> content of what a design is: law, proof and model; nothing is drawn.

    Names: ``gains.json`` (not for an analysis), ``certificate.json``, and with ``source`` what
    ``read_design`` needs besides: ``design.json`` and ``model/<name>``.
    """
    files: Files = {}
    if "controller" in design.document:
        files[GAINS] = gain_file_of(design)
    files[CERTIFICATE] = dumps(design.document)
    if source is not None:
        top = source.files[0]
        copies = {f"{MODEL}/{f.relative_to(top.parent).as_posix()}": f for f in source.files}
        files |= _record(design, source)
        files |= {name: copied.read_bytes() for name, copied in copies.items()}
    return files


def drawn_files(
    design: Design, *, source: ModelFile | None = None, tell: Tell | None = None
) -> Files:
    """Return the report's files, and of a turbine ``design.json`` with what was measured for it."""
    report = report_files(design, tell=tell)
    if source is None or design.kind == "plant":
        return report
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.reports.simulation.measured_loop import measured_loop

    assert isinstance(design, TurbineDesign)  # of kind "turbine"
    return _record(replace(design, measured=measured_loop(design)), source) | report


def unmeasured(design: Design) -> Design:
    """Return a turbine's design whose summary has no margins and no simulated runs."""
    if design.kind == "plant":
        return design
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.reports.simulation.measured_loop import NOTHING

    assert isinstance(design, TurbineDesign)  # of kind "turbine"
    return replace(design, measured=NOTHING)


def _record(design: Design, source: ModelFile) -> Files:
    from takagi.reports.design_record import design_record

    return {RECORD: design_record(design, source, f"{MODEL}/{source.files[0].name}")}


def gain_file_of(design: Design) -> str:
    """Return the text of ``gains.json``."""
    from takagi.reports.gains_file.envelope import dump_gains

    return dump_gains(_made("gains", design))


def report_files(design: Design, *, tell: Tell | None = None) -> Files:
    """Return relative name -> content of the report.

    Names: ``report.html``, ``figures/<name>.svg``, and of a plant the numbers beside them,
    ``figures/<name>.csv``.
    """
    report = _made("report", design, tell=tell)
    return {REPORT: report.html} | {f"{FIGURES}/{n}": text for n, text in report.figures.items()}


def summary_of(design: Design) -> Sequence[SummaryRow]:
    """Return the rows that terminal, report and formats of continuous integration show."""
    rows: Sequence[SummaryRow] = _made("summary", design)
    return rows


class DesignFolder(NamedTuple):
    """A finished design's folder: ``record`` is the content of design.json, the rest are places.

    ``gains`` is None of an analysis.
    """

    record: Mapping[str, Any]
    model: Path
    certificate: Path
    gains: Path | None


def design_folder(folder: Path) -> DesignFolder:
    """Return the parts of a folder of a design.

    Raises
    ------
    CertificateError : as ``design_file``, or a file is damaged.
    """
    record, certificate = _content(design_file(folder, RECORD)), design_file(folder, CERTIFICATE)
    name = str(record.get(MODEL))
    if not (folder / name).resolve().is_relative_to((folder / MODEL).resolve()):
        raise CertificateError(
            f"{folder}: {RECORD} names a model outside of {MODEL}/; {_again(folder)}"
        )
    model = design_file(folder, name)
    gains = design_file(folder, GAINS) if "controller" in _content(certificate) else None
    return DesignFolder(record, model, certificate, gains)


def read_design(folder: Path, *, tell: Tell | None = None) -> Design:
    """Return the design in a folder; nothing is designed again, and the certificate is checked.

    Raises
    ------
    CertificateError : as ``design_folder``, or gains, certificate and model are not of one design.
    ModelError : the model, or ``design.json``, cannot be read; another version may have written it.
    """
    paths = design_folder(folder)
    from takagi.reports.design_record import design_of_record

    design = design_of_record(*paths, tell=tell)
    if paths.gains is not None and paths.gains.read_text(encoding="utf-8") != gain_file_of(design):
        raise CertificateError(
            f"{folder}: the gains or texts of {RECORD} are not those of {GAINS}, so that one of "
            f"both was changed; {_again(folder)}"
        )
    return design


def _content(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        content = None
    if not isinstance(content, dict):
        raise CertificateError(f"{path}: is damaged; {_again(path.parent)}")
    return content


def design_file(folder: Path, name: str) -> Path:
    """Return the place of a file of a design.

    Raises
    ------
    CertificateError : no such folder, or none of a design; or the file is missing.
    """
    if (folder / name).is_file():
        return folder / name
    if not any((folder / file_name).is_file() for file_name in (GAINS, CERTIFICATE, RECORD)):
        problem = "holds no design" if folder.is_dir() else "no such folder of a design"
        raise CertificateError(
            f"{folder}: {problem}; make one with 'takagi design MODEL --out DIR', and give DIR"
        )
    raise CertificateError(
        f"{folder}: {name} is missing, of a folder that is incomplete or of an earlier version of "
        f"takagi; {_again(folder)}"
    )


def refuse_to_replace(folder: Path) -> None:
    """Return if the folder holds no design.

    Raises
    ------
    CertificateError : it holds one.
    """
    for name in (GAINS, CERTIFICATE, RECORD):
        if (folder / name).is_file():
            raise CertificateError(
                f"{folder}: holds a design already ({name}); give another folder, or --force to "
                "replace it"
            )


def _again(folder: Path) -> str:
    return f"design again with 'takagi design MODEL --out {folder} --force'"


def appendix_files(design: Design, *, tell: Tell | None = None) -> Files:
    """Return relative name -> content of the LaTeX appendix: two texts, and figures as PDF."""
    files: Files = _made("appendix", design, tell=tell)
    return files


def _made(output: str, design: Design, **options: Any) -> Any:
    module, _, name = _MADE_BY[design.kind][output].partition(":")
    return getattr(import_module(f"takagi.reports.{module}"), name)(design, **options)
