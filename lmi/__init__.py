"""What is asked of a solver: LMIs as data, gains and analysis by them, the only solver calls.

A public function is imported from ``takagi.lmi``; its module may move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.analysis.common_quadratic import common_lyapunov as common_lyapunov
    from takagi.lmi.analysis.decay_rate import (
        common_lyapunov_condition as common_lyapunov_condition,
    )
    from takagi.lmi.analysis.decay_rate import max_decay_rate as max_decay_rate
    from takagi.lmi.analysis.disturbance.energy_and_variance import h2_norm as h2_norm
    from takagi.lmi.analysis.disturbance.energy_and_variance import (
        h2_norm_condition as h2_norm_condition,
    )
    from takagi.lmi.analysis.disturbance.energy_and_variance import hinf_norm as hinf_norm
    from takagi.lmi.analysis.disturbance.energy_and_variance import (
        hinf_norm_condition as hinf_norm_condition,
    )
    from takagi.lmi.analysis.disturbance.exit_exponent import ExitFunction as ExitFunction
    from takagi.lmi.analysis.disturbance.exit_exponent import NoisyVertices as NoisyVertices
    from takagi.lmi.analysis.disturbance.exit_exponent import exit_condition as exit_condition
    from takagi.lmi.analysis.disturbance.exit_exponent import exit_function as exit_function
    from takagi.lmi.analysis.disturbance.peak_to_peak import peak_gain as peak_gain
    from takagi.lmi.analysis.disturbance.peak_to_peak import (
        peak_gain_condition as peak_gain_condition,
    )
    from takagi.lmi.analysis.pole_region import d_stability as d_stability
    from takagi.lmi.analysis.pole_region import d_stability_condition as d_stability_condition
    from takagi.lmi.analysis.start_set import StartSet as StartSet
    from takagi.lmi.analysis.start_set import start_set as start_set
    from takagi.lmi.analysis.start_set import start_set_condition as start_set_condition
    from takagi.lmi.analysis.start_set import tracking_condition as tracking_condition
    from takagi.lmi.analysis.start_set import tracking_function as tracking_function
    from takagi.lmi.answer import Answer as Answer
    from takagi.lmi.answer import Design as Design
    from takagi.lmi.answer import RelaxationResult as RelaxationResult
    from takagi.lmi.answer import Try as Try
    from takagi.lmi.condition.evaluate import exact_matrices as exact_matrices
    from takagi.lmi.condition.express import expressed as expressed
    from takagi.lmi.condition.log_det import log_det as log_det
    from takagi.lmi.condition.region import EigenvalueRegion as EigenvalueRegion
    from takagi.lmi.condition.statements import lmi_of as lmi_of
    from takagi.lmi.condition.statements import pose as pose
    from takagi.lmi.condition.term import LMI as LMI
    from takagi.lmi.condition.term import Condition as Condition
    from takagi.lmi.condition.term import Constant as Constant
    from takagi.lmi.condition.term import Equality as Equality
    from takagi.lmi.condition.term import Term as Term
    from takagi.lmi.condition.typeset import latex as latex
    from takagi.lmi.condition.typeset import markdown as markdown
    from takagi.lmi.condition.unknown import Unknown as Unknown
    from takagi.lmi.decision.decide import decide as decide
    from takagi.lmi.decision.decide import optimise as optimise
    from takagi.lmi.decision.outcome import Outcome as Outcome
    from takagi.lmi.decision.rounds import decide_by_rounds as decide_by_rounds
    from takagi.lmi.decision.rounds import optimise_by_rounds as optimise_by_rounds
    from takagi.lmi.equalities import ExactSolution as ExactSolution
    from takagi.lmi.equalities import Parametrised as Parametrised
    from takagi.lmi.equalities import exact_solution as exact_solution
    from takagi.lmi.equalities import parametrised as parametrised
    from takagi.lmi.explaining.explanation import Explanation as Explanation
    from takagi.lmi.explaining.weaker_requests import explain as explain
    from takagi.lmi.expressions.expression import Equation as Equation
    from takagi.lmi.expressions.expression import Expression as Expression
    from takagi.lmi.expressions.expression import He as He
    from takagi.lmi.expressions.expression import Inequality as Inequality
    from takagi.lmi.expressions.expression import Parameter as Parameter
    from takagi.lmi.expressions.expression import added as added
    from takagi.lmi.expressions.expression import block as block
    from takagi.lmi.expressions.expression import matrix as matrix
    from takagi.lmi.expressions.expression import trace as trace
    from takagi.lmi.gains.attraction.design import attraction_ellipsoid as attraction_ellipsoid
    from takagi.lmi.gains.attraction.design import attraction_pdc as attraction_pdc
    from takagi.lmi.gains.cost.regulator import lqr_pdc as lqr_pdc
    from takagi.lmi.gains.cost.regulator import lqr_pdc_condition as lqr_pdc_condition
    from takagi.lmi.gains.decay.condition import pdc_condition as pdc_condition
    from takagi.lmi.gains.decay.pdc import pdc as pdc
    from takagi.lmi.gains.disturbance.energy_gain import hinf_pdc as hinf_pdc
    from takagi.lmi.gains.disturbance.energy_gain import hinf_pdc_condition as hinf_pdc_condition
    from takagi.lmi.gains.disturbance.output_variance import h2_pdc as h2_pdc
    from takagi.lmi.gains.disturbance.output_variance import h2_pdc_condition as h2_pdc_condition
    from takagi.lmi.gains.disturbance.peak_gain import peak_pdc as peak_pdc
    from takagi.lmi.gains.disturbance.peak_gain import peak_pdc_condition as peak_pdc_condition
    from takagi.lmi.gains.fuzzy.pdc import FuzzyDesign as FuzzyDesign
    from takagi.lmi.gains.fuzzy.pdc import fuzzy_pdc as fuzzy_pdc
    from takagi.lmi.gains.fuzzy.pdc import fuzzy_pdc_condition as fuzzy_pdc_condition
    from takagi.lmi.gains.observer import observer as observer
    from takagi.lmi.gains.observer import observer_condition as observer_condition
    from takagi.lmi.gains.output_feedback.fixed_order import FixedOrderDesign as FixedOrderDesign
    from takagi.lmi.gains.output_feedback.fixed_order import (
        GeneralisedPlant as GeneralisedPlant,
    )
    from takagi.lmi.gains.output_feedback.fixed_order import hinf_fixed_order as hinf_fixed_order
    from takagi.lmi.gains.structured.design import StructuredDesign as StructuredDesign
    from takagi.lmi.gains.structured.design import structured_pdc as structured_pdc
    from takagi.lmi.gains.zero_gains import ZeroGainsWarning as ZeroGainsWarning
    from takagi.lmi.parameter_search.largest_parameter import Extreme as Extreme
    from takagi.lmi.parameter_search.largest_parameter import extreme_parameter as extreme_parameter
    from takagi.lmi.polynomials import PolynomialLyapunov as PolynomialLyapunov
    from takagi.lmi.problem_files.arrays import save_cvxpy as save_cvxpy
    from takagi.lmi.refutation.refutation import Alternative as Alternative
    from takagi.lmi.refutation.refutation import exact_no as exact_no
    from takagi.lmi.refutation.refutation import objective_below as objective_below
    from takagi.lmi.refutation.refutation import rigorous_no as rigorous_no
    from takagi.lmi.solver.time_limit import time_limit as time_limit
    from takagi.lmi.sums.corner_rules import ProductRules as ProductRules
    from takagi.lmi.sums.corner_rules import product_rules as product_rules
    from takagi.lmi.sums.double_sum import DoubleSum as DoubleSum
    from takagi.lmi.sums.double_sum import double_sum_of as double_sum_of
    from takagi.lmi.sums.relaxations import RelaxationSize as RelaxationSize
    from takagi.lmi.sums.relaxations import relaxation_named as relaxation_named
    from takagi.lmi.sums.relaxations import relaxation_size as relaxation_size
    from takagi.lmi.sums_of_squares.polynomial import StatePolynomial as StatePolynomial
    from takagi.lmi.varying.lyapunov_functions import fuzzy_lyapunov as fuzzy_lyapunov
    from takagi.lmi.varying.lyapunov_functions import (
        fuzzy_lyapunov_condition as fuzzy_lyapunov_condition,
    )

__getattr__, __dir__ = lazy_names(__name__)
