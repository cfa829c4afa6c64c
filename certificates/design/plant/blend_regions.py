"""Gains of a blended plant by its regions: sought without errors, put on all rules of the model.

The rules of the model with errors are corners of premises that the law knows and of errors that it
does not.  Each takes the gain of that rule of the model without errors which has the same corners
of what is known; so gains differ only with what is known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.document.plant_text import blend_of, unknown_premises
from takagi.models.arrays import Indices
from takagi.models.blending.blending import SHARE
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

    from takagi.lmi import Design
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

ONE_GAIN = "common-gain"


@dataclass(frozen=True, slots=True, eq=False)
class Errorless:
    """The plant with actuators without error, and its model."""

    plant: Plant
    model: TSModel


def errorless(model: TSModel, settings: PlantSettings) -> tuple[Errorless, Indices] | None:
    """Return the plant without errors, and for each rule of ``model`` the rule that it takes.

    None where the model without errors has no premise in the share, or one that is not found in
    ``model``.
    """
    from takagi.models.blending.substitution import blended_model, blended_plant

    blending = blend_of(model)
    if blending is None:
        return None
    sure = replace(
        blending,
        low=replace(blending.low, error=Fraction(0)),
        high=replace(blending.high, error=Fraction(0)),
    )
    nominal = blended_plant(sure)
    choice, rest = settings.choice, settings.rest
    errorless_model = blended_model(nominal, choice=choice, rest=rest, share_apart=True)
    indices = _premise_indices(errorless_model, model)
    if indices is None or not any(
        str(symbol) in (SHARE, f"delta_{SHARE}")
        for expression in _expressions(errorless_model)
        for symbol in expression.free_symbols
    ):
        return None
    numbers = {rule: k for k, rule in enumerate(errorless_model.rules)}
    rules = [numbers[tuple(rule[index] for index in indices)] for rule in model.rules]
    return Errorless(nominal, errorless_model), np.array(rules, dtype=np.intp)


def expanded(design: Design, rules: Indices) -> Design:
    """Return the design with the gain of ``rules[i]`` in rule i."""
    gains = np.asarray(design.require()[0])
    return replace(design, gains=gains[rules])


def _premise_indices(errorless_model: TSModel, model: TSModel) -> list[int] | None:
    """Return which premise of ``model`` is each one of the errorless model, up to a constant."""
    is_known = [not unknown for unknown in unknown_premises(model)]
    expressions = _expressions(model)
    indices = []
    pairs = zip(errorless_model.premises, _expressions(errorless_model), strict=True)
    for premise, expression in pairs:
        width = premise.upper - premise.lower
        same = [
            k
            for k, candidate in enumerate(expressions)
            if is_known[k]
            and not (candidate - expression).simplify().free_symbols
            and abs((model.premises[k].upper - model.premises[k].lower) - width) <= width / 10**6
        ]
        if not same:
            return None
        indices.append(same[0])
    return indices


def _expressions(model: TSModel) -> list[sp.Expr]:
    form = None if model.derivation is None else model.derivation.form
    return [] if form is None else list(form.factored.premises.values())


def _unknown(model: TSModel) -> str:
    return "uncertain parameters" if blend_of(model) is None else "the errors of the actuators"


def one_gain(model: TSModel, settings: PlantSettings) -> tuple[PlantSettings, tuple[str, ...]]:
    """Return the settings, with one gain for all rules where a premise is not known to the law.

    Raises
    ------
    ModelError : another relaxation was asked for.
    """
    if any(unknown_premises(model)):
        cause = f"{_unknown(model)} are not known to a law"
        note = f"{_unknown(model)} are not measured: one gain for all rules"
    elif commanded := _commanded_premises(model):
        cause = f"{', '.join(commanded)} depends on an input, which the law knows only afterwards"
        note = f"{cause}: one gain for all rules"
    else:
        return settings, ()
    if settings.relaxation not in (None, ONE_GAIN):
        raise ModelError(
            f"relaxation {settings.relaxation!r} makes a gain for each rule, but {cause}; leave it "
            f"out, or give {ONE_GAIN!r}"
        )
    return replace(settings, relaxation=ONE_GAIN), (note,)


def _commanded_premises(model: TSModel) -> list[str]:
    """Return the names of the premises that depend on an input."""
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return []
    inputs = set(form.problem.equations.inputs)
    premises = form.factored.premises.items()
    return [symbol.name for symbol, e in premises if inputs & e.free_symbols]
