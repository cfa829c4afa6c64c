"""Whether the loop that runs is stable, before anything is proved about its law.

A certificate is about a rigid tower and shaft.  A tower so soft that its mode lies inside the
crossover can make the loop that runs unstable with a law that is proved.  So a design looks at the
turbine as its file says, with observer, filters and sampling, every 0.2 m/s, and where the loop is
close to growing also at the nodes of the law's tables, on both sides: where the law passes from
torque to pitch the growth rises within 0.05 m/s, and it jumps at the nodes.  It looks at the plants
of ``PLANTS`` (inertia and wake, the ends of what a certificate covers) at whole winds and where
pitch begins to act.  An unstable loop is refused with its wind and with the part that makes it so:
the first one without which the loop is stable there.

A stable loop whose margins are below those of ``running_over_wind`` is noted, with wind, mode and
cure.

A law with a fast wind filter is for a wind that is measured (docs/laws.md): a loop that the
turbine's default filter makes stable is not refused, but noted.

All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import degrees, pi
from typing import Any, NamedTuple, TypeAlias

from takagi.certificates.design.turbine.effort_sharing_gains import (
    wind_by_wind_law,
    wind_observer_design,
)
from takagi.certificates.design.turbine.result import speed_filter
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.lmi.turbine.effort import EffortSettings
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import derated
from takagi.reports.margins.running_loop import NOMINAL, SAMPLE, PlantChoice, RunningLoops
from takagi.reports.margins.running_over_wind import (
    GROWTH,
    LEAST_GAIN,
    LEAST_PHASE,
    SmallMargin,
    decisive_winds,
    fine_winds,
    growths,
    growths_over_wind,
    loop_at,
    plant_modes,
    small_margins,
    unstable,
    wind_ranges,
)
from takagi.reports.output import sentence

WORDS = "margins/words.toml"
# Gets a step in words.
Tell: TypeAlias = Callable[[str], None]

# Factors on a number of the law that are tried as a cure, smallest change first.
BANDWIDTHS = (0.5, 0.25)
FILTERS = (1.7, 2.5)
SHARES = (1.5, 2.0)
NO_CURE = "no smaller bandwidth, slower wind filter or larger pitch effectiveness share tried"
# A drive that is this many times as quick, to see whether the file's drive is too slow.
QUICKER = 4.0
# The lags of a file's two pitch drives, larger over smaller, up to which they are one drive.
SAME_DRIVE = 2.0
# The time constant [s] from which the 5-MW loop's own claim is not proved: 1, 2.5 and 3 s were
# tried, the last but one also with less bandwidth, a slower filter, one inertia and no frozen wake.
SLOW_DRIVE = 1.0
_WAKE_WORDS = {
    "dynamic": "a dynamic wake",
    "frozen": "a frozen wake",
    "equilibrium": "a wake in equilibrium",
}


class UnstableLoop(NamedTuple):
    """The loop grows at some winds: where it grows fastest, what part does it, and what helps.

    ``by_filter`` : whether the turbine's default wind filter makes it stable at all these winds.
    """

    reason: str
    by_filter: bool


def loops_of(turbine: Turbine, settings: DesignSettings, tell: Tell) -> RunningLoops:
    """Return the loop of settings that runs, with gains found wind by wind."""
    tell("gains wind by wind")
    turbine = derated(turbine, settings.torque_setpoint, speed_setpoint=settings.speed_setpoint)
    observer = wind_observer_design(turbine, settings).observer
    law = wind_by_wind_law(turbine, settings)[1]
    return RunningLoops.of(turbine, law, observer, speed_filter=speed_filter(settings))


def unstable_loop(loops: RunningLoops, settings: DesignSettings, tell: Tell) -> UnstableLoop | None:
    """Return where the loop that runs is unstable; None where it is stable.

    A wind at which it has no equilibrium is left out: there is nothing to linearise at.

    Raises
    ------
    ModelError : it has an equilibrium at no wind.
    """
    turbine = loops.plant.turbine
    tell(f"{turbine.cut_in:g} to {turbine.cut_out:g} m/s")
    which, rates = NOMINAL, growths_over_wind(loops)
    if not rates:
        raise ModelError(sentence(WORDS, "no rest", low=turbine.cut_in, high=turbine.cut_out))
    bad = {wind: rate for wind, rate in rates.items() if rate > GROWTH}
    if not bad:
        tell("inertia and wake at the ends of what is covered")
        uncertain = _unstable_plant(loops, settings)
        if uncertain is None:
            return None
        which, rates = uncertain
        bad = {wind: rate for wind, rate in rates.items() if rate > GROWTH}
    worst = max(bad, key=bad.__getitem__)
    usual = default_settings(turbine).wind_filter
    slower = loops.other(law=_with_filter(loops, usual))
    by_filter = settings.wind_filter < usual and not unstable(slower, [*bad], which)
    if by_filter:
        what = sentence(WORDS, "filter", filter=settings.wind_filter, usual=usual)
    else:
        tell(f"unstable at {worst:g} m/s; looking for the part that does it")
        part, change = _culprit(loops, lambda one: not unstable(one, [worst], which))
        trying = f"unstable at {worst:g} m/s; trying"
        tried = _cures(loops, settings, [*bad], which, lambda option: tell(f"{trying} {option}"))
        what = f"{part}{' or '.join(filter(None, [change, *tried])) or NO_CURE} makes it stable"
    plant = f" with inertia {which[0]:g} of nominal and {_WAKE_WORDS[which[1]]}"
    reason = sentence(
        WORDS, "unstable", wind=worst, plant="" if which == NOMINAL else plant,
        sample=SAMPLE * 1e3, growth=bad[worst], winds=wind_ranges([*bad], [*rates]), what=what,
    )  # fmt: skip
    return UnstableLoop(reason, by_filter)


def _unstable_plant(
    loops: RunningLoops, settings: DesignSettings
) -> tuple[PlantChoice, dict[float, float]] | None:
    """Return which plant that the certificate covers grows fastest, and wind -> growth [1/s]."""
    covered = settings.uncertainty
    wakes = [wake for wake in _WAKE_WORDS if covered.frozen_wake or wake != "frozen"]
    factors = [float(end) for end in (covered.inertia.lower, covered.inertia.upper)]
    winds = decisive_winds(loops)
    found = {
        (factor, wake): growths(loops, winds, (factor, wake))
        for factor in factors
        for wake in wakes
    }
    worst = max(found, key=lambda plant: max(found[plant].values(), default=0.0))
    return (worst, found[worst]) if max(found[worst].values(), default=0.0) > GROWTH else None


def _cures(
    loops: RunningLoops,
    settings: DesignSettings,
    bad: Sequence[float],
    which: PlantChoice,
    tell: Tell,
) -> list[str]:
    """Return options of the command line that make the loop stable, one a kind."""
    effort, turbine = settings.effort or EffortSettings(), loops.plant.turbine

    def law_of(**changed: Any) -> EffortSharingLaw:
        return wind_by_wind_law(turbine, replace(settings, **changed))[1]

    def helps(option: str, law_at: Callable[[float], EffortSharingLaw], number: float) -> bool:
        tell(option)
        try:
            changed = loops.other(law=law_at(number))
        except ModelError:
            return False  # no gains with this number
        return (
            not unstable(changed, bad, which)
            and max(growths_over_wind(changed).values(), default=1.0) <= GROWTH
            and _unstable_plant(changed, settings) is None
        )

    kinds: tuple[tuple[str, float, Sequence[float], Callable[[float], EffortSharingLaw]], ...] = (
        ("bandwidth", effort.bandwidth, BANDWIDTHS,
         lambda number: law_of(effort=replace(effort, bandwidth=number))),
        # The gains do not depend on the filter.
        ("wind-filter", settings.wind_filter, FILTERS,
         lambda number: _with_filter(loops, number)),
        ("pitch-effectiveness-share", settings.effectiveness_share, SHARES,
         lambda number: law_of(effectiveness_share=number)),
    )  # fmt: skip
    cures = []
    for name, usual, factors, law_at in kinds:
        numbers = (float(f"{factor * usual:.2g}") for factor in factors)
        options = ((f"--{name} {number:g}", number) for number in numbers)
        cures.append(next((text for text, n in options if helps(text, law_at, n)), ""))
    return [option for option in cures if option]


def _with_filter(loops: RunningLoops, time: float) -> EffortSharingLaw:
    law = loops.program.law
    assert isinstance(law, EffortSharingLaw)
    return replace(law, wind_filter=time)


def _culprit(loops: RunningLoops, good: Callable[[RunningLoops], bool]) -> tuple[str, str]:
    """Return the part without which a loop is good, and how to change it; "" for none."""
    plant, turbine = loops.plant, loops.plant.turbine
    for mode in plant_modes(plant):
        without: dict[str, Any] = {mode.name: False}
        if good(loops.other(plant=replace(plant, **without))):
            words = f"the {mode.name} mode, {mode.frequency:.3g} rad/s "
            words += f"({mode.frequency / 2 / pi:.3g} Hz),"
            stiffer = "a stiffer tower" if mode.name == "tower" else "a stiffer drivetrain"
            return sentence(WORDS, "mode", mode=words), stiffer
    drive = turbine.pitch_drive_frequency
    quicker = replace(turbine, pitch_drive_frequency=QUICKER * drive)
    if good(loops.other(plant=replace(plant, turbine=quicker))):
        words = sentence(WORDS, "drive", drive=drive, hertz=drive / 2 / pi, times=QUICKER)
        return words, "a quicker pitch drive"
    return "", ""


def small_margin_note(loops: RunningLoops) -> str | None:
    """Return what is to be noted of a stable loop whose margins are small; None for none."""
    at_winds = ((wind, loop_at(loops, wind)) for wind in fine_winds(loops))
    margins = {wind: small_margins(loop) for wind, loop in at_winds if loop is not None}
    met = {wind: small for wind, small in margins.items() if small}
    if not met:
        return None
    worst = min(met, key=lambda wind: min(margin.share for margin in met[wind]))
    least = min(met[worst], key=lambda margin: margin.share)

    def without_small(changed: RunningLoops) -> bool:
        loop = loop_at(changed, worst)
        return loop is not None and not small_margins(loop)

    part, change = _culprit(loops, without_small)
    part = part.replace("the loop is stable there: ", "the margin is larger there; ")
    return sentence(
        WORDS, "small margins", wind=worst, sample=SAMPLE * 1e3, least=_by_how_much(least),
        winds=wind_ranges([*met], [*margins]), part=part,
        ways=", ".join(filter(None, [change, *_ways(least)])),
    )  # fmt: skip


def _by_how_much(one: SmallMargin) -> str:
    if one.kind == "gain":
        factor = LEAST_GAIN**one.share
        return sentence(
            WORDS, "gain", command=one.command, more=100 * (factor - 1), factor=factor,
            least=LEAST_GAIN,
        )  # fmt: skip
    if one.kind == "phase":
        least = degrees(LEAST_PHASE)
        return sentence(WORDS, "phase", command=one.command, lag=one.share * least, least=least)
    return f"if the commands come one sample later ({SAMPLE * 1e3:g} ms)"


def _ways(least: SmallMargin) -> list[str]:
    """Return options of the command line that make such a margin larger."""
    of_torque = ["a band-stop below the torsion mode (--torsion-filter)", "a faster --speed-filter"]
    return [
        *(of_torque if least.command != "pitch" else []),
        "a smaller --bandwidth",
        "a slower --wind-filter",
    ]


def require_stable(
    turbine: Turbine, settings: DesignSettings, tell: Tell = lambda step: None
) -> tuple[str, ...]:
    """Refuse settings whose loop that runs is unstable; return what is to be noted.

    Noted are a wind filter that needs a wind that is measured, margins below the least ones, a
    turbine whose file describes two different pitch drives, and a drive too slow for the proof.

    Parameters
    ----------
    tell : gets each step in words.

    Raises
    ------
    ModelError : names wind, growth, the part that does it, and what helps.
    """
    loops = loops_of(turbine, settings, tell)
    found = unstable_loop(loops, settings, tell)
    if found is not None and not found.by_filter:
        raise ModelError(found.reason)
    tell("margins")
    margins = small_margin_note(loops) if found is None else found.reason
    told = margins, two_drives_note(turbine), slow_drive_note(turbine)
    return tuple(note for note in told if note is not None)


def slow_drive_note(turbine: Turbine) -> str | None:
    """Return what helps where the pitch drive is too slow for the proof; None where it is not."""
    if turbine.pitch_time_constant < SLOW_DRIVE:
        return None
    return sentence(WORDS, "slow drive", lag=turbine.pitch_time_constant, slow=SLOW_DRIVE)


def two_drives_note(turbine: Turbine) -> str | None:
    """Return what is to be noted where the file's two descriptions of the pitch drive differ.

    The second-order drive lags by 2 zeta / omega at low frequency, the first-order one by its
    time constant.
    """
    first, frequency = turbine.pitch_time_constant, turbine.pitch_drive_frequency
    second = 2 * turbine.pitch_drive_damping / frequency
    if max(first, second) <= SAME_DRIVE * min(first, second):
        return None
    damping = turbine.pitch_drive_damping
    return sentence(
        WORDS, "two drives", first=first, frequency=frequency, damping=damping, second=second,
        other=2 * damping / first,
    )  # fmt: skip
