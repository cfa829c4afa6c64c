"""What is asked of a solver: LMIs as data, one condition a file, the only solver calls.

    expressions/       matrices that are written with operators, P @ A
    condition/         an LMI as data: sums of L X R with constants, batched over vertices; and its
                       readers: floats, rationals, cvxpy, LaTeX
    sums_of_squares/   Lyapunov functions that are polynomials of the state
    polynomials/       matrix polynomials in memberships; a Lyapunov matrix that changes with them
    sums/              double sums over rules, and the relaxations that make LMIs of them
    cone/, solver/     cone data and their multipliers; the solver calls
    refutation/        exact reasons for a no
    equalities/        equalities solved exactly; exact answers
    decision/          decide, optimise, check, diagnose
    parameter_search/  the best value of a parameter in a condition
    analysis/          one condition a file about a given loop: stability, decay, norms, regions
    varying/           ... by Lyapunov functions that change with parameters or memberships
    gains/             search for gains, one kind of question a folder
    explaining/        why a design fails, and what would help
    turbine/           gains of the multi-region wind-turbine controller
    answer, relaxation_result    what is returned
    argument_checks, stabilisability    what is checked on entry

Importing this package imports nothing heavy: names are looked up when they are used.  No module
has the name of a function: it would hide it once imported.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.analysis.actuator_rates import input_rate_bound
    from takagi.lmi.analysis.box_enlargement import max_box_enlargement
    from takagi.lmi.analysis.common_quadratic import common_lyapunov, common_lyapunov_condition
    from takagi.lmi.analysis.decay_rate import max_decay_rate
    from takagi.lmi.analysis.disturbance.energy_gain import hinf_norm, hinf_norm_condition
    from takagi.lmi.analysis.disturbance.output_variance import h2_norm, h2_norm_condition
    from takagi.lmi.analysis.disturbance.passivity import passivity, passivity_condition
    from takagi.lmi.analysis.disturbance.peak_condition import peak_gain_condition
    from takagi.lmi.analysis.disturbance.peak_to_peak import peak_gain
    from takagi.lmi.analysis.growth_condition import box_enlargement_condition
    from takagi.lmi.analysis.loop_growth import enlarged_loops
    from takagi.lmi.analysis.norm_bounded import robust_lyapunov, robust_lyapunov_condition
    from takagi.lmi.analysis.pole_region import d_stability, d_stability_condition
    from takagi.lmi.answer import Answer, Design, Try
    from takagi.lmi.condition.exact import exact_matrices
    from takagi.lmi.condition.express import expressed
    from takagi.lmi.condition.region import EigenvalueRegion, Region
    from takagi.lmi.condition.statements import pose
    from takagi.lmi.condition.term import LMI, Condition, Constant, Equality, Term
    from takagi.lmi.condition.typeset import latex, markdown
    from takagi.lmi.condition.uncertainty import NormBounded
    from takagi.lmi.condition.unknown import Unknown
    from takagi.lmi.decision.decide import decide, optimise
    from takagi.lmi.decision.item_rounds import decide_by_rounds, optimise_by_rounds
    from takagi.lmi.decision.outcome import Outcome
    from takagi.lmi.equalities.exact_solution import ExactSolution, exact_solution
    from takagi.lmi.equalities.parametrised import Parametrised, parametrised
    from takagi.lmi.explaining.explanation import Explanation
    from takagi.lmi.explaining.weaker_requests import explain
    from takagi.lmi.expressions.expression import Equation, Expression, Inequality
    from takagi.lmi.expressions.matrices import He, block, matrix, trace
    from takagi.lmi.gains.attraction.design import attraction_ellipsoid, attraction_pdc
    from takagi.lmi.gains.cost.condition import lqr_pdc_condition
    from takagi.lmi.gains.cost.regulator import lqr_pdc
    from takagi.lmi.gains.decay.condition import pdc_condition
    from takagi.lmi.gains.decay.pdc import pdc
    from takagi.lmi.gains.decay.relaxation_table import Ladder, relaxation_ladder
    from takagi.lmi.gains.disturbance.energy_gain import hinf_pdc
    from takagi.lmi.gains.disturbance.energy_gain_sums import hinf_pdc_condition
    from takagi.lmi.gains.disturbance.output_variance import h2_pdc
    from takagi.lmi.gains.disturbance.output_variance_sums import h2_pdc_condition
    from takagi.lmi.gains.disturbance.peak_gain import peak_pdc
    from takagi.lmi.gains.disturbance.peak_gain_sums import peak_pdc_condition
    from takagi.lmi.gains.fuzzy.design import FuzzyDesign
    from takagi.lmi.gains.fuzzy.pdc import fuzzy_pdc, fuzzy_pdc_condition
    from takagi.lmi.gains.given.condition import closed_loop_condition
    from takagi.lmi.gains.given.ladder import closed_loop_ladder
    from takagi.lmi.gains.given.largest_decay import closed_loop_decay
    from takagi.lmi.gains.observer import observer, observer_condition
    from takagi.lmi.gains.output_feedback.condition import hinf_output_feedback_condition
    from takagi.lmi.gains.output_feedback.controller import OutputFeedback, hinf_output_feedback
    from takagi.lmi.gains.output_feedback.generalised_plant import GeneralisedPlant
    from takagi.lmi.gains.output_feedback.weighted_loop import mixed_sensitivity
    from takagi.lmi.gains.requirements.rate_limits import with_input_states
    from takagi.lmi.gains.secant_vertices import secant_vertices
    from takagi.lmi.gains.structured.answer import StructuredDesign
    from takagi.lmi.gains.structured.design import structured_pdc
    from takagi.lmi.gains.structured.slack_matrix import structured_pdc_condition
    from takagi.lmi.parameter_search.largest_parameter import Extreme, extreme_parameter
    from takagi.lmi.parameter_search.parameter_sweep import sweep
    from takagi.lmi.polynomials.polynomial_lyapunov import LyapunovFamily, PolynomialLyapunov
    from takagi.lmi.refutation.alternative import Alternative
    from takagi.lmi.refutation.objective_limit import objective_below
    from takagi.lmi.refutation.refutation import exact_no, rigorous_no
    from takagi.lmi.relaxation_result import RelaxationResult, Rung
    from takagi.lmi.sums.corner_rules import ProductRules, product_rules
    from takagi.lmi.sums.double_sum import DoubleSum, Fixed, Part
    from takagi.lmi.sums.membership_shape import (
        neighbouring_rules,
        product_bounds,
        with_overlap,
        with_shape,
    )
    from takagi.lmi.sums.relaxation_sizes import RelaxationSize, relaxation_size
    from takagi.lmi.sums.relaxations import relaxation_named
    from takagi.lmi.sums.summands import KnownBlock, SumPart
    from takagi.lmi.sums_of_squares.attraction_level import (
        AttractionLevel,
        attraction_level,
        attraction_level_condition,
    )
    from takagi.lmi.sums_of_squares.homogeneous_lyapunov import (
        HomogeneousLyapunov,
        homogeneous_lyapunov,
        homogeneous_lyapunov_condition,
    )
    from takagi.lmi.sums_of_squares.polynomial import StatePolynomial
    from takagi.lmi.varying.constant_parameters import (
        polynomial_lyapunov,
        polynomial_lyapunov_condition,
    )
    from takagi.lmi.varying.robust_gain import robust_hinf_norm, robust_hinf_norm_condition
    from takagi.lmi.varying.varying_memberships import fuzzy_lyapunov, fuzzy_lyapunov_condition

__all__ = [
    "Alternative",
    "Answer",
    "AttractionLevel",
    "Condition",
    "Constant",
    "Design",
    "DoubleSum",
    "EigenvalueRegion",
    "Equality",
    "Equation",
    "ExactSolution",
    "Explanation",
    "Expression",
    "Extreme",
    "Fixed",
    "FuzzyDesign",
    "GeneralisedPlant",
    "He",
    "HomogeneousLyapunov",
    "Inequality",
    "KnownBlock",
    "LMI",
    "Ladder",
    "LyapunovFamily",
    "NormBounded",
    "Outcome",
    "OutputFeedback",
    "Parametrised",
    "Part",
    "PolynomialLyapunov",
    "ProductRules",
    "Region",
    "RelaxationResult",
    "RelaxationSize",
    "Rung",
    "StatePolynomial",
    "StructuredDesign",
    "SumPart",
    "Term",
    "Try",
    "Unknown",
    "attraction_ellipsoid",
    "attraction_level",
    "attraction_level_condition",
    "attraction_pdc",
    "block",
    "box_enlargement_condition",
    "closed_loop_condition",
    "closed_loop_decay",
    "closed_loop_ladder",
    "common_lyapunov",
    "common_lyapunov_condition",
    "d_stability",
    "d_stability_condition",
    "decide",
    "decide_by_rounds",
    "enlarged_loops",
    "exact_matrices",
    "exact_no",
    "exact_solution",
    "explain",
    "expressed",
    "extreme_parameter",
    "fuzzy_lyapunov",
    "fuzzy_lyapunov_condition",
    "fuzzy_pdc",
    "fuzzy_pdc_condition",
    "h2_norm",
    "h2_norm_condition",
    "h2_pdc",
    "h2_pdc_condition",
    "hinf_norm",
    "hinf_norm_condition",
    "hinf_output_feedback",
    "hinf_output_feedback_condition",
    "hinf_pdc",
    "hinf_pdc_condition",
    "homogeneous_lyapunov",
    "homogeneous_lyapunov_condition",
    "input_rate_bound",
    "latex",
    "lqr_pdc",
    "lqr_pdc_condition",
    "markdown",
    "matrix",
    "max_box_enlargement",
    "max_decay_rate",
    "mixed_sensitivity",
    "neighbouring_rules",
    "objective_below",
    "observer",
    "observer_condition",
    "optimise",
    "optimise_by_rounds",
    "parametrised",
    "pdc",
    "pdc_condition",
    "passivity",
    "passivity_condition",
    "peak_gain",
    "peak_gain_condition",
    "peak_pdc",
    "peak_pdc_condition",
    "polynomial_lyapunov",
    "polynomial_lyapunov_condition",
    "pose",
    "product_bounds",
    "product_rules",
    "relaxation_ladder",
    "relaxation_named",
    "relaxation_size",
    "rigorous_no",
    "robust_hinf_norm",
    "robust_hinf_norm_condition",
    "robust_lyapunov",
    "robust_lyapunov_condition",
    "secant_vertices",
    "structured_pdc",
    "structured_pdc_condition",
    "sweep",
    "trace",
    "with_input_states",
    "with_overlap",
    "with_shape",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
