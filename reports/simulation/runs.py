"""Every law in every wind; a loop that diverges or leaves the data is reported."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.laws.protocol import require_times
from takagi.models.simulation.closed_loop import TIME_STEP, Diverged, History, fitting_step
from takagi.models.simulation.scenario import Metrics, measure
from takagi.models.simulation.turbine_plant import Flag, SimulatedTurbine, validation_plant
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine
from takagi.reports.simulation.compiled_law import SampledLoop, in_threads
from takagi.reports.simulation.laws import ChosenLaws

WAKES = ("equilibrium", "dynamic")
# What a simulation can leave out of the validation plant, beside the wake.
PARTS = ("tower", "flap", "torsion", "torque-lag")
# Fractions above which the table gets a remark [-].
WORTH_TELLING = 0.01
FIGHTING = 5.0
# Mean pitch rate of a loop that oscillates [deg/s]; working through turbulence takes about half.
RESTLESS = 1.0
# A turbine would have been shut down by its safety system long before [% above rated].
RUNAWAY = 20.0
# The shortest and the longest possible sample time [s].
MOST_OFTEN, RAREST = 0.001, 1.0

FLAG_WORDS = {
    Flag.TIP_SPEED_RATIO_CLIPPED: "outside the coefficient table (tip-speed ratio)",
    Flag.PITCH_OUTSIDE_TABLE: "outside the coefficient table (pitch)",
    Flag.PITCH_RATE_LIMITED: "pitch drive at its rate limit",
    Flag.PITCH_POSITION_LIMITED: "pitch reference outside the pitch range",
    Flag.TORQUE_RATE_LIMITED: "torque at its rate limit",
    Flag.TORQUE_LIMITED: "torque command outside its range",
}

Tell = Callable[[str, float], None]


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One law in one wind.

    Attributes
    ----------
    law, wind : their names.
    history : over time; None where the loop diverged, or where only the metrics are kept.
    metrics : None where the loop diverged.
    diverged : when [s]; None where it did not.
    flags : share of samples at which each one stands [-];  first : when that begins [s].
    """

    law: str
    wind: str
    history: History | None = None
    metrics: Metrics | None = None
    diverged: float | None = None
    flags: Mapping[Flag, float] = field(default_factory=dict)
    first: Mapping[Flag, float] = field(default_factory=dict)

    def remarks(self) -> tuple[str, ...]:
        """Return the remarks needed to read the numbers, most important first."""
        if self.metrics is None:
            return (f"diverged: the states grew beyond all numbers before {self.diverged:g} s",)
        found = []
        if self.metrics.overspeed > RUNAWAY:
            found.append("runaway: a turbine's safety system would have stopped it")
        for flag, words in FLAG_WORDS.items():
            share = self.flags[flag]
            if share >= WORTH_TELLING or (share > 0 and "table" in words):
                begins = f" from {self.first[flag]:.1f} s on" if "table" in words else ""
                found.append(f"{words} {_percent(share)} of the time{begins}")
        if self.metrics.pitch_rate >= RESTLESS:
            found.append(f"pitch is restless: {self.metrics.pitch_rate:.1f} deg/s on average")
        if self.metrics.both_active >= FIGHTING:
            found.append(
                f"pitch sheds power while torque is below rated {self.metrics.both_active:.0f} % "
                "of the time"
            )
        return tuple(found)


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """What was simulated, and what came out: laws in their order, winds within.

    ``asked`` has the words of the winds, see ``takagi.reports.simulation.winds``.
    ``sample_time`` [s] is how often the laws run, ``computation_time`` [s] how late they send.
    """

    turbine: Turbine
    asked: tuple[str, ...]
    parts: PlantParts
    winds: tuple[WindSeries, ...]
    chosen: ChosenLaws
    runs: tuple[Run, ...]
    sample_time: float = TIME_STEP
    computation_time: float = 0.0

    @property
    def diverged(self) -> tuple[Run, ...]:
        """The runs that did not reach the end."""
        return tuple(run for run in self.runs if run.diverged is not None)


@dataclass(frozen=True, slots=True)
class PlantParts:
    """What a simulation asks of the validation plant.

    Attributes
    ----------
    wake : one of ``WAKES``: one that needs time, or one in equilibrium.
    without : of ``PARTS``, those that are left out.
    speed_filter : corner of a low-pass on the measured speed, for every law [rad/s]; 0 for none,
        None for each law's own.
    ripple : amplitude of a wind oscillation three times a turn, over the wind [-].

    Raises
    ------
    ModelError : an unknown wake or part.
    """

    wake: str = "dynamic"
    without: tuple[str, ...] = ()
    speed_filter: float | None = None
    ripple: float = 0.0

    def __post_init__(self) -> None:
        for what, names, known in (("wake", (self.wake,), WAKES), ("part", self.without, PARTS)):
            for name in names:
                if name not in known:
                    raise ModelError(
                        f"{what} {name!r} is not known{did_you_mean(name, known)}; choose one of "
                        f"{', '.join(known)}"
                    )


def simulation_plant(turbine: Turbine, parts: PlantParts) -> SimulatedTurbine:
    """Return the validation plant with what is asked of it.

    Raises
    ------
    ModelError : a filter or ripple out of range.
    """
    return validation_plant(
        turbine,
        tower="tower" not in parts.without,
        flap=False if "flap" in parts.without else None,
        torsion=False if "torsion" in parts.without else None,
        torque_lag=0.0 if "torque-lag" in parts.without else None,
        wake=parts.wake == "dynamic",
        speed_filter=parts.speed_filter or None,
        ripple=parts.ripple,
    )


def require_sampling(sample_time: float, computation_time: float) -> None:
    """Refuse times that fit no program, or whose steps are too large to integrate the plant.

    Raises
    ------
    ModelError : says which time, and what fits.
    """
    if not MOST_OFTEN <= sample_time <= RAREST:
        raise ModelError(
            f"sample time {sample_time:g} s was given; {MOST_OFTEN:g} to {RAREST:g} s is needed "
            "(a turbine controller runs every 0.01 to 0.02 s)"
        )
    require_times(sample_time, computation_time)
    fitting_step(sample_time, computation_time)


def run_simulation(
    turbine: Turbine,
    chosen: ChosenLaws,
    winds: Sequence[WindSeries],
    *,
    asked: Sequence[str] = (),
    parts: PlantParts | None = None,
    sample_time: float = TIME_STEP,
    computation_time: float = 0.0,
    series: bool = True,
    tell: Tell | None = None,
) -> Simulation:
    """Return every law in every wind on the validation plant, from rest at each first wind.

    Parameters
    ----------
    asked : the words of the winds, for titles; their names unless given.
    parts : of the plant; None takes all that the turbine's file states.
    sample_time, computation_time : of the laws' program [s], see ``SampledLaw``.
    series : False keeps the metrics alone, of many long runs (10 MB a run of 600 s).
    tell : called with the step in words and the share done.

    Raises
    ------
    ModelError : a filter or ripple out of range, or times that make no program.
    """
    parts = parts or PlantParts()
    plant = simulation_plant(turbine, parts)
    # The low-pass that is exported with a law, unless another is given.
    own_filters = chosen.speed_filters if parts.speed_filter is None else {}
    loops = {
        name: SampledLoop(
            replace(plant, speed_filter=own_filters.get(name, plant.speed_filter)),
            law,
            chosen.observer,
            sample_time=sample_time,
            computation_time=computation_time,
        )
        for name, law in chosen.laws.items()
    }
    runs = tuple(_runs(loops, winds, tell, series=series))
    words = tuple(asked) or tuple(wind.name for wind in winds)
    return Simulation(
        turbine, words, parts, tuple(winds), chosen, runs, sample_time, computation_time
    )


def _runs(
    loops: Mapping[str, SampledLoop],
    winds: Sequence[WindSeries],
    tell: Tell | None,
    *,
    series: bool,
) -> Iterator[Run]:
    pairs = [(name, wind) for name in loops for wind in winds]
    if tell is not None:
        tell("the plant's equations, compiled once", 0.0)

    def run(name: str, wind: WindSeries) -> Run:
        try:
            history = loops[name].run(wind)
        except Diverged as end:
            return Run(name, wind.name, diverged=end.time)
        return Run(
            name,
            wind.name,
            history if series else None,
            measure(history, loops[name].plant.turbine),
            flags={flag: history.share_flagged(flag) for flag in Flag},
            first={flag: history.first_flagged(flag) for flag in Flag},
        )

    for done, result in enumerate(in_threads([partial(run, *pair) for pair in pairs]), 1):
        if tell is not None:
            tell(f"{result.law}, {result.wind}", done / len(pairs))
        yield result


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.01 else "less than 1 %"
