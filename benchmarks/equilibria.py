"""Draws docs/figures/equilibria.svg: how often the loop of each law rests at every constant wind.

    python benchmarks/equilibria.py [--gains FILE] [--out DIR]

Without a gain file the effort-sharing law has the gains that ``--two-step`` gives it.  Every answer
in the figure is PROVED by ``takagi check``'s own checker, or the script stops; about four minutes.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import get_args

from takagi.certificates.design.given.runnable_law import law_from_gains
from takagi.certificates.design.turbine.published_law import designed_law
from takagi.certificates.design.turbine.regions import regional_design
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.certificates.equilibrium import (
    ClosedLoopEquilibria,
    EquilibriumCell,
    closed_loop_equilibria,
)
from takagi.lmi.turbine.effort import effort_gains
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.laws.published.law import PublishedLaw, PublishedLawName
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw
from takagi.reports.figures.equilibria import equilibria_figure
from takagi.reports.figures.writing import figure_to_svg
from takagi.reports.output import write_folder

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
PLACEMENTS = {"paper": (0.0, 0.5, 0.9, 1.0), "paper-two-integrators": (0.0, 0.5)}


def main() -> None:
    """Count the rests of all laws, and draw them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gains", type=Path, help="gain file of an effort-sharing law")
    parser.add_argument("--out", type=Path, default=FIGURES)
    asked = parser.parse_args()
    turbine = nrel5mw()
    loops: dict[str, EffortSharingLaw | PublishedLaw] = {"coherent": coherent(turbine, asked.gains)}
    loops |= published(turbine)
    found = {name: spans(turbine, name, law) for name, law in loops.items()}
    words = "Number of rests of each law over constant wind"
    drawn = figure_to_svg(equilibria_figure(found), name="equilibria", description=words)
    write_folder(asked.out, {"equilibria.svg": drawn + "\n"})


def coherent(turbine: Turbine, gains: Path | None) -> EffortSharingLaw | PublishedLaw:
    """Return the law of a gain file, or the one with gains found wind by wind."""
    if gains is not None:
        return law_from_gains(gains, turbine)
    schedule = effort_schedule(turbine)
    return EffortSharingLaw.of(turbine, schedule, effort_gains(turbine, schedule).gains)


def published(turbine: Turbine) -> dict[str, PublishedLaw]:
    """Return the paper's laws by name and placement of the ramp."""
    models = regional_design(turbine)
    return {
        f"{law}, placement {place:g}": designed_law(
            turbine, DesignSettings(law=law, ramp_placement=place), models
        )
        for law in get_args(PublishedLawName)
        for place in PLACEMENTS[law]
    }


def spans(
    turbine: Turbine, name: str, law: EffortSharingLaw | PublishedLaw
) -> tuple[EquilibriumCell, ...]:
    """Return the proved cells of a loop, neighbours with one answer joined."""
    began = time.perf_counter()
    rests: ClosedLoopEquilibria = closed_loop_equilibria(turbine, law)
    verdict = rests.check().verdict.name
    print(f"{name}: {verdict}, {time.perf_counter() - began:.0f} s", flush=True)
    for cell in rests.spans():
        print(f"  {cell.wind[0]:.6g} to {cell.wind[1]:.6g} m/s: {cell.rests}", flush=True)
    if verdict != "PROVED":
        raise SystemExit(f"{name}: the checker says {verdict}; nothing was drawn")
    return rests.spans()


if __name__ == "__main__":
    main()
