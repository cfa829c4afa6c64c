"""`takagi simulate`: laws on the nonlinear plant, of a turbine side by side in the same winds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from takagi.cli.command import run_command
from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.options.design_options import Model
from takagi.cli.options.model_kind import defaults_of, model_kind, refuse_options
from takagi.cli.options.plant_options import plant_options
from takagi.cli.progress import Tell, progress
from takagi.cli.verbs.simulate_campaign import campaign_options, without_campaign

if TYPE_CHECKING:
    from takagi.models.simulation.wind import WindSeries
    from takagi.models.turbine.data import Turbine
    from takagi.reports.simulation.laws import ChosenLaws
    from takagi.reports.simulation.runs import Simulation

__all__ = ["run", "simulate"]

Groups: TypeAlias = tuple[Callable[..., None], ...]

# The whole as one bar: making the laws takes about as long as simulating them.
_MAKING, _SIMULATING = 0.45, 0.95
_DESIGN_STEPS = 7


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    groups = (turbine_simulation, campaign_options, plant_simulation, plant_options)
    return run_command("simulate", simulate, arguments, groups=groups)


def turbine_simulation(
    law: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Turbines: coherent, paper, paper-two-integrators or baseline; may be repeated. "
            "Without it: coherent, paper and baseline.",
        ),
    ] = None,
    law_from: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Turbines: simulate the law of a gain file, with its observer; of the named laws, "
            "only baseline can stand beside it.",
        ),
    ] = None,
    scenario: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="Turbines: paper (three turbulent winds), step, gust or ramp."
        ),
    ] = "paper",
    wake: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Turbines: equilibrium, or dynamic: the wake needs time to follow pitch.",
        ),
    ] = "equilibrium",
    seed: Annotated[
        int | None, typer.Option(help="Turbines: of the turbulence; 0 or more. Scenario paper.")
    ] = None,
    sample_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS", help="Turbines: how often the law runs [s], its command held."
        ),
    ] = 0.02,
    computation_time: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="Turbines: from measuring to sending [s]; at most the sample time.",
        ),
    ] = 0.0,
) -> None:
    """Declare what a simulation of a wind turbine may be asked for."""


def plant_simulation(
    gains: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Plants: a gain file; without it, gains are designed."),
    ] = None,
    start: Annotated[
        list[str] | None,
        typer.Option(
            metavar="STATE=VALUE,...",
            help="Plants: where a run starts, such as angle=20deg,rate=0.5; other states at rest. "
            "May be repeated; without it: the corners of the box, drawn in to the proved set.",
        ),
    ] = None,
) -> None:
    """Declare what a simulation of a plant may be asked for."""


def simulate(
    model: Model,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="The folder for tables and figures."),
    ] = None,
    *,
    duration: Annotated[
        float | None,
        typer.Option(
            help="Of every run [s]; turbines 60 (paper), 120 (step), 90 (gust) or 180 (ramp), "
            "plants some time constants."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
    **options: Any,
) -> int:
    """Simulate laws on the nonlinear plant. A simulation proves nothing.

    A wind turbine: the project's law, the published one and the reference's own side by side, with
    a pitch drive and its limits, a torque rate limit and the tower's fore-aft mode; the wind
    observer is in the loop. Another plant: its own equations under its law by rules, from corners
    of its box or from --start, disturbances at rest.

    With --certificate FILE, a wind turbine's: thousands of random runs of the certified loop,
    starts, winds and plants within what the file claims, each compared with every bound; the exit
    status is 1 where one is exceeded. With --beyond: outside of it, and what breaks first.

    Prints a table; with --out also leaves tables, figures/ and simulation.json in DIR: all of them,
    or none.

    Exit status: 0 every loop ran to its end; 1 one diverged, or there are no gains; 2 misuse.
    """
    kind = model_kind(model)
    own: Groups = (turbine_simulation, campaign_options)
    other: Groups = (plant_simulation, plant_options)
    if kind == "plant":
        own, other = other, own
    refuse_options(model, kind, *_of_groups(options, other))
    asked, _ = _of_groups(options, own)
    if kind == "plant":
        from takagi.cli.verbs.simulate_plant import simulate_plant

        return simulate_plant(model, out, asked, duration=duration, as_json=as_json)
    if asked["certificate"] is not None:
        from takagi.cli.verbs.simulate_campaign import simulate_campaign

        scenario, defaults = _of_groups(options, (turbine_simulation,))
        return simulate_campaign(
            model, out, asked, (scenario, defaults), duration=duration, as_json=as_json
        )
    return _turbine(model, out, duration=duration, as_json=as_json, **without_campaign(asked))


def _of_groups(options: Mapping[str, Any], groups: Groups) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (what was given, the defaults) of the options of some groups."""
    defaults = {name: value for group in groups for name, value in defaults_of(group).items()}
    return {name: options[name] for name in defaults}, defaults


def _turbine(
    model: str,
    out: Path | None,
    *,
    law: Sequence[str] | None,
    law_from: Path | None,
    scenario: str,
    wake: str,
    seed: int | None,
    sample_time: float,
    computation_time: float,
    duration: float | None,
    as_json: bool,
) -> int:
    if out is not None:
        from takagi.cli.output_place import require_folder_place

        files = ("summary.md", "simulation.csv", "simulation.json")
        require_folder_place(out, files=files, folders=("figures", "series"))
    from takagi.models.turbine.loader import load_turbine
    from takagi.reports.simulation.filed_law import filed_laws
    from takagi.reports.simulation.laws import DEFAULT_LAWS, require_law_names
    from takagi.reports.simulation.runs import require_sampling, simulation_plant
    from takagi.reports.simulation.scenarios import scenario_winds

    # All that can be refused is refused before the long work.
    names = () if law_from and not law else require_law_names(law or DEFAULT_LAWS)
    turbine = load_turbine(model)
    laws: ChosenLaws | Sequence[str] = names
    if law_from:
        turbine, laws = filed_laws(turbine, law_from, names)
    simulation_plant(turbine, wake)
    winds = scenario_winds(turbine, scenario, duration=duration, seed=seed)
    require_sampling(sample_time, computation_time)
    written: list[str] = []
    with progress(f"takagi simulate {model}") as tell:
        times = (sample_time, computation_time)
        found = _simulate(turbine, model, laws, winds, scenario, wake, times, tell)
        if out is not None:
            tell("figures and tables", _SIMULATING)
            written = _write(found, out)
    _print(found, written, as_json=as_json)
    return UNPROVED if found.diverged else PROVED


def _simulate(
    turbine: Turbine,
    model: str,
    laws: ChosenLaws | Sequence[str],
    winds: Sequence[WindSeries],
    scenario: str,
    wake: str,
    times: tuple[float, float],
    tell: Tell,
) -> Simulation:
    from takagi.models.turbine.loader import model_files
    from takagi.reports.simulation.laws import ChosenLaws, chosen_laws
    from takagi.reports.simulation.runs import run_simulation

    steps = 0

    def making(step: str) -> None:
        nonlocal steps
        tell(step, _MAKING * min(steps / _DESIGN_STEPS, 1.0))
        steps += 1

    def running(step: str, done: float) -> None:
        tell(step, begin + (_SIMULATING - begin) * done)

    if isinstance(laws, ChosenLaws):
        chosen = laws
    else:
        chosen = chosen_laws(turbine, laws, files=model_files(model), tell=making)
    begin = _MAKING if steps else 0.0
    return run_simulation(
        turbine,
        chosen,
        winds,
        scenario=scenario,
        wake=wake,
        sample_time=times[0],
        computation_time=times[1],
        tell=running,
    )


def _write(found: Simulation, out: Path) -> list[str]:
    from takagi.reports.output import write_folder
    from takagi.reports.simulation.folder import simulation_files

    files = simulation_files(found)
    write_folder(out, files)
    return [str(out / name) for name in files]


def _print(found: Simulation, written: list[str], *, as_json: bool) -> None:
    from takagi.reports.simulation.tables import as_json as json_text

    if as_json:
        print(json_text(found, files=written), end="")
        return
    from takagi.cli.terminal.simulation_table import print_simulation

    print_simulation(found, written)
