"""The longest time from sample to sample of a program, and the one to start with.

How it follows from a turbine's filters, or from a plant's loop, is told in
``takagi.certificates.controller.longest_sample``.
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal

from takagi.certificates.controller.longest_sample import LongestSample, longest_of_turbine
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram

USUAL_SAMPLE_TIME = Decimal("0.01")  # s, where neither law nor user states one


def longest_sample(program: ControllerProgram) -> LongestSample | None:
    """Return the longest sample time of a program; None where none is known.

    A turbine's follows from the programs that are not left out; a plant's is in its gain file.

    Raises
    ------
    ModelError : the file states one that is no positive time.
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

    Raises
    ------
    ModelError : the user's T differs from that of a law in discrete time, or is longer than the
        longest of the program.
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
