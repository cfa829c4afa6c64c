"""`takagi simulate TURBINE --certificate FILE`: random runs compared with what the file claims."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.options.given import defaults_of, option_of
from takagi.cli.progress import Tell, progress
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.campaign.outside import Beyond
    from takagi.certificates.campaign.runs import Campaign
    from takagi.models.turbine.loader import TurbineFile
    from takagi.reports.campaign.folder import CampaignReport

RUNS, RUNS_BEYOND = 10_000, 2000
_WIDTH = 100  # in a pipe or a file there is no terminal to fit into
_DRAWING = 0.97


def campaign_options(
    certificate: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Turbines: random runs of the loop that a certificate speaks of, each compared "
            "with every bound that it claims, in place of a scenario.",
        ),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(
            help=f"With --certificate: how many; {RUNS} unless given, {RUNS_BEYOND} with --beyond."
        ),
    ] = None,
    beyond: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WHAT",
            help="With --certificate: runs outside of the claim, to see which bound fails first: "
            "3 or wind=3 (the wind class times 3), wind-error=3, wind-rate=3, start=4 (starts with "
            "V up to 4), inertia=0.8:1.2, wake=1.5, or all. May be repeated.",
        ),
    ] = None,
) -> None:
    """Declare what a campaign of random runs may be asked for."""


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

    Parameters
    ----------
    options : ``certificate``, ``runs``, ``beyond`` and ``seed``, and those of a scenario.
    scenario : the defaults of the latter; of them only ``seed`` may be given.

    Raises
    ------
    ModelError : options that do not go together, or make no sense.
    CertificateError : the file is no certificate, or not about this model.
    """
    _refuse_scenario(options, scenario)
    if out is not None:
        from takagi.cli.output_place import require_folder_place
        from takagi.reports.campaign.folder import FILES

        require_folder_place(out, files=FILES, folders=("figures",))
    asked = _beyond(options["beyond"] or [])
    written: list[str] = []
    with progress(f"takagi simulate {source.name}") as tell:
        tell("checking the certificate", 0.0)
        report = _run(source.document.path, options, asked, duration, tell)
        if out is not None:
            from takagi.reports.campaign.folder import campaign_files
            from takagi.reports.output import write_folder

            tell("figures and tables", _DRAWING)
            files = campaign_files(report)
            write_folder(out, files)
            written = [str(out / name) for name in files]
    if as_json:
        from takagi.reports.campaign.tables import as_json as json_text

        print(json_text(report.inside, report.beyond, report.about, written), end="")
    else:
        _print(report, written)
    inside = report.inside
    proved = report.verdict == "PROVED"
    kept = inside is None or not (inside.violations or inside.coarse)
    return PROVED if proved and kept else UNPROVED


def without_campaign(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a scenario, where no certificate is given.

    Raises
    ------
    ModelError : an option that needs --certificate.
    """
    own = defaults_of((campaign_options,))
    for name in own:
        if options[name] not in (None, []):
            raise ModelError(
                f"option --{name} is about random runs of a certified loop; give the certificate "
                "too: --certificate FILE"
            )
    return {name: value for name, value in options.items() if name not in own}


def _refuse_scenario(given: Mapping[str, Any], defaults: Mapping[str, Any]) -> None:
    for name, default in defaults.items():
        if name != "seed" and given[name] != default and given[name] != []:
            raise ModelError(
                f"option {option_of(name)} is about a scenario; with --certificate the "
                "law and the winds are the certificate's: leave it out"
            )


def _beyond(texts: list[str]) -> list[Beyond]:
    from takagi.certificates.campaign.outside import STANDARD, beyond_of

    found: list[Beyond] = []
    for text in texts:
        found += STANDARD if text == "all" else [beyond_of(text)]
    return found


def _run(
    model: Path, options: Mapping[str, Any], asked: list[Beyond], duration: float | None, tell: Tell
) -> CampaignReport:
    from takagi.certificates.campaign.outside import INSIDE
    from takagi.certificates.campaign.runs import DURATION, require_numbers, run_campaign
    from takagi.certificates.checker.replay.certificate import check
    from takagi.reports.campaign.folder import CampaignReport

    default = RUNS_BEYOND if asked else RUNS
    runs = default if options["runs"] is None else options["runs"]
    lasting = DURATION if duration is None else duration
    seed = options["seed"] or 0
    # Before the certificate is checked, which takes seconds.
    require_numbers(runs, lasting, seed)
    path = options["certificate"]
    # Strictly read, and about this model: what is simulated is what the checker judged.
    verdict = check(path, model=model).verdict.name
    document = json.loads(path.read_text(encoding="utf-8"))
    parts = asked or [INSIDE]
    found = []
    for i, beyond in enumerate(parts):

        def told(words: str, done: float, before: int = i) -> None:
            tell(words, _DRAWING * (before + done) / len(parts))

        found.append(
            run_campaign(
                document,
                runs=runs,
                duration=lasting,
                seed=seed,
                beyond=beyond,
                tell=told,
            )
        )
    inside = None if asked else found[0]
    return CampaignReport(found[0].loop.name, verdict, inside, found if asked else [])


def _print(report: CampaignReport, written: list[str]) -> None:
    from rich.console import Console

    from takagi.reports.campaign.tables import sentence

    width = None if sys.stdout.isatty() else _WIDTH
    console = Console(file=sys.stdout, width=width, highlight=False)
    print(f"{report.model}: random runs of the certified loop; the certificate is {report.verdict}")
    if report.inside is not None:
        console.print(_inside_table(report.inside))
        print(f"\n{sentence(report.inside)}.")
        print("A share of 1 is the bound itself; late is the second half of the runs.")
    if report.beyond:
        console.print(_beyond_table(report))
        print("\nOutside of the certificate: no bound is promised here.")
    print("A simulation proves nothing.")
    if written:
        names = ", ".join(Path(name).name for name in written if "figures" not in name)
        print(f"\n{Path(written[0]).parent}\n  {names}, figures/")


def _inside_table(inside: Campaign) -> Any:
    from takagi.reports.campaign.tables import bound_rows

    table = _table("bound", "largest share", "late", "violations", "step halving")
    for row in bound_rows(inside):
        table.add_row(
            row["bound"],
            *("–" if row[x] is None else f"{row[x]:.4f}" for x in
              ("largest_share", "largest_share_late")),
            str(row["violations"]),
            f"{row['step_halving']:.0e}",
        )  # fmt: skip
    return table


def _beyond_table(report: CampaignReport) -> Any:
    from takagi.reports.campaign.tables import beyond_row, first_words

    table = _table("beyond", "leave\nthe set", "V\nup to", "over-\nspeed", "in the set\nat the end")
    table.add_column("first other bound that breaks", justify="left", vertical="bottom")
    for row in map(beyond_row, report.beyond):
        table.add_row(
            row["beyond"],
            f"{100 * row['left_set']:.1f} %",
            f"{row['largest_value']:.3g}",
            f"{row['overspeed']:.2f} %",
            f"{100 * row['inside_at_end']:.1f} %",
            first_words(row),
        )
    return table


def _table(first: str, *others: str) -> Any:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    table.add_column(first, no_wrap=True, vertical="bottom")
    for head in others:
        table.add_column(head, justify="right", vertical="bottom")
    return table
