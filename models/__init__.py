"""What is controlled and by which law: Takagi-Sugeno models, their derivation, wind turbines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.arrays import Floats as Floats
    from takagi.models.control_systems import law_system as law_system
    from takagi.models.control_systems import nonlinear_system as nonlinear_system
    from takagi.models.control_systems import statespace as statespace
    from takagi.models.equations.derivation_step import Step as Step
    from takagi.models.equations.solved_rest import solve_rest as solve_rest
    from takagi.models.errors import ModelError as ModelError
    from takagi.models.files.library import built_in_models as built_in_models
    from takagi.models.intervals.interval import Interval as Interval
    from takagi.models.loading import load_model as load_model
    from takagi.models.plant.entries import plant_file_schema as plant_file_schema
    from takagi.models.plant.plant import Output as Output
    from takagi.models.plant.plant import Parameter as Parameter
    from takagi.models.plant.plant import Plant as Plant
    from takagi.models.plant.plant import Variable as Variable
    from takagi.models.plant_files.writer import plant_text as plant_text
    from takagi.models.ranges.cell_search import Cell as Cell
    from takagi.models.ranges.expression_range import Domain as Domain
    from takagi.models.ranges.expression_range import sampled_bounds as sampled_bounds
    from takagi.models.sector.model import rule_count as rule_count
    from takagi.models.sector.model import sector_model as sector_model
    from takagi.models.sector.premise_bounds import RuleCount as RuleCount
    from takagi.models.sources.control_plant import from_control as from_control
    from takagi.models.sources.linear import from_arrays as from_arrays
    from takagi.models.sources.linear import from_csv as from_csv
    from takagi.models.sources.linear import from_lin as from_lin
    from takagi.models.sources.linear import from_mat as from_mat
    from takagi.models.sources.symbolic import from_sympy as from_sympy
    from takagi.models.splines.spline import Curve as Curve
    from takagi.models.splines.spline import Surface as Surface
    from takagi.models.splines.spline import interpolate_curve as interpolate_curve
    from takagi.models.splines.table_function import table_function as table_function
    from takagi.models.ts.mat_file import load_ts_model as load_ts_model
    from takagi.models.ts.model import Derivation as Derivation
    from takagi.models.ts.model import Matrices as Matrices
    from takagi.models.ts.model import TSModel as TSModel
    from takagi.models.ts.premise import Premise as Premise
    from takagi.models.turbine.data import Turbine as Turbine
    from takagi.models.turbine.loader import nrel5mw as nrel5mw
    from takagi.models.turbine.region_models import full_load_model as full_load_model
    from takagi.models.turbine.region_models import partial_load_model as partial_load_model
    from takagi.models.turbine.wind_observer import WindObserver as WindObserver
    from takagi.models.turbine.wind_observer import wind_observer_model as wind_observer_model

__getattr__, __dir__ = lazy_names(__name__)
