"""Messages about models and matrices, completed for the user of a plant file.

The lower layers do not know the plant file.  Their messages are completed here: the meaning of
``delta_h``, the point at which an equation has no value, and the entry of the file to change.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.plant import in_file_units, range_in_file_units, rate_in_file_units

if TYPE_CHECKING:
    import sympy as sp

    from takagi.certificates.checker.kernel.result import Checked
    from takagi.lmi.answer import Answer
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.plant import Plant, Variable
    from takagi.models.ts.model import TSModel

# Number of points from rest to each end of a range, and of bisections between the last two.
POINTS, HALVINGS = 64, 40
_SINGULAR = ("has a pole at", "no finite bound near", "seems to have a pole", "beyond all floats")
_ROW = re.compile(r"\brow (\d+)\b(?=:)")
_STUCK = "can be moved by no input"
# Largest number of pairs of rules that are tried, and the singular value that counts as zero.
MOST_PAIRS, _RANK = 4000, 1e-6
_RATE = re.compile(r"(?<![\w.])(-?\d[\d.]*(?:e[-+]?\d+)?) 1/s")


@contextmanager
def in_plant_words(plant: Plant) -> Iterator[None]:
    """Add to the message of a ``ModelError`` which entry of the plant's file to change."""
    try:
        yield
    except ModelError as error:
        raise ModelError(completed(str(error), plant)) from error


def completed(words: str, plant: Plant) -> str:
    """Return the message with the meaning of its names, and the entry of the file to change."""
    words = _ROW.sub(lambda found: _row(int(found.group(1)), found.group(0), plant), words)
    # The notation of powers in a plant file.
    words = words.replace("**", "^")
    added = []
    if any(phrase in words for phrase in _SINGULAR):
        added.append(_singular(words, plant))
    if _STUCK in words:
        added.append(
            "In the plant's file: let an input stand in an equation that moves what grows there, "
            "or leave out states that no input can hold"
        )
    added += _deviations(words, plant)
    return ". ".join([words, *added])


def in_file_rates(words: str, plant: Plant) -> str:
    """Return the text with rates in the unit of time of the plant's file."""

    def shown(match: re.Match[str]) -> str:
        value = float(match.group(1))
        if value <= 0:
            return match.group(0)
        number, unit = rate_in_file_units(plant, value)
        return match.group(0) if unit == "1/s" else f"{number:.4g} {unit}"

    return _RATE.sub(shown, words)


def require_sensible(plant: Plant, model: TSModel, settings: PlantSettings) -> None:
    """Refuse a plant for which there can be no gains, in the words of its file.

    Raises
    ------
    ModelError : an input that no equation has; a state that rests at the end of its range; starts
        that are not inside a range.
    """
    symbols = {symbol for row in plant.equations for symbol in row.free_symbols}
    if plant.mass is not None:
        symbols |= plant.mass.free_symbols
    for variable in plant.inputs:
        if variable.symbol not in symbols:
            raise ModelError(
                f"input {variable.name} stands in no equation, so it does nothing; write it into "
                "the equation that it acts in, or remove it from [inputs]"
            )
    for variable, label in zip(plant.states, model.states, strict=True):
        if label not in model.box:
            continue
        low, high = model.box[label]
        room = float(min(-low, high))
        if room <= 0:
            raise ModelError(
                f"state {variable.name} rests at {_shown(variable, float(variable.rest))}, the "
                f"end of its range {range_in_file_units(variable, 6)}; a set about rest needs room "
                "to either side: widen the range, or move the rest"
            )
        start = settings.initial.get(variable.name)
        if start is not None and start >= room:
            raise ModelError(
                f"initial of {variable.name}: {_shown(variable, start)} was given, and the range "
                f"{range_in_file_units(variable, 6)} ends {_shown(variable, room)} from rest; the "
                "set of starts must lie inside the range: give a smaller initial, or a wider range"
            )


def stuck_blend(model: TSModel) -> str:
    """Return values of the premises at which an unstable mode is not controllable; empty if none.

    Tested in floating point are blends of two rules that differ in one premise: the blend with the
    least effect of the inputs, and the middle.  The memberships, products of weights, can take
    these values.  The mode of an unstable eigenvalue s is not controllable if [A - s I, B] does not
    have full rank.
    """
    A, B = (np.asarray(stack, dtype=np.float64) for stack in (model.A, model.B))
    r = len(A)
    if r * r > MOST_PAIRS or not B.size or not model.premises:
        return ""
    rules, discrete = np.asarray(model.rules), model.sample_time is not None
    for i, j in zip(*np.triu_indices(r, 1), strict=True):
        if np.count_nonzero(rules[i] != rules[j]) != 1:
            continue
        d = B[j] - B[i]
        minimiser = -float((B[i] * d).sum()) / float((d * d).sum()) if np.any(d) else 0.5
        for t in (minimiser, 0.5):
            if 0 < t < 1 and _is_stuck(
                (1 - t) * A[i] + t * A[j], (1 - t) * B[i] + t * B[j], discrete=discrete
            ):
                return _premises_at(model, rules[i], rules[j], t)
    return ""


def _is_stuck(A: Floats, B: Floats, *, discrete: bool) -> bool:
    size = max(float(np.abs(A).max()), float(np.abs(B).max()), 1e-12)
    for mode in np.linalg.eigvals(A):
        slow = abs(mode) >= 1 - 1e-9 if discrete else mode.real >= -1e-9 * size
        if slow:
            reach = np.hstack([A - mode * np.eye(len(A)), B])
            if np.linalg.svd(reach, compute_uv=False)[-1] < _RANK * size:
                return True
    return False


def _premises_at(model: TSModel, first: Floats, second: Floats, t: float) -> str:
    sentences = []
    for premise, corner, other_corner in zip(model.premises, first, second, strict=True):
        ends = (float(premise.lower), float(premise.upper))
        value = (1 - t) * ends[int(corner)] + t * ends[int(other_corner)]
        text = "" if premise.proof is None else f" = {premise.proof.expression}".replace("**", "^")
        unit = "" if premise.unit in ("-", "SI") else f" {premise.unit}"
        sentences.append(f"{premise.name}{text} is about {value + 0.0:.3g}{unit}")
    return " and ".join(sentences)


def _row(number: int, written: str, plant: Plant) -> str:
    rows = plant.states
    return f"equation of {rows[number - 1].name}" if 0 < number <= len(rows) else written


def _singular(words: str, plant: Plant) -> str:
    """Return where an equation has no value, and which variable's range to change."""
    for variable in (*plant.states, *plant.inputs):
        for end in _ends(variable):
            state_and_value = _first_without_value(plant, variable, end)
            if state_and_value is None:
                continue
            state, value = state_and_value
            return (
                f"The equation of {state} has no value where {variable.name} is "
                f"{in_file_units(variable, value)} or beyond, all else at rest: a root or "
                "logarithm of a negative number, a division by 0, or a number too large. Let the "
                f"range of {variable.name} end before"
            )
    named = [v.name for v in plant.variables if v.range is not None and _named(v.name, words)]
    if not named:
        return "Give the states and inputs ranges on which the equations have a value everywhere"
    return (
        f"In the plant's file: give {' and '.join(named)} a range on which the equations have a "
        "finite value everywhere"
    )


def _first_without_value(plant: Plant, variable: Variable, end: float) -> tuple[str, float] | None:
    """Return a state and the first value, from rest to an end, without a value of its equation."""
    import sympy as sp

    from takagi.models.ranges.float_value import float_function

    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    values |= {
        v.symbol: sp.Rational(*v.rest.as_integer_ratio())
        for v in plant.variables
        if v.symbol != variable.symbol
    }
    equilibrium = float(variable.rest)
    for state, row in zip(plant.states, plant.equations, strict=True):
        function_of_variable = sp.sympify(row).subs(values)
        if function_of_variable.has(sp.zoo, sp.nan, sp.oo):
            continue  # no value at rest: another message says so
        function = float_function([variable.symbol], function_of_variable)
        defined = equilibrium
        if not _has_value(function, defined):
            continue
        for share in np.linspace(0.0, 1.0, POINTS + 1)[1:]:
            undefined = equilibrium + float(share) * (end - equilibrium)
            if _has_value(function, undefined):
                defined = undefined
                continue
            for _ in range(HALVINGS):
                middle = (defined + undefined) / 2
                if _has_value(function, middle):
                    defined = middle
                else:
                    undefined = middle
            # Bisection ends close to the border, which is mostly 0.
            width = max(abs(end_) for end_ in _ends(variable)) or 1.0
            return state.name, 0.0 if abs(undefined) < 1e-9 * width else undefined
    return None


def _has_value(function: sp.Lambda, value: float) -> bool:
    with np.errstate(all="ignore"):
        try:
            result = complex(function(value))
        except (ArithmeticError, ValueError, TypeError):
            return False
    return bool(np.isfinite(result)) and not result.imag


def _deviations(words: str, plant: Plant) -> Iterator[str]:
    """Yield the meaning of names such as ``delta_h`` in a message."""
    meanings = []
    for variable in plant.variables:
        name = f"delta_{variable.name}"
        if _named(name, words):
            meanings.append(
                f"{name} is the deviation of {variable.name} from its rest, "
                f"{_shown(variable, float(variable.rest))}"
            )
    if meanings:
        yield f"Here {'; '.join(meanings)}"


def _named(name: str, words: str) -> bool:
    return re.search(rf"(?<![A-Za-z0-9_]){re.escape(name)}(?![A-Za-z0-9_])", words) is not None


def _ends(variable: Variable) -> tuple[float, ...]:
    side = variable.range
    return () if side is None else (float(side.lower), float(side.upper))


def _shown(variable: Variable, value: float) -> str:
    return in_file_units(variable, value, 6)


def advice_of(checked: Checked) -> tuple[str, ...]:
    """Return what to write where the checker cannot prove that the model is the plant; () else."""
    for claim in checked.claims:
        if claim.verdict.name != "UNDECIDED" or not claim.text.startswith("not proved: "):
            continue
        if "has no limit at" in claim.text or "do not give the equation of" in claim.text:
            return (
                "the checker does not know a rule by which the model is the equation: write the "
                "equation without a function inside another, such as sin(a)*cos(b) + "
                "cos(a)*sin(b) for sin(a + b), or make the inner one a state",
            )
        if "its bounds" in claim.text:
            return (
                "the checker needs narrower ranges of the variables that are named there, or that "
                "term as a premise of your own in [premises]",
            )
    return ()


DECAY = "decay"
# How the label of an inequality begins -> the requirement that it expresses.
_WISHES = {
    "disc": "fastest",
    "sector": "damping",
    "gain bound": "gain_bound",
    "initial state": "initial",
    "state box": "range",
    "input effort": "input_limit",
    "input limit": "input_limit",
    "input saturation limit": "input_limit",
    "command limit": "input_limit",
}


def obstacle(answer: Answer, plant: Plant, model: TSModel, settings: PlantSettings) -> str:
    """Return the sentence; empty where the answer does not say which inequalities stop it."""
    from takagi.lmi.decision.outcome import binding_shares

    if answer.found:
        return ""
    stuck = stuck_blend(model)
    if stuck:
        return (
            f"In the model, where {stuck}, no input moves a part of the plant that does not settle "
            "by itself. What to change: give the states and signals in that expression ranges "
            "that leave such values out, or add an input that acts there."
        )
    if answer.status != "infeasible" or answer.condition is None:
        return _undecided(plant, model, settings)
    strict = [lmi.name for lmi in answer.condition.lmis if lmi.strict][1:]
    sizes: dict[str, float] = defaultdict(float)
    for share in binding_shares(answer.condition, answer.multipliers, *strict):
        wishes = (wish for start, wish in _WISHES.items() if share.label.startswith(start))
        sizes[next(wishes, DECAY)] += share.share
    if not sizes:
        return ""
    if not settings.decay_rate and settings.gain_bound is not None:
        sizes.setdefault("gain_bound", 0.0)
    # That the loop settles is no wish that could be given up, unless it has a rate.
    wished = {DECAY} if settings.decay_rate else set()
    order = sorted(sizes, key=lambda wish: (wish == DECAY and wish not in wished, -sizes[wish]))
    first, *further = order
    second = f" Next in the way: {_what(further[0], plant, settings)}." if further else ""
    return (
        f"Most in the way is {_what(first, plant, settings)}. "
        f"What to change: {_advice(first, settings)}.{second}"
    )


def turning_effects(plant: Plant, model: TSModel) -> str:
    """Return on which states the effect of an input changes sign over the vertices; "" on none.

    No law can use an input much there: where the sign is the other one, it would do harm.
    """
    turns = (model.B.min(axis=0) < 0) & (model.B.max(axis=0) > 0)
    phrases = []
    for variable, column in zip(plant.inputs, turns.T, strict=False):
        states = [model.states[k].partition(" [")[0] for k in np.flatnonzero(column)]
        phrases += [f"{variable.name} on {', '.join(states)}"] if states else []
    return "; ".join(phrases)


def _undecided(plant: Plant, model: TSModel, settings: PlantSettings) -> str:
    """Return the sentence where the solvers found neither gains nor a reason why there are none."""
    rate = settings.decay_rate
    if isinstance(rate, float | int) and rate > 0:
        number, unit = rate_in_file_units(plant, rate)
        turning = turning_effects(plant, model)
        change = (
            f"narrow the ranges, because the effect of {turning} changes its sign within them; or "
            if turning
            else ""
        )
        return (
            f"No solver found gains with the decay rate of {number:.4g} {unit}, nor a proof that "
            f"there are none. What to change: {change}lower the rate (--decay-rate, or a longer "
            "--settle); if it is right, write the plant in units in which its figures are of like "
            "size."
        )
    return (
        "No solver found gains, nor a proof that there are none. What to change: give the states "
        "that stand in the premises smaller ranges, or write the plant in units in which its "
        "figures are of like size."
    )


def _what(wish: str, plant: Plant, settings: PlantSettings) -> str:
    if wish == DECAY:
        rate = settings.decay_rate
        if isinstance(rate, float | int) and rate > 0:
            number, unit = rate_in_file_units(plant, rate)
            return f"the decay rate of {number:.4g} {unit}, which all rules and their blends need"
        return "that one function has to decay along all rules and their blends"
    if wish == "fastest":
        assert settings.fastest is not None
        number, unit = rate_in_file_units(plant, settings.fastest)
        return f"fastest = {number:.4g} {unit}, the largest size of the poles"
    return {
        "damping": f"damping = {settings.damping or 0:g}, the least damping ratio of the poles",
        "gain_bound": f"gain_bound = {settings.gain_bound or 0:g}, on every gain",
        "initial": "that the set must hold all initial states",
        "range": "that the set must stay in the ranges of the states",
        "input_limit": "that no input may pass its limit",
    }[wish]


def _advice(wish: str, settings: PlantSettings) -> str:
    if wish == DECAY:
        rate = settings.decay_rate
        advice = ["raise gain_bound (--gain-bound)"] if settings.gain_bound is not None else []
        if isinstance(rate, float | int) and rate > 0:
            advice.append("lower the rate (--decay-rate, or a longer --settle)")
        advice.append("give the states that stand in the premises smaller ranges")
        if settings.relaxation is not None:
            advice.append("take richer relaxations (--relaxation auto)")
        return ", or ".join(advice)
    return {
        "fastest": "raise it (--fastest), or leave it out",
        "damping": "lower it (--damping), or leave it out",
        "gain_bound": "raise it (--gain-bound), or leave it out",
        "initial": "take smaller initial states (--initial), or wider ranges of inputs and states",
        "range": "give the states wider ranges, or take smaller initial states (--initial)",
        "input_limit": "give the inputs wider ranges (or --input-limit), or take smaller initial "
        "states (--initial)",
    }[wish]
