"""What is asked of a solver: LMIs as data, one condition a file, the only solver calls.

    condition/         an LMI as data: sums of L X R with constants, batched over vertices; and its
                       readers: floats, rationals, cvxpy, LaTeX
    polynomials/       matrix polynomials in memberships; a Lyapunov matrix that changes with them
    sums/              double sums over rules, and the relaxations that make LMIs of them
    cone/, solver/     cone data and their multipliers; the solver calls
    refutation/        exact reasons for a no
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

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.lmi.analysis.actuator_rates import input_rate_bound
    from takagi.lmi.analysis.box_enlargement import max_box_enlargement
    from takagi.lmi.analysis.common_quadratic import common_lyapunov, common_lyapunov_condition
    from takagi.lmi.analysis.decay_rate import max_decay_rate
    from takagi.lmi.analysis.disturbance.energy_gain import hinf_norm, hinf_norm_condition
    from takagi.lmi.analysis.disturbance.output_variance import h2_norm, h2_norm_condition
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
    from takagi.lmi.condition.term import LMI, Condition, Constant, Term
    from takagi.lmi.condition.typeset import latex, markdown
    from takagi.lmi.condition.uncertainty import NormBounded
    from takagi.lmi.condition.unknown import Unknown
    from takagi.lmi.decision.decide import decide, optimise
    from takagi.lmi.decision.item_rounds import decide_by_rounds, optimise_by_rounds
    from takagi.lmi.decision.outcome import Outcome
    from takagi.lmi.explaining.explanation import Explanation
    from takagi.lmi.explaining.weaker_requests import explain
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
    from takagi.lmi.gains.observer import observer, observer_condition
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
    from takagi.lmi.varying.constant_parameters import (
        polynomial_lyapunov,
        polynomial_lyapunov_condition,
    )
    from takagi.lmi.varying.robust_gain import robust_hinf_norm, robust_hinf_norm_condition
    from takagi.lmi.varying.varying_memberships import fuzzy_lyapunov, fuzzy_lyapunov_condition

__all__ = [
    "Alternative",
    "Answer",
    "Condition",
    "Constant",
    "Design",
    "DoubleSum",
    "EigenvalueRegion",
    "Explanation",
    "Extreme",
    "Fixed",
    "FuzzyDesign",
    "KnownBlock",
    "LMI",
    "Ladder",
    "LyapunovFamily",
    "NormBounded",
    "Outcome",
    "Part",
    "PolynomialLyapunov",
    "ProductRules",
    "Region",
    "RelaxationResult",
    "RelaxationSize",
    "Rung",
    "StructuredDesign",
    "SumPart",
    "Term",
    "Try",
    "Unknown",
    "attraction_ellipsoid",
    "attraction_pdc",
    "box_enlargement_condition",
    "common_lyapunov",
    "common_lyapunov_condition",
    "d_stability",
    "d_stability_condition",
    "decide",
    "decide_by_rounds",
    "enlarged_loops",
    "exact_matrices",
    "exact_no",
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
    "hinf_pdc",
    "hinf_pdc_condition",
    "input_rate_bound",
    "latex",
    "lqr_pdc",
    "lqr_pdc_condition",
    "markdown",
    "max_box_enlargement",
    "max_decay_rate",
    "neighbouring_rules",
    "objective_below",
    "observer",
    "observer_condition",
    "optimise",
    "optimise_by_rounds",
    "pdc",
    "pdc_condition",
    "peak_gain",
    "peak_gain_condition",
    "peak_pdc",
    "peak_pdc_condition",
    "polynomial_lyapunov",
    "polynomial_lyapunov_condition",
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
    "with_input_states",
    "with_overlap",
    "with_shape",
]

_HOME = {
    "Alternative": "refutation.alternative",
    "Answer": "answer",
    "Condition": "condition.term",
    "Constant": "condition.term",
    "Design": "answer",
    "DoubleSum": "sums.double_sum",
    "EigenvalueRegion": "condition.region",
    "Explanation": "explaining.explanation",
    "Extreme": "parameter_search.largest_parameter",
    "FuzzyDesign": "gains.fuzzy.design",
    "Fixed": "sums.double_sum",
    "KnownBlock": "sums.double_sum",
    "LMI": "condition.term",
    "Ladder": "gains.decay.relaxation_table",
    "LyapunovFamily": "polynomials.polynomial_lyapunov",
    "NormBounded": "condition.uncertainty",
    "Outcome": "decision.outcome",
    "PolynomialLyapunov": "polynomials.polynomial_lyapunov",
    "ProductRules": "sums.corner_rules",
    "Region": "condition.region",
    "RelaxationResult": "relaxation_result",
    "RelaxationSize": "sums.relaxation_sizes",
    "Rung": "relaxation_result",
    "StructuredDesign": "gains.structured.answer",
    "Part": "sums.double_sum",
    "SumPart": "sums.double_sum",
    "Term": "condition.term",
    "Try": "answer",
    "Unknown": "condition.unknown",
    "attraction_ellipsoid": "gains.attraction.design",
    "attraction_pdc": "gains.attraction.design",
    "box_enlargement_condition": "analysis.growth_condition",
    "common_lyapunov": "analysis.common_quadratic",
    "common_lyapunov_condition": "analysis.common_quadratic",
    "d_stability": "analysis.pole_region",
    "d_stability_condition": "analysis.pole_region",
    "decide": "decision.decide",
    "decide_by_rounds": "decision.item_rounds",
    "enlarged_loops": "analysis.loop_growth",
    "exact_matrices": "condition.exact",
    "exact_no": "refutation.refutation",
    "explain": "explaining.weaker_requests",
    "expressed": "condition.express",
    "extreme_parameter": "parameter_search.largest_parameter",
    "fuzzy_lyapunov": "varying.varying_memberships",
    "fuzzy_lyapunov_condition": "varying.varying_memberships",
    "fuzzy_pdc": "gains.fuzzy.pdc",
    "fuzzy_pdc_condition": "gains.fuzzy.pdc",
    "h2_norm": "analysis.disturbance.output_variance",
    "h2_norm_condition": "analysis.disturbance.output_variance",
    "h2_pdc": "gains.disturbance.output_variance",
    "h2_pdc_condition": "gains.disturbance.output_variance_sums",
    "hinf_norm": "analysis.disturbance.energy_gain",
    "hinf_norm_condition": "analysis.disturbance.energy_gain",
    "hinf_pdc": "gains.disturbance.energy_gain",
    "hinf_pdc_condition": "gains.disturbance.energy_gain_sums",
    "input_rate_bound": "analysis.actuator_rates",
    "latex": "condition.typeset",
    "lqr_pdc": "gains.cost.regulator",
    "lqr_pdc_condition": "gains.cost.condition",
    "markdown": "condition.typeset",
    "max_box_enlargement": "analysis.box_enlargement",
    "max_decay_rate": "analysis.decay_rate",
    "neighbouring_rules": "sums.membership_shape",
    "objective_below": "refutation.objective_limit",
    "observer": "gains.observer",
    "observer_condition": "gains.observer",
    "optimise": "decision.decide",
    "optimise_by_rounds": "decision.item_rounds",
    "pdc": "gains.decay.pdc",
    "pdc_condition": "gains.decay.condition",
    "peak_gain": "analysis.disturbance.peak_to_peak",
    "peak_gain_condition": "analysis.disturbance.peak_condition",
    "peak_pdc": "gains.disturbance.peak_gain",
    "peak_pdc_condition": "gains.disturbance.peak_gain_sums",
    "polynomial_lyapunov": "varying.constant_parameters",
    "polynomial_lyapunov_condition": "varying.constant_parameters",
    "product_bounds": "sums.membership_shape",
    "product_rules": "sums.corner_rules",
    "relaxation_ladder": "gains.decay.relaxation_table",
    "relaxation_named": "sums.relaxations",
    "relaxation_size": "sums.relaxation_sizes",
    "rigorous_no": "refutation.refutation",
    "robust_hinf_norm": "varying.robust_gain",
    "robust_hinf_norm_condition": "varying.robust_gain",
    "robust_lyapunov": "analysis.norm_bounded",
    "robust_lyapunov_condition": "analysis.norm_bounded",
    "secant_vertices": "gains.secant_vertices",
    "structured_pdc": "gains.structured.design",
    "structured_pdc_condition": "gains.structured.slack_matrix",
    "sweep": "parameter_search.parameter_sweep",
    "with_input_states": "gains.requirements.rate_limits",
    "with_overlap": "sums.membership_shape",
    "with_shape": "sums.membership_shape",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.lmi.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
