"""What an export says is proved: verdict, time, ranges and claims, as the gain file states them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from takagi.reports.code.controller_program import ControllerProgram


def proof_lines(program: ControllerProgram) -> tuple[str, ...]:
    """Return one sentence a line: verdict, in which time, in which ranges, and each claim's name.

    The gain file's word; nothing is checked here, and the first line says how to check it.
    """
    if not program.hashes:
        return (f"Proved: nothing; {program.verdict}.",)
    sampled = program.sample_time
    time = (
        "in exact arithmetic and continuous time; the samples of this code are covered only by a "
        "claim that names a sample time"
        if sampled is None
        else f"in exact arithmetic and discrete time, with a sample every {sampled} s and no other"
    )
    claims = program.document["certificate"].get("claims", ())
    return (
        f"The gain file says {program.verdict}. Confirm it with: takagi check CERTIFICATE --gains "
        "GAINS",
        f"What is proved holds {time}.",
        f"What is proved holds in these ranges: {', '.join(_ranges(program)) or 'all values'}.",
        *(f"Claim {k}, {claim['verdict']}: {claim['name']}" for k, claim in enumerate(claims, 1)),
    )


def as_list(lines: Iterable[str]) -> str:
    """Return the lines as a list of Markdown."""
    return "\n".join(f"- {line}" for line in lines)


def _ranges(program: ControllerProgram) -> Iterator[str]:
    document = program.document
    if program.kind == "turbine":
        winds = [float(wind) for wind in document["trim"]["wind"]]
        yield f"wind {min(winds):g} to {max(winds):g} m/s, and what each claim assumes of the wind"
        return
    signals: list[Mapping[str, Any]] = [*document.get("states", ()), *document.get("inputs", ())]
    for signal in signals:
        if signal.get("range") is not None:
            low, high = (f"{float(end):.6g}" for end in signal["range"])
            yield f"{signal['name']} {low} to {high} {signal['unit']}"
