"""One design as the page shows it, and the folder in which it is kept.

What is shown is read from the files of ``takagi design``, and their certificate is checked each
time they are read.  So a file that was changed, is damaged, or is of another version counts as
none, and the design is made anew.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.plant.static_gains import plant_of_law
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import file_unit
from takagi.reports.design_folder import design_folder, law_files, read_design
from takagi.reports.figures.plant.proved_set import ellipse, planes, section
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop
from takagi.reports.loops.plant_motion import around, motions, starts
from takagi.reports.output import write_folder
from takagi.reports.page.text import unit_of

if TYPE_CHECKING:
    from takagi.models.plant_files.loader import PlantFile

Cell: TypeAlias = dict[str, Any]
# (plant's file, options by the names of their parameters) -> settings, as the command line has it.
SettingsOf: TypeAlias = "Callable[[PlantFile, Mapping[str, Any]], PlantSettings]"
NONE = "none.json"
# The step of a design that asks many questions only to explain why there is no answer.
EXPLAINING = "what would help"
AROUND, AROUND_MANY, MOST_POINTS = 6, 3, 100


class _NotSought(Exception):
    """There are no gains; why is what the command says."""


def made_cell(
    source: PlantFile,
    options: Mapping[str, Any],
    folder: Path,
    settings_of: SettingsOf,
    tell: Callable[[str], None],
) -> Cell:
    """Return the design with the options; it is made unless the folder has it.

    Parameters
    ----------
    folder : of this design alone.
    tell : called with a word before each step of a design; what it raises ends the work.
    """
    started = time.perf_counter()
    try:
        settings = settings_of(source, options)
        reason = _reason_kept(folder, options)
        design = None if reason else _kept(folder, source, settings)
        new = reason is None and design is None
        if new:
            made = _designed(source, settings, tell)
            if isinstance(made, NoDesign):
                reason = made.reason
                write_folder(folder, {NONE: json.dumps({"reason": reason, "for": options})})
            else:
                write_folder(folder, law_files(made, source=source))
                design = read_checked(folder, source, settings)
    except (ModelError, CertificateError, OSError) as error:
        return {"none": str(error), "new": True, "seconds": time.perf_counter() - started}
    answer = {"none": reason} if design is None else shown(design)
    return answer | {"new": new, "seconds": time.perf_counter() - started}


def _designed(
    source: PlantFile, settings: PlantSettings, tell: Callable[[str], None]
) -> PlantDesign | NoDesign:
    from takagi.certificates.design.plant.design import design_plant

    def step(words: str) -> None:
        tell(words)
        if words == EXPLAINING:
            raise _NotSought

    try:
        plant = plant_of_law(source.model, settings)
        return design_plant(plant, settings, files=source.files, tell=step)
    except _NotSought:
        return NoDesign("The solver finds no gains for this. The command says what is in the way.")


def _reason_kept(folder: Path, options: Mapping[str, Any]) -> str | None:
    try:
        kept = json.loads((folder / NONE).read_text(encoding="utf-8"))
        return str(kept["reason"]) if kept["for"] == options else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _kept(folder: Path, source: PlantFile, settings: PlantSettings) -> PlantDesign | None:
    try:
        return read_checked(folder, source, settings)
    except (ModelError, CertificateError, OSError):
        return None


def read_checked(folder: Path, source: PlantFile, settings: PlantSettings) -> PlantDesign:
    """Return the design in a folder, with the verdicts of a check made now.

    Raises
    ------
    CertificateError : no whole design, or one of another plant or for other requirements.
    ModelError : a file that cannot be read.
    """
    copied = design_folder(folder).model
    design = read_design(folder)
    same = all(
        (copied.parent / file.relative_to(source.files[0].parent)).read_bytes() == file.read_bytes()
        for file in source.files
    )
    if not isinstance(design, PlantDesign) or not same or design.settings != settings:
        raise CertificateError(f"{folder}: holds another design; remove it")
    return design


def shown(design: PlantDesign) -> Cell:
    """Return the design's badge, answer, rows, gains and picture."""
    from takagi.reports.sections.plant.summary import answer_sentence, summary_rows

    return {
        "proved": design.proved,
        "verdict": "PROVED" if design.proved else f"{design.verdict_words}: a candidate",
        "sentence": answer_sentence(design),
        "rows": [
            {
                "name": row.name,
                "text": row.text,
                "basis": row.basis or "proved",
                "shortfall": row.shortfall if row.partial else "",
            }
            for row in summary_rows(design)
            if row.name != "gains"
        ],
        "gains": _gains(design),
        "planes": _planes(design, plant_loop(design)),
        "claims": [[claim.name, claim.verdict.name] for claim in design.checked.claims],
        "notes": list(design.notes),
    }


def _gains(design: PlantDesign) -> Mapping[str, Any]:
    """Return the gains of u - u* = -sum_i h_i K_i (x - x*), as the gain file has them."""
    K = np.asarray(design.gains)
    labels = [f"{label}, rule {i + 1}" for label in design.model.inputs for i in range(len(K))]
    rows = [[f"{value:.9g}" for value in K[i, k]] for k in range(K.shape[1]) for i in range(len(K))]
    return {"columns": list(design.model.states), "labels": labels, "rows": rows}


def _planes(design: PlantDesign, loop: PlantLoop) -> list[Mapping[str, Any]]:
    """Return sets, ranges and motions in planes of two states, as deviations in file units."""
    if not planes(loop):
        return []
    begin = [*starts(loop), *around(loop, AROUND_MANY)]
    simulated = motions(loop, around(loop, AROUND) if len(loop.names) == 2 else begin)
    plane_list: list[Mapping[str, Any]] = []
    for pair in planes(loop):
        units = [_unit(loop, k) for k in pair]
        sizes = np.array([[size] for size, _ in units])
        of_set: dict[str, Any] = {"safe": None, "set": None}
        if loop.bounded:
            of_set["safe"] = _points(section(*loop.start_ellipsoid, pair) / sizes)
            if len(loop.names) > 2 or loop.observed is not None:
                of_set["set"] = _points(ellipse(*loop.ellipsoid, pair) / sizes)
        box = [loop.model.box.get(loop.model.states[k]) for k in pair]
        covered = [design.settings.initial.get(loop.names[k], 0.0) for k in pair]
        plane_list.append(
            {
                "axes": [
                    f"{loop.names[k]} [{unit}]" for k, (_, unit) in zip(pair, units, strict=True)
                ],
                "proved": loop.level_proved and design.proved,
                **of_set,
                "range": [
                    None if ends is None else [float(end) / size for end in ends]
                    for ends, (size, _) in zip(box, units, strict=True)
                ],
                "covered": [half / size for half, (size, _) in zip(covered, units, strict=True)],
                "motions": [_points(motion.state[:, pair].T / sizes) for motion in simulated],
            }
        )
    return plane_list


def _unit(loop: PlantLoop, state: int) -> tuple[float, str]:
    if state < len(loop.plant.states):
        return file_unit(loop.plant.states[state])
    return 1.0, unit_of(loop.model.states[state])


def _points(line: Floats) -> list[list[float]]:
    step = -(-line.shape[1] // MOST_POINTS)
    return [[float(f"{value:.4g}") for value in row] for row in line[:, ::step]]
