"""From what was found to a claim with its sentence.

The assumptions of a verdict about a turbine's loop: one list for all outputs.

A verdict is about a model of the machine. Effects that the model omits, and conditions on the
start, are listed here once, by kind of claim. Terminal, JSON, report and continuous integration
print this list.
"""

from __future__ import annotations

from takagi.certificates.checker.kernel.result import Claim, Outcome


def in_words(outcome: Outcome) -> Claim:
    """Return the claim with its verdict and its sentence."""
    if isinstance(outcome, Claim):
        return outcome
    return Claim(outcome.claim.name, outcome.verdict, outcome.claim.sentence())


RIGID = ("rigid shaft, tower and blades", "wake without states of its own")
# A gain file's program limits the rates of torque and pitch; these kinds have the drive's alone.
DRIVES = (
    "torque without delay, and commands without a limit of their rates",
    "first-order pitch drive",
)
PROGRAM = ("continuous time", "exact speed")
IN_THE_SET = "start with V <= 1 and pitch at or above its lower limit"
OUTSIDE = "wind estimate from outside, within the stated class"
KNOWN_WIND = "constant wind that the law knows"
RUNNING = (
    "constant wind",
    "start with V <= 1 in the set of that wind cell, pitch at or above its lower limit, schedule "
    "wind within the tables, and what is sent equal to what the law asks for",
    "c_P of the table",
    "wake with one state, which answers to pitch alone",
    "torque without delay, and known to the observer",
    "first-order pitch drive",
    RIGID[0],
    PROGRAM[0],
    "speed measured exactly before its filters, pitch exactly",
)
LOOP = (IN_THE_SET, *DRIVES, *RIGID, *PROGRAM)
ASSUMED = {
    "coherent-loop": (*LOOP, OUTSIDE),
    "wind-rate": (*LOOP, OUTSIDE, "start of the wind filter at its estimate"),
    "actuator-rates": (*LOOP, OUTSIDE),
    "paper-loop": (
        "start inside the set of the wind's cell",
        KNOWN_WIND,
        *DRIVES,
        *RIGID,
        *PROGRAM,
    ),
    "running-loop": RUNNING,
}


def assumed(kind: str) -> tuple[str, ...]:
    """Return the assumptions of a kind of claim; empty if it is not about a turbine's loop."""
    return ASSUMED.get(kind, ())
