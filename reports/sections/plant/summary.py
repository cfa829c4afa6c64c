"""What a plant's design is worth, as figures, and what each claim takes for granted.

The figures are made once from the claims that are proved.
Terminal and JSON show the same rows.  A figure from a linear loop in floating point says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.plant.plain_words import turning_effects
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.plant.plant import file_unit, rate_in_file_units, time_in_file_units
from takagi.reports.loops.plant_claims import (
    SETTLED,
    norm_settling_time,
    overshoots,
    proved_jumps,
    settling_time,
    withstood,
)
from takagi.reports.loops.plant_local import PlantLocalLoop, Regulator, regulator, rest_loops
from takagi.reports.loops.plant_loop import (
    PlantLoop,
    largest_commands,
    plant_loop,
    proved_claims,
    proved_kinds,
)
from takagi.reports.page.text import (
    at_least,
    at_most,
    behind,
    name_of,
    per_unit,
    significant,
    unit_of,
)

# A deviation above this share of a variable's range counts as all of it.
ALL_OF_RANGE = 0.995
# sqrt(x' P x) of the proved decay: what falls to 2 % where no set is proved.
NORM = "the norm of the proof"
# Below this share the proved set is called little.
LITTLE = 0.1


@dataclass(frozen=True, slots=True)
class Number:
    """One number of a row, as a machine reads it.

    Attributes
    ----------
    quantity : the variable or the measure, e.g. ``"theta"`` or ``"settling time"``.
    value, unit : in the units of the plant's file.
    share : of what the file states, 0 to 1; None where it states nothing.
    """

    quantity: str
    value: float
    unit: str
    share: float | None = None


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One line of the answer.

    Attributes
    ----------
    name : the heading, e.g. ``"safe start"``.
    parts : its figures in words; each stays on one line.
    numbers : the same figures for machines.
    basis : of figures that are not proved, what they rest on; "" for figures that follow from
        proved claims.
    regulator : the same of a linear-quadratic regulator, "" where there is none.
    partial : whether less than the range that the file states is proved.
    shortfall : what is less there, or worse.
    claim, assumes : name and assumptions of the claim that the figures follow from.
    """

    name: str
    parts: tuple[str, ...]
    numbers: tuple[Number, ...] = ()
    regulator: str = ""
    basis: str = ""
    partial: bool = False
    shortfall: str = "less than stated"
    claim: str = ""
    assumes: tuple[str, ...] = ()

    @property
    def proved(self) -> bool:
        return not self.basis

    @property
    def text(self) -> str:
        """The figures in one line."""
        return ", ".join(self.parts).replace("+, ", "+ ")


def starts_alone(design: PlantDesign) -> dict[str, float]:
    """Return state -> sqrt(c / P_kk) in SI; {} where no set {x'Px <= c} is proved invariant.

    It is the largest deviation of this state in the set while all other states are at rest.
    """
    loop = plant_loop(design)
    return {
        label: number.value * _unit_of_state(loop, k)[0]
        for k, (label, number) in enumerate(zip(loop.model.states, _starts(loop), strict=False))
    }


def summary_rows(design: PlantDesign) -> list[SummaryRow]:
    """Return the rows on a design, those without content left out."""
    loop = plant_loop(design)
    beside = regulator(design)
    rows = [
        _settles(design, loop, beside),
        _scheduled(design, loop),
        _safe_start(loop, beside),
        _polynomial_set(design, loop),
        _in_samples(design, loop),
        _overshoot(design, loop),
        _follows(design),
        _norm(design, loop),
        _disturbance(design),
        _input(design, loop),
        _margins(loop, beside),
        *gain_spans(loop),
        _observer(design),
        _not_covered(design, loop),
    ]
    return [_resting(design, loop, row) for row in rows if row is not None and row.parts]


# Row -> kinds of claims, of which the first that is proved gives its figures.
_RESTS_ON = {
    "settles": ("decay", "observed-loop"),
    "safe start": ("input-limits", "invariant-ellipsoid", "observed-loop"),
    "polynomial": ("attraction-region",),
    "in samples": ("sampled-loop",),
    "follows": ("tracking",),
    "input": ("input-limits", "observed-loop"),
}


def _resting(design: PlantDesign, loop: PlantLoop, row: SummaryRow) -> SummaryRow:
    """Return the row with the claim that it follows from, and the assumptions of that claim."""
    for kind in _RESTS_ON.get(row.name, ()) if row.proved else ():
        for claim in proved_claims(design.document, design.checked, kind):
            assumes = tuple(assumptions(loop, claim))
            return replace(row, claim=str(claim["name"]), assumes=assumes)
    return row


def answer_sentence(design: PlantDesign) -> str:
    """Return in one sentence what is proved; for another verdict which claim is not."""
    claims = design.checked.claims
    missing = [claim for claim in claims if claim.verdict is not Verdict.PROVED]
    if missing or not claims:
        proved = f"{len(claims) - len(missing)} of {len(claims)} claims are proved"
        verdict = missing[0].verdict.name if missing else ""
        return f"{proved}; {verdict}: {missing[0].name}." if missing else "There is no claim."
    loop = plant_loop(design)
    where = "" if design.is_about_plant else "Of the Takagi-Sugeno model: "
    words = f"{where}{_subject(loop)} to {_outcome(loop)}"
    sizes = _input(design, loop) if loop.level_proved else None
    if sizes is not None and sizes.parts and sizes.proved:
        words += f", with {' and '.join(sizes.parts)}"
    sampled = _in_samples(design, loop)
    if sampled is not None:
        words += f"; run in samples, starts up to {_with_degrees(sampled.numbers[0])}"
    jumps = _follows(design)
    if jumps is not None and jumps.numbers:
        steps = [
            f"{name} steps up to {at_least(size)}{behind(unit)}"
            for name, size, unit in ((n.quantity, n.value, n.unit) for n in jumps.numbers)
        ]
        words += f"; {', '.join(dict.fromkeys(steps))} are followed without error"
    return f"{words}."


def _subject(loop: PlantLoop) -> str:
    """Return which motions the sentence is about; of several states the first is named."""
    for number in _starts(loop)[:1]:
        alone = ", the other states at rest," if len(loop.names) > 1 else ""
        return f"Starts up to {_with_degrees(number)} in {number.quantity}{alone} are proved"
    return f"All motions{' that stay in the ranges' if loop.model.box else ''} are proved"


def _outcome(loop: PlantLoop) -> str:
    phrase = "come to rest" + (", undisturbed" if _disturbed(loop) else "")
    time = settling_time(loop)
    if time is not None:
        value, unit = time_in_file_units(loop.plant, time)
        return f"{phrase}, to {100 * SETTLED:g} % within {at_most(value)} {unit}"
    if loop.decay_rate:
        value, unit = time_in_file_units(loop.plant, norm_settling_time(loop.decay_rate))
        return f"{phrase}, to {100 * SETTLED:g} % within {at_most(value)} {unit} (in {NORM})"
    return "stay in the safe set" if loop.level_proved else "keep what the claims below state"


def _with_degrees(number: Number) -> str:
    """Return a lower bound, radians also in degrees."""
    beside = f" ({at_least(float(np.degrees(number.value)))} deg)" if number.unit == "rad" else ""
    return f"{at_least(number.value)}{behind(number.unit)}{beside}"


def set_starts(loop: PlantLoop, P: ArrayLike, level: object) -> tuple[Number, ...]:
    """Return how far each state alone may start in {x'Px <= level}, and its share of the range.

    A controller starts at rest: its states are left out.
    """
    numbers = []
    diagonal = np.diag(np.asarray(P, dtype=np.float64))
    count = len(diagonal) - len(loop.plant.integrators)
    for k, (label, entry) in enumerate(zip(loop.model.states[:count], diagonal, strict=False)):
        size, unit = _unit_of_state(loop, k)
        reach = float(np.sqrt(float(Fraction(str(level))) / entry))
        ends = loop.model.box.get(label)
        share = None if ends is None else reach / max(abs(float(end)) for end in ends)
        numbers.append(Number(name_of(label), reach / size, unit, share))
    return tuple(numbers)


def start_words(number: Number, *, shared: bool = False) -> str:
    """Return e.g. ``angle 0.684 rad (46 %)``, the share only where it is asked for."""
    words = f"{number.quantity} {at_least(number.value)}{behind(number.unit)}"
    if number.share is None or not shared:
        return words
    return f"{words} ({'all' if number.share >= ALL_OF_RANGE else f'{100 * number.share:.2g} %'})"


def _start_parts(numbers: Sequence[Number]) -> list[str]:
    """Return the starts in words; of several states, that these hold for one state at a time."""
    alone = ["one at a time"] if len(numbers) > 1 else []
    return [start_words(number, shared=True) for number in numbers] + alone


def _starts(loop: PlantLoop) -> tuple[Number, ...]:
    return set_starts(loop, *loop.start_ellipsoid) if loop.bounded and loop.level_proved else ()


def _settles(design: PlantDesign, loop: PlantLoop, beside: Regulator | None) -> SummaryRow | None:
    """Return the time to 2 % and the decay rate of the proved function.

    A time that was asked is about the norm: where a state takes longer, this is said.
    """
    phrases, numbers = [], []
    if loop.decay_rate:
        time = settling_time(loop)
        value, unit = time_in_file_units(loop.plant, time or norm_settling_time(loop.decay_rate))
        norm = "" if time else f" in {NORM}"
        quantity = "settling time" if time else "settling time of the norm"
        condition = " without disturbance" if _disturbed(loop) else ""
        phrases.append(f"{at_most(value)} {unit} to {100 * SETTLED:g} %{norm}{condition}")
        numbers.append(Number(quantity, value, unit))
        rate = design.settings.decay_rate
        asked = norm_settling_time(rate) if isinstance(rate, float) and rate > 0 else None
        if time and asked and norm_settling_time(loop.decay_rate) <= asked < time:
            value, unit = time_in_file_units(loop.plant, asked)
            phrases.append(f"in {NORM} within the {value:.3g} {unit} that were asked")
        value, unit = rate_in_file_units(loop.plant, loop.decay_rate)
        phrases.append(f"decay rate >= {at_least(value)} {unit}")
        numbers.append(Number("decay rate", value, unit))
    times = (
        []
        if beside is None
        else [
            beside.settling(of_design=of_design, step=loop.model.sample_time)
            for of_design in (False, True)
        ]
    )
    words = ""
    if phrases and all(time is not None for time in times) and times:
        first, second = (time_in_file_units(loop.plant, float(time or 0)) for time in times)
        words = f"linear {second[0]:.3g} {second[1]}, LQR {first[0]:.3g} {first[1]}"
    return SummaryRow("settles", tuple(phrases), tuple(numbers), words)


def _safe_start(loop: PlantLoop, beside: Regulator | None) -> SummaryRow | None:
    """Return how far each state alone may start in the proved set, as a share of its range."""
    numbers = _starts(loop)
    phrases = _start_parts(numbers)
    words = ""
    if beside is not None and beside.starts is not None:
        sizes = (_unit_of_state(loop, k)[0] for k in range(len(numbers)))
        regulator_starts = zip(beside.starts, sizes, strict=False)
        starts = ", ".join(at_least(float(start) / size) for start, size in regulator_starts)
        words = f"LQR, proved too: {starts}"
    elif phrases and beside is not None and beside.sought:
        words = "LQR: none proved"
    shares = [number.share for number in numbers if number.share is not None]
    little = bool(shares) and max(shares) < LITTLE
    if little:
        phrases.append("little of the ranges: try narrower ranges, a lower rate, larger inputs")
    return SummaryRow("safe start", tuple(phrases), numbers, words, partial=little)


def _polynomial_set(design: PlantDesign, loop: PlantLoop) -> SummaryRow | None:
    """Return how far each state alone may start in the set of a polynomial."""
    if loop.region is None:
        return None
    numbers = []
    for k, label in enumerate(loop.model.states):
        size, unit = _unit_of_state(loop, k)
        ends, reach = loop.model.box.get(label), loop.region.starts[k]
        share = None if ends is None else reach / max(abs(float(end)) for end in ends)
        numbers.append(Number(name_of(label), reach / size, unit, share))
    first, *others = _start_parts(numbers)
    return SummaryRow("polynomial", (f"safe start {first}", *others), tuple(numbers))


def _in_samples(design: PlantDesign, loop: PlantLoop) -> SummaryRow | None:
    """Return the safe starts of a law that runs in samples, which has a set of its own."""
    for claim in proved_claims(design.document, design.checked, "sampled-loop"):
        numbers = set_starts(loop, claim["P"], claim["level"])
        starts = _start_parts(numbers)
        step = f"every {float(claim['sample_time']):g} s, safe start {starts[0]}"
        return SummaryRow("in samples", (step, *starts[1:]), numbers)
    return None


def _overshoot(design: PlantDesign, loop: PlantLoop) -> SummaryRow | None:
    factors = overshoots(design, loop)
    phrases = [f"{name} at most {at_most(k)}" for name, k in factors.items()]
    if phrases:
        phrases[-1] += " times the initial deviation"
    return SummaryRow(
        "overshoot", tuple(phrases), tuple(Number(name, k, "") for name, k in factors.items())
    )


def _follows(design: PlantDesign) -> SummaryRow | None:
    """Return which steps of a reference are followed, of the range that the file states."""
    phrases, numbers = [], []
    signals = {v.name: v for v in design.plant.disturbances}
    jumps = proved_jumps(design)
    for reference in design.plant.references if jumps else ():
        variable = signals[reference.name]
        size, unit = file_unit(variable)
        assert variable.range is not None  # a reference has one
        rest = float(variable.rest)
        steps = [abs(jump[reference.name] - rest) for jump in jumps if reference.name in jump]
        widest = max(abs(float(end) - rest) for end in (variable.range.lower, variable.range.upper))
        reach, share = max(steps), max(steps) / widest
        words = f"{reference.name} steps up to {at_least(reach / size)}{behind(unit)}"
        words += ", all of its range" if share >= ALL_OF_RANGE else f" (of {widest / size:.6g})"
        phrases.append(f"{words}, no final error in {reference.follows}")
        numbers.append(Number(reference.name, reach / size, unit, min(share, 1.0)))
    partial = any(number.share is not None and number.share < ALL_OF_RANGE for number in numbers)
    return SummaryRow("follows", tuple(phrases), tuple(numbers), partial=partial)


def _scheduled(design: PlantDesign, loop: PlantLoop) -> SummaryRow | None:
    """Return the decay that is proved by a function of the weights, and what it assumes."""
    for claim in proved_claims(design.document, design.checked, "fuzzy-decay"):
        number, unit = rate_in_file_units(loop.plant, float(Fraction(str(claim["decay_rate"]))))
        motions = f"all motions{' that stay in the ranges' if loop.model.box else ''}"
        phrases = [f"{motions}, by V = x'P(h)x, decay rate >= {at_least(number)} {unit}"]
        rated = any(claim.get("rates") or ())
        if rated:
            phrases.append("while the weights keep to the rates of the claim")
        row = SummaryRow(
            "decays",
            tuple(phrases),
            (Number("decay rate", number, unit),),
            partial=rated,
            shortfall="these rates are assumed, not proved",
        )
        return replace(row, claim=str(claim["name"]), assumes=tuple(assumptions(loop, claim)))
    return None


# Kind -> member of the norm, of claims about an output of their own: those that were asked for.
_NORMS = {"l2-gain": "gain", "h2-norm": "norm", "peak": "gain"}


def _norm(design: PlantDesign, loop: PlantLoop) -> SummaryRow | None:
    """Return the proved norm from disturbances to performance that was asked for."""
    phrases, numbers, below = [], [], design.settings.norm_below
    claim_name, assumes = "", tuple[str, ...]()
    for kind, member in _NORMS.items():
        for claim in proved_claims(design.document, design.checked, kind):
            if "output" not in claim:
                continue
            claim_name, unit = str(claim["name"]), unit_of(str(claim["name"]))
            assumes = tuple(assumptions(loop, claim))
            value = float(Fraction(str(claim[member])))
            phrases.append(f"{name_of(claim_name)} <= {at_most(value)}{behind(unit)}")
            if "entering" in claim:
                phrases.append("the other disturbances at rest")
            if kind == "peak":
                phrases.append(
                    f"for |w| <= {at_least(float(Fraction(str(claim['disturbance_norm']))))}"
                )
            numbers.append(Number(name_of(claim_name), value, unit))
    missed = below is not None and all(number.value > below for number in numbers)
    if missed and numbers:
        phrases.append(f"not the {below:g} that was asked for")
    return SummaryRow(
        "norm",
        tuple(phrases),
        tuple(numbers),
        partial=missed,
        shortfall="more than asked for",
        claim=claim_name,
        assumes=assumes,
    )


def _disturbance(design: PlantDesign) -> SummaryRow | None:
    """Return the disturbances under which a proved set is never left, and their shares."""
    if {claim["kind"] for claim in design.document["claims"]} == {"tracking"}:
        # Where references alone are claimed, no set against moving disturbances was asked for.
        return None
    followed = {name for jump in proved_jumps(design) for name in jump}
    phrases, numbers = [], []
    for row in withstood(design) if design.gains is not None else ():
        if row.variable.name in followed:
            continue
        size, unit = file_unit(row.variable)
        stated = f"{row.stated / size:.6g}{behind(unit)}"
        name = row.variable.name
        if not row.proved:
            phrases.append(f"{name}: nothing proved of the stated {stated}")
        elif row.share < 1:
            reach = f"{at_least(row.proved / size)}{behind(unit)}"
            label = f"{name} that varies," if followed else name
            phrases.append(f"{label} up to {reach}: {100 * row.share:.2g} % of the stated {stated}")
        else:
            phrases.append(f"{name} up to {stated}, all of its range")
        if followed and row.share < 1:
            phrases.append(f"{name} held constant: all of its range")
        numbers.append(Number(name, row.proved / size, unit, row.share))
    partial = any(number.share is not None and number.share < 1 for number in numbers)
    shortfall = f"less than stated{' where it varies' if followed else ''}: state less, or narrow"
    shortfall += " the ranges that premises depend on"
    if design.plant.measured is not None:
        shortfall = (
            "less than stated: of a law with an observer nothing is claimed under disturbance"
        )
    return SummaryRow(
        "disturbance", tuple(phrases), tuple(numbers), partial=partial, shortfall=shortfall
    )


def _input(design: PlantDesign, loop: PlantLoop) -> SummaryRow | None:
    """Return the proved bounds of the inputs; else the largest commands in floating point."""
    proved = proved_limits(design)
    commands = largest_commands(loop)
    if proved:
        commands = list(zip(loop.model.inputs, proved, strict=True))
    phrases, numbers = [], []
    count = len(loop.plant.inputs) - len(loop.plant.integrators)
    for variable, (label, bound) in zip(loop.plant.inputs[:count], commands, strict=False):
        size, unit = file_unit(variable)
        phrases.append(f"|{name_of(label)}| <= {at_most(bound / size)}{behind(unit)}")
        numbers.append(Number(name_of(label), bound / size, unit))
    basis = "" if proved else "floating point, not proved"
    idle = _hardly_used(loop)
    shortfall = f"the law uses {', '.join(idle)}" if idle else ""
    if idle and (turning := turning_effects(loop.plant, loop.model)):
        shortfall += f": the effect of {turning} changes its sign within the ranges, narrow them"
    return SummaryRow(
        "input",
        tuple(phrases),
        tuple(numbers),
        basis=basis,
        partial=bool(idle),
        shortfall=shortfall,
    )


def _hardly_used(loop: PlantLoop) -> list[str]:
    """Return the inputs of which the law uses less than a tenth, with the share in words."""
    phrases = []
    commands = dict(largest_commands(loop))
    for variable, label in zip(loop.plant.inputs, loop.model.inputs, strict=False):
        ends = loop.model.box.get(label)
        if ends is None or label not in commands:
            continue
        share = commands[label] / min(abs(float(end)) for end in ends)
        if share < LITTLE:
            phrases.append(f"{100 * share:.2g} % of {variable.name}")
    return phrases


def proved_limits(design: PlantDesign) -> list[float]:
    """Return the proved bound of |u - u*| of each input in SI; [] where none is proved."""
    for kind in ("input-limits", "observed-loop"):
        for claim in proved_claims(design.document, design.checked, kind):
            if limits := claim.get("input_limits"):
                return [float(Fraction(str(limit))) for limit in limits]
    return []


LINEAR = "linear at rest, not proved"


def _margins(loop: PlantLoop, beside: Regulator | None) -> SummaryRow | None:
    """Return the least margins of the linear loops at rest."""
    numbers = least_margins(rest_loops(loop))
    if numbers is None:
        return None
    if not numbers:
        return SummaryRow("margins", ("the linear loop at rest is not stable",), basis=LINEAR)
    words = ""
    if beside is not None:
        regulator_margins = least_margins(rest_loops(loop, beside.gain))
        words = f"LQR {', '.join(_margin_words(margin) for margin in regulator_margins or ())}"
    phrases = tuple(_margin_words(number) for number in numbers)
    return SummaryRow("margins", phrases, numbers, words, LINEAR)


def least_margins(loops: Sequence[PlantLocalLoop]) -> tuple[Number, ...] | None:
    """Return the least finite phase, disk and delay margin of loops.

    None without a loop, () where one is unstable.
    """
    margins = [local_loop.margins for local_loop in loops]
    if not margins or not all(m.stable for m in margins):
        return () if margins else None
    numbers = (
        Number("phase", min(float(np.degrees(m.phase)) for m in margins), "deg"),
        Number("disk", min(float(m.disk.alpha) for m in margins), ""),
        Number("delay", min(float(m.delay) for m in margins), "s"),
    )
    return tuple(number for number in numbers if np.isfinite(number.value))


def _margin_words(number: Number) -> str:
    return f"{number.quantity} {significant(number.value, 2)}{behind(number.unit)}"


def gain_spans(loop: PlantLoop) -> list[SummaryRow]:
    """Return a row for each input: least and largest value of each gain over the rules, in SI.

    Of a law with a controller the states that it does not measure are left out.
    """
    if loop.gains is None:
        return []
    low, high = loop.gains.min(axis=0), loop.gains.max(axis=0)
    rows = []
    for k, label in enumerate(loop.model.inputs):
        terms = []
        for j, state in enumerate(loop.model.states):
            if loop.plant.integrators and not loop.gains[:, :, j].any():
                continue
            unit = per_unit(unit_of(label) or "-", unit_of(state) or "-")
            value = f"{low[k, j]:.4g}"
            if low[k, j] != high[k, j]:
                value += f"..{high[k, j]:.4g}"
            terms.append(f"{value}{behind(unit)} {name_of(state)}")
        sum_of_gains = tuple(f"{term} +" for term in terms[:-1]) + (f"{terms[-1]})",)
        head = f"{label} = -({sum_of_gains[0]}"
        rows.append(SummaryRow("gains", (head, *sum_of_gains[1:]), basis="in gains.json"))
    return rows


def _observer(design: PlantDesign) -> SummaryRow | None:
    law = design.output_law
    if design.plant.integrators:
        names = ", ".join(state for state, _ in design.plant.integrators)
        measured = f"of {', '.join(design.settings.feedback)}"
        phrases = (measured, f"states of its own, which start at rest: {names}")
        return SummaryRow("controller", phrases, basis="in gains.json")
    if law is None:
        return None
    weights = "its weights are the plant's"
    if law.at_estimate:
        weights = "its weights are those at the estimate"
    if design.plant.references:
        weights = "constant matrices"
    outputs = ", ".join(design.plant.outputs[k].name for k in law.rows)
    largest = f"largest gain {np.abs(law.L).max():.4g} in SI, all in gains.json"
    return SummaryRow("observer", (f"of {outputs}", weights, largest), basis="in gains.json")


def _not_covered(design: PlantDesign, loop: PlantLoop) -> SummaryRow:
    """Return what none of the claims speaks of."""
    kinds = proved_kinds(design)
    phrases = []
    if not design.is_about_plant:
        phrases.append("the plant beside its model")
    if not loop.discrete and loop.gains is not None and "sampled-loop" not in kinds:
        phrases.append("sampling (--sample-time)")
    if loop.gains is not None and "exit-probability" not in kinds:
        phrases.append("measurement noise")
    if loop.gains is not None and not proved_limits(design):
        phrases.append("limits of the inputs")
    phrases.append("states outside their ranges")
    return SummaryRow("not covered", tuple(phrases), basis="no claim")


def _unit_of_state(loop: PlantLoop, index: int) -> tuple[float, str]:
    """Return (size, unit) of a state in the file; SI for states that the law adds."""
    if index < len(loop.plant.states):
        return file_unit(loop.plant.states[index])
    return 1.0, unit_of(loop.model.states[index])


def _disturbed(loop: PlantLoop) -> bool:
    return any(not variable.schedules for variable in loop.plant.disturbances)


EMBEDDINGS = ("sector-embedding", "secant-embedding", "slope-embedding", "effort-blend")
SETS = ("invariant-ellipsoid", "input-limits", "sampled-loop", "observed-loop", "exit-probability")
# Kinds that have disturbances of their own.
_DISTURBED = ("l2-gain", "fuzzy-l2-gain", "h2-norm", "peak", "exit-probability", "tracking")


def assumptions(loop: PlantLoop, claim: Mapping[str, Any]) -> list[str]:
    """Return what this claim alone takes for granted."""
    kind = str(claim.get("kind", ""))
    if kind in (*EMBEDDINGS, "bumpless"):
        return ["equations and parameters as in the file", "variables in their ranges"]
    phrases = []
    if kind in SETS or kind == "tracking":
        phrases.append("start in the set")
    elif loop.model.box:
        phrases.append("states stay in their ranges")
    if loop.gains is not None:
        phrases.append("all states known exactly" if loop.observed is None else "exact outputs")
        if kind == "sampled-loop":
            phrases.append("no time for computing")
        elif not loop.discrete:
            phrases.append("no sampling")
    moving = any(not variable.schedules for variable in loop.plant.disturbances)
    if moving and not claim.get("disturbance_bounds") and kind not in _DISTURBED:
        phrases.append("no disturbance")
    if "entering" in claim:
        phrases.append("no other disturbance")
    if kind == "tracking":
        phrases.append("other signals constant, in their ranges")
    if claim.get("membership_rates") or (kind.startswith("fuzzy") and any(claim.get("rates", ()))):
        phrases.append("memberships keep to the stated rates")
    return phrases
