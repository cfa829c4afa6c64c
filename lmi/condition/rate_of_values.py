"""The decay rate that given unknowns show, by one generalised eigenvalue for each item."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from takagi.lmi.condition.evaluate import lmi_value
from takagi.lmi.condition.term import LMI, Array, Condition


def rate_of_values(condition: Condition, values: Mapping[str, Array], step: float | None) -> float:
    """Return the largest decay rate in 1/s at which these unknowns satisfy the condition.

    With G = sign F > 0 at the parameter theta and D = -d G / d theta, the LMI holds up to theta +
    delta for delta = 1 / lambda_max(L^-1 D L'^-1), G = L L'.  (For ``contraction`` the same with
    D = d G / d theta, down to theta - delta.)

    Parameters
    ----------
    condition : has the parameter ``alpha``, or ``contraction`` = e^(-2 alpha T), and holds with a
        positive margin at ``values``.
    step : T in s; None for continuous time.
    """
    name = "alpha" if step is None else "contraction"
    towards = 1.0 if step is None else -1.0
    theta = condition.parameters[name]
    room = min(
        (
            _room(condition, lmi, values, name, towards)
            for lmi in condition.lmis
            if any(term.parameter == name for term in lmi.terms)
        ),
        default=np.inf,
    )
    return rate_of_parameter(theta + towards * room, step)


def rate_of_parameter(theta: float, step: float | None) -> float:
    """Return alpha in 1/s from ``alpha``, or from ``contraction``."""
    if step is None:
        return float(theta)
    return float(-np.log(theta) / (2.0 * step)) if theta > 0 else np.inf


def _room(
    condition: Condition, lmi: LMI, values: Mapping[str, Array], name: str, towards: float
) -> float:
    """Return how far the parameter may move before an item of the LMI is singular."""
    here = dict(condition.parameters)
    there = {**here, name: here[name] + towards}
    G = lmi.sign * lmi_value(lmi, values, here)
    D = G - lmi.sign * lmi_value(lmi, values, there)
    try:
        L = np.linalg.cholesky((G + G.transpose(0, 2, 1)) / 2)
    except np.linalg.LinAlgError:
        return 0.0
    inside = np.linalg.solve(L, np.linalg.solve(L, D).transpose(0, 2, 1))
    largest = float(np.linalg.eigvalsh((inside + inside.transpose(0, 2, 1)) / 2)[:, -1].max())
    return 1.0 / largest if largest > 0 else np.inf
