"""What is controlled and by which law: Takagi-Sugeno models, their derivation, wind turbines.

    ts/                     TSModel: vertices, premises with proved ranges, rules, box
    plant/, plant_files/    Plant: equations, variables with units and ranges; plant files read
    files/, expressions/    what model files share; expressions as text
    equations/, sector/     the plant about its equilibrium; symbolic sector nonlinearity
    intervals/, splines/, ranges/    interval arithmetic; spline surfaces; rigorous ranges
    reduction/              fewer rules with a proved error; a box cut into cells
    ramps/, blending/       one quantity handed over to another; two actuators that share one effort
    laws/, loops/           controller laws as values; closed loops as families of matrices
    turbine/, simulation/   wind turbines; the nonlinear plant and the loop in time
    loading, errors         models from files and built-in ones by name; ModelError
    lazy_names              the names of a package, imported when they are used

Importing this package imports nothing heavy: names are looked up when they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.control_systems.law_systems import law_system
    from takagi.models.control_systems.plant_systems import nonlinear_system, statespace
    from takagi.models.equations.solved_rest import solve_rest
    from takagi.models.equations.step import Step
    from takagi.models.errors import ModelError
    from takagi.models.files.library import built_in_models
    from takagi.models.intervals.interval import Interval
    from takagi.models.loading import load_model
    from takagi.models.loops.secant.embedding import Region, SecantRegion, secant_embedding
    from takagi.models.loops.secant.feedback import Feedback, blended_feedback, product_memberships
    from takagi.models.loops.secant.matrices import SecantEmbedding
    from takagi.models.plant.entries import plant_file_schema
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Output, Parameter, Variable
    from takagi.models.ranges.cell import Cell
    from takagi.models.ranges.domain import Domain
    from takagi.models.ranges.sampled import sampled_bounds
    from takagi.models.reduction.box_refinement import refine
    from takagi.models.reduction.cell_models import CellModels, ModelCell
    from takagi.models.reduction.error_bound import ErrorBound
    from takagi.models.reduction.norm_block import NormBlock
    from takagi.models.reduction.reduced_model import MergedModel, ReducedModel
    from takagi.models.reduction.rule_tensor import mode_spectrum
    from takagi.models.reduction.tensor_reduction import reduce_rules
    from takagi.models.reduction.vertex_merging import merge_vertices
    from takagi.models.sector.model import rule_count, sector_model
    from takagi.models.sector.rule_counting import RuleCount
    from takagi.models.splines.curve import Curve, interpolate_curve
    from takagi.models.splines.surface import Surface
    from takagi.models.splines.table_function import table_function
    from takagi.models.ts.derivation import Derivation
    from takagi.models.ts.mat_file import load_ts_model
    from takagi.models.ts.model import Matrices, TSModel
    from takagi.models.ts.premise import Premise
    from takagi.models.turbine.data import Turbine
    from takagi.models.turbine.full_load import full_load_model
    from takagi.models.turbine.loader import nrel5mw
    from takagi.models.turbine.partial_load import partial_load_model
    from takagi.models.turbine.wind_observer import WindObserver, wind_observer_model

__all__ = [
    "Cell",
    "CellModels",
    "Curve",
    "Derivation",
    "Domain",
    "ErrorBound",
    "Feedback",
    "Interval",
    "Matrices",
    "MergedModel",
    "ModelCell",
    "ModelError",
    "NormBlock",
    "Output",
    "Parameter",
    "Plant",
    "Premise",
    "ReducedModel",
    "Region",
    "RuleCount",
    "SecantEmbedding",
    "SecantRegion",
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
    "law_system",
    "load_model",
    "load_ts_model",
    "merge_vertices",
    "mode_spectrum",
    "nonlinear_system",
    "nrel5mw",
    "partial_load_model",
    "plant_file_schema",
    "product_memberships",
    "reduce_rules",
    "refine",
    "rule_count",
    "sampled_bounds",
    "secant_embedding",
    "sector_model",
    "solve_rest",
    "statespace",
    "table_function",
    "wind_observer_model",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
