"""What is asked of a solver: LMIs as data, one condition a file, the only solver calls.

    term, unknown      an LMI as data: sums of L X R with constants, batched over vertices
    evaluate, exact, express, typeset    its readers: floats, rationals, cvxpy, LaTeX
    answer, intake     what is handed back; what is checked at the door
    multisimplex, unknown_polynomial    matrix polynomials in memberships, as LMI coefficients
    lyapunov_family    a Lyapunov matrix that changes with the memberships
    alternative, indefinite              exact reasons for a no, checked by integers alone
    explanation, cures                   what stands in the way, and what would help
    solver/            cone data, the solver calls; decide, optimise, re-centre, check, diagnose
    analysis/          one condition a file about a given loop: stability, decay, norms, regions
    synthesis/         one condition a file about gains that are sought, and the double sums
    turbine/           gains of the multi-region wind-turbine controller

Importing this package imports nothing heavy: names are looked up when they are used.  No module
bears the name of a function: it would hide it once imported.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.lmi.alternative import Alternative
    from takagi.lmi.analysis.actuator_rates import input_rate_bound
    from takagi.lmi.analysis.box_enlargement import max_box_enlargement
    from takagi.lmi.analysis.constant_parameters import (
        polynomial_lyapunov,
        polynomial_lyapunov_condition,
    )
    from takagi.lmi.analysis.decay_rate import max_decay_rate
    from takagi.lmi.analysis.energy_gain import hinf_norm, hinf_norm_condition
    from takagi.lmi.analysis.growth_condition import box_enlargement_condition
    from takagi.lmi.analysis.loop_growth import enlarged_loops
    from takagi.lmi.analysis.norm_bounded import robust_lyapunov, robust_lyapunov_condition
    from takagi.lmi.analysis.output_variance import h2_norm, h2_norm_condition
    from takagi.lmi.analysis.peak_condition import peak_gain_condition
    from takagi.lmi.analysis.peak_to_peak import peak_gain
    from takagi.lmi.analysis.pole_region import d_stability, d_stability_condition
    from takagi.lmi.analysis.quadratic import common_lyapunov, common_lyapunov_condition
    from takagi.lmi.analysis.robust_gain import robust_hinf_norm, robust_hinf_norm_condition
    from takagi.lmi.analysis.varying_memberships import fuzzy_lyapunov, fuzzy_lyapunov_condition
    from takagi.lmi.answer import Answer, Design, Try
    from takagi.lmi.cures import explain
    from takagi.lmi.exact import exact_matrices
    from takagi.lmi.explanation import Explanation
    from takagi.lmi.express import expressed
    from takagi.lmi.lyapunov_family import LyapunovFamily
    from takagi.lmi.objective_limit import objective_below
    from takagi.lmi.region import Region
    from takagi.lmi.rung import Rung
    from takagi.lmi.solver.item_rounds import decide_by_rounds, optimise_by_rounds
    from takagi.lmi.solver.largest_parameter import Extreme, extreme_parameter
    from takagi.lmi.solver.outcome import Outcome
    from takagi.lmi.solver.parameter_sweep import sweep
    from takagi.lmi.solver.refutation import exact_no, rigorous_no
    from takagi.lmi.solver.stages import decide, optimise
    from takagi.lmi.synthesis.attraction import attraction_ellipsoid, attraction_pdc
    from takagi.lmi.synthesis.compensation import pdc
    from takagi.lmi.synthesis.compensation_condition import pdc_condition
    from takagi.lmi.synthesis.corner_rules import ProductRules, product_rules
    from takagi.lmi.synthesis.cost_condition import lqr_pdc_condition
    from takagi.lmi.synthesis.double_sum import DoubleSum, Fixed, Part
    from takagi.lmi.synthesis.energy_gain_design import hinf_pdc
    from takagi.lmi.synthesis.energy_gain_sums import hinf_pdc_condition
    from takagi.lmi.synthesis.fuzzy_compensation import fuzzy_pdc, fuzzy_pdc_condition
    from takagi.lmi.synthesis.fuzzy_design import FuzzyDesign
    from takagi.lmi.synthesis.ladder import Ladder, relaxation_ladder
    from takagi.lmi.synthesis.membership_shape import (
        neighbouring_rules,
        product_bounds,
        with_overlap,
        with_shape,
    )
    from takagi.lmi.synthesis.observation import observer, observer_condition
    from takagi.lmi.synthesis.output_variance_design import h2_pdc
    from takagi.lmi.synthesis.output_variance_sums import h2_pdc_condition
    from takagi.lmi.synthesis.peak_gain_design import peak_pdc
    from takagi.lmi.synthesis.peak_gain_sums import peak_pdc_condition
    from takagi.lmi.synthesis.rate_limits import with_input_states
    from takagi.lmi.synthesis.regulator import lqr_pdc
    from takagi.lmi.synthesis.relaxation_sizes import RelaxationSize, relaxation_size
    from takagi.lmi.synthesis.relaxations import relaxation_named
    from takagi.lmi.synthesis.secant_family import secant_vertices
    from takagi.lmi.synthesis.structured_answer import StructuredDesign
    from takagi.lmi.synthesis.structured_design import structured_pdc
    from takagi.lmi.synthesis.structured_slack import structured_pdc_condition
    from takagi.lmi.term import LMI, Condition, Constant, Term
    from takagi.lmi.typeset import latex, markdown
    from takagi.lmi.uncertainty import NormBounded
    from takagi.lmi.unknown import Unknown

__all__ = [
    "Alternative",
    "Answer",
    "Condition",
    "Constant",
    "Design",
    "DoubleSum",
    "Explanation",
    "Extreme",
    "Fixed",
    "FuzzyDesign",
    "LMI",
    "Ladder",
    "LyapunovFamily",
    "NormBounded",
    "Outcome",
    "Part",
    "ProductRules",
    "Region",
    "RelaxationSize",
    "Rung",
    "StructuredDesign",
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
    "Alternative": "alternative",
    "Answer": "answer",
    "Condition": "term",
    "Constant": "term",
    "Design": "answer",
    "DoubleSum": "synthesis.double_sum",
    "Explanation": "explanation",
    "Extreme": "solver.largest_parameter",
    "Fixed": "synthesis.double_sum",
    "FuzzyDesign": "synthesis.fuzzy_design",
    "LMI": "term",
    "Ladder": "synthesis.ladder",
    "LyapunovFamily": "lyapunov_family",
    "NormBounded": "uncertainty",
    "Outcome": "solver.outcome",
    "Part": "synthesis.double_sum",
    "ProductRules": "synthesis.corner_rules",
    "Region": "region",
    "RelaxationSize": "synthesis.relaxation_sizes",
    "Rung": "rung",
    "StructuredDesign": "synthesis.structured_answer",
    "Term": "term",
    "Try": "answer",
    "Unknown": "unknown",
    "attraction_ellipsoid": "synthesis.attraction",
    "attraction_pdc": "synthesis.attraction",
    "box_enlargement_condition": "analysis.growth_condition",
    "common_lyapunov": "analysis.quadratic",
    "common_lyapunov_condition": "analysis.quadratic",
    "d_stability": "analysis.pole_region",
    "d_stability_condition": "analysis.pole_region",
    "decide": "solver.stages",
    "decide_by_rounds": "solver.item_rounds",
    "enlarged_loops": "analysis.loop_growth",
    "exact_matrices": "exact",
    "exact_no": "solver.refutation",
    "explain": "cures",
    "expressed": "express",
    "extreme_parameter": "solver.largest_parameter",
    "fuzzy_lyapunov": "analysis.varying_memberships",
    "fuzzy_lyapunov_condition": "analysis.varying_memberships",
    "fuzzy_pdc": "synthesis.fuzzy_compensation",
    "fuzzy_pdc_condition": "synthesis.fuzzy_compensation",
    "h2_norm": "analysis.output_variance",
    "h2_norm_condition": "analysis.output_variance",
    "h2_pdc": "synthesis.output_variance_design",
    "h2_pdc_condition": "synthesis.output_variance_sums",
    "hinf_norm": "analysis.energy_gain",
    "hinf_norm_condition": "analysis.energy_gain",
    "hinf_pdc": "synthesis.energy_gain_design",
    "hinf_pdc_condition": "synthesis.energy_gain_sums",
    "input_rate_bound": "analysis.actuator_rates",
    "latex": "typeset",
    "lqr_pdc": "synthesis.regulator",
    "lqr_pdc_condition": "synthesis.cost_condition",
    "markdown": "typeset",
    "max_box_enlargement": "analysis.box_enlargement",
    "max_decay_rate": "analysis.decay_rate",
    "neighbouring_rules": "synthesis.membership_shape",
    "objective_below": "objective_limit",
    "observer": "synthesis.observation",
    "observer_condition": "synthesis.observation",
    "optimise": "solver.stages",
    "optimise_by_rounds": "solver.item_rounds",
    "pdc": "synthesis.compensation",
    "pdc_condition": "synthesis.compensation_condition",
    "peak_gain": "analysis.peak_to_peak",
    "peak_gain_condition": "analysis.peak_condition",
    "peak_pdc": "synthesis.peak_gain_design",
    "peak_pdc_condition": "synthesis.peak_gain_sums",
    "polynomial_lyapunov": "analysis.constant_parameters",
    "polynomial_lyapunov_condition": "analysis.constant_parameters",
    "product_bounds": "synthesis.membership_shape",
    "product_rules": "synthesis.corner_rules",
    "relaxation_ladder": "synthesis.ladder",
    "relaxation_named": "synthesis.relaxations",
    "relaxation_size": "synthesis.relaxation_sizes",
    "rigorous_no": "solver.refutation",
    "robust_hinf_norm": "analysis.robust_gain",
    "robust_hinf_norm_condition": "analysis.robust_gain",
    "robust_lyapunov": "analysis.norm_bounded",
    "robust_lyapunov_condition": "analysis.norm_bounded",
    "secant_vertices": "synthesis.secant_family",
    "structured_pdc": "synthesis.structured_design",
    "structured_pdc_condition": "synthesis.structured_slack",
    "sweep": "solver.parameter_sweep",
    "with_input_states": "synthesis.rate_limits",
    "with_overlap": "synthesis.membership_shape",
    "with_shape": "synthesis.membership_shape",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.lmi.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
