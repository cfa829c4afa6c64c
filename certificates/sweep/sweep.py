"""A sweep of a law: its axes, as a user writes them, and all points of their grid as rows.

One point of a sweep: what is proved of a turbine's law for some of its parameters.

Effort-sharing law: the gains are designed wind by wind, one quadratic function is sought for all
winds, and its claim is judged.

Published laws: at each wind one window of ``WINDOW`` m/s is examined, as one cell (two if a table
has a node in it); nothing is claimed between the windows.  Regional gains and trim tables do not
depend on the overlaps and are made once in each process.

The independent checker judges all claims, on the decimals that a certificate would state.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.cell_loop import WindClass
from takagi.certificates.claims.turbine.effort_sharing import (
    effort_sharing_candidate,
    effort_sharing_claim,
    failing_winds,
)
from takagi.certificates.claims.turbine.published import (
    PublishedCandidate,
    published_candidate,
    published_claim,
    with_overlaps,
)
from takagi.certificates.design.turbine.published_law import designed_law, regional_design
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    files_sha256,
    published_law_data,
    turbine_data,
)
from takagi.certificates.sweep.tasks import RESULTS, Task, Tell, run_tasks
from takagi.lmi.turbine.effort import EffortSettings, effort_gains
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import to_si, typed_figure
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import EffortSharingLaw, LoopUncertainty
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.laws.published.regional_schedule import coupling_filter
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import TurbineFile
from takagi.models.turbine.trim import rated_wind


@dataclass(frozen=True, slots=True)
class AxisKind:
    """A quantity that may be swept, as ``--over`` names it, with the SI unit of its values.

    Its values lie above 0 (or on it, if ``closed``), and not beyond ``highest``.
    """

    name: str
    unit: str
    highest: float = math.inf
    closed: bool = False


EFFORT_SHARING = (
    AxisKind("overlap", "rad/s^2"),
    AxisKind("bandwidth", "1/s"),
    AxisKind("partial-bandwidth", "1/s"),
    AxisKind("effectiveness", "-"),
    AxisKind("pitch-lag", "s"),
    AxisKind("inertia", "-", highest=0.9, closed=True),
    AxisKind("frozen-wake", "-", highest=3.0, closed=True),
    AxisKind("power-coefficient", "-", highest=0.9, closed=True),
    AxisKind("wind-rate", "m/s^2", closed=True),
)
SPEED, TORQUE, WIND = "speed-overlap", "torque-overlap", "wind"
PUBLISHED = (AxisKind(SPEED, "rad/s"), AxisKind(TORQUE, "N m"), AxisKind(WIND, "m/s"))

# Half widths in speed of the sets to try, the largest first [rad/s].
LADDER = (0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001, 5e-5, 2e-5)
# Wider windows would need smaller cells where the ramp is steep [m/s].
WINDOW = 0.004
# Distance from rated wind within which further winds are added, because the regions meet [m/s].
NEAR_RATED = 1.5
# Of a wind, and of a value between the ends of an axis, which identifies the point.
DIGITS = 9
UNCONFIRMED = "the checker did not confirm what was found"

REMEDY = "reduce the uncertainty (inertia, frozen-wake, power-coefficient) or the bandwidth"

Span = tuple[float, float]


def effort_sharing_point(turbine: Turbine, at: Mapping[str, float]) -> dict[str, Any]:
    """Return what is proved at a point; wind class, overspeed and decay only where PROVED.

    ``at`` : axis name -> value; a name that is missing keeps the setting of a design.

    Raises
    ------
    ModelError : no trim, no gain, or a box that leaves a table or an actuator's limits; names the
        wind and what to change.
    """
    plant, law, covered = loop_at(turbine, at)
    candidate = effort_sharing_candidate(plant, law, **covered)
    if candidate.P is None:
        reason = f"{failing_winds(candidate.cells)}; {REMEDY}"
        return {"verdict": "UNDECIDED", "reason": reason}
    claim = effort_sharing_claim(candidate)
    (checked,) = _checked(plant, effort_sharing_law_data(law), [claim])
    if checked.verdict is not Verdict.PROVED:
        return {"verdict": checked.verdict.name, "reason": f"{checked.text}; {REMEDY}"}
    fastest = float(law.schedule.rotor_speed.max()) + float(claim["peaks"]["speed_error"])
    excess = 100 * (fastest / turbine.rated_rotor_speed - 1)
    widths, error, rate = np.diff(law.schedule.wind), candidate.wind_error, candidate.wind_rate
    return {
        "verdict": "PROVED",
        "reason": None,
        # A bound, so it is rounded up.
        "overspeed [%]": float(np.ceil(1e4 * excess) / 1e4),
        "common_decay [1/s]": float(candidate.common_rate),
        "least_decay [1/s]": float(candidate.decay_rate.min()),
        "mean_wind_error [m/s]": float(f"{np.average(error, weights=widths):.6g}"),
        "least_wind_error [m/s]": float(error.min()),
        "mean_wind_rate [m/s^2]": float(f"{np.average(rate, weights=widths):.6g}"),
        "least_wind_rate [m/s^2]": float(rate.min()),
    }


def loop_at(
    turbine: Turbine, at: Mapping[str, float]
) -> tuple[Turbine, EffortSharingLaw, dict[str, Any]]:
    """Return plant, law with gains found wind by wind, and what its claim shall cover.

    Uncertainty and wind class are those of a design, except for what the axes change.
    """
    design = default_settings(turbine)
    plant = replace(turbine, pitch_time_constant=at.get("pitch-lag", turbine.pitch_time_constant))
    uncertainty, effort = _uncertainty(design.uncertainty, at), design.effort or EffortSettings()
    effort = replace(
        effort,
        bandwidth=at.get("bandwidth", effort.bandwidth),
        partial_bandwidth=at.get("partial-bandwidth", effort.partial_bandwidth),
        inertia=(float(uncertainty.inertia.lower), float(uncertainty.inertia.upper)),
    )
    schedule = effort_schedule(
        plant,
        overlap=at.get("overlap", design.overlap),
        effectiveness_share=at.get("effectiveness", design.effectiveness_share),
        speed_setpoint=design.speed_setpoint,
    )
    if "frozen-wake" in at:
        limit = np.round(at["frozen-wake"] * schedule.effectiveness_limit, 6)
        schedule = replace(schedule, effectiveness_limit=limit)
    wind_class = WindClass()
    if "wind-rate" in at:
        factor = at["wind-rate"] / max(wind_class.rate)
        wind_class = replace(wind_class, rate=tuple(factor * rate for rate in wind_class.rate))
    law = EffortSharingLaw.of(plant, schedule, effort_gains(plant, schedule, effort).gains)
    return plant, law, {"box": design.box, "uncertainty": uncertainty, "wind_class": wind_class}


def _uncertainty(uncertainty: LoopUncertainty, at: Mapping[str, float]) -> LoopUncertainty:
    changed: dict[str, Any] = {}
    for axis in ("inertia", "power-coefficient"):
        if axis in at:
            # The decimal as it is written, because a certificate states decimals.
            share = Fraction(f"{at[axis]:.9g}")
            changed[axis.replace("-", "_")] = Interval(1 - share, 1 + share)
    if "frozen-wake" in at:
        changed["frozen_wake"] = at["frozen-wake"] > 0
    return replace(uncertainty, **changed)


def _checked(plant: Turbine, law: dict[str, Any], claims: list[dict[str, Any]]) -> list[Claim]:
    """Return what the independent checker says of each claim, as in a certificate."""
    document = certificate_document(
        model=turbine_data(plant, ()), gains=law, claims=claims, provenance={"solver": {}}
    )
    return check_document(document).claims


def default_winds(turbine: Turbine) -> tuple[float, ...]:
    """Return a wind per m/s from half a metre above cut-in on, and some near rated wind [m/s]."""
    rated = rated_wind(turbine)
    halves = [turbine.cut_in + 0.5 * k for k in range(1, 1000)]
    inside = [v for v in halves if v < turbine.cut_out]
    return tuple(
        round(v, DIGITS) for k, v in enumerate(inside) if k % 2 == 0 or abs(v - rated) <= NEAR_RATED
    )


def require_winds(turbine: Turbine, winds: Sequence[float]) -> None:
    """Refuse a wind whose window is not between cut-in and cut-out."""
    last = round(turbine.cut_out - WINDOW, DIGITS)
    for v in winds:
        if not turbine.cut_in <= v <= last:
            raise ModelError(
                f"axis {WIND}: {v:g} m/s was given; the window from there on, {WINDOW:g} m/s wide, "
                f"must lie between cut-in and cut-out: give winds from {turbine.cut_in:g} to "
                f"{last:g} m/s"
            )


def published_point(
    name: str, turbine: Turbine, at: Mapping[str, float], winds: Sequence[float]
) -> dict[str, Any]:
    """Return what is proved at one pair of overlaps, together and by window of wind.

    Parameters
    ----------
    name : of the law, as files have it.
    at : axis name -> value; an overlap that is missing keeps the design's value.
    winds : at which a window begins [m/s].

    Raises
    ------
    ModelError : overlaps without a valid coupling filter.
    """
    law = _law(name, turbine)
    speed = at.get(SPEED, law.coupling.speed_ramp.width)
    torque = at.get(TORQUE, law.coupling.torque_overlap)
    coupling_filter(turbine, speed_overlap=speed, torque_overlap=torque)
    return windows_result(with_overlaps(law, speed_overlap=speed, torque_overlap=torque), winds)


def windows_result(law: PublishedLaw, winds: Sequence[float]) -> dict[str, Any]:
    """Return what is proved of a law, together and by window, which begin at the winds [m/s]."""
    windows = certified_windows(law, [(v, round(v + WINDOW, DIGITS)) for v in winds])
    proved = [window for window in windows if window["verdict"] == "PROVED"]
    failing = next((window for window in windows if window not in proved), None)
    first = None if failing is None else failing["from [m/s]"]
    return {
        "verdict": "PROVED" if failing is None else "PARTLY" if proved else "UNDECIDED",
        "reason": failing and f"{first:g} to {failing['to [m/s]']:g} m/s: {failing['reason']}",
        "proved_windows": len(proved),
        "proved_at_trim": sum(window["rest"] == "intended" for window in proved),
        "first_failing_wind [m/s]": first,
        "least_decay_rate [1/s]": min((w["decay_rate [1/s]"] for w in proved), default=None),
        "windows": windows,
    }


@lru_cache(maxsize=2)
def _law(name: str, turbine: Turbine) -> PublishedLaw:
    settings = replace(default_settings(turbine), law=name)
    return designed_law(turbine, settings, regional_design(turbine))


def certified_windows(law: PublishedLaw, winds: Sequence[Span]) -> list[dict[str, Any]]:
    """Return, for each window of wind [m/s], whether the checker proves the law there, and why not.

    Cells are searched in floating point and written as decimals; a window is proved only if the
    checker proves its claim.  ``decay_rate`` is the least of its cells', ``half_width`` in speed
    that of the smallest box.  ``rest`` says where the law rests at the window's lower end:
    "intended" (at the trim), "shifted" (elsewhere) or "none"; ``power_ratio`` is the power there
    over that of the trim.
    """
    candidates = [
        published_candidate(law, winds=[span], narrowest=span[1] - span[0], ladder=LADDER)
        for span in winds
    ]
    covered = [candidate for candidate in candidates if not candidate.unproved]
    claims = [published_claim(candidate) for candidate in covered]
    checked = _checked(law.turbine, published_law_data(law), claims) if claims else []
    proved = [
        candidate
        for candidate, claim in zip(covered, checked, strict=True)
        if claim.verdict is Verdict.PROVED
    ]
    return [_window(candidate, candidate in proved) for candidate in candidates]


def _window(candidate: PublishedCandidate, proved: bool) -> dict[str, Any]:
    ((low, high),) = candidate.winds
    rest, cells = candidate.rests[low], candidate.cells if proved else ()
    gap = min(candidate.unproved, key=lambda gap: gap.wind, default=None)
    return {
        "from [m/s]": low,
        "to [m/s]": high,
        "verdict": "PROVED" if proved else "UNDECIDED",
        "decay_rate [1/s]": min((cell.decay_rate for cell in cells), default=None),
        "half_width [rad/s]": min((float(cell.cell.box[0]) for cell in cells), default=None),
        "rest": rest.kind,
        "power_ratio [-]": None if rest.kind == "none" else round(rest.power_ratio, 6),
        "reason": None if proved else gap.reason if gap else UNCONFIRMED,
    }


# The laws that can be swept, by their names in files, with the quantities that --over knows.
LAWS: Mapping[str, tuple[AxisKind, ...]] = MappingProxyType(
    {"paper": PUBLISHED, "coherent": EFFORT_SHARING}
)
Row = dict[str, Any]
_COUNT = 100_000


@dataclass(frozen=True, slots=True)
class Axis:
    """A quantity with the values it takes, in its SI unit, increasing."""

    name: str
    unit: str
    values: tuple[float, ...]

    @property
    def label(self) -> str:
        """Name and unit, as at the head of a column."""
        return f"{self.name} [{self.unit}]"


def parse_axes(written: Sequence[str], kinds: Sequence[AxisKind]) -> tuple[Axis, ...]:
    """Return the axes that texts like ``speed-overlap=0.02:0.2:20`` ask for, in their order.

    A text is NAME=LOW:HIGH:COUNT (evenly spaced, both ends included) or NAME=VALUE,VALUE,...; a
    number may have a unit behind it (``torque-overlap=0.5kN m:5kN m:10``), else it is in SI.

    Raises
    ------
    ModelError : a name that is not known (the known ones are listed) or is given twice, a text of
        another form, a unit of another quantity, values that do not increase, a value beyond what
        the quantity allows, more than 100 000 points.
    """
    named, axes = {kind.name: kind for kind in kinds}, dict[str, Axis]()
    for text in written:
        name, _, values = text.partition("=")
        name = name.strip()
        if name not in named:
            raise ModelError(
                f"--over {text}: {name!r} cannot be swept{did_you_mean(name, named)}; known here: "
                + ", ".join(f"{kind.name} [{kind.unit}]" for kind in kinds)
            )
        if name in axes:
            raise ModelError(f"--over {text}: {name} was given before; give each axis once")
        try:
            axes[name] = _axis(named[name], values)
        except ModelError as error:
            raise ModelError(f"--over {text}: {error}") from error
    points = math.prod(len(axis.values) for axis in axes.values())
    if points > _COUNT:
        raise ModelError(f"{points} points were asked for; at most {_COUNT} are made in one sweep")
    return tuple(axes.values())


def _axis(kind: AxisKind, text: str) -> Axis:
    ends = text.split(":")
    if len(ends) not in (1, 3) or not text.strip():
        raise ModelError(f"write {kind.name}=LOW:HIGH:COUNT or {kind.name}=VALUE,VALUE,...")
    if len(ends) == 3:
        values = _spaced(_number(kind, ends[0]), _number(kind, ends[1]), ends[2])
    else:
        values = [_number(kind, number) for number in text.split(",")]
    for value in values:
        if not (0 < value or kind.closed and value == 0) or value > kind.highest:
            limit = f"{'at least' if kind.closed else 'above'} 0"
            limit += f" and at most {kind.highest:g}" if kind.highest < math.inf else ""
            raise ModelError(
                f"{value:g} {kind.unit} was given; {kind.name} must be {limit} {kind.unit}"
            )
    for low, high in zip(values, values[1:], strict=False):
        if not low < high:
            raise ModelError(f"{low:g} is followed by {high:g} {kind.unit}; values must increase")
    return Axis(kind.name, kind.unit, tuple(values))


def _spaced(low: float, high: float, count: str) -> list[float]:
    if not re.fullmatch(r"\s*[0-9]{1,6}\s*", count) or not 2 <= int(count) <= _COUNT:
        raise ModelError(
            f"{count!r} was given as the number of values; a whole number from 2 to {_COUNT} is "
            "needed"
        )
    n = int(count) - 1
    steps = [low + (high - low) * i / n for i in range(1, n)]
    return [low, *(float(f"{value:.{DIGITS}g}") for value in steps), high]


def _number(kind: AxisKind, text: str) -> float:
    value, unit = typed_figure(text)
    # The unit's factor must not add further digits to a decimal that was typed.
    return float(f"{to_si(value, unit, kind.unit):.12g}") if unit else value


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """A finished sweep.

    Attributes
    ----------
    law : its name in files;  model : the turbine's name.
    axes : of the grid.  An axis of winds of a published law is not among them: each point examines
        all these winds.
    rows : one a point, in the order of the grid: the axes' values, then the result.  ``verdict`` is
        PROVED, PARTLY (some winds), UNDECIDED, or FAILED after an unforeseen error; ``windows`` are
        a published law's winds.
    resumed : how many points were computed before.
    """

    law: str
    model: str
    axes: tuple[Axis, ...]
    rows: tuple[Row, ...]
    resumed: int

    def counted(self) -> dict[str, int]:
        """Return verdict -> number of points."""
        verdicts = [row["verdict"] for row in self.rows]
        return {verdict: verdicts.count(verdict) for verdict in sorted(set(verdicts))}


def run_sweep(
    law: str,
    source: TurbineFile,
    axes: Sequence[Axis],
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> Sweep:
    """Return every point of a grid; results are kept in ``folder``/results and not made again.

    Parameters
    ----------
    law : one of ``LAWS``.
    workers, scheduler, tell : see ``run_tasks``.

    Raises
    ------
    ModelError : a wind outside the turbine's range; what ``run_tasks`` refuses.
    OSError : a result cannot be written.
    """
    inputs: dict[str, Any] = {"law": law, "files": files_sha256(source.files)}
    grid = [axis for axis in axes if axis.name != WIND]
    if LAWS[law] is PUBLISHED:
        default = default_winds(source.model)
        winds = next((axis.values for axis in axes if axis.name == WIND), default)
        inputs["winds"] = list(winds)
        require_winds(source.model, winds)
    grid_points = list(product(*(axis.values for axis in grid)))
    ats = [dict(zip((axis.name for axis in grid), values, strict=True)) for values in grid_points]
    results, resumed = run_tasks(
        [Task(f"{__name__}:point", source.model, {**inputs, "at": at}) for at in ats],
        folder / RESULTS,
        workers=workers,
        scheduler=scheduler,
        tell=tell,
    )
    rows = []
    for values, result in zip(grid_points, results, strict=True):
        if "error" in result:
            result = {"verdict": "FAILED", "reason": result["error"]}
        rows.append(dict(zip((axis.label for axis in grid), values, strict=True)) | result)
    return Sweep(law, source.model.name, tuple(grid), tuple(rows), resumed)


def point(turbine: Turbine, inputs: Mapping[str, Any]) -> Row:
    """Return the result of a task; what cannot be is UNDECIDED, with the reason."""
    try:
        if inputs["law"] == "coherent":
            return effort_sharing_point(turbine, inputs["at"])
        return published_point(inputs["law"], turbine, inputs["at"], inputs["winds"])
    except ModelError as error:
        return {"verdict": "UNDECIDED", "reason": str(error)}
