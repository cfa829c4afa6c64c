"""Gains with a Lyapunov function that depends on the weights, where no common one has any.

V = x' P(h) x with P(h) = sum_i h_i P_i.  In discrete time the weights may jump.  In continuous time
the claim assumes bounds on the rates of the premises; they are enclosed here from the equations, on
the ranges of states, inputs and signals:

    |dz/dt| <= max |sum_k dz/dx_k f_k(x, u, w)|

A premise whose rate has no bound, because it depends on a signal, or on something without a range,
has no part in P.  Sets and limits of inputs are proved by a common P alone, so such gains are not
sought where inputs have limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.plant.gain_task import FoundGains, GainTask
from takagi.certificates.document.model_data import rounded_up
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

# In the order in which they are tried; more rules take minutes.
RELAXATIONS, MOST_RULES = ("wang-tanaka-griffin", "polya-2"), 8


def premise_rates(plant: Plant, model: TSModel) -> dict[str, float] | None:
    """Return premise -> bound on |dz/dt| in its unit per second, inf for none.

    None where no premise has a bound, and in discrete time, where none is needed.
    """
    form = None if model.derivation is None else model.derivation.form
    if form is None or model.sample_time is not None or plant.mass is not None:
        return None
    rates = {}
    expressions = form.factored.premises.values()
    for premise, expression in zip(model.premises, expressions, strict=True):
        rates[premise.name] = _rate(plant, expression)
    return rates if np.isfinite(list(rates.values())).any() else None


def _rate(plant: Plant, premise: object) -> float:
    """Return the bound for one premise; inf for none."""
    import sympy as sp

    from takagi.models.ranges.expression_range import expression_range

    shifts = {
        sp.Symbol(f"delta_{v.name}", real=True): v.symbol - plant.at_rest[v.symbol]
        for v in plant.variables
    }
    z = sp.sympify(premise).subs(shifts).subs(plant.rationals)
    states = {v.symbol for v in plant.states}
    box = {symbol: side for symbol, side in plant.box.items()}
    if not z.free_symbols <= states:
        return np.inf
    pairs = zip(plant.states, plant.equations, strict=True)
    rate = sp.simplify(sum(sp.diff(z, v.symbol) * row.subs(plant.rationals) for v, row in pairs))
    if not rate.free_symbols <= set(box):
        return np.inf
    try:
        outer = expression_range(rate, box).outer
    except ModelError:
        return np.inf
    return rounded_up(float(max(abs(outer.lower), abs(outer.upper))), 4)


def fuzzy_gains(task: GainTask) -> FoundGains | None:
    """Return gains by ``fuzzy_pdc`` with the mean P; None without any.

    None too where something is asked that a common P alone proves, or where no premise has a rate.
    """
    from takagi.lmi import Design, fuzzy_pdc

    model, settings = task.model, task.settings
    asked = (settings.damping, settings.fastest, settings.gain_bound, settings.objective)
    if any(asked) or settings.decay_rate == "max" or settings.relaxation or settings.feedback:
        return None
    discrete = model.sample_time is not None
    rates = premise_rates(task.plant, model)
    if not 1 < len(model.A) <= MOST_RULES or (rates is None and not discrete):
        return None
    alpha = settings.decay_rate or 0.0
    for relaxation in RELAXATIONS:
        found = fuzzy_pdc(model, rate_bounds=rates, decay_rate=alpha, relaxation=relaxation)
        if found.gains is not None and found.matrices is not None:
            break
    else:
        return None
    design = Design(
        gains=found.gains,
        P=found.matrices.mean(axis=0),
        decay_rate=alpha,
        margin=found.margin,
        relaxation=relaxation,
        answer=found.answer,
    )
    assumed = "" if discrete else ", which assumes the rates of the premises that its claim states"
    note = (
        "no common function x' P x has gains by the relaxations that were tried: these were found "
        f"with one that depends on the weights, x' P(h) x{assumed}"
    )
    return FoundGains(design, (note,))
