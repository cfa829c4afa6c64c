"""Designs of plants that several tests read, made once."""

from __future__ import annotations

from functools import cache

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant, load_model


@cache
def design_of(name: str) -> PlantDesign:
    """The design of a built-in plant with the settings that nobody chose."""
    plant = load_model(name)
    assert isinstance(plant, Plant)
    found = design_plant(plant)
    assert isinstance(found, PlantDesign)
    return found
