"""The status of a sample, a sum of bits: the same in C, FMU, Structured Text and MATLAB."""

from __future__ import annotations

from collections.abc import Collection
from decimal import Decimal

from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.sampling import longest_sample

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

    Parameters
    ----------
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
