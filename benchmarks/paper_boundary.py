"""The published laws over wind and speed overlap: where proved, and what starts and gusts do.

    python benchmarks/paper_boundary.py --out DIR [--law paper]

Simulated: the design model (rigid rotor, first-order pitch drive, equilibrium wake, wind known),
and the same with the second-order pitch drive of the validation plant; nine starts and gusts per
wind and overlap.  Proved: a window of 0.03 m/s at each wind, by ``takagi check``'s own checker.
The effort-sharing law, with its own filter on the wind, is run through the same disturbances.
Leaves boundary.json, boundary.csv, boundary-LAW.svg and .png.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from boundary_figure import Boundary, boundary_csv, boundary_figure
from disturbance_trials import DISTURBANCES, TrialOutcome, tried
from numpy.typing import NDArray
from trial_laws import effort_sharing_trial, published_trial
from trial_plant import TrialRotor, rotor_of

from takagi.certificates.campaign.loop import certified_loop
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.published import (
    published_candidate,
    published_claim,
    published_law_data,
    with_overlaps,
)
from takagi.certificates.design.turbine.published_law import designed_law
from takagi.certificates.design.turbine.regions import regional_design
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.certificates.document.certificate_file import certificate_document, turbine_data
from takagi.models.laws.published.equilibrium import equilibrium
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw
from takagi.reports.figures.writing import figure_to_png, figure_to_svg
from takagi.reports.output import write_folder

Floats = NDArray[np.float64]
LAWS = ("paper", "paper-two-integrators")
WINDS = (13.0, 15.0, 17.0, 19.0, 21.0, 23.0, 25.0)
OVERLAPS = (0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3)
WINDOW = 0.03
PLACEMENT = 0.5


def law_of(name: str, turbine: Turbine, models: Any, overlap: float) -> PublishedLaw:
    """Return the law with a centred ramp of this overlap [rad/s]."""
    asked = DesignSettings(law=name, ramp_placement=PLACEMENT)
    law = designed_law(turbine, asked, models)
    return with_overlaps(law, speed_overlap=overlap, torque_overlap=law.coupling.torque_overlap)


def proved(law: PublishedLaw, model: dict[str, Any]) -> NDArray[np.bool_]:
    """Return at which of the winds a window is PROVED."""
    found = []
    for wind in WINDS:
        # The last window ends at cut-out.
        low = min(wind, law.turbine.cut_out - WINDOW)
        candidate = published_candidate(
            law, winds=[(low, round(low + WINDOW, 9))], narrowest=WINDOW / 4
        )
        if candidate.unproved or not candidate.cells:
            found.append(False)
            continue
        document = certificate_document(
            model=model,
            gains=published_law_data(law),
            claims=[published_claim(candidate)],
            provenance={},
        )
        found.append(check_document(document).verdict.name == "PROVED")
    return np.array(found)


def starts(law: PublishedLaw, wind: float) -> list[float]:
    """Return speed, pitch, pitch rate and integrals at rest; at the trim where there is none."""
    rest = equilibrium(law, wind)
    speed, pitch = rest.rotor_speed, rest.pitch
    if rest.kind == "none":
        speed, pitch = rest.trim.rotor_speed, rest.trim.pitch
    return [speed, pitch, 0.0, *rest.integrals]


def run_laws(laws: list[PublishedLaw], rotor: TrialRotor) -> TrialOutcome:
    """Return the outcome of every overlap, wind and disturbance, in this order."""
    cases = [(law, wind, d) for law in laws for wind in WINDS for d in DISTURBANCES]
    wind = np.array([wind for _, wind, _ in cases])
    by_place = {(id(law), w): starts(law, w) for law in laws for w in WINDS}
    rest = np.array([by_place[id(law), w] for law, w, _ in cases]).T
    ramps = [law.coupling.speed_ramp for law, _, _ in cases]
    trial = published_trial(
        published_law_data(laws[0]),
        rotor,
        ramp_start=np.array([ramp.start for ramp in ramps]),
        ramp_width=np.array([ramp.width for ramp in ramps]),
    )
    return tried(
        rotor, trial, rest, wind, [d for _, _, d in cases],
        rated_speed=laws[0].turbine.rated_rotor_speed,
    )  # fmt: skip


def run_coherent(document: dict[str, Any], rotor: TrialRotor) -> TrialOutcome:
    """Return the outcome of the effort-sharing law at every wind and disturbance."""
    loop = certified_loop(document)
    cases = [(wind, d) for wind in WINDS for d in DISTURBANCES]
    wind = np.array([wind for wind, _ in cases])
    speed, effort, b = (np.interp(wind, loop.wind, loop.tables[i]) for i in (0, 1, 2))
    rest = np.stack([speed, loop.pitch_min + effort / b, 0 * wind, 0 * wind, wind])
    trial = effort_sharing_trial(loop, float(document["gains"]["wind_filter"]))
    return tried(
        rotor, trial, rest, wind, [d for _, d in cases],
        rated_speed=loop.rated_speed,
    )  # fmt: skip


def boundary(
    name: str, turbine: Turbine, models: Any, model: dict[str, Any], drives: dict[str, TrialRotor]
) -> Boundary:
    """Return what is proved of a law, and what every run of it came to."""
    shape = (len(OVERLAPS), len(WINDS), len(DISTURBANCES))
    laws = [law_of(name, turbine, models, overlap) for overlap in OVERLAPS]
    held = np.array([proved(law, model) for law in laws])
    codes, fastest = {}, {}
    for drive, rotor in drives.items():
        outcome = run_laws(laws, rotor)
        codes[drive] = outcome.code.reshape(shape)
        fastest[drive] = (outcome.fastest / turbine.rated_rotor_speed - 1).reshape(shape)
        print(name, drive, np.bincount(outcome.code, minlength=3), flush=True)
    names = [d.name for d in DISTURBANCES]
    return Boundary(name, WINDS, OVERLAPS, names, held, codes, fastest)


def main() -> None:
    """Run the laws, and write figures and data."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--law", choices=LAWS, action="append")
    parser.add_argument(
        "--certificate", type=Path, help="of the effort-sharing law, for comparison"
    )
    asked = parser.parse_args()
    turbine = nrel5mw()
    models, model = regional_design(turbine), turbine_data(turbine, [])
    drives = {
        "first-order pitch drive": rotor_of(model),
        "second-order pitch drive": rotor_of(
            model,
            frequency=turbine.pitch_drive_frequency,
            damping=turbine.pitch_drive_damping,
        ),
    }
    files: dict[str, bytes | str] = {}
    summary: dict[str, Any] = {}
    for name in asked.law or LAWS:
        found = boundary(name, turbine, models, model, drives)
        figure = boundary_figure(found)
        files[f"boundary-{name}.svg"] = figure_to_svg(figure, name=f"boundary-{name}") + "\n"
        files[f"boundary-{name}.png"] = figure_to_png(figure, dpi=144)
        files[f"boundary-{name}.csv"] = boundary_csv(found)
        summary[name] = found.summary()
    if asked.certificate:
        document = json.loads(asked.certificate.read_text(encoding="utf-8"))
        for drive, rotor in drives.items():
            outcome = run_coherent(document, rotor)
            summary[f"coherent, {drive}"] = {
                "stays, cycles, loses the trim": np.bincount(outcome.code, minlength=3).tolist(),
                "largest overspeed [%]": float(
                    100 * (outcome.fastest.max() / turbine.rated_rotor_speed - 1)
                ),
            }
    files["boundary.json"] = json.dumps(summary, indent=2) + "\n"
    write_folder(asked.out, files)
    print(files["boundary.json"])


if __name__ == "__main__":
    main()
