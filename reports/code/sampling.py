"""The longest time from sample to sample of a program, and the status of a sample, a sum of bits.

How it follows from a turbine's filters, or from a plant's loop, is told in
``takagi.certificates.controller.longest_sample``.  The status is the same in C, FMU, Structured
Text and MATLAB.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from decimal import Decimal

from takagi.certificates.controller.longest_sample import LongestSample, longest_of_turbine
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram

USUAL_SAMPLE_TIME = Decimal("0.01")  # s, where neither law nor user states one


def longest_sample(program: ControllerProgram) -> LongestSample | None:
    """Return the longest sample time of a program; None where none is known.

    A turbine's follows from the programs that are not left out; a plant's is in its gain file.

    Raises ModelError: the file states one that is no positive time.
    """
    if program.kind == "turbine":
        names = {stage.name for stage in program.stages}
        longest: LongestSample | None = longest_of_turbine(program.document, names)
        return longest
    stated = program.document.get("sampling", {})
    time = stated.get("longest") if isinstance(stated, Mapping) else stated
    if program.sample_time is not None or time is None:
        return None
    if not (isinstance(time, Decimal) and time.is_finite() and time > 0):
        raise ModelError(f"sampling.longest is {time}; a positive time in s is needed")
    return LongestSample(time, str(stated.get("reason", "its gain file says so")))


def start_sample_time(program: ControllerProgram, requested: float | None) -> Decimal:
    """Return T [s] to start with: that of the law, else of the user, else a usual one.

    Raises ModelError: the user's T differs from that of a law in discrete time, or is longer than
        the longest of the program.
    """
    fixed_time = program.sample_time
    if fixed_time is not None:
        if requested is not None and abs(requested - float(fixed_time)) > 1e-6 * float(fixed_time):
            raise ModelError(
                f"--sample-time {requested} was given; the law is one in discrete time with "
                f"{fixed_time} s"
            )
        return fixed_time
    longest = longest_sample(program)
    if requested is None:
        return USUAL_SAMPLE_TIME if longest is None else min(USUAL_SAMPLE_TIME, longest.time)
    if longest is not None and requested > float(longest.time):
        raise ModelError(
            f"--sample-time {requested:g} s was given; at most {longest.time} s is needed, since "
            f"{longest.reason}; "
            + (
                "a turbine controller runs every 0.01 to 0.02 s"
                if program.kind == "turbine"
                else "'takagi design --sample-time' proves a sampled loop"
            )
        )
    return Decimal(repr(requested))


# (bit, word, meaning), the most serious first: ``W_message`` of C reports the first that is set.
STATUS_BITS = (
    (4, "RESULT_NOT_FINITE", "a result was not finite; the last good one was sent"),
    (8, "NOT_STARTED", "a step before init, or a damaged state; the law started anew"),
    (1, "INPUT_NOT_FINITE", "an input was not finite; the last good one stood in"),
    (16, "SAMPLE_TIME_REFUSED", "a sample time was refused; the one before is kept"),
    (2, "INPUT_OUTSIDE", "an input lies outside the range where the model holds"),
    (64, "ESTIMATE_HELD", "the wind estimate is held at a limit, or at the end of a table"),
    (32, "AT_LIMIT", "a command is held at a limit"),
)
BIT = {word: bit for bit, word, _ in STATUS_BITS} | {"SAMPLE_TIME_LONG": 128}
# Structured Text and MATLAB report these, and a sample time that is too long.
REPORTED = ("INPUT_NOT_FINITE", "INPUT_OUTSIDE", "RESULT_NOT_FINITE", "SAMPLE_TIME_REFUSED")


def status_bits(
    program: ControllerProgram, words: Collection[str] | None = None
) -> tuple[tuple[int, str, str], ...]:
    """Return (bit, word, meaning), the most serious first; a long sample where there is one.

    words : those that a target reports; None for all.
    """
    longest = longest_sample(program)
    bits = [bit for bit in STATUS_BITS if words is None or bit[1] in words]
    if longest is not None:
        index = sum(bit not in (2, 32, 64) for bit, *_ in bits)
        bits.insert(index, (BIT["SAMPLE_TIME_LONG"], "SAMPLE_TIME_LONG", longest.words))
    return tuple(bits)


def reported_range(limits: tuple[Decimal, Decimal]) -> tuple[Decimal, Decimal]:
    """Return the ends beyond which an input is reported as outside of its range.

    An input outside by less than 1e-5 of the range is noise of a measurement or of a float.
    """
    tolerance = Decimal("1e-5") * (limits[1] - limits[0])
    return limits[0] - tolerance, limits[1] + tolerance
