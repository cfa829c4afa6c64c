"""Runs a design, or a proof of given gains, for a plant; that there are no gains is an answer."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.cli.options.plant_options import plant_settings
from takagi.cli.progress import Tell
from takagi.cli.runs.turbine import Unprovable, asked_for

if TYPE_CHECKING:
    from takagi.certificates.design.plant.design import PlantDesign

__all__ = ["plant_asked", "plant_certified", "plant_with_gains", "verdict_words"]


def plant_asked(model: str, tell: Tell, options: Mapping[str, Any]) -> PlantDesign | Unprovable:
    """Return the finished design of a plant for the options of the command line.

    Raises
    ------
    ModelError : misuse: a malformed file, an option that makes no sense, a plant that has no
        model on its box.
    """
    from takagi.certificates.design.plant.design import NoPlantDesign, design_plant
    from takagi.models.plant_files.loader import load_plant, plant_files

    plant, settings = load_plant(model), plant_settings(model, options)
    found = design_plant(plant, settings, files=plant_files(model), tell=tell)
    if isinstance(found, NoPlantDesign):
        return Unprovable(_with_cure(found.reason, options))
    return found


def plant_with_gains(
    model: str, gains: Path, tell: Tell, options: Mapping[str, Any]
) -> PlantDesign:
    """Return the proof for the gains of a file, as they stand.

    Raises
    ------
    ModelError : as ``plant_asked``.
    CertificateError : the gain file is unreadable, or not for this plant.
    """
    from takagi.certificates.design.given.plant_gains import read_gains
    from takagi.certificates.design.plant.design import certify_plant
    from takagi.models.plant_files.loader import load_plant, plant_files

    plant, settings = load_plant(model), plant_settings(model, options)
    return certify_plant(
        plant,
        lambda derived: read_gains(gains, derived),
        settings,
        files=plant_files(model),
        tell=tell,
    )


def plant_certified(model: str, gains: Path, tell: Tell, options: Mapping[str, Any]) -> PlantDesign:
    """Return the proof for the law of a file, also on a plant that has changed since.

    Raises
    ------
    ModelError : as ``plant_asked``.
    CertificateError : the gain file is unreadable, or not for this plant.
    """
    from takagi.certificates.design.plant.design import certify_filed
    from takagi.models.plant_files.loader import load_plant, plant_files

    plant, settings = load_plant(model), plant_settings(model, options)
    return certify_filed(plant, gains, settings, files=plant_files(model), tell=tell)


def verdict_words(design: PlantDesign) -> str:
    """Return ``PROVED`` only where it is said of the plant, not of its model's vertices alone."""
    alone = "" if design.is_about_plant else ", of the vertices alone: not of the plant"
    return f"{design.verdict.name}{alone}"


def _with_cure(reason: str, options: Mapping[str, Any]) -> str:
    given = asked_for(options)
    relax = f"\nAsked for on the command line: {given}; relax that first." if given else ""
    return f"{reason}{relax}"
