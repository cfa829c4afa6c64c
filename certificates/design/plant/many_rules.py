"""Gains for a model with many rules, within a budget of time.

A gain for every rule is the default.  Where it is estimated to take longer than the budget, one
gain for all rules is sought: its inequalities are linear in the vertices, so those at the vertices
are all, and the unknowns do not grow with the rules.  It is found for the whole model.  Where there
is none, gains that depend on the premises of most effect alone are sought, with the other premises
in the middle of their ranges.  That model is not the plant; these gains are valid only if the
certificate, which is always about all rules, is proved.

The time is estimated before the search. With g gains the double sum has N inequalities of n (n + 1)
/ 2 numbers each, over n (n + 1) / 2 + g m n unknowns v. A premise that both vertices and gains
depend on triples N, because the pairs (low, high) and (high, low) of its corners are one; with one
gain for all rules it doubles N.

Measured on a plant with 8 premises, 4 states, 3 inputs, 4 to 128 rules (two 2 GHz cores, one
of them in use, Clarabel): one largest ellipsoid takes 0.3 s + 4 ms N + 5 us N n (n + 1) / 2 v; the
process takes 150 MB + 16 bytes N n (n + 1) / 2 v.  The proof takes some 50 ms for each inequality.
On other machines it may differ by a factor of three: the estimate chooses between searches, and
no claim depends on it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.plant.gain_task import ONE_GAIN, FoundGains, GainTask
from takagi.certificates.design.plant.gains import expanded, find_gains
from takagi.certificates.document.plant_embedding import unknown_premises
from takagi.models.arrays import Floats, Indices
from takagi.models.plant.design_settings import NORMS
from takagi.models.ts.model import TSModel

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings

BUDGET = 120.0  # s
# Work that is announced although nothing is changed because of it.
LONG = 20.0  # s
MOST_PREMISES = 3  # premises in the announcement
READABLE = 60  # characters of a premise's expression that are shown whole


@dataclass(frozen=True, slots=True)
class GainChoice:
    """How gains are sought: what is announced before, ``""`` for short work, and the notes.

    Attributes
    ----------
    shortened : whether a gain for every rule would take longer than the budget.
    """

    shortened: bool
    announcement: str = ""
    note: str = ""


def gain_choice(model: TSModel, settings: PlantSettings, budget: float) -> GainChoice:
    """Return how gains are sought within ``budget`` [s], by estimates alone.

    A relaxation that was asked for is kept, however long it takes.
    """
    sizes = (len(model.states), len(model.inputs))
    single = work_of(len(model.A), sizes, settings, one_gain=True)
    if settings.relaxation == ONE_GAIN:
        words = f"one gain for all rules: {single.words}"
        return GainChoice(False, "" if single.seconds < LONG else f"{_head(model)}; {words}")
    estimate = work_of(len(model.A), sizes, settings, one_gain=False, merged=bool(model.premises))
    if estimate.seconds < LONG or len(model.A) == 1:
        return GainChoice(False)
    announcement = f"{_head(model)}; a gain for every rule: {estimate.words}"
    if settings.relaxation is not None or estimate.seconds <= budget:
        return GainChoice(False, f"{announcement}. {_less(model, settings, single)}")
    note = (
        f"one gain for all {len(model.A)} rules: a gain for every rule would take "
        f"{estimate.words}, more than the {budget:g} s of --time"
    )
    choice = f"Chosen: one gain for all rules, {single.words}, because the budget is {budget:g} s"
    announcement += f". {choice} (--time). {_less(model, settings, single)}"
    return GainChoice(True, announcement, note)


def shortened_gains(task: GainTask, choice: GainChoice) -> FoundGains:
    """Return one gain for all rules; what answers that there is none is returned too."""
    gains = find_gains(task.asking(relaxation=ONE_GAIN))
    return replace(gains, notes=(choice.note, *gains.notes), options=None)


def gains_of_few_premises(task: GainTask, budget: float) -> FoundGains | None:
    """Return gains that depend on the premises of most effect, as many as the budget allows.

    None where no two rules are left, or where the smaller model has no gains.
    """
    model = task.model
    sizes = (len(model.states), len(model.inputs))
    order = np.argsort(-effects(model), kind="stable")
    count = len(order) - 1
    while count and work_of(2**count, sizes, task.settings, one_gain=False).seconds > budget / 2:
        count -= 1
    if not count:
        return None
    premises = sorted(int(k) for k in order[:count])
    names = ", ".join(model.premises[k].name for k in premises)
    subject = f"gains that depend on {names} alone, sought with the other premises"
    return _gains_of(premises, task, subject)


def _gains_of(premises: list[int], task: GainTask, subject: str) -> FoundGains | None:
    """Return gains that depend on these premises; None where the smaller model has none."""
    if task.settings.objective in NORMS or task.settings.feedback:
        # The smaller model has no disturbance, nor the premises that say what is measured.
        return None
    smaller, rules = model_of_premises(task.model, premises)
    gains = find_gains(task.with_model(smaller))
    if not gains.design.found:
        return None
    note = f"{subject} in the middle of their ranges and proved with all {len(task.model.A)} rules"
    return replace(gains, design=expanded(gains.design, rules), notes=(note, *gains.notes))


def gains_of_known_premises(task: GainTask) -> FoundGains | None:
    """Return gains that depend on the premises without uncertain parameters.

    They are sought with the other premises in the middle of their ranges.  None where no premise is
    uncertain or known, or where the smaller model has no gains.
    """
    unknown = unknown_premises(task.model)
    known = [k for k, hidden in enumerate(unknown) if not hidden]
    kept = task.plant.blending is not None or task.settings.relaxation is not None
    if not any(unknown) or not known or kept:
        return None
    subject = (
        "gains that depend on the premises without uncertain parameters, sought with the others"
    )
    return _gains_of(known, task, subject)


def model_of_premises(model: TSModel, premises: list[int]) -> tuple[TSModel, Indices]:
    """Return the model with the other premises at mid-range, and each rule's place in it."""
    rules_at: dict[tuple[int, ...], list[int]] = {}
    for rule, corners in enumerate(model.rules):
        rules_at.setdefault(tuple(corners[k] for k in premises), []).append(rule)
    members = [rules_at[corners] for corners in sorted(rules_at)]
    means = [
        np.array([stack[rules].mean(axis=0) for rules in members]) for stack in (model.A, model.B)
    ]
    smaller = TSModel(
        *means,
        states=model.states,
        inputs=model.inputs,
        premises=[model.premises[k] for k in premises],
        rules=sorted(rules_at),
        box=model.box,
        sample_time=model.sample_time,
        name=model.name,
    )
    reduced_rule = np.empty(len(model.A), dtype=np.intp)
    for number, rules in enumerate(members):
        reduced_rule[rules] = number
    return smaller, reduced_rule


def _head(model: TSModel) -> str:
    """Return rules and the premises of most effect, with ranges and units."""
    ranked = np.argsort(-effects(model), kind="stable")[:MOST_PREMISES]
    ranges = [
        f"{p.name}{_formula(model, k)} in [{float(p.lower):.4g}, {float(p.upper):.4g}]"
        + (f" {p.unit}" if p.unit != "-" else "")
        for k, p in ((int(k), model.premises[int(k)]) for k in ranked)
    ]
    widest = f", of most effect {'; '.join(ranges)}" if ranges else ""
    return f"{len(model.A)} rules by {len(model.premises)} premises{widest}"


def _formula(model: TSModel, premise: int) -> str:
    """Return " = " and the premise's expression; of a long one the variables that it depends on."""
    form = None if model.derivation is None else model.derivation.form
    if form is None:
        return ""
    expression = list(form.factored.premises.values())[premise]
    text = str(expression)
    if len(text) <= READABLE:
        return f" = {text}"
    return f", which depends on {', '.join(sorted(map(str, expression.free_symbols)))},"


def _less(model: TSModel, settings: PlantSettings, single: WorkEstimate) -> str:
    """Return what takes less time."""
    if len(model.premises) < 2:
        return f"--relaxation {ONE_GAIN} takes {single.words}."
    weakest = model.premises[int(np.argmin(effects(model)))]
    sizes = (len(model.states), len(model.inputs))
    fewer = work_of(len(model.A) // 2, sizes, settings, one_gain=False)
    return (
        f"What takes less: a plant with one premise less, {fewer.time}; {weakest.name} has the "
        "least effect. A given --decay-rate, which is one problem in the place of several. "
        f"--relaxation {ONE_GAIN}, {single.time}."
    )


# Problems that are solved, by what is asked of the decay rate; one for a rate in numbers.
PROBLEMS: dict[object, int] = {None: 8, "max": 20}
# Measured as above, in seconds: for a problem, for an inequality in it, for an inequality
# times unknowns times entries, and for the proof of an inequality.
PROBLEM_TIME, INEQUALITY_TIME, PRODUCT_TIME, PROOF_TIME = 0.3, 4e-3, 5e-6, 0.05
# In MB: at the start, and for the same product.
START_MEMORY, PRODUCT_MEMORY = 150.0, 16e-6


@dataclass(frozen=True, slots=True)
class WorkEstimate:
    """Size of a search for gains, the time of search and proof [s], and memory [MB]."""

    inequalities: int
    unknowns: int
    seconds: float
    megabytes: float

    @property
    def time(self) -> str:
        """The time to one or two digits, with its unit."""
        for unit, size in (("h", 3600.0), ("min", 60.0)):
            if self.seconds >= 2 * size:
                count = self.seconds / size
                return f"{count:.0f} {unit}" if count >= 10 else f"{count:.2g} {unit}"
        return f"{max(self.seconds, 1.0):.0f} s"

    @property
    def words(self) -> str:
        """Time and memory to one or two digits."""
        size = self.megabytes
        memory = f"{size / 1000:.2g} GB" if size >= 1000 else f"{round(size, -1):.0f} MB"
        return f"about {self.time} and {memory}"


def work_of(
    rules: int,
    sizes: tuple[int, int],
    settings: PlantSettings,
    *,
    one_gain: bool,
    merged: bool = True,
) -> WorkEstimate:
    """Return the estimate.

    Parameters
    ----------
    sizes : states n and inputs m.
    one_gain : for all rules, in the place of a gain for each.
    merged : whether rules are all corners of premises, whose pairs are partly one.
    """
    n, m = sizes
    premises = int(round(np.log2(rules)))
    if one_gain:
        inequalities = rules
    elif merged and 2**premises == rules:
        inequalities = 3**premises
    else:
        inequalities = rules * (rules + 1) // 2
    entries = n * (n + 1) // 2
    unknowns = entries + (1 if one_gain else rules) * m * n
    problems = PROBLEMS.get(settings.decay_rate, 1)
    product = inequalities * entries * unknowns
    seconds = problems * (PROBLEM_TIME + INEQUALITY_TIME * inequalities + PRODUCT_TIME * product)
    seconds += PROOF_TIME * inequalities
    return WorkEstimate(inequalities, unknowns, seconds, START_MEMORY + PRODUCT_MEMORY * product)


def effects(model: TSModel) -> Floats:
    """Return how much each premise moves the vertices, (p,): mean change over the sum of sizes.

    States are in units of their box, inputs in units of theirs, so that the units of the file do
    not matter where there are ranges.
    """
    s, tau = (_half_widths(model, names) for names in (model.states, model.inputs))
    vertices = np.concatenate([model.A * s / s[:, None], model.B * tau / s[:, None]], axis=2)
    rules = np.array(model.rules)
    size = np.abs(vertices).mean(axis=0).max() or 1.0
    sizes = []
    for k in range(len(model.premises)):
        ends = [vertices[rules[:, k] == corner] for corner in (0, 1)]
        change = ends[1].mean(axis=0) - ends[0].mean(axis=0) if len(ends[1]) else np.zeros(1)
        sizes.append(float(np.abs(change).max() / size))
    return np.array(sizes)


def _half_widths(model: TSModel, names: tuple[str, ...]) -> Floats:
    """Return half of each range; of a blend's or a free variable's, 1."""
    ranges = [model.box.get(name) for name in names]
    return np.array([1.0 if ends is None else float(ends[1] - ends[0]) / 2 for ends in ranges])
