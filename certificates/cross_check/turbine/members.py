"""The members that claims about a turbine's loop may have, each as the names on the way to it.

A member that no condition reads could be an uncertainty, or a filter, that is not shown.  So a
claim that has another one is refused, and so is a file whose turbine, law or observer has one.
``*`` stands for any name: multipliers have the names of factors, which are looked at where they are
read.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from takagi.certificates.cross_check.kernel.reading import Refusal, entry

_WORDS = {
    "coherent-loop": """
        state P uncertainty.inertia uncertainty.frozen_wake uncertainty.power_coefficient
        box.speed_error box.effort_lag box.speed_signal box.wind_share
        peaks.speed_error peaks.effort_lag peaks.speed_signal peaks.integral
        settling.P settling.decay_rate
        cells.wind cells.effectiveness_limit cells.stiffness cells.loop_gain cells.lag_gain
        cells.share_gain cells.lag_rate cells.residual cells.wind_gain cells.inertia_gain
        cells.effectiveness_slope cells.reference_slope cells.lag_disturbance cells.integral_rate
        cells.wind_error cells.wind_rate cells.multiplier cells.decay_rate
    """,
    "wind-rate": """
        loop ranges.wind ranges.estimate_rate ranges.schedule_rate ranges.estimate_error
    """,
    "actuator-rates": """
        loop wind_rate torque_step
        cells.pitch_rate cells.signal_rate cells.torque_rate cells.schedule_bend
    """,
    "running-loop": """
        winds decay_rate uncertainty.inertia uncertainty.wake_length
        observer.l1 observer.l2 observer.wind_limits measurement.speed_filter
        measurement.torsion_filter.frequency measurement.torsion_filter.passed
        cells.wind cells.P cells.multipliers.* cells.sides.speed cells.sides.measured
        cells.sides.pitch cells.sides.signal cells.sides.effort cells.sides.schedule
        cells.sides.estimate cells.sides.integral cells.sides.measured_rate cells.sides.innovation
    """,
}
_Path = tuple[str, ...]
# The parts that a claim is about.  The content of the model's files (``model_file``, or in early
# files their hashes) is no part of the loop.
_TURBINE = """
    kind name units torque_constant rotor_radius rotor_inertia generator_inertia gear_ratio
    rated_rotor_speed pitch_time_constant pitch_rate_limit pitch_min pitch_max torque_rate_limit
    torque_surface.formula torque_surface.tip_speed_ratio_knots torque_surface.pitch_knots
    torque_surface.coefficients
"""
_FILES = ("model_file", "files_sha256")
SI = "SI, angles in rad, generator inertia on the high-speed shaft"
_LAW = """
    name wind rotor_speed trim_effort effectiveness effectiveness_limit overlap proportional
    integral_rate inertia_feedforward feedforward_limit pitch_lead rated_torque effort_torque
    pitch_min pitch_max wind_filter integral_limit
"""
_OBSERVER = "l1 l2 wind_limits decay_rate equations"


def _allowed(words: str) -> set[_Path]:
    """Return the ways to all members and to the objects that they are in."""
    ways = [tuple(word.split(".")) for word in words.split()]
    return {way[:n] for way in ways for n in range(1, len(way) + 1)}


ALLOWED = {kind: _allowed(f"kind name {words}") for kind, words in _WORDS.items()}
PARTS = {name: _allowed(words) for name, words in (
    ("model", _TURBINE), ("gains", _LAW), ("observer", _OBSERVER)
)}  # fmt: skip


def no_other_members(claim: Any, kind: str) -> None:
    """Refuse a claim with a member that is not listed for its kind.

    Raises
    ------
    Refusal : names the first one.
    """
    for way in _ways(claim):
        if way not in ALLOWED[kind] and (*way[:-1], "*") not in ALLOWED[kind]:
            raise Refusal(f"{'.'.join(way)[:60]!a}: a member that no condition of {kind} reads")


def nothing_unread(document: Any) -> None:
    """Refuse a file whose turbine, effort-sharing law or observer has a member that is not listed,
    or whose numbers are not in SI units.

    A published law is not replayed here, and so it is not looked at.

    Raises
    ------
    Refusal : names the first one.
    """
    model, gains = entry(document, "model"), entry(document, "gains")
    if isinstance(model, dict):
        model = {name: value for name, value in model.items() if name not in _FILES}
        if model.get("units", SI) != SI:
            raise Refusal(f"model.units: {SI!r} is needed")
    controller = document.get("controller")
    found = {"model": model}
    if isinstance(gains, dict) and gains.get("name") == "coherent":
        found["gains"] = gains
    if isinstance(controller, dict):
        found["observer"] = controller.get("observer")
    for part, stated in found.items():
        for way in _ways(stated):
            if way not in PARTS[part]:
                raise Refusal(f"{part}.{'.'.join(way)[:60]!a}: a member that no condition reads")


def _ways(owner: Any) -> Iterator[_Path]:
    """Yield the way to every member; entries of a list count as their list."""
    if isinstance(owner, list):
        for one in owner:
            yield from _ways(one)
    elif isinstance(owner, dict):
        for name, value in owner.items():
            yield (name,)
            yield from ((name, *way) for way in _ways(value))
