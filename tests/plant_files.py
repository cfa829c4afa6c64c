"""Plant files that tests write, and the plants and designs of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from takagi.models import Plant
from takagi.models.plant_files.loader import PlantFile, load_plant

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign


def written(folder: Path, text: str, name: str = "plant.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def filed_plant(folder: Path, text: str, name: str = "plant.toml") -> Plant:
    return load_plant(written(folder, text, name))


def designed_in(folder: Path, text: str, name: str = "plant.toml") -> PlantDesign:
    """Return the design of a plant file; certificate and gain file are written beside it."""
    from takagi.certificates.design.plant.design import design_plant
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.certificates.document.certificate_file import dumps
    from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file

    path = written(folder, text, name)
    design = design_plant(load_plant(path), files=PlantFile.of(path).files)
    assert isinstance(design, PlantDesign) and design.proved
    written(folder, dumps(design.document), "c.json")
    written(folder, dump_gains(plant_gain_file(design)), "gains.json")
    return design
