"""`takagi certify`: a certificate alone, for gains that exist or for a new design."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.design.design import NoDesign
from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.given import refuse_designing
from takagi.cli.options.turbine_options import Model
from takagi.cli.output_place import require_file_place
from takagi.cli.progress import progress
from takagi.cli.runs.makers import DESIGN_OPTIONS, maker_of
from takagi.cli.runs.previous_certificate import (
    TOLERANCE,
    PreviousCertificate,
    compared,
    read_baseline,
    tolerance_of,
)
from takagi.cli.terminal.rows import claim_lines, claims_as_data, tell_none
from takagi.models.errors import ModelError
from takagi.reports.output import write_file

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.result import Checked
    from takagi.reports.baseline.comparison import CertificateComparison


def certify(
    model: Model,
    out: Path,
    gains: Path | None = None,
    gains_out: Path | None = None,
    baseline: Path | None = None,
    tolerance: str = TOLERANCE,
    *,
    as_json: bool = False,
    **options: Any,
) -> int:
    """Write a certificate for MODEL with the gains of a file, or with gains designed anew."""
    require_file_place(out)
    if gains_out is not None:
        _require_gains_out(gains, gains_out, out)
    share = tolerance_of(tolerance)
    old = None
    if baseline is not None:
        if out.exists() and baseline.exists() and out.samefile(baseline):
            raise ModelError(
                f"{out}: --out is the --baseline, which would be gone; give it a new place"
            )
        old = read_baseline(baseline)
    maker = maker_of(model, options)
    if gains is not None:
        refuse_designing(maker.asked)
        # Refused before the work where it is no JSON; imported here, for many have no such file.
        from takagi.certificates.checker.kernel.reader import read_json

        read_json(gains)
    with progress(f"takagi certify {model}") as tell:
        outcome = maker.design(tell) if gains is None else maker.certify(gains, tell)
        if isinstance(outcome, NoDesign):
            return tell_none(outcome, as_json=as_json)
        checked = outcome.checked
        document = _bound(outcome.document, checked, gains, gains_out)
        from takagi.certificates.document.certificate_file import dumps

        write_file(out, dumps(document))
    # A plant whose equations cannot be written has a certificate of its model's vertices alone.
    alone = not outcome.is_about_plant
    difference = None
    if old is not None:
        from takagi.certificates.checker.kernel.reader import read_text

        written = read_text(dumps(document), "certificate")
        difference = compared(old, PreviousCertificate(out, written, checked), share)
    warned = ""
    if gains is not None:
        from takagi.certificates.controller.content import differences_in_words

        differs = differences_in_words(document, gains) if gains_out is None else ""
        warned = "\n".join((*outcome.notes, *([differs] if differs else ())))
    _print(out, checked, gains_out or gains, old, difference, warned, alone=alone, as_json=as_json)
    passes = difference is None or difference.passes
    return PROVED if checked.verdict.name == "PROVED" and not alone and passes else UNPROVED


run = partial(run_command, "certify", certify, options=DESIGN_OPTIONS)


def _require_gains_out(gains: Path | None, gains_out: Path, out: Path) -> None:
    require_file_place(gains_out)
    if gains is None:
        raise ModelError(
            "option --gains-out writes the file of --gains anew; give that, or 'takagi design' "
            "for new gains"
        )
    if gains_out.resolve() == out.resolve():
        raise ModelError(f"{out}: --gains-out and --out are the same file; give two places")


def _bound(
    document: Mapping[str, Any], checked: Checked, gains: Path | None, gains_out: Path | None
) -> Mapping[str, Any]:
    """Return the certificate bound to the gain file that was given, or to the one written anew."""
    if gains is None:
        return document
    from takagi.certificates.controller.content import bound_to_file, refreshed

    controller = document.get("controller")
    if gains_out is None:
        return bound_to_file(document, gains, controller)
    from takagi.certificates.controller.plant_members import statement
    from takagi.reports.gains_file.envelope import dump_gains

    certificate, content = refreshed(document, gains, controller or {}, statement(checked))
    write_file(gains_out, dump_gains(content))
    return certificate


def _print(
    out: Path,
    checked: Checked,
    gains: Path | None,
    old: PreviousCertificate | None,
    difference: CertificateComparison | None,
    warned: str,
    *,
    alone: bool,
    as_json: bool,
) -> None:
    if as_json:
        data = {"certificate": str(out), **claims_as_data(checked)}
        if alone:
            data["vertices_alone"] = True
        if warned:
            data["notes"] = warned.splitlines()
        if old is not None and difference is not None:
            from takagi.reports.baseline.page import as_data

            data["baseline"] = {"certificate": str(old.source), **as_data(difference)}
        print(json.dumps(data, indent=2))
        return
    words = ", of the vertices alone: not of the plant" if alone else ""
    print("\n".join([f"{out}: {checked.verdict.name}{words}", *claim_lines(checked)]))
    if old is not None and difference is not None:
        from takagi.reports.baseline.page import as_text

        print(f"\n{as_text(difference, source=str(old.source))}")
    if warned:
        print(f"\n{warned}")
    companion = "" if gains is None else f" --gains {gains}"
    print(f"\nNext\n  takagi check {out}{companion}")
