"""What is controlled and by which law: Takagi-Sugeno models, their derivation, wind turbines.

    ts_model, premise       TSModel: vertices, premises with proved ranges, rules, box
    plant/                  Plant: equations, variables with units and ranges; plant files
    sector/                 sector_model: symbolic sector nonlinearity, bounds by ball arithmetic
    surface, enclosure/     spline surfaces and rigorous ranges in exact arithmetic
    turbine/                wind turbines: data, aerodynamics, trim, regional models, observer
    loading, library        models from files and built-in ones by name

Importing this package imports nothing heavy: names are looked up when they are used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.curve import Curve, interpolate_curve
    from takagi.models.derivation import Derivation, Step
    from takagi.models.embedding.feedback import Feedback, blended_feedback, product_memberships
    from takagi.models.embedding.secant import Region, secant_embedding
    from takagi.models.embedding.secant_family import SecantEmbedding
    from takagi.models.enclosure.interval import Interval
    from takagi.models.errors import ModelError
    from takagi.models.library import built_in_models
    from takagi.models.loading import load_model
    from takagi.models.plant.entries import plant_file_schema
    from takagi.models.plant.plant import Output, Parameter, Plant, Variable
    from takagi.models.plant.table_function import table_function
    from takagi.models.premise import Premise
    from takagi.models.sector.model import sector_model
    from takagi.models.surface import Surface
    from takagi.models.ts_model import Matrices, TSModel
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.full_load import full_load_model
    from takagi.models.turbine.loader import nrel5mw
    from takagi.models.turbine.partial_load import partial_load_model
    from takagi.models.turbine.wind_observer import WindObserver, wind_observer_model
    from takagi.models.vertex_merging import MergedModel, merge_vertices

__all__ = [
    "Curve",
    "Derivation",
    "Feedback",
    "Interval",
    "Matrices",
    "MergedModel",
    "ModelError",
    "Output",
    "Parameter",
    "Plant",
    "Premise",
    "Region",
    "SecantEmbedding",
    "Step",
    "Surface",
    "TSModel",
    "Turbine",
    "Variable",
    "WindObserver",
    "blended_feedback",
    "built_in_models",
    "full_load_model",
    "interpolate_curve",
    "load_model",
    "merge_vertices",
    "nrel5mw",
    "partial_load_model",
    "plant_file_schema",
    "product_memberships",
    "secant_embedding",
    "sector_model",
    "table_function",
    "wind_observer_model",
]

_HOME = {
    "Curve": "curve",
    "Derivation": "derivation",
    "Feedback": "embedding.feedback",
    "Interval": "enclosure.interval",
    "Matrices": "ts_model",
    "MergedModel": "vertex_merging",
    "ModelError": "errors",
    "Output": "plant.plant",
    "Parameter": "plant.plant",
    "Plant": "plant.plant",
    "Premise": "premise",
    "Region": "embedding.secant",
    "SecantEmbedding": "embedding.secant_family",
    "Step": "derivation",
    "Surface": "surface",
    "TSModel": "ts_model",
    "Turbine": "turbine.data",
    "Variable": "plant.plant",
    "WindObserver": "turbine.wind_observer",
    "blended_feedback": "embedding.feedback",
    "built_in_models": "library",
    "full_load_model": "turbine.full_load",
    "interpolate_curve": "curve",
    "load_model": "loading",
    "merge_vertices": "vertex_merging",
    "nrel5mw": "turbine.loader",
    "partial_load_model": "turbine.partial_load",
    "plant_file_schema": "plant.entries",
    "product_memberships": "embedding.feedback",
    "secant_embedding": "embedding.secant",
    "sector_model": "sector.model",
    "table_function": "plant.table_function",
    "wind_observer_model": "turbine.wind_observer",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.models.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
