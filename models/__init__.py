"""What is controlled and by which law: Takagi-Sugeno models, their derivation, wind turbines.

    ts/                     TSModel: vertices, premises with proved ranges, rules, box
    plant/, plant_files/    Plant: equations, variables with units and ranges; plant files read
    files/, expressions/    what model files share; expressions as text
    equations/, sector/     the plant about its equilibrium; symbolic sector nonlinearity
    intervals/, splines/, ranges/    interval arithmetic; spline surfaces; rigorous ranges
    ramps, blending/        one quantity handed over to another; two actuators that share one effort
    laws/, tracking         controller laws as values; outputs that follow references
    turbine/, simulation/   wind turbines; the nonlinear plant and the loop in time
    plant_simulation/       any other plant in time
    loading, errors         models from files and built-in ones by name; ModelError
    control_systems         plants, models and laws as systems of python-control
    lazy_names              the names of a package, imported when they are used

Importing this package imports nothing heavy: names are looked up when they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.arrays import Floats as Floats
    from takagi.models.control_systems import law_system as law_system
    from takagi.models.control_systems import nonlinear_system as nonlinear_system
    from takagi.models.control_systems import statespace as statespace
    from takagi.models.equations.equations import Step as Step
    from takagi.models.equations.solved_rest import solve_rest as solve_rest
    from takagi.models.errors import ModelError as ModelError
    from takagi.models.files.library import built_in_models as built_in_models
    from takagi.models.intervals.interval import Interval as Interval
    from takagi.models.loading import load_model as load_model
    from takagi.models.plant.entries import plant_file_schema as plant_file_schema
    from takagi.models.plant.plant import Plant as Plant
    from takagi.models.plant.variables import Output as Output
    from takagi.models.plant.variables import Parameter as Parameter
    from takagi.models.plant.variables import Variable as Variable
    from takagi.models.ranges.cell_search import Cell as Cell
    from takagi.models.ranges.domain import Domain as Domain
    from takagi.models.ranges.sampled import sampled_bounds as sampled_bounds
    from takagi.models.sector.model import rule_count as rule_count
    from takagi.models.sector.model import sector_model as sector_model
    from takagi.models.sector.premise_bounds import RuleCount as RuleCount
    from takagi.models.splines.curve import Curve as Curve
    from takagi.models.splines.curve import interpolate_curve as interpolate_curve
    from takagi.models.splines.surface import Surface as Surface
    from takagi.models.splines.table_function import table_function as table_function
    from takagi.models.ts.mat_file import load_ts_model as load_ts_model
    from takagi.models.ts.model import Derivation as Derivation
    from takagi.models.ts.model import Matrices as Matrices
    from takagi.models.ts.model import TSModel as TSModel
    from takagi.models.ts.premise import Premise as Premise
    from takagi.models.turbine.data import Turbine as Turbine
    from takagi.models.turbine.full_load import full_load_model as full_load_model
    from takagi.models.turbine.loader import nrel5mw as nrel5mw
    from takagi.models.turbine.partial_load import partial_load_model as partial_load_model
    from takagi.models.turbine.wind_observer import WindObserver as WindObserver
    from takagi.models.turbine.wind_observer import wind_observer_model as wind_observer_model

__getattr__, __dir__ = lazy_names(__name__)
