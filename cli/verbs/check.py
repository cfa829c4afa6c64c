"""`takagi check`: prove a certificate file, with the standard library and the checker alone.

Only this verb is parsed by argparse: it runs in continuous integration and on small machines, and
must not depend on packages outside the trusted code.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from takagi.cli.command import MISUSE, PROVED, UNPROVED, tell_error
from takagi.cli.progress import progress
from takagi.cli.terminal.rows import claim_lines, claims_as_data, trusted_text
from takagi.cli.texts import option_words, verb_text

if TYPE_CHECKING:
    from takagi.certificates.audit.trusted_lines import Trusted
    from takagi.certificates.cross_check.comparison import VerdictComparison
    from takagi.reports.ci_formats import CheckedFile
    from takagi.reports.margins.thresholds import AskedMargins

_USAGE = "takagi check [OPTIONS] CERT"


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    parser = _parser()
    parser.as_json = "--json" in arguments
    try:
        options = parser.parse_args(list(arguments))
        if options.c_source and not options.gains:
            parser.error("--c-source needs --gains FILE, the gain file that it was exported from")
        if options.margins and not (options.gains and options.model):
            parser.error("--margins needs --gains FILE and --model FILE, the law and its turbine")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else MISUSE
    return _check(options)


def _check(options: argparse.Namespace) -> int:
    from takagi.certificates.checker import CertificateError

    # What is asked wrongly is refused before the long work.
    asked = None
    if options.margins:
        # Imported here, with all that linearises: few users ask for it; it is not trusted code.
        from takagi.reports.margins.thresholds import asked_margins

        asked = asked_margins(options.margins)
    _require_places(options)
    try:
        if options.certificate.is_dir():
            _take_folder(options)
        with progress(f"takagi check {options.certificate}"):
            checked, trusted = _verdict(options)
    except CertificateError as error:
        # Continuous integration shows the refusal where it shows results.
        from takagi.reports.ci_formats import refusal

        needed, is_another = _needed(error, options)
        _write_reports(options, refusal(str(error), needed=needed))
        if not is_another:
            raise  # the status is the boundary's, as for any misuse
        # The certificate is valid but about another loop, so nothing is proved for this one.
        tell_error(str(error), UNPROVED, as_json=options.json)
        return UNPROVED
    missed, lines = _further(options, asked)
    if missed or lines:
        # Imported here: most checks ask for nothing beside the claims.
        from takagi.reports.ci_formats import with_failures

        checked = with_failures(checked, missed, lines)
    _write_reports(options, checked)
    if options.json:
        compared = _compared(options) if options.cross else None
        print(_as_json(options, checked, trusted, compared))
    else:
        # Printed before FLINT decides, because that may take long.
        print(_as_text(options, checked, trusted))
        compared = _compared(options) if options.cross else None
        if compared is not None:
            print(compared.text)
    if compared is not None and not compared.agrees:
        from takagi.reports.ci_formats import with_failures

        differ = ("both deciders agree", compared.text)
        _write_reports(options, with_failures(checked, [differ]))
        return UNPROVED
    return PROVED if checked.verdict.name == "PROVED" else UNPROVED


def _take_folder(options: argparse.Namespace) -> None:
    """Take certificate, gains and model of a design's folder; files that are named are kept."""
    # Imported here: most checks are given a file.
    from takagi.reports.design_folder import design_folder

    options.folder = options.certificate
    design = design_folder(options.folder)
    options.certificate = design.certificate
    options.plant_file = options.model or Path(str(design.record.get("given")))
    options.gains, options.model = options.gains or design.gains, options.model or design.model


def _require_places(options: argparse.Namespace) -> None:
    """Refuse reports that cannot be written, and a C file that cannot be read."""
    if reports := [report for report in (options.junit, options.sarif, options.summary) if report]:
        # Imported here: most checks write no report.
        from takagi.cli.output_place import require_file_place

        for report in reports:
            require_file_place(report)
    if options.c_source:
        from takagi.reports.code.c.comparison import require_readable

        require_readable(options.c_source)


def _further(
    options: argparse.Namespace, asked: AskedMargins | None
) -> tuple[list[tuple[str, str]], list[str]]:
    """Return what is asked beside the claims and missed, with its reason; and lines on the rest."""
    missed: list[tuple[str, str]] = []
    lines: list[str] = []
    # Imported here: most checks ask for neither, and neither is trusted code.
    if options.c_source:
        from takagi.reports.code.c.comparison import source_differences

        if found := source_differences(options.c_source, options.gains):
            missed.append(("the C file is the gain file's", "; ".join(found)))
        else:
            lines.append(f"{options.c_source}: it is the export of {options.gains}, byte by byte")
    if options.folder and (options.junit or options.summary) and (why := _take_summary(options)):
        missed.append(("the folder holds the design of the certificate", why))
    if asked is not None:
        from takagi.reports.simulation.measured_loop import filed_margins

        model = _file_of(options.model)
        assert model is not None  # run() asks for it
        with progress(f"takagi check {options.certificate}: margins"):
            below, measured = filed_margins(asked, options.gains, model)
        if below:
            reason = f"{options.gains}: {'; '.join(below)}"
            missed.append(("the loop that runs has the margins asked", reason))
        lines += measured
    return missed, lines


def _needed(error: Exception, options: argparse.Namespace) -> tuple[str, bool]:
    """Return the failed requirement, and whether the file is valid but about something else."""
    from takagi.certificates.checker.files.model_content import OtherModel
    from takagi.certificates.checker.kernel.refusal import OtherGains

    if isinstance(error, OtherGains):
        return "the gain file is the certificate's", True
    if isinstance(error, OtherModel):
        return "the model file is the certificate's", True
    # Every refusal begins with the file that it is about.
    for kind, path in (("gain", options.gains), ("model", _file_of(options.model))):
        if path is not None and path != options.certificate and str(error).startswith(f"{path}:"):
            return f"the {kind} file can be read", False
    return "the file is a certificate", False


def _verdict(options: argparse.Namespace) -> tuple[CheckedFile, Trusted | None]:
    """Return the verdict, and what it ran through where that is asked."""
    given = {"gains": options.gains, "model": _file_of(options.model)}
    if options.allow_old_gain_files:
        given["allow_old_gain_files"] = True
    if not options.trusted:
        from takagi.certificates.checker import check

        return check(options.certificate, **given), None
    from takagi.certificates.audit.trusted_lines import check_counted

    return check_counted(options.certificate, **given)


def _file_of(model: Path | None) -> Path | None:
    """Return the file of a built-in name, as other verbs read MODEL; any other path as it is."""
    if model is None or model.name != str(model) or model.suffix or model.is_file():
        return model
    # Imported here: most checks are given a path.
    from takagi.models.files.library import data_folder

    built_in = data_folder() / f"{model}.toml"
    return built_in if built_in.is_file() else model


def _compared(options: argparse.Namespace) -> VerdictComparison:
    # Imported here: the checker needs the standard library alone.
    from takagi.certificates.cross_check.comparison import cross_checked

    with progress(f"takagi check {options.certificate}: decided by FLINT"):
        return cross_checked(options.certificate)


def _write_reports(options: argparse.Namespace, checked: CheckedFile) -> None:
    if not (options.junit or options.sarif or options.summary):
        return
    # Imported here: most checks write no report.
    from takagi.reports import ci_formats
    from takagi.reports.output import write_file

    source = str(options.certificate)
    if options.junit:
        report = ci_formats.junit(checked, source=source, summary=options.rows)
        write_file(options.junit, report)
    if options.sarif:
        kinds = _kinds(options.certificate) if checked.verdict.name != "REFUSED" else []
        # The user's file, given or designed from; a built-in model has none.
        file = options.plant_file or options.model
        plant = file if file is not None and file.suffix and file.is_file() else None
        report = ci_formats.sarif(checked, source=source, kinds=kinds, plant=plant)
        write_file(options.sarif, report)
    if options.summary:
        report = ci_formats.markdown(checked, source=source, summary=options.rows)
        write_file(options.summary, report)


def _take_summary(options: argparse.Namespace) -> str:
    """Take the summary of a folder's design, by all of takagi; return why it has none."""
    from takagi.certificates.checker import CertificateError
    from takagi.models.errors import ModelError
    from takagi.reports.design_folder import read_design, summary_of

    with progress(f"takagi check {options.folder}: summary") as tell:
        try:
            options.rows = summary_of(read_design(options.folder, tell=tell))
        except (ModelError, CertificateError) as error:
            return str(error)
    return ""


def _kinds(certificate: Path) -> list[str]:
    """Return the kinds of a certificate's claims; none of a file that is refused."""
    try:
        return [str(claim["kind"]) for claim in json.loads(certificate.read_bytes())["claims"]]
    except (OSError, ValueError, LookupError, TypeError):
        return []


def _as_text(options: argparse.Namespace, checked: CheckedFile, trusted: Trusted | None) -> str:
    lines = [f"{options.certificate}: {checked.verdict.name}", *claim_lines(checked)]
    lines += checked.messages
    if trusted is not None:
        lines.append(trusted_text(trusted))
    return "\n".join(lines)


def _as_json(
    options: argparse.Namespace,
    checked: CheckedFile,
    trusted: Trusted | None,
    compared: VerdictComparison | None,
) -> str:
    answer: dict[str, Any] = {
        "certificate": str(options.certificate),
        **claims_as_data(checked),
        "messages": list(checked.messages),
    }
    if trusted is not None:
        # Imported here: few ask for it.
        from takagi.cli.terminal.rows import as_data

        answer["trusted"] = as_data(trusted)
    if compared is not None:
        answer["cross"] = compared.data
    return json.dumps(answer, indent=2)


class _Parser(argparse.ArgumentParser):
    """argparse, speaking like the other verbs."""

    as_json = False

    def error(self, message: str) -> NoReturn:
        if self.as_json:
            tell_error(message, MISUSE, as_json=True)
            raise SystemExit(MISUSE)
        text = f"Usage: {_USAGE}\nTry 'takagi check --help' for help.\n\nError: {message}"
        print(text, file=sys.stderr)
        raise SystemExit(MISUSE)

    def format_help(self) -> str:
        # argparse alone writes "usage:" and "options:" in small letters.
        text = super().format_help()
        return text.replace("usage: ", "Usage: ", 1).replace("\noptions:", "\nOptions:", 1)


def _parser() -> _Parser:
    parser = _Parser(
        prog="takagi check",
        usage=_USAGE,
        description=verb_text("check"),
        epilog=verb_text("check, behind the options"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    arguments = parser.add_argument_group("Arguments")
    arguments.add_argument(
        "certificate",
        metavar="CERT",
        type=Path,
        help="the certificate file, or the folder of a design",
    )
    for declared, words in option_words("check").items():
        name, _, metavar = declared.partition(" ")
        kind: dict[str, Any] = {"metavar": metavar, "type": str if metavar == "TEXT" else Path}
        parser.add_argument(
            f"--{name}", help=words, **kind if metavar else {"action": "store_true"}
        )
    parser.set_defaults(plant_file=None, folder=None, rows=())
    return parser
