"""What is asked of a solver: LMIs as data, one condition a file, the only solver calls.

    term, unknown             an LMI as data: sums of L X R with constants, batched over vertices
    assemble, exact, express, typeset    its readers: cone data, rationals, cvxpy, LaTeX
    evaluate                  the same in floating point, for checking candidates
    solve, stages             the solver calls; decide, optimise, re-centre, check
    quadratic, decay_rate, compensation, observation    one condition a file
    energy_gain, output_variance, regulator             norms from disturbance to output; cost
    relaxations, double_sum, limits    what the synthesis conditions are made of

Importing this package imports nothing heavy: names are looked up when they are used.  No module
bears the name of a function: it would hide it once imported.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer, Design, Try
    from takagi.lmi.compensation import pdc
    from takagi.lmi.compensation_condition import pdc_condition
    from takagi.lmi.cost_condition import lqr_pdc_condition
    from takagi.lmi.decay_rate import max_decay_rate
    from takagi.lmi.energy_gain import hinf_norm, hinf_norm_condition
    from takagi.lmi.exact import exact_matrices
    from takagi.lmi.express import expressed
    from takagi.lmi.observation import observer, observer_condition
    from takagi.lmi.output_variance import h2_norm, h2_norm_condition
    from takagi.lmi.quadratic import common_lyapunov, common_lyapunov_condition
    from takagi.lmi.regulator import lqr_pdc
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
    "common_lyapunov": "quadratic",
    "common_lyapunov_condition": "quadratic",
    "exact_matrices": "exact",
    "expressed": "express",
    "h2_norm": "output_variance",
    "h2_norm_condition": "output_variance",
    "hinf_norm": "energy_gain",
    "hinf_norm_condition": "energy_gain",
    "latex": "typeset",
    "lqr_pdc": "regulator",
    "lqr_pdc_condition": "cost_condition",
    "max_decay_rate": "decay_rate",
    "observer": "observation",
    "observer_condition": "observation",
    "pdc": "compensation",
    "pdc_condition": "compensation_condition",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.lmi.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
