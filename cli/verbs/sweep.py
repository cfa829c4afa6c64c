"""`takagi sweep`: where a law is proved, over a grid of its parameters."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from takagi.cli.command import run_command
from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.options.design_options import Model
from takagi.cli.options.law_names import law_in_files, typed_name
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import progress
from takagi.cli.runs.makers import MAKERS
from takagi.cli.verbs.sweep_maps import LAWS, TRADE_OFF, SweptLaw
from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from takagi.certificates.sweep.grid import SweepMap, SweepResult
    from takagi.cli.progress import Tell
    from takagi.models.loading import ModelFile


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("sweep", sweep, arguments)


def sweep(
    model: Model,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write.")],
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AXIS",
            help="NAME=LOW:HIGH:COUNT or NAME=VALUE,VALUE,...; numbers in SI, or with their unit "
            "(0.5kNm). Give it once for each axis. Published laws: speed-overlap [rad/s], "
            "torque-overlap [N m], wind [m/s]; another law's are told when a name is not known.",
        ),
    ] = None,
    *,
    law: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"One of {', '.join(typed_name(law.law) for law in LAWS)}; "
            f"{typed_name(LAWS[0].law)} unless given, {typed_name(TRADE_OFF.law)} with "
            "--trade-off.",
            callback=law_in_files,
        ),
    ] = None,
    trade_off: Annotated[
        bool,
        typer.Option(
            "--trade-off",
            help="Law effort-sharing: the largest wind class against its overspeed bound, for all "
            "winds and by range, over overlap, bandwidth and speed-error unless --over says "
            "otherwise.",
        ),
    ] = False,
    workers: Annotated[
        int | None,
        typer.Option(metavar="N", help="Processes; as many as there are cores unless given."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
) -> int:
    """Map where a law of MODEL, a wind turbine, is proved, over a grid of its parameters.

    Every finished point is a line of points.jsonl in DIR: a sweep that was stopped goes on where
    it was when the same command is given again. Figures, tables and a page follow at the end.

    Exit status: 0 every point has its answer, PROVED or not; 1 a point ended in an error, and is
    tried again by the same command; 2 misuse.
    """
    source = _source(model)
    swept = _trade_off(law) if trade_off else _swept_law(law or LAWS[0].law)
    axes = over or _ready_made(swept)
    require_folder_place(out)
    with progress(f"takagi sweep {model}") as tell:
        try:
            result = _run(swept, source, out, axes, workers, tell)
        except KeyboardInterrupt:
            print(f"Finished points are kept in {out}: the same command goes on.", file=sys.stderr)
            raise
        files = _write(swept, result, out, tell)
    failed = result.counted().get("FAILED", 0)
    print(_as_json(result, out, files) if as_json else _as_text(result, out, files))
    return UNPROVED if failed else PROVED


def _source(model: str) -> ModelFile:
    from takagi.models.loading import read_model

    source = read_model(model)
    maker = MAKERS[source.kind]
    if not maker.has_maps:
        raise ModelError(
            f"takagi sweep maps the laws of a wind turbine, but model {model} is {maker.words}; "
            f"`takagi design` proves {maker.words}'s law"
        )
    return source


def _swept_law(name: str) -> SweptLaw:
    known = {law.law: law for law in LAWS}
    if name not in known:
        raise ModelError(
            f"--law {name}: no map is known of it{did_you_mean(name, known)}; known: "
            + ", ".join(known)
        )
    return known[name]


def _trade_off(law: str | None) -> SweptLaw:
    if law not in (None, TRADE_OFF.law):
        raise ModelError(
            f"--trade-off belongs to --law {typed_name(TRADE_OFF.law)}, but {law} was asked for; "
            "leave one of the two out"
        )
    return TRADE_OFF


def _ready_made(swept: SweptLaw) -> Sequence[str]:
    """Return the axes that a map has ready; refuses one that has none."""
    axes: Sequence[str] = getattr(import_module(swept.map), "READY_MADE", ())
    if not axes:
        raise ModelError(
            f"no axis was given: add --over NAME=LOW:HIGH:COUNT for --law {typed_name(swept.law)}; "
            "an unknown name lists those that there are"
        )
    return axes


def _run(
    swept: SweptLaw,
    source: ModelFile,
    out: Path,
    over: Sequence[str],
    workers: int | None,
    tell: Tell,
) -> SweepResult:
    from takagi.certificates.sweep.axis import parse_axes
    from takagi.certificates.sweep.runner import run_sweep

    maker = import_module(swept.map)
    axes = parse_axes(over, maker.AXES)
    asked: SweepMap = maker.build(swept.law, source.model, source.files, axes, tell)
    return run_sweep(asked, out, workers=workers, tell=tell)


def _write(swept: SweptLaw, result: SweepResult, out: Path, tell: Tell) -> list[str]:
    from takagi.reports.output import write_folder

    tell("figures and tables")
    files: dict[str, bytes | str] = import_module(swept.pages).pages(result)
    write_folder(out, files)
    return list(files)


def _as_text(result: SweepResult, out: Path, files: Sequence[str]) -> str:
    counted = ", ".join(f"{number} {verdict}" for verdict, number in result.counted().items())
    axes = " x ".join(f"{axis.name} ({len(axis.values)})" for axis in result.map.axes) or "1 point"
    lines = [f"{typed_name(result.map.name)} over {axes}: {counted}"]
    if result.resumed:
        lines.append(f"{result.resumed} of {len(result.points)} points were in the journal already")
    errors = [point for point in result.points if point.result["verdict"] == "FAILED"]
    for point in errors[:3]:
        at = ", ".join(f"{name} {value:g}" for name, value in point.at.items())
        lines.append(f"FAILED at {at}: {point.result['reason']}")
    return "\n".join([*lines, "", str(out), *(f"  {name}" for name in files)])


def _as_json(result: SweepResult, out: Path, files: Sequence[str]) -> str:
    return json.dumps(
        {
            "law": result.map.name,
            "axes": [
                {"name": axis.name, "unit": axis.unit, "values": list(axis.values)}
                for axis in result.map.axes
            ],
            "points": len(result.points),
            "resumed": result.resumed,
            "verdicts": result.counted(),
            "files": [str(out / name) for name in files],
        },
        indent=2,
    )
