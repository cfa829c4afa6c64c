"""The options of a plant's design, in place of entries of ``[design]``, and of its simulation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from takagi.cli.options.given import Options, declared, option_of
from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.plant.entries import PlantEntry, VariableEntry
    from takagi.models.plant_files.loader import PlantFile
    from takagi.models.plant_simulation.signals import Noise, Signal
    from takagi.reports.simulation.plant_words import PlantScenario

_PAIR = re.compile(
    r"\s*([A-Za-z][A-Za-z0-9_]*)\s*=\s*([-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*(.*)"
)


# Of the loop and of the model.
PLANT_OPTIONS: Options = declared(
    "plant-speed", "plant-limits", "objective", "plant-norm", "plant-law"
)
# Of a design and its certificate; a simulation has its own --sample-time and --noise.
PLANT_DESIGN_OPTIONS: Options = (*PLANT_OPTIONS, *declared("plant-claims"))


def plant_settings(source: PlantFile, given: Mapping[str, Any]) -> PlantSettings:
    """Return the settings of the plant's file, replaced where the command line has an option.

    Raises
    ------
    ModelError : an option that makes no sense for the plant; names the option.
    """
    from takagi.models.plant.design_settings import NORMS, settling_rate
    from takagi.models.plant_files.sections import names_of, static_feedback

    settings, entry = source.settings, source.entry
    direct = "relaxation gain_bound damping fastest choice effort objective norm_below safe_start"
    changes: dict[str, Any] = {
        name: given[name] for name in direct.split() if given.get(name) is not None
    }
    if changes.get("objective") not in (None, *NORMS):
        # What the file says about a norm belongs to the objective that is replaced.
        changes = {"performance": (), "disturbances": (), "norm_below": None} | changes
    if given.get("controller") is not None:
        match = re.fullmatch(r"static|order=([1-9][0-9]?)", given["controller"])
        if match is None:
            raise ModelError(
                f"option --controller: {given['controller']!r} was given; static is needed, or "
                "order=2 for a controller with two states, or leave it out for an observer"
            )
        changes |= {"feedback": static_feedback(entry), "order": int(match.group(1) or 0)}
    for name in ("performance", "disturbances"):
        if given.get(name):
            typed = [part.strip() for text in given[name] for part in text.split(",")]
            changes[name] = tuple(part for part in typed if part)
    if given.get("solve_rest"):
        changes["rest"] = "solve inputs"
    for name in ("sample_time", "horizon"):
        if given.get(name) is not None:
            changes[name] = time_asked(option_of(name), given[name])
    if given.get("decay_rate") is not None:
        changes["decay_rate"] = _rate(given["decay_rate"])
    if given.get("settle") is not None:
        if "decay_rate" in changes:
            raise ModelError(
                "options --settle and --decay-rate both say how fast the loop is; leave one out"
            )
        settled = time_asked("--settle", given["settle"], positive=True)
        changes["decay_rate"] = settling_rate(settled)
    for name, variables in (
        ("input_limit", entry.commanded),
        ("initial", entry.all_states),
        ("noise", entry.disturbances),
    ):
        if given.get(name):
            changes[name] = values_in_si(option_of(name), given[name], variables)
    try:
        changed = replace(settings, **changes)
        changed.require_names(**names_of(entry))
    except ModelError as error:
        # Every message begins with the field's name.
        field = str(error).split()[0]
        prefix = f"option {option_of(field)}: " if field in changes else ""
        raise ModelError(f"{prefix}{error}") from error
    return changed


def values_in_si(
    option: str, written: Sequence[str], variables: Mapping[str, VariableEntry]
) -> dict[str, float]:
    """Return name -> value in SI of texts such as ``angle=10deg``, several joined by commas.

    A value without a unit is in the unit that the plant's file gives the variable.

    Raises
    ------
    ModelError : a text of another form, a name that is not one of the variables, or a unit that
        does not fit; names the option.
    """
    from takagi.models.files.units import parse_unit

    values: dict[str, float] = {}
    for pair in (pair for text in written for pair in text.split(",")):
        match = _PAIR.fullmatch(pair)
        if match is None:
            raise ModelError(
                f"option {option}: {pair!r} was given; NAME=VALUE is needed, such as angle=0.2 or "
                "angle=10deg"
            )
        name, value, unit = match.groups()
        if name not in variables:
            raise ModelError(
                f"option {option}: there is no {name}{did_you_mean(name, variables)}; the plant "
                f"has {', '.join(variables) or 'none'}"
            )
        file_unit = parse_unit(variables[name].unit)
        try:
            typed_unit = parse_unit(unit) if unit.strip() else file_unit
        except ModelError as error:
            raise ModelError(f"option {option} {pair}: {error}") from error
        if typed_unit.dimension != file_unit.dimension:
            raise ModelError(
                f"option {option} {pair}: {name} is in {file_unit.text}, which {unit.strip()!r} "
                "does not fit"
            )
        values[name] = float(typed_unit.to_si(Fraction(value)))
    return values


def _rate(written: str) -> float | str:
    if written == "max":
        return written
    try:
        return float(written)
    except ValueError as error:
        raise ModelError(
            f'option --decay-rate: {written!r} was given; a number in 1/s or "max" is needed'
        ) from error


def time_asked(option: str, written: str, *, positive: bool = False, bare: str = "s") -> float:
    """Return a time in s of a text such as 10ms.

    Parameters
    ----------
    positive : whether 0 and less are refused.
    bare : the unit of a number alone; "" refuses one.

    Raises
    ------
    ModelError : a text of another form, or a unit that is none of time; names the option.
    """
    from takagi.models.files.units import parse_unit

    match = _PAIR.fullmatch(f"time={written}")
    unit = match.group(3).strip() or bare if match else ""
    if match is None or not unit:
        with_unit = "a number with a unit is needed, such as 60s or 5min"
        needed = "a time such as 10ms is needed" if bare else with_unit
        raise ModelError(f"option {option}: {written!r} was given; {needed}")
    try:
        typed_unit = parse_unit(unit)
        if typed_unit.dimension != parse_unit("s").dimension:
            raise ModelError(f"{unit!r} is no unit of time; 60s and 10ms have one")
        seconds = float(typed_unit.to_si(Fraction(match.group(2))))
    except (ModelError, OverflowError) as error:
        raise ModelError(f"option {option} {written}: {error}") from error
    if positive and not seconds > 0:
        raise ModelError(f"option {option}: {written!r} was given; a time above 0 is needed")
    return seconds


_SHAPES = '"load=step 0.2 at 1s"'


def plant_scenario(
    entry: PlantEntry, options: Mapping[str, Any], *, duration: float | None
) -> PlantScenario:
    """Return the scenario that was asked for on the command line.

    Raises
    ------
    ModelError : a name, kind, unit or time that makes no sense for the plant; names the option.
    """
    from takagi.models.plant_simulation.signals import Noise
    from takagi.reports.simulation.plant_words import PlantScenario

    seed = options["seed"] or 0
    if seed < 0:
        raise ModelError(f"option --seed: {seed} was given; 0 or more is needed")
    step = None
    if options["sample_time"] is not None:
        step = time_asked("--sample-time", options["sample_time"], positive=True)
        if duration is not None and step > duration:
            raise ModelError(
                f"option --sample-time: {step:g} s is longer than the run of {duration:g} s; give "
                "a shorter one, or a longer --duration"
            )
    outer = {**entry.disturbances, **entry.scheduling}
    moved = [
        _signal("--disturbance", text, outer, (seed, k), "disturbance", duration)
        for k, text in enumerate(options["disturbance"] or [])
    ]
    texts = [part for text in options["noise"] or [] for part in text.split(",")]
    measured: list[tuple[str, Noise]] = []
    for k, text in enumerate(texts, len(moved)):
        name, sign, size = text.partition("=")
        # The kind of signal is known here, but writing it is allowed.
        plain = size.strip().removeprefix("white ").removeprefix("noise ")
        signal_text = f"{name}{sign}{'noise ' * bool(plain)}{plain}"
        name, signal = _signal(
            "--noise", signal_text, entry.all_states, (seed, k), "state", duration
        )
        assert isinstance(signal, Noise)
        if step is not None and signal.every and signal.every < step:
            # The program reads one value per sample and would not see the others.
            signal = replace(signal, every=step)
        measured.append((name, signal))
    return PlantScenario(tuple(moved), tuple(measured), step)


def _signal(
    option: str,
    text: str,
    variables: Mapping[str, VariableEntry],
    seed: tuple[int, ...],
    what: str,
    duration: float | None,
) -> tuple[str, Signal]:
    from takagi.models.files.units import parse_unit
    from takagi.models.plant_simulation.signals import parse_signal

    name, found, written = (part.strip() for part in text.partition("="))
    if not found or not written:
        example = _SHAPES if what == "disturbance" else '"angle=0.5 deg"'
        raise ModelError(f"option {option} {text.strip()!r}: NAME=... is needed, such as {example}")
    if name not in variables:
        listed = ", ".join(variables) or "none"
        raise ModelError(
            f"option {option} {text.strip()!r}: there is no {what} {name}"
            f"{did_you_mean(name, variables)}; the plant has {listed}"
        )
    place = f"option {option} {name}:"
    signal = parse_signal(
        written, parse_unit(variables[name].unit), place=place, seed=seed, every=lambda: 0.0
    )
    start = getattr(signal, "start", 0.0)
    if duration is not None and start >= duration:
        raise ModelError(
            f"{place} {written!r} begins at {start:g} s, but the run ends at {duration:g} s; "
            f"let it begin earlier, or give a --duration beyond {start:g}"
        )
    return name, signal
