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
from dataclasses import dataclass, replace
from math import degrees, pi
from typing import TypeAlias

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
    Mode,
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


@dataclass(frozen=True, slots=True)
class UnstableLoop:
    """The loop grows at some winds.

    Attributes
    ----------
    reason : the wind at which it grows fastest, how fast, what part does it, and what helps.
    by_filter : whether the turbine's default wind filter makes it stable at all these winds.
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

        def tried_now(option: str) -> None:
            tell(f"unstable at {worst:g} m/s; trying {option}")

        tried = _cures(loops, settings, [*bad], which, tried_now)
        ways = [*([change] if change else []), *tried]
        what = f"{part}{' or '.join(ways) or NO_CURE} makes it stable"
    return UnstableLoop(
        sentence(
            WORDS,
            "unstable",
            wind=worst,
            plant=_plant_words(which),
            sample=SAMPLE * 1e3,
            growth=bad[worst],
            winds=wind_ranges([*bad], [*rates]),
            what=what,
        ),
        by_filter,
    )


def _plant_words(which: PlantChoice) -> str:
    if which == NOMINAL:
        return ""
    return f" with inertia {which[0]:g} of nominal and {_WAKE_WORDS[which[1]]}"


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

    def narrower(factor: float) -> tuple[str, Callable[[], EffortSharingLaw]]:
        number = _short(factor * effort.bandwidth)
        changed = replace(settings, effort=replace(effort, bandwidth=number))
        return f"--bandwidth {number:g}", lambda: wind_by_wind_law(turbine, changed)[1]

    def slower(factor: float) -> tuple[str, Callable[[], EffortSharingLaw]]:
        number = _short(factor * settings.wind_filter)
        # The gains do not depend on the filter.
        return f"--wind-filter {number:g}", lambda: _with_filter(loops, number)

    def calmer(factor: float) -> tuple[str, Callable[[], EffortSharingLaw]]:
        number = _short(factor * settings.effectiveness_share)
        changed = replace(settings, effectiveness_share=number)
        option = f"--pitch-effectiveness-share {number:g}"
        return option, lambda: wind_by_wind_law(turbine, changed)[1]

    def helps(option: str, law: Callable[[], EffortSharingLaw]) -> bool:
        tell(option)
        try:
            found = loops.other(law=law())
        except ModelError:
            return False  # no gains with this number
        if unstable(found, bad, which):
            return False
        if max(growths_over_wind(found).values(), default=1.0) > GROWTH:
            return False
        return _unstable_plant(found, settings) is None

    kinds = (
        [narrower(factor) for factor in BANDWIDTHS],
        [slower(factor) for factor in FILTERS],
        [calmer(factor) for factor in SHARES],
    )
    tried = (next((text for text, law in kind if helps(text, law)), None) for kind in kinds)
    return [text for text in tried if text is not None]


def _with_filter(loops: RunningLoops, time: float) -> EffortSharingLaw:
    law = loops.program.law
    assert isinstance(law, EffortSharingLaw)
    return replace(law, wind_filter=time)


def _short(number: float) -> float:
    return float(f"{number:.2g}")


def _culprit(loops: RunningLoops, good: Callable[[RunningLoops], bool]) -> tuple[str, str]:
    """Return the part without which a loop is good, and how to change it; "" for none."""
    plant, turbine = loops.plant, loops.plant.turbine
    for mode in plant_modes(plant):
        if mode.name == "tower":
            without, change = replace(plant, tower=False), "a stiffer tower"
        else:
            without, change = replace(plant, torsion=False), "a stiffer drivetrain"
        if good(loops.other(plant=without)):
            return sentence(WORDS, "mode", mode=_mode_words(mode)), change
    drive = turbine.pitch_drive_frequency
    quicker = replace(turbine, pitch_drive_frequency=QUICKER * drive)
    if good(loops.other(plant=replace(plant, turbine=quicker))):
        words = sentence(WORDS, "drive", drive=drive, hertz=drive / 2 / pi, times=QUICKER)
        return words, "a quicker pitch drive"
    return "", ""


def _mode_words(mode: Mode) -> str:
    return f"the {mode.name} mode, {mode.frequency:.3g} rad/s ({mode.frequency / 2 / pi:.3g} Hz),"


def small_margin_note(loops: RunningLoops) -> str | None:
    """Return what is to be noted of a stable loop whose margins are small; None for none."""
    met: dict[float, tuple[SmallMargin, ...]] = {}
    winds = []
    for wind in fine_winds(loops):
        loop = loop_at(loops, wind)
        if loop is not None:
            winds.append(wind)
            if found := small_margins(loop):
                met[wind] = found
    if not met:
        return None
    worst = min(met, key=lambda wind: min(one.share for one in met[wind]))
    least = min(met[worst], key=lambda one: one.share)
    part, change = _culprit(loops, lambda one: _without_small(one, worst))
    part = part.replace("the loop is stable there: ", "the margin is larger there; ")
    ways = [*([change] if change else []), *_ways(least)]
    return sentence(
        WORDS, "small margins", wind=worst, sample=SAMPLE * 1e3, least=_by_how_much(least),
        winds=wind_ranges([*met], winds), part=part, ways=", ".join(ways),
    )  # fmt: skip


def _without_small(loops: RunningLoops, wind: float) -> bool:
    loop = loop_at(loops, wind)
    return loop is not None and not small_margins(loop)


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
