"""Gains of a file for a plant that has changed: the file's own model is kept if possible.

The law u = u* - sum_j g_j K_j (x - x*) has the weights g of the file: its premises with their
bounds.  A changed plant may be derived with other premises.  There are two ways to prove the law:

1.  the model is derived anew with the premises and bounds of the file, so that model and law have
    the same weights: the new equations are the blend of new vertices in the old premises;
2.  if that is impossible (a term needs another premise, or a range exceeds its bounds), the model
    has its own premises and the law its own weights. The proof then holds for any weights of the
    law, because every vertex is combined with every gain.  This is a stronger requirement.

The notes give the reason why the first way is impossible.

In both ways the law rests where the changed plant rests, and its observer has the equations of the
changed plant: a rest that is solved moves with a parameter.  So the law that is proved has the
gains, premises and rules of the file, and the trim of the plant.

Weaker claims for given gains if the plant's whole box is not proved: smaller ranges, lower rate.

The gains are not changed.  All ranges of states are multiplied by one factor about rest.  A decay
that is proved on a box holds on every smaller box, so bisection finds the largest factor.  The
sentence states a factor that was proved, not an estimate.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.reader import Number, digest, read_json
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.claims.certification import certify
from takagi.certificates.controller.content import plain
from takagi.certificates.design.design import Tell
from takagi.certificates.design.given.plant_gains import read_gains, read_plant_law
from takagi.certificates.design.plant.tracking_design import range_in_words
from takagi.certificates.document.certificate_file import as_read, content_of, files_sha256
from takagi.certificates.requests.decay import Decay
from takagi.models.arrays import Floats
from takagi.models.equations.equilibrium import balls_of
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import behind
from takagi.models.intervals.interval import Interval
from takagi.models.plant.design_settings import PlantSettings
from takagi.models.plant.plant import Plant, Variable, file_unit, rate_in_file_units

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.ts.model import TSModel

# Members of the law that must agree with the plant, whatever the premises are.
SHARED = ("sample_time", "state_names", "input_names")
REST_MOVED = (
    "the rest has moved: the gains are proved about the rest of this plant, which is not that of "
    "their file; --gains-out FILE writes the law that is proved"
)


@dataclass(frozen=True, slots=True, eq=False)
class GivenLaw:
    """The model for the proof, the gains, and the law if it has its own weights.

    Attributes
    ----------
    gains : (r, m, n) if the law has the model's weights; (s, m, n) if it has its own.
    law : as the file states it; None if it has the weights of the model.
    notes : texts on the way that was used, and why the other was impossible.
    """

    model: TSModel
    gains: Floats
    law: Mapping[str, Any] | None
    notes: tuple[str, ...]


def law_for(
    plant: Plant, model: TSModel, path: Path, settings: PlantSettings, *, files: Sequence[Path] = ()
) -> GivenLaw:
    """Return the model and law with which the gains of a file are proved on a plant.

    Parameters
    ----------
    model : of the plant, derived without the gain file.
    files : the data files of the plant.  A gain file that was written for them needs the model
        that was derived then; if its law differs, it is refused.

    Raises
    ------
    CertificateError : the file is unreadable, has no law of a plant, or one for other states,
        inputs or sample time.
    """
    try:
        return GivenLaw(model, read_gains(path, model), None, ("gains were given",))
    except CertificateError as error:
        error_without_change = error
    if is_of(model, path, files):
        raise error_without_change
    try:
        # Nothing but the rest has moved.
        K = read_gains(path, model, any_trim=True)
        return GivenLaw(model, K, None, ("gains were given", REST_MOVED))
    except CertificateError as error:
        error_without_change = error
    law = plain(read_plant_law(path))
    try:
        model_of_file = model_in_premises_of(plant, law, settings)
        K = read_gains(path, model_of_file, any_trim=True)
    except (ModelError, CertificateError) as reason:
        return _own_weights(model, law, path, error_without_change, str(reason))
    notes = ("gains were given", "the premises of their file were kept")
    return GivenLaw(model_of_file, K, None, (*notes, *moved_rest(law, model_of_file)))


def model_in_premises_of(plant: Plant, law: Mapping[str, Any], settings: PlantSettings) -> TSModel:
    """Return the model in the premises of the law, with the law's bounds."""
    from takagi.models.sector.model import sector_model

    if plant.blending is not None:
        raise ModelError("premises of a plant behind a blend are not kept")
    premises, stated = _premises(plant, law), law.get("premises", [])
    bounds = {
        symbol: (_number(p["lower"]), _number(p["upper"]))
        for symbol, p in zip(premises, stated, strict=True)
    }
    return sector_model(
        replace(plant, premises={}),
        rest=settings.rest,
        choice=settings.choice,
        premises=premises,
        bounds=bounds,
        # Numbers may hide a unit that the expression had when it was derived.
        units={s: p["unit"] for s, p in zip(premises, stated, strict=True) if "unit" in p},
    )


def _premises(plant: Plant, law: Mapping[str, Any]) -> dict[sp.Symbol, sp.Expr]:
    """Return the law's premises in the plant's own variables."""
    import sympy as sp

    from takagi.certificates.checker.plant.expression import NAME
    from takagi.models.expressions.parser import Scope, parse_expression

    variables = {v.name: v for v in plant.variables}
    symbols = {name: v.symbol for name, v in variables.items()}
    deviations = {
        f"delta_{name}": sp.Symbol(f"delta_{name}", real=True)
        for name, v in variables.items()
        if v.rest != 0 and f"delta_{name}" not in variables
    }
    balls = balls_of(plant)
    symbols |= {ball.symbol.name: ball.symbol for ball in balls.values()}
    back = {}
    for name, symbol in deviations.items():
        variable = variables[name.removeprefix("delta_")]
        ball = balls.get(variable.symbol)
        at_rest = sp.Rational(*variable.rest.as_integer_ratio()) if ball is None else ball.symbol
        back[symbol] = variable.symbol - at_rest
    premises = {}
    for premise in law.get("premises", []):
        name, text = premise.get("name"), premise.get("expression")
        if not isinstance(text, str) or not isinstance(name, str) or not NAME.fullmatch(name):
            raise ModelError(f"premise {name!a} has no expression that could be kept")
        expression = parse_expression(text, Scope({**symbols, **deviations}))
        premises[sp.Symbol(name, real=True)] = expression.xreplace(back)
    if not premises:
        raise ModelError("the law has no premises to keep")
    return premises


def _number(value: float | int | str) -> str:
    return value if isinstance(value, str) else repr(value)


def _own_weights(
    model: TSModel, law: Mapping[str, Any], path: Path, first_error: CertificateError, reason: str
) -> GivenLaw:
    """Return the law with its own weights; it may differ from the model in its weights only."""
    from takagi.certificates.document.model_data import pdc_law_data
    from takagi.certificates.document.plant_embedding import law_members, plant_and_claim

    r, n, m = model.B.shape
    K = np.array(law["K"], dtype=np.float64)
    data = plant_and_claim(model)[0]
    if data is None or "blending" in law:
        raise first_error
    law_of_model = plain(pdc_law_data(model, np.zeros((m, n))) | law_members(data))
    differing = next((key for key in SHARED if law.get(key) != law_of_model.get(key)), None)
    mismatches = misfits(law, law_of_model)
    if mismatches:
        raise CertificateError(
            f"{path}: law.{differing or SHARED[0]} is not the model's, so the law cannot be run on "
            f"this plant: {'; '.join(mismatches)}"
        )
    if differing is not None:
        raise first_error
    rest_note = moved_rest(law, model)
    law = {**law, "trim": law_of_model["trim"]} if rest_note else law
    if K.ndim != 3 or K.shape[1:] != (m, n):
        raise first_error
    notes = (
        "gains were given",
        f"the premises of {path} are not kept: {reason}",
        "so the law has weights of its own: every vertex is taken with every gain",
        *rest_note,
    )
    return GivenLaw(model, K, law, notes)


def moved_rest(law: Mapping[str, Any], model: TSModel) -> tuple[str, ...]:
    """Return a note where a law rests elsewhere than the plant of a model; () otherwise."""
    from takagi.certificates.document.plant_embedding import law_members, plant_and_claim

    data = plant_and_claim(model)[0]
    trim = {} if data is None else plain(law_members(data)).get("trim")
    return () if law.get("trim") == trim else (REST_MOVED,)


def is_of(model: TSModel, path: Path, files: Sequence[Path]) -> bool:
    """Return whether the file was written for this plant, so that its law was changed later."""
    from takagi.certificates.document.plant_embedding import plant_and_claim

    stated: Any = read_json(path)
    for key in ("certificate", "sha256", "model"):
        stated = stated.get(key) if isinstance(stated, Mapping) else None
    data = plant_and_claim(model)[0]
    if data is None:
        return False
    members = [content_of(files)]
    if files:
        # Older gain files have a digest that includes the bytes of the model's files.
        members.append({"files_sha256": files_sha256(files)})
    return any(stated == digest(as_read({**data, **content})) for content in members)


# Numbers in files are short decimals; a relative difference below this counts as none.
_SAME = 1e-12


def misfits(law: Mapping[str, Any], law_of_model: Mapping[str, Any]) -> list[str]:
    """Return why a law cannot be used for a plant: states, inputs, units, sample time, rest.

    ``law``, ``law_of_model`` : the ``law`` of the gain file, and that of the present plant with any
    gains.
    """
    mismatches: list[str] = []
    for key, word in (("state_names", "state"), ("input_names", "input")):
        ours, theirs = (
            [str(label) for label in labels] if isinstance(labels := data.get(key), list) else []
            for data in (law, law_of_model)
        )
        mismatches += _labels(ours, theirs, word)
    old, new = law.get("sample_time"), law_of_model.get("sample_time")
    if not _near(old, new):
        mismatches.append(
            f"the gains are for {_time(old)}, the plant is in {_time(new)}: design gains for it"
        )
    return mismatches


def changes_of_signals(plant: Plant, file: Mapping[str, Any], trim: Mapping[str, Any]) -> list[str]:
    """Return ranges, rests and units in which a plant differs from the one of its gain file.

    ``trim`` is where the plant rests, SI; figures are in the units of the plant's file.
    """
    rests = [*(trim.get("state") or []), *(trim.get("input") or [])]
    variables = [*plant.states, *plant.inputs]
    signals = {v.name: (v, float(str(x))) for v, x in zip(variables, rests, strict=False)}
    signals |= {v.name: (v, float(v.rest)) for v in plant.disturbances}
    changes: list[str] = []
    for key in ("states", "inputs", "signals"):
        listed = file.get(key)
        for entry in listed if isinstance(listed, list) else []:
            if isinstance(entry, Mapping) and str(entry.get("name")) in signals:
                variable, equilibrium = signals[str(entry["name"])]
                changes += _changed(variable, equilibrium, entry)
    return changes


def _labels(old: list[str], new: list[str], word: str) -> Iterator[str]:
    """Yield the states or inputs that differ; labels have the form ``angle [rad]``."""
    there, here = (dict(label.partition(" [")[::2] for label in labels) for labels in (old, new))
    if list(there) != list(here) and set(there) == set(here):
        yield (
            f"the {word}s stand in another order: {', '.join(there)} there, {', '.join(here)} "
            "here; write them in the old order"
        )
    for name in there:
        if name not in here:
            yield (
                f"the gains need the {word} {name}, which the plant does not have"
                f"{did_you_mean(name, here)}: give the {word} its old name, or design gains anew"
            )
        elif there[name] != here[name]:
            yield (
                f"{word} {name} is in {there[name].rstrip(']')} there and in "
                f"{here[name].rstrip(']')} here: its gains mean something else; correct the unit"
            )
    for name in here:
        if name not in there:
            yield (
                f"the plant has the {word} {name}, for which there are no gains: design gains anew"
            )


def _changed(variable: Variable, equilibrium: float, entry: Mapping[str, Any]) -> Iterator[str]:
    size, unit = file_unit(variable)
    text = behind(unit)
    if str(entry.get("unit")) != variable.unit:
        yield (f"{variable.name}: the unit was {entry.get('unit')}, it is {variable.unit} now (SI)")
        return
    old = entry.get("rest")
    if _is_number(old) and not _near(float(str(old)), equilibrium):
        yield (
            f"{variable.name}: rest {float(str(old)) / size:.6g}{text} -> "
            f"{equilibrium / size:.6g}{text}"
        )
    side = variable.range
    ends = None if side is None else [float(side.lower), float(side.upper)]
    old_range, new_range = (_span(stated, size) for stated in (entry.get("range"), ends))
    if old_range != new_range:
        yield f"{variable.name}: range {old_range}{text} -> {new_range}{text}"


def _span(stated: Any, size: float) -> str:
    if not isinstance(stated, list) or len(stated) != 2 or not all(map(_is_number, stated)):
        return "none"
    low, high = (f"{float(str(end)) / size:.6g}" for end in stated)
    return f"[{low}, {high}]"


def _time(step: Any) -> str:
    return "continuous time" if step is None else f"samples of {float(str(step)):g} s"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | Number) and not isinstance(value, bool)


def _near(first: Any, second: Any) -> bool:
    if not (_is_number(first) and _is_number(second)):
        return bool(first == second)
    x, y = float(str(first)), float(str(second))
    return abs(x - y) <= _SAME * max(abs(x), abs(y), 1.0)


# Factors are multiples of this: five proofs find the factor to 3 % of the whole box.
FINEST = Fraction(1, 32)
# With more rules than this each of the proofs may take half a minute.
MOST_RULES = 64


@dataclass(frozen=True, slots=True)
class LargestChange:
    """The largest claims that are proved with unchanged gains.

    Attributes
    ----------
    rate : largest decay rate [1/s] found on the whole box; None if none is proved there.
    share : largest factor on the ranges of the states in which decay is proved; 1 for the whole
        box, 0 if not even ``FINEST`` of it.
    share_rate : decay rate [1/s] that is proved in it.
    """

    rate: float | None
    share: Fraction
    share_rate: float | None


def largest_change(
    plant: Plant,
    path: Path,
    settings: PlantSettings,
    *,
    files: Sequence[Path] = (),
    tell: Tell | None = None,
) -> LargestChange | None:
    """Return the largest claims for the gains of a file; None if they are not searched.

    They are not searched for a plant with [blending] or measured outputs, or without a range of
    any state.

    Raises
    ------
    CertificateError : the gain file is not for this plant.
    """
    ranges = any(v.range is not None for v in plant.states)
    if plant.blending is not None or plant.measured is not None or not ranges:
        return None
    full_rate = _rate(plant, path, settings, files, Fraction(1))
    if full_rate is None:
        return None
    if full_rate > 0:
        return LargestChange(full_rate, Fraction(1), full_rate)
    proved_share, failing_share, best = Fraction(0), Fraction(1), None
    while failing_share - proved_share > FINEST:
        middle = (proved_share + failing_share) / 2
        if tell is not None:
            tell(f"ranges of states times {float(middle):.3g}")
        rate = _rate(plant, path, settings, files, middle)
        if rate:
            proved_share, best = middle, rate
        else:
            failing_share = middle
    return LargestChange(None, proved_share, best)


def as_sentences(change: LargestChange, plant: Plant, settings: PlantSettings) -> list[str]:
    """Return the claims in words, with ranges and rates in the units of the plant's file."""
    required_rate = settings.decay_rate if isinstance(settings.decay_rate, float | int) else None
    if change.rate is not None:
        number, unit = rate_in_file_units(plant, change.rate)
        if required_rate is None or required_rate <= change.rate:
            return [f"with these gains a decay of {number:.4g} {unit} is proved on the whole box"]
        required, its_unit = rate_in_file_units(plant, required_rate)
        return [
            f"the plant's file asks for a decay rate of {required:.4g} {its_unit}; with these "
            f"gains {number:.4g} {unit} is proved on the whole box: ask for less in [design], or "
            "design gains anew"
        ]
    if not change.share or change.share_rate is None:
        return [
            f"not even with {float(FINEST):.2g} of the ranges of the states is a decay proved: "
            "these gains do not hold the new plant near its rest; design gains anew"
        ]
    number, unit = rate_in_file_units(plant, change.share_rate)
    narrower = (drawn_in(v, change.share) for v in plant.states if v.range is not None)
    sides = ", ".join(map(range_in_words, narrower))
    return [
        f"with these gains a decay of {number:.4g} {unit} is proved where the ranges of the states "
        f"are {float(change.share):.3g} times as wide about rest: {sides}. Give the states such "
        "ranges in the plant's file, or design gains anew"
    ]


def _rate(
    plant: Plant, path: Path, settings: PlantSettings, files: Sequence[Path], share: Fraction
) -> float | None:
    """Return the proved decay rate, 0 if none is proved; None if it would take too long."""
    from takagi.models.sector.model import sector_model

    smaller = plant if share == 1 else replace(
        plant, states=tuple(drawn_in(v, share) for v in plant.states)
    )  # fmt: skip
    try:
        model = sector_model(smaller, rest=settings.rest, choice=settings.choice)
        law = law_for(smaller, model, path, settings, files=files if share == 1 else ())
    except (ModelError, CertificateError):
        if share == 1:
            raise
        return 0.0
    if len(law.model.rules) > MOST_RULES:
        return None
    certificate = certify(law.model, law.gains, claims=[Decay()], law=law.law)
    if certificate.verdict is not Verdict.PROVED:
        return 0.0
    (claim,) = (c for c in certificate.document["claims"] if c["kind"] == "decay")
    return float(claim["decay_rate"])


def drawn_in(variable: Variable, share: Fraction) -> Variable:
    """Return the variable with its range times ``share`` about its rest."""
    side = variable.range
    if side is None:
        return variable
    low, high = (variable.rest + share * (end - variable.rest) for end in (side.lower, side.upper))
    return replace(variable, range=Interval(low, high))
