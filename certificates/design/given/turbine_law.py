"""A certificate for existing gains: the law is read from its file and analysed unchanged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.reader import member, number, numbers, read_json, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.checker.turbine.running_loop.inputs import STATED
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_UNCERTAINTY,
    effort_sharing_candidate,
)
from takagi.certificates.claims.turbine.failing_winds import failing_winds
from takagi.certificates.claims.turbine.loop_claims import loop_document
from takagi.certificates.controller.content import plain
from takagi.certificates.design.step_clock import Tell
from takagi.certificates.design.turbine.effort_sharing_gains import widened
from takagi.certificates.design.turbine.scale import scaled_box
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.laws.effort_sharing.schedule import (
    EffortSchedule,
    Feedforward,
    frozen_wake_effectiveness,
)
from takagi.models.turbine.data import Turbine


def read_law(path: Path) -> Mapping[str, Any]:
    """Return the ``law`` of a gain file, its numbers as they are written.

    Raises
    ------
    CertificateError : unreadable, not strict JSON, or without a law.
    """
    law = member(read_json(path), "law", str(path))
    if not isinstance(law, Mapping):
        raise CertificateError(f"{path}: 'law' must be an object, as in a gain file of takagi")
    return law


def read_observer(path: Path) -> dict[str, Any]:
    """Return the members ``observer`` and ``measurement`` of a gain file, where it has them.

    Raises
    ------
    CertificateError : unreadable, or not strict JSON.
    """
    file = read_json(path)
    return {part: plain(file[part]) for part in STATED if file.get(part) is not None}


def effort_sharing_law_from_data(
    data: Mapping[str, Any], *, source: str = "gains"
) -> EffortSharingLaw:
    """Return the law that ``effort_sharing_law_data`` wrote.

    Parameters
    ----------
    data : the law as ``read_law`` returns it.
    source : its name in messages.

    Raises
    ------
    CertificateError : another law, or a member that is missing or not a number.
    ModelError : tables that do not make a law.
    """
    name = text(data, "name", source)
    if name != "coherent":
        raise CertificateError(
            f"{source}.name: {name!r} was given; a gain file is certified for the "
            "effort-sharing law ('coherent'), a published law by designing it anew, without --gains"
        )
    nodes = len(numbers(data, "wind", source))
    row = {
        key: [float(value) for value in numbers(data, key, source, nodes - less)]
        for key, less in _ROWS
    }
    single: dict[str, Any] = {key: float(number(data, key, source)) for key in _SINGLE}
    schedule = EffortSchedule(**_part(row, _SCHEDULE), overlap=single.pop("overlap"))
    inertia, limit = (np.array(row[key]) for key in _AHEAD)
    ahead = Feedforward(inertia, limit, single.pop("pitch_lead"))
    return EffortSharingLaw(schedule, EffortGains(**_part(row, _GAINS)), ahead, **single)


_SCHEDULE = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
_GAINS = ("proportional", "integral_rate")
_AHEAD = ("inertia_feedforward", "feedforward_limit")
# How many entries a row has fewer than there are wind nodes: 1 for values per cell.
_ROWS = tuple(
    (key, int(key in ("integral_rate", *_AHEAD))) for key in (*_SCHEDULE, *_GAINS, *_AHEAD)
)
_SINGLE = (
    "overlap",
    "rated_torque",
    "effort_torque",
    "pitch_min",
    "pitch_max",
    "pitch_lead",
    "wind_filter",
    "integral_limit",
)


def _part(rows: Mapping[str, list[float]], keys: Sequence[str]) -> dict[str, Any]:
    return {key: rows[key] for key in keys}


@dataclass(frozen=True, slots=True)
class _Asked:
    """The settings that the certificate's configuration records."""

    law: str
    box: LoopBox
    uncertainty: LoopUncertainty


# The last decimal that the table is written with.
WAKE_DECIMAL = 1e-6


def _require_the_turbines_wake(turbine: Turbine, schedule: EffortSchedule) -> None:
    """Refuse a frozen-wake table that is not the turbine's, because the claim would use it."""
    pairs = zip(schedule.wind.tolist(), schedule.effectiveness_limit.tolist(), strict=True)
    for wind, stated in pairs:
        own = frozen_wake_effectiveness(turbine, wind)
        if abs(stated - own) > WAKE_DECIMAL:
            raise ModelError(
                f"effectiveness_limit is {stated:.7g} rad/s^2 per rad at {wind:.6g} m/s; a claim "
                f"with the frozen wake of {turbine.name} needs {own:.7g} there, from the turbine's "
                "own file. Take the table as 'takagi design' wrote it, or leave the frozen wake "
                "out of the claim (--equilibrium-wake)"
            )


def certify_law(
    turbine: Turbine,
    law: EffortSharingLaw,
    *,
    box: LoopBox | None = None,
    uncertainty: LoopUncertainty = DEFAULT_UNCERTAINTY,
    files: Sequence[Path] = (),
    controller: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
) -> tuple[dict[str, Any], Checked]:
    """Return the certificate of a given law on a turbine, and the checker's verdict.

    Parameters
    ----------
    box : the region around the trim that is enclosed; None takes ``scaled_box`` of the turbine.
    files : the turbine's data files; the certificate records their SHA-256.
    controller : the gain file's observer and filters, for the claim about the loop with them; None
        makes no such claim.
    tell : called with a word on progress.

    Raises
    ------
    ModelError : no common quadratic function was found, or the box leaves what is enclosed; names
        the condition and what to relax.  Or the law's table of the frozen wake is not the
        turbine's, although that wake is to be covered; names the wind.
    """
    if uncertainty.frozen_wake:
        _require_the_turbines_wake(turbine, law.schedule)
    if box is None:
        box = scaled_box(turbine)
    candidate = effort_sharing_candidate(turbine, law, box=box, uncertainty=uncertainty, tell=tell)
    if candidate.P is None:
        raise ModelError(
            f"no common quadratic function; {failing_winds(candidate.cells)}. Reduce the "
            "uncertainty, or change the gains there"
        )
    candidate = widened(turbine, law, candidate, tell=tell)
    if tell is not None:
        tell("exact proof")
    asked = _Asked(law.name, box, uncertainty)
    document = loop_document(
        turbine,
        law,
        candidate,
        asked,
        files=files,
        controller=controller,
        tell=tell,
    )
    return document, check_document(document)
