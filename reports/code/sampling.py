r"""The longest time from sample to sample with which a turbine's program is run.

    band-stop   six samples in a period of its frequency w:   T <= 2 pi / (6 w)
    observer    an Euler step of half its time constant:      T <= 1 / (2 l_1)
    baseline    the same of its low-pass with corner c:       T <= 1 / (2 c)

A band-stop that is sampled more rarely neither stops the drivetrain's mode nor leads: sampling
turns the mode into a slow one that the law then moves.  On the validation plant the program of the
NREL 5-MW turbine (w = 9.3 rad/s) is quiet up to 0.2 s, and oscillates from 0.3 s on.  The observer
takes Euler steps, and becomes unstable near 2 / l_1; the low-pass of the published baseline
controller likewise at 2 / c.  A plant's law in continuous time has no such
limit: ``takagi design --sample-time`` proves one.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_DOWN, Decimal
from math import pi

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram

SAMPLES_A_PERIOD = 6
# Of the time constant of what takes Euler steps: the observer's is 1 / l_1.
EULER_SHARE = 0.5
USUAL_SAMPLE_TIME = Decimal("0.01")  # s, where neither law nor user states one


@dataclass(frozen=True, slots=True)
class LongestSample:
    """The longest sample time: ``time`` [s], two digits, and ``reason`` in words."""

    time: Decimal
    reason: str

    @property
    def words(self) -> str:
        """The meaning of a status bit for a longer one."""
        return f"the sample time is longer than {self.time} s: {self.reason}"


def longest_sample(program: ControllerProgram) -> LongestSample | None:
    """Return the longest sample time of a program; None for a plant's, or one without such part."""
    if program.kind != "turbine":
        return None
    stages, document = {one.name for one in program.stages}, program.document
    found: list[tuple[float, str]] = []
    stop = document.get("measurement", {}).get("torsion_filter")
    if "speed filter" in stages and stop:
        frequency = float(stop["frequency"])
        found.append(
            (
                2 * pi / (SAMPLES_A_PERIOD * frequency),
                f"the band-stop at {frequency:g} rad/s needs {SAMPLES_A_PERIOD} samples a period",
            )
        )
    if "observer" in stages:
        gain = float(document["observer"]["l1"])
        found.append(
            (
                EULER_SHARE / gain,
                f"the observer, with l1 = {gain:g} 1/s, takes steps of at most half its time "
                "constant",
            )
        )
    law = document["law"]
    if law["name"] == "baseline" and "law" in stages:
        corner = float(law["speed_filter"])
        found.append(
            (
                EULER_SHARE / corner,
                f"its low-pass at {corner:g} rad/s takes steps of at most half its time constant",
            )
        )
    if not found:
        return None
    time, reason = min(found)
    exact = Decimal(repr(time))
    unit = Decimal((0, (1,), exact.adjusted() - 1))
    return LongestSample(exact.quantize(unit, rounding=ROUND_DOWN), reason)


def with_long_sample(
    status: tuple[tuple[int, str], ...], number: int, program: ControllerProgram
) -> tuple[tuple[int, str], ...]:
    """Return (number, meaning) of a status, with one for a sample time that is too long."""
    longest = longest_sample(program)
    return status if longest is None else (*status, (number, longest.words))


def start_sample_time(program: ControllerProgram, asked: float | None) -> Decimal:
    """Return T [s] to start with: that of the law, else of the user, else a usual one.

    Raises
    ------
    ModelError : the user's T differs from that of a law in discrete time, or is longer than the
        longest of a turbine's program.
    """
    own = program.sample_time
    if own is not None:
        if asked is not None and abs(asked - float(own)) > 1e-6 * float(own):
            raise ModelError(
                f"--sample-time {asked} was given; the law is one in discrete time with {own} s"
            )
        return own
    longest = longest_sample(program)
    if asked is None:
        return USUAL_SAMPLE_TIME if longest is None else min(USUAL_SAMPLE_TIME, longest.time)
    if longest is not None and asked > float(longest.time):
        raise ModelError(
            f"--sample-time {asked:g} s was given; at most {longest.time} s is needed, since "
            f"{longest.reason}; a turbine controller runs every 0.01 to 0.02 s"
        )
    return Decimal(repr(asked))
