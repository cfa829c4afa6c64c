"""`takagi simulate` for a turbine: laws side by side in the same winds, or random runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.options.given import Groups, defaults_of
from takagi.cli.progress import Tell, progress
from takagi.cli.verbs.simulate_campaign import campaign_options, without_campaign

if TYPE_CHECKING:
    from takagi.models.simulation.wind import WindSeries
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.loader import TurbineFile
    from takagi.reports.simulation.laws import ChosenLaws
    from takagi.reports.simulation.runs import Simulation

__all__ = ["GROUPS", "simulate"]

# The whole as one bar: making the laws takes about as long as simulating them.
_MAKING, _SIMULATING = 0.45, 0.95
_DESIGN_STEPS = 7


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


GROUPS: Groups = (turbine_simulation, campaign_options)


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
        from takagi.cli.verbs.simulate_campaign import simulate_campaign

        defaults = defaults_of((turbine_simulation,))
        return simulate_campaign(source, out, asked, defaults, duration=duration, as_json=as_json)
    return _laws(source, out, duration=duration, as_json=as_json, **without_campaign(asked))


def _laws(
    source: TurbineFile,
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
    from takagi.reports.simulation.filed_law import filed_laws
    from takagi.reports.simulation.laws import DEFAULT_LAWS, require_law_names
    from takagi.reports.simulation.runs import require_sampling, simulation_plant
    from takagi.reports.simulation.scenarios import scenario_winds

    # All that can be refused is refused before the long work.
    names = () if law_from and not law else require_law_names(law or DEFAULT_LAWS)
    turbine = source.model
    laws: ChosenLaws | Sequence[str] = names
    if law_from:
        turbine, laws = filed_laws(turbine, law_from, names)
    simulation_plant(turbine, wake)
    winds = scenario_winds(turbine, scenario, duration=duration, seed=seed)
    require_sampling(sample_time, computation_time)
    written: list[str] = []
    with progress(f"takagi simulate {source.name}") as tell:
        times = (sample_time, computation_time)
        found = _simulate(turbine, source.files, laws, winds, scenario, wake, times, tell)
        if out is not None:
            tell("figures and tables", _SIMULATING)
            written = _write(found, out)
    _print(found, written, as_json=as_json)
    return UNPROVED if found.diverged else PROVED


def _simulate(
    turbine: Turbine,
    files: Sequence[Path],
    laws: ChosenLaws | Sequence[str],
    winds: Sequence[WindSeries],
    scenario: str,
    wake: str,
    times: tuple[float, float],
    tell: Tell,
) -> Simulation:
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
        chosen = chosen_laws(turbine, laws, files=files, tell=making)
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
