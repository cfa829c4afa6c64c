"""`takagi simulate TURBINE --certificate FILE`: random runs compared with what the file claims."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.cli.command import PROVED, UNPROVED
from takagi.cli.options.given import declared, defaults_of, option_of
from takagi.cli.progress import progress
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.turbine.loader import TurbineFile

RUNS, RUNS_BEYOND = 10_000, 2000
CAMPAIGN_OPTIONS = declared("simulate-campaign")


def simulate_campaign(
    source: TurbineFile,
    out: Path | None,
    options: Mapping[str, Any],
    scenario: Mapping[str, Any],
    *,
    duration: float | None,
    as_json: bool,
) -> int:
    """Read and check the certificate, run, print; return the exit status.

    options : those of ``CAMPAIGN_OPTIONS``, ``seed``, and those of a scenario.
    scenario : the defaults of the latter; of them only ``seed`` may be given.

    Raises ModelError: options that do not go together, or make no sense.
    Raises CertificateError: the file is no certificate, or not about this model.
    """
    for name, default in scenario.items():
        if name != "seed" and options[name] != default and options[name] != []:
            raise ModelError(
                f"option {option_of(name)} is about a scenario; with --certificate the "
                "law and the winds are the certificate's: leave it out"
            )
    from takagi.certificates.campaign import runs as campaign
    from takagi.certificates.checker.replay.certificate import check
    from takagi.certificates.sweep.store import RESULTS
    from takagi.cli.output_place import require_folder_place
    from takagi.reports.output import write_folder
    from takagi.reports.sweep import campaigns

    texts = options["beyond"] or []
    requests = [name for text in texts for name in (campaign.STANDARD if text == "all" else [text])]
    asked = [campaign.beyond_of(request) for request in requests]
    runs = (RUNS_BEYOND if asked else RUNS) if options["runs"] is None else options["runs"]
    duration = campaign.DURATION if duration is None else duration
    seed: int = options["seed"] or 0
    # Before the certificate is checked, which takes seconds.
    campaign.require_numbers(runs, duration=duration, seed=seed)
    if out is not None:
        require_folder_place(out, files=campaigns.FILES, folders=("figures", RESULTS))
    path: Path = options["certificate"]
    written: list[str] = []
    # Without --out nothing is kept.
    place = nullcontext(out / RESULTS) if out is not None else tempfile.TemporaryDirectory()
    with progress(f"takagi simulate {source.name}") as tell, place as folder:
        tell("checking the certificate", 0.0)
        # Strictly read, and about this model: what is simulated is what the checker judged.
        verdict = check(path, model=source.document.path).verdict.name
        try:
            results = campaign.run_campaigns(
                path,
                Path(folder),
                asked or [campaign.INSIDE],
                runs=runs,
                duration=duration,
                seed=seed,
                workers=options["workers"],
                scheduler=options["scheduler"],
                tell=tell,
            )
        except KeyboardInterrupt:
            if out is not None:
                print(
                    f"Finished runs are kept in {out}: the same command goes on.", file=sys.stderr
                )
            raise
        report = campaigns.CampaignReport(str(source.model.name), verdict, results)
        if out is not None:
            tell("figure and table")
            files = campaigns.campaign_files(report)
            write_folder(out, files)
            written = [str(out / name) for name in files]
    if as_json:
        print(campaigns.as_json(report, written), end="")
    else:
        print("\n".join([campaigns.as_text(report), *written]))
    inside = report.inside
    violated = inside is not None and inside.violations
    return PROVED if verdict == "PROVED" and not violated else UNPROVED


def without_campaign(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a scenario, where no certificate is given.

    Raises ModelError: an option that needs --certificate.
    """
    declared = defaults_of(CAMPAIGN_OPTIONS)
    for name in declared:
        if options[name] not in (None, []):
            raise ModelError(
                f"option --{name} is about random runs of a certified loop; give the certificate "
                "too: --certificate FILE"
            )
    return {name: value for name, value in options.items() if name not in declared}
