"""`takagi simulate` for a turbine: laws side by side in the same winds, or random runs."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.cli.command import PROVED, UNPROVED
from takagi.cli.options.given import Options, declared, defaults_of, option_of
from takagi.cli.options.plant_options import time_asked
from takagi.cli.options.turbine_options import law_in_files
from takagi.cli.options.turbine_settings import typed_size
from takagi.cli.output_place import kept_results, require_folder_place
from takagi.cli.progress import Tell, progress
from takagi.models.errors import ModelError
from takagi.reports.output import write_folder

if TYPE_CHECKING:
    from takagi.models.simulation.turbine_plant import SimulatedTurbine
    from takagi.models.turbine.loader import TurbineFile

# The whole as one bar: when the laws are made, and when they are simulated.
_MAKING, _SIMULATING = 0.2, 0.95
SCENARIO_OPTIONS = declared("simulate-turbine", "simulate-shared", callback=law_in_files)
CAMPAIGN_OPTIONS = declared("simulate-campaign")
OPTIONS: Options = (*SCENARIO_OPTIONS, *CAMPAIGN_OPTIONS)
# How often a turbine's law runs unless it is said [s].
SAMPLE_TIME = 0.02
SETPOINT_UNITS = {"speed": "rad/s", "power": "W"}


def simulate(
    source: TurbineFile,
    out: Path | None,
    asked: Mapping[str, Any],
    *,
    duration: float | None,
    as_json: bool,
) -> int:
    """Simulate laws side by side, or random runs of a certified loop; return the exit status."""
    if asked["certificate"] is not None:
        return _campaign(source, out, asked, duration=duration, as_json=as_json)
    for name in defaults_of(CAMPAIGN_OPTIONS):
        if asked[name] not in (None, []):
            raise ModelError(
                f"option --{name} is about random runs of a certified loop; give the certificate "
                "too: --certificate FILE"
            )
    if out is not None:
        files = ("summary.md", "simulation.csv", "simulation.json")
        require_folder_place(out, files=files, folders=("figures", "series"))
    from takagi.reports.simulation.laws import (
        chosen_laws,
        default_laws,
        filed_laws,
        require_law_names,
        with_setpoints,
    )
    from takagi.reports.simulation.runs import (
        PlantParts,
        require_sampling,
        run_simulation,
        simulation_plant,
    )
    from takagi.reports.simulation.winds import DEFAULT_WINDS, requested_winds

    # All that can be refused is refused before the long work.
    law, law_from = asked["law"], asked["law_from"]
    turbine, filed = source.model, None
    names = () if law_from and not law else require_law_names(law or default_laws(turbine))
    if law_from and asked["coupling_filter"] is not None:
        raise ModelError(
            "--coupling-filter was given with --law-from; the gain file has a filter of its own: "
            "leave the option out"
        )
    if law_from:
        turbine, filed = filed_laws(turbine, law_from, names)
    if asked["setpoint"]:
        turbine, filed = with_setpoints(turbine, filed, _setpoints(asked["setpoint"]))
    parts = PlantParts(
        asked["wake"], tuple(asked["without"] or ()), asked["speed_filter"], asked["ripple"]
    )
    plant = simulation_plant(turbine, parts)
    words = tuple(asked["wind"] or DEFAULT_WINDS)
    winds = requested_winds(turbine, words, duration=duration, seed=asked["seed"])
    step_text = asked["sample_time"]
    step = SAMPLE_TIME if step_text is None else time_asked("--sample-time", step_text)
    require_sampling(step, asked["computation_time"])
    _tell_slow_sampling(plant, step)
    written: list[str] = []
    with progress(f"takagi simulate {source.name}") as tell:
        tell("gains", 0.0)
        laws = filed or chosen_laws(turbine, names, coupling_filter=asked["coupling_filter"])
        begin = 0.0 if filed else _MAKING
        simulation = run_simulation(
            turbine,
            laws,
            winds,
            asked=words,
            computation_time=asked["computation_time"],
            series=out is not None,
            sample_time=step,
            parts=parts,
            tell=lambda step, done: tell(step, begin + (_SIMULATING - begin) * done),
        )
        if out is not None:
            from takagi.reports.simulation.tables import simulation_files

            tell("figures and tables", _SIMULATING)
            content = simulation_files(simulation)
            write_folder(out, content)
            written = [str(out / name) for name in content]
    if as_json:
        from takagi.reports.simulation.tables import as_json as json_text

        print(json_text(simulation, files=written), end="")
    else:
        from takagi.cli.terminal.simulation_table import print_simulation

        print_simulation(simulation, written)
    return UNPROVED if simulation.diverged else PROVED


def _setpoints(texts: Sequence[str]) -> dict[str, float]:
    """Return the set-points of texts such as speed=11.5rpm, in SI."""
    setpoints: dict[str, float] = {}
    for text in texts:
        name, _, written = text.partition("=")
        if name not in SETPOINT_UNITS or name in setpoints:
            raise ModelError(
                f"option --setpoint {text}: speed=11.5rpm or power=4MW is needed, each once"
            )
        option = f"--setpoint {name}="
        setpoints[name] = typed_size(option, written, SETPOINT_UNITS[name], "11.5rpm or 4MW")
    return setpoints


def _tell_slow_sampling(plant: SimulatedTurbine, step: float) -> None:
    """Say before the long work that a mode has too few samples; the simulation shows the rest."""
    from takagi.reports.margins.running_over_wind import plant_modes, slow_sampling

    words = slow_sampling(step, plant_modes(plant))
    if words is not None:
        print(
            f"note: {words}; what the law then sees of this mode is made by the sampling, and an "
            "exported law refuses or reports such a time",
            file=sys.stderr,
            flush=True,
        )


RUNS, RUNS_BEYOND = 10_000, 2000


def _campaign(
    source: TurbineFile,
    out: Path | None,
    options: Mapping[str, Any],
    *,
    duration: float | None,
    as_json: bool,
) -> int:
    """Read and check the certificate, run, print; return the exit status."""
    for name, default in defaults_of(SCENARIO_OPTIONS).items():
        if name != "seed" and options[name] != default and options[name] != []:
            raise ModelError(
                f"option {option_of(name)} is about a scenario; with --certificate the "
                "law and the winds are the certificate's: leave it out"
            )
    from takagi.certificates.campaign import runs as campaign
    from takagi.certificates.checker.replay.certificate import check
    from takagi.certificates.sweep.tasks import RESULTS
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

    def work(tell: Tell) -> campaigns.CampaignReport:
        tell("checking the certificate", 0.0)
        # Strictly read, and about this model: what is simulated is what the checker judged.
        verdict = check(path, model=source.document.path).verdict.name
        # Without --out nothing is kept.
        place = nullcontext(out / RESULTS) if out is not None else tempfile.TemporaryDirectory()
        with place as folder:
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
        return campaigns.CampaignReport(str(source.model.name), verdict, results)

    title = f"takagi simulate {source.name}"
    report, written = kept_results(title, out, work, campaigns.campaign_files, what="runs")
    if as_json:
        print(campaigns.as_json(report, written), end="")
    else:
        print("\n".join([campaigns.as_text(report), *written]))
    violated = report.inside is not None and report.inside.violations
    return PROVED if report.verdict == "PROVED" and not violated else UNPROVED
