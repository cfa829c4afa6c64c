"""The options of a simulation: those that turbines and plants share, and a plant's scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from takagi.cli.options.plant_options import time_asked
from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from takagi.models.plant.entries import PlantEntry, VariableEntry
    from takagi.models.plant_simulation.signals import Noise, Signal
    from takagi.reports.simulation.plant_scenario import PlantScenario

_SHAPES = '"load=step 0.2 at 1s"'


def plant_scenario(
    entry: PlantEntry, options: Mapping[str, Any], *, duration: float | None
) -> PlantScenario:
    """Return the scenario that was asked for on the command line.

    Raises ModelError: a name, kind, unit or time that makes no sense for the plant; names the
        option.
    """
    from takagi.models.plant_simulation.signals import Noise
    from takagi.reports.simulation.plant_scenario import PlantScenario

    seed = options["seed"] or 0
    if seed < 0:
        raise ModelError(f"option --seed: {seed} was given; 0 or more is needed")
    step = None
    if options["sample_time"] is not None:
        step = time_asked("--sample-time", options["sample_time"])
        if not step > 0:
            raise ModelError(
                f"option --sample-time: {options['sample_time']!r} was given; a time above 0 is "
                "needed, such as 10ms"
            )
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
