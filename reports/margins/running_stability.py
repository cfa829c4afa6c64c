"""Whether the loop that runs is stable, before anything is proved about its law.

A certificate is about a rigid tower and shaft.  A tower so soft that its mode lies inside the
crossover can make the loop that runs unstable with a law that is proved.  So a design looks at the
turbine as its file says, with observer, filters and sampling, at winds 0.2 m/s apart.  Between
them it may grow faster: where the law passes from torque to pitch the growth rises within 0.05 m/s,
and it jumps at the nodes of the law's tables.  So where the loop is close to growing it looks at
these nodes, too, on both sides.  An unstable loop is refused with its wind and with the part that
makes it so: the first one without which the loop is stable there.

A law with a fast wind filter is for a wind that is measured (docs/laws.md): a loop that the
turbine's default filter makes stable is not refused, but noted.

All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

from takagi.certificates.design.turbine.result import speed_filter
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.certificates.design.turbine.wind_by_wind import wind_by_wind_law, wind_observer_design
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.sampled import SampledLaw
from takagi.models.simulation.turbine_plant import SimulatedTurbine, validation_plant
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.derating import derated
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.margins.design_levers import effort_of
from takagi.reports.margins.running_equilibrium import NoEquilibrium
from takagi.reports.margins.running_loop import linearised_loop
from takagi.reports.margins.running_over_wind import plant_modes
from takagi.reports.margins.running_search import FINE, wind_ranges, winds_between

# As ``AskedMargins``: how often the law runs where nothing else is said [s].
SAMPLE = 0.02
# The loop is refused where it grows faster than this [1/s]; less is the noise of differences.
GROWTH = 1e-4
# Where it decays slower than this [1/s], the nodes of the law's tables around are looked at, too.
CLOSE = 0.03
# Factors on a number of the law that are tried as a cure, smallest change first.
BANDWIDTHS = (0.5, 0.25)
FILTERS = (1.7, 2.5)
SHARES = (1.5, 2.0)
NO_CURE = "no smaller bandwidth, slower wind filter or larger pitch effectiveness share tried"


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


def unstable_loop(turbine: Turbine, settings: DesignSettings) -> UnstableLoop | None:
    """Return where the loop of settings that runs is unstable; None where it is stable.

    The gains are those found wind by wind.  A wind at which the loop has no equilibrium is left
    out: there is nothing to linearise at.

    Raises
    ------
    ModelError : no gains at some wind, a wind that the observer cannot estimate, or no wind at
        which the loop has an equilibrium.
    """
    turbine = derated(turbine, settings.torque_setpoint, speed_setpoint=settings.speed_setpoint)
    observer = wind_observer_design(turbine, settings).observer
    law = wind_by_wind_law(turbine, settings)[1]
    plant = replace(validation_plant(turbine), speed_filter=speed_filter(settings))
    growths = _over_wind(plant, law, observer)
    if not growths:
        raise ModelError(
            f"from {turbine.cut_in:g} to {turbine.cut_out:g} m/s the loop that runs (validation "
            "plant, with observer and filters) has an equilibrium near the turbine's trim at no "
            "wind, so its stability is not known; another set-point or wind filter may help"
        )
    bad = {wind: rate for wind, rate in growths.items() if rate > GROWTH}
    if not bad:
        return None
    worst = max(bad, key=bad.__getitem__)
    usual = default_settings(turbine).wind_filter
    slower = replace(law, wind_filter=usual)
    by_filter = settings.wind_filter < usual and not _unstable(plant, slower, observer, [*bad])
    if by_filter:
        what = (
            f"the wind filter of {settings.wind_filter:g} s does it, {usual:g} s does not: this "
            "law needs a wind that is measured, by a lidar say"
        )
    else:
        part, change = _culprit(plant, law, observer, worst)
        tried = _cures(plant, observer, settings, [*bad])
        ways = [*([change] if change else []), *tried]
        what = f"{part}{' or '.join(ways) or NO_CURE} makes it stable"
    return UnstableLoop(
        f"at {worst:g} m/s the loop that runs (validation plant, with observer and filters, "
        f"sampled every {SAMPLE * 1e3:g} ms) is unstable: it grows at {bad[worst]:.3g} 1/s; "
        f"unstable at {wind_ranges([*bad], [*growths])}; {what}",
        by_filter,
    )


def _cures(
    plant: SimulatedTurbine,
    observer: WindObserver,
    settings: DesignSettings,
    bad: Sequence[float],
) -> list[str]:
    """Return options of the command line that make the loop stable at all winds, one a kind."""
    effort = effort_of(settings)

    def narrower(factor: float) -> tuple[str, DesignSettings]:
        number = _short(factor * effort.bandwidth)
        changed = replace(settings, effort=replace(effort, bandwidth=number))
        return f"--bandwidth {number:g}", changed

    def slower(factor: float) -> tuple[str, DesignSettings]:
        number = _short(factor * settings.wind_filter)
        return f"--wind-filter {number:g}", replace(settings, wind_filter=number)

    def calmer(factor: float) -> tuple[str, DesignSettings]:
        number = _short(factor * settings.effectiveness_share)
        changed = replace(settings, effectiveness_share=number)
        return f"--pitch-effectiveness-share {number:g}", changed

    def helps(changed: DesignSettings) -> bool:
        try:
            law = wind_by_wind_law(plant.turbine, changed)[1]
        except ModelError:
            return False  # no gains with this number
        if _unstable(plant, law, observer, bad):
            return False
        return max(_over_wind(plant, law, observer).values(), default=GROWTH) <= GROWTH

    kinds = (
        [narrower(factor) for factor in BANDWIDTHS],
        [slower(factor) for factor in FILTERS],
        [calmer(factor) for factor in SHARES],
    )
    found = (next((text for text, one in kind if helps(one)), None) for kind in kinds)
    return [text for text in found if text is not None]


def _short(number: float) -> float:
    return float(f"{number:.2g}")


def _culprit(
    plant: SimulatedTurbine, law: EffortSharingLaw, observer: WindObserver, wind: float
) -> tuple[str, str]:
    """Return the mode without which the loop is stable, and how to change it; "" for none."""
    for mode in plant_modes(plant):
        if mode.name == "tower":
            without, change = replace(plant, tower=False), "a stiffer tower"
        else:
            without, change = replace(plant, torsion=False), "a stiffer drivetrain"
        if not _unstable(without, law, observer, [wind]):
            hertz = mode.frequency / 2 / pi
            return (
                f"the {mode.name} mode, {mode.frequency:.3g} rad/s ({hertz:.3g} Hz), lies inside "
                "the crossover, since without it the loop is stable there: ",
                change,
            )
    return "", ""


def _unstable(
    plant: SimulatedTurbine, law: EffortSharingLaw, observer: WindObserver, winds: Sequence[float]
) -> bool:
    return any(rate > GROWTH for rate in _growths(plant, law, observer, winds).values())


def _over_wind(
    plant: SimulatedTurbine, law: EffortSharingLaw, observer: WindObserver
) -> dict[float, float]:
    """Return wind -> growth from cut-in to cut-out, with the law's nodes where it is close to 0."""
    low, high = plant.turbine.cut_in, plant.turbine.cut_out
    found = _growths(plant, law, observer, winds_between(low, high, FINE))
    close = [wind for wind, rate in found.items() if rate > -CLOSE]
    nodes = [float(node) for node in law.schedule.wind if low <= node <= high]
    near = [node for node in nodes if any(abs(node - wind) < FINE for wind in close)]
    return found | _growths(plant, law, observer, near)


def _growths(
    plant: SimulatedTurbine, law: EffortSharingLaw, observer: WindObserver, winds: Sequence[float]
) -> dict[float, float]:
    """Return wind -> largest real part of the loop's poles [1/s], where it has an equilibrium.

    At a node of the law's tables it is the larger one of both sides.
    """
    program, found = SampledLaw(law, SAMPLE, 0.0), dict[float, float]()
    low, high = plant.turbine.cut_in, plant.turbine.cut_out
    nodes = {float(node) for node in law.schedule.wind if low < node < high}
    for wind in winds:
        sides = (1, -1) if wind in nodes else (-1,) if wind >= high else (1,)
        try:
            loops = [linearised_loop(plant, program, observer, wind, side=side) for side in sides]
        except NoEquilibrium:
            continue
        found[wind] = max(float(loop.poles.real.max()) for loop in loops)
    return found


def require_stable(turbine: Turbine, settings: DesignSettings) -> tuple[str, ...]:
    """Refuse settings whose loop that runs is unstable; return what is to be noted.

    Raises
    ------
    ModelError : names wind, growth, the part that does it, and what helps.
    """
    found = unstable_loop(turbine, settings)
    if found is None:
        return ()
    if found.by_filter:
        return (found.reason,)
    raise ModelError(found.reason)
