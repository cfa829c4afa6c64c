"""What is asked of a solver: LMIs as data, one condition a file, the only solver calls.

    term, unknown      an LMI as data: sums of L X R with constants, batched over vertices
    evaluate, exact, express, typeset    its readers: floats, rationals, cvxpy, LaTeX
    answer, intake     what is handed back; what is checked at the door
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
    from takagi.lmi.analysis.decay_rate import max_decay_rate
    from takagi.lmi.analysis.energy_gain import hinf_norm, hinf_norm_condition
    from takagi.lmi.analysis.output_variance import h2_norm, h2_norm_condition
    from takagi.lmi.analysis.quadratic import common_lyapunov, common_lyapunov_condition
    from takagi.lmi.answer import Answer, Design, Try
    from takagi.lmi.exact import exact_matrices
    from takagi.lmi.express import expressed
    from takagi.lmi.synthesis.compensation import pdc
    from takagi.lmi.synthesis.compensation_condition import pdc_condition
    from takagi.lmi.synthesis.cost_condition import lqr_pdc_condition
    from takagi.lmi.synthesis.observation import observer, observer_condition
    from takagi.lmi.synthesis.regulator import lqr_pdc
    from takagi.lmi.term import LMI, Condition, Constant, Term
    from takagi.lmi.typeset import latex
    from takagi.lmi.unknown import Unknown

__all__ = [
    "Answer",
    "Condition",
    "Constant",
    "Design",
    "LMI",
    "Term",
    "Try",
    "Unknown",
    "common_lyapunov",
    "common_lyapunov_condition",
    "exact_matrices",
    "expressed",
    "h2_norm",
    "h2_norm_condition",
    "hinf_norm",
    "hinf_norm_condition",
    "latex",
    "lqr_pdc",
    "lqr_pdc_condition",
    "max_decay_rate",
    "observer",
    "observer_condition",
    "pdc",
    "pdc_condition",
]

_HOME = {
    "Answer": "answer",
    "Condition": "term",
    "Constant": "term",
    "Design": "answer",
    "LMI": "term",
    "Term": "term",
    "Try": "answer",
    "Unknown": "unknown",
    "common_lyapunov": "analysis.quadratic",
    "common_lyapunov_condition": "analysis.quadratic",
    "exact_matrices": "exact",
    "expressed": "express",
    "h2_norm": "analysis.output_variance",
    "h2_norm_condition": "analysis.output_variance",
    "hinf_norm": "analysis.energy_gain",
    "hinf_norm_condition": "analysis.energy_gain",
    "latex": "typeset",
    "lqr_pdc": "synthesis.regulator",
    "lqr_pdc_condition": "synthesis.cost_condition",
    "max_decay_rate": "analysis.decay_rate",
    "observer": "synthesis.observation",
    "observer_condition": "synthesis.observation",
    "pdc": "synthesis.compensation",
    "pdc_condition": "synthesis.compensation_condition",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.lmi.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
