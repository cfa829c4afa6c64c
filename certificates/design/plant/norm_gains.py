"""Gains for a norm from disturbances to performance, together with the other wishes.

One set of LMIs has the norm and, where they are asked for:

    wish                            hinf    h2      peak
    decay rate (settle)             yes     yes     yes, the rate of the ellipsoid itself
    damping, fastest                yes     yes     yes
    gain_bound                      yes     yes     yes
    input limits, state ranges      yes     no      yes

Limits hold on an ellipsoid x' P x <= 1 that contains the initial box and all states that
disturbances of a size reach from rest: an energy for hinf, a peak for peak.  The size is searched
for, because the norm that the LMIs show is about that of the ellipsoid over it: the larger the size
for which the limits have room, the less the initial box adds.  White noise leaves every ellipsoid,
so h2 has no such LMIs: there the norm is reduced as long as the gains keep the limits from the box.

The least norm is often approached only as the gains grow without bound.  So gains are designed for
a norm above the least one by a share (``ABOVE``), and of these with about the least input effort.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.design.plant.gain_task import FoundGains, GainTask
from takagi.certificates.design.plant.norm_wish import NormWish
from takagi.certificates.design.plant.plain_words import in_file_rates
from takagi.certificates.design.plant.wishes import crossing_rates, held_from, pole_rates
from takagi.models.arrays import Floats
from takagi.models.plant.design_settings import Norm

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
    from takagi.models.plant.design_settings import Effort

# Of the least norm that was found, the norm that gains are designed for.
ABOVE: Mapping[Effort, float] = {"small": 1.5, "moderate": 1.1, "large": 1.02}
# Factors on the size of the disturbance, their number, and the norm that is better by another one.
GROWTH, MOST_SIZES, BETTER = 3.0, 6, 0.98
# Factor by which the norm of plain gains is reduced at first, how often at most, and the root of it
# at which the search ends.
REDUCED, MOST_REDUCED, NEARLY = 4.0, 16, 0.85
# The claim is about rounded gains, so the LMIs are posed a little below the norm that is asked for.
INSIDE = 0.999


@dataclass(frozen=True, slots=True, eq=False)
class NormQuestion:
    """One way to ask for gains with a norm.

    Attributes
    ----------
    plant : as the LMI layer takes it, with the region of the poles.
    relaxation : of the double sum.
    options : what is asked beside the norm, as the LMI layer names it.
    limited : whether limits hold on the ellipsoid, so that a size of the disturbance is needed.
    duration : time scale of the plant [s].
    """

    wish: NormWish
    plant: DisturbedPlant
    relaxation: str
    options: Mapping[str, Any]
    limited: bool
    duration: float

    @classmethod
    def of(cls, task: GainTask, wish: NormWish, relaxation: str) -> NormQuestion:
        """Return the question with all wishes that have LMIs beside the norm.

        Without an initial box, limits are not posed.  The last, fastest of the plant's rates gives
        the time scale.
        """
        model, box, limit, rate = task.model, task.box, task.input_limit, task.rate
        options: dict[str, Any] = {"gain_bound": task.settings.gain_bound}
        if rate:
            options["decay_rate"] = rate
        limited = any(task.initial) and wish.kind != "h2"
        if limited:
            options |= {"initial_box": task.initial, "input_limit": limit}
            options["state_box"] = box if np.isfinite(box).any() else None
        rates = pole_rates(model) if limit is None else crossing_rates(model, box, limit)
        duration = 1 / (rate or (rates[-1] if rates else 1.0))
        return cls(wish, wish.plant(model, task.region), relaxation, options, limited, duration)

    def asked(self, below: float | None, size: float) -> Design:
        """Return gains with a norm below a number, or the least; else the last attempt.

        ``size`` : of the disturbance for which limits hold, in its ranges.
        """
        from takagi.lmi import h2_pdc, hinf_pdc, peak_pdc

        function: Any = {"hinf": hinf_pdc, "h2": h2_pdc, "peak": peak_pdc}[self.wish.kind]
        sizes: dict[Norm, dict[str, float]] = {
            "hinf": {"disturbance_energy": (size * self.wish.size) ** 2 * self.duration},
            "peak": {"disturbance_peak": size * self.wish.size},
        }
        options = dict(self.options)
        if self.limited:
            options |= sizes[self.wish.kind]
        design: Design = function(
            self.plant, relaxation=self.relaxation, norm_below=below, **options
        )
        return design


def norm_gains(task: GainTask, wish: NormWish, plain: Design) -> FoundGains:
    """Return gains with the norm that is asked for, or near the least one.

    Where the LMIs do not reach the norm that is asked for, the gains are those with the least norm
    that was found; the claim, which is about the loop, may still be proved.

    Parameters
    ----------
    plain : gains with all wishes but the norm, which is then reduced from theirs where the least
        is not found, or where its LMIs lack the limits of inputs.
    """
    if not plain.found:
        return FoundGains(plain)
    question = NormQuestion.of(task, wish, plain.relaxation)
    below, size = wish.below, 1.0
    limits, notes = task.input_limit, tuple[str, ...]()
    # Without limits in the LMIs, gains have to keep those of the inputs from the initial box.
    reduced = limits is not None and not question.limited
    if limits is not None and reduced:
        keeps = partial(held_from, task.model, task.initial, limits)
        design, note = _reduced(question, plain, keeps)
    else:
        design, size = _least(question)
        notes = (_size_note(question, size),) if question.limited and design.found else ()
        note = f"the least norm of the LMIs with all wishes is {_gain(design):.4g}"
        if not design.found and not question.limited:
            design, note = _reduced(question, plain, lambda gains: True)
    if design.found and (below is not None or not reduced):
        above = ABOVE[task.settings.effort] * _gain(design)
        target = INSIDE * below if below is not None else above
        asked = question.asked(target, size)
        design = asked if asked.found else design
        if below is None and asked.found:
            note += f"; designed for {target:.4g}, where the gains are smaller"
        elif below is not None and asked.found:
            note = ""
        elif below is not None:
            note += f", above norm_below = {below:g}: these gains have about that; allow more, or "
            note += "relax another wish"
    words = filter(None, (*notes, note))
    return FoundGains(design, tuple(in_file_rates(n, task.plant) for n in words))


def _reduced(
    question: NormQuestion, plain: Design, keeps_limits: Callable[[Floats], bool]
) -> tuple[Design, str]:
    """Return the gains with the least norm, from that of plain gains on, for which limits hold."""
    norm = _norm_of(question, np.asarray(plain.gains))
    best, factor, step = replace(plain, answer=replace(plain.answer, gain=norm)), 1.0, 1 / REDUCED
    for _ in range(MOST_REDUCED):
        design = question.asked(factor * step * norm, 1.0)
        if design.found and keeps_limits(np.asarray(design.gains)):
            best, factor = design, factor * step
        else:
            step = float(np.sqrt(step))
        if step > NEARLY:
            break
    words = f"a norm of {_gain(best):.4g} was reached from that of gains without regard to it"
    return best, f"{words}, {norm:.4g}"


def _norm_of(question: NormQuestion, gains: Floats) -> float:
    """Return the norm that one quadratic function shows of the loop with gains (r, m, n)."""
    from takagi.lmi import h2_norm, hinf_norm, peak_gain

    plant = question.plant
    first, second = np.triu_indices(len(plant.A))
    pairs = list(zip(first.tolist(), second.tolist(), strict=True))
    A = [_mean(plant.A, plant.B, gains, i, j) for i, j in pairs]
    C = [_mean(plant.C, plant.D12, gains, i, j) for i, j in pairs]
    E, D = ((stack[first] + stack[second]) / 2 for stack in (plant.E, plant.D11))
    functions: dict[Norm, Any] = {"hinf": hinf_norm, "h2": h2_norm, "peak": peak_gain}
    function = functions[question.wish.kind]
    answer = function(np.array(A), E, np.array(C), D, sample_time=plant.sample_time)
    return np.inf if answer.gain is None else float(answer.gain)


def _mean(X: Floats, Y: Floats, K: Floats, i: int, j: int) -> Floats:
    return np.asarray((X[i] - Y[i] @ K[j] + X[j] - Y[j] @ K[i]) / 2)


def _least(question: NormQuestion) -> tuple[Design, float]:
    """Return the gains with the least norm, and the size of the disturbance in its ranges.

    A larger disturbance in the LMIs loosens the bound, until the limits leave no room for it.
    """
    size = 1.0
    best = question.asked(None, size)
    if not question.limited:
        return best, size
    step = GROWTH if best.found else 1 / GROWTH
    for _ in range(MOST_SIZES):
        other = question.asked(None, step * size)
        if best.found and not _gain(other) < BETTER * _gain(best):
            break
        best, size = other, step * size
    return best, size


def _gain(design: Design) -> float:
    return np.inf if design.answer.gain is None else float(design.answer.gain)


def _size_note(question: NormQuestion, size: float) -> str:
    lasting = f" during {question.duration:.3g} s" if question.wish.kind == "hinf" else ""
    return (
        f"the limits were posed for starts in the initial box and disturbances of {size:.3g} times "
        f"the range (without a range, the unit){lasting}"
    )
