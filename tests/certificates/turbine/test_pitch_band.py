"""The pitch that the set reaches, and the pitch that the law commands, each against the limit."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop


def last_cell(document: dict[str, Any], rate: str, pitch_max: Fraction | None = None) -> Loop:
    """Return the loop in the last wind cell, at a rate of the wind [m/s^2] and a limit [rad]."""
    read = read_text(json.dumps(document), "document")
    subject = Subject.read(read["claims"][0], read["model"], read["gains"], "claim")
    if pitch_max is not None:
        subject = replace(subject, law=replace(subject.law, pitch_max=pitch_max))
    return Loop(subject, len(subject.law.wind) - 2, Fraction(rate))


def test_pitch_alone_beyond_the_limit_is_refused(short: Any) -> None:
    """While the schedule rests the command is below the limit, the pitch on its way there not.

    The set reaches pitch that is larger than any command by the effort that pitch still owes.
    """
    found = last_cell(short, "0")
    reached, asked = Fraction(found.reached.high, ONE), found.largest_pitch()
    assert asked < reached

    between = last_cell(short, "0", (asked + reached) / 2)
    assert between.largest_pitch() < between.law.pitch_max
    assert "pitch beyond its limit" in first_failure(between.limits())
    assert first_failure(last_cell(short, "0", reached).limits()) == ""
    hair = Fraction(1, ONE)
    assert "pitch beyond its limit" in first_failure(last_cell(short, "0", reached - hair).limits())


def test_a_command_alone_beyond_the_limit_is_refused(short: Any) -> None:
    """The lead of a fast schedule commands more than the pitch ever reaches."""
    reached = Fraction(last_cell(short, "0").reached.high, ONE)
    rate = next(r for r in range(100) if last_cell(short, str(r)).largest_pitch() > reached)

    failed = last_cell(short, str(rate), reached)
    assert "pitch beyond its limit" in first_failure(failed.limits())
    asked = failed.largest_pitch()
    assert "pitch beyond" not in first_failure(last_cell(short, str(rate), asked).limits())
