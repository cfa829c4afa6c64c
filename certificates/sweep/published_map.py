"""The map of the published laws: the winds proved, over both overlaps of the coupling filter.

At a pair of overlaps (eps_omega, eps_T) one window of ``WINDOW`` m/s is examined per wind, as one
cell (two if a table has a node in it); nothing is claimed between the windows.  Regional gains,
trim tables and premises do not depend on the overlaps and are made once per process.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from takagi.certificates.claims.turbine.published import published_law_data
from takagi.certificates.design.turbine.published_law import designed_law
from takagi.certificates.design.turbine.regions import regional_design
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.provenance import provenance
from takagi.certificates.sweep.axis import Axis, AxisKind
from takagi.certificates.sweep.effort_sharing_row import effort_sharing_row
from takagi.certificates.sweep.grid import SweepMap, Task
from takagi.certificates.sweep.loop_settings import model_numbers
from takagi.certificates.sweep.published_point import LADDER, overlap_point
from takagi.models.errors import ModelError
from takagi.models.laws.published.coupling_filter import CouplingFilter, coupling_filter
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

SPEED, TORQUE, WIND = "speed-overlap", "torque-overlap", "wind"

AXES = (
    AxisKind(SPEED, "rad/s", "overlap of the coupling filter in rotor speed"),
    AxisKind(TORQUE, "N m", "overlap of the coupling filter in torque"),
    AxisKind(WIND, "m/s", "winds at which a window is looked at"),
)

# Distance from rated wind within which further winds are added, because the regions meet [m/s].
NEAR_RATED = 1.5
# Wider windows would need smaller cells where the ramp is steep [m/s].
WINDOW = 0.004
DIGITS = 9


def build(
    law: str,
    turbine: Turbine,
    files: Sequence[Path],
    axes: Sequence[Axis],
    tell: Callable[..., None],
) -> SweepMap:
    """Return the map of law "paper" or "paper-two-integrators" over the overlaps.

    The axis "wind" adds no points: it lists the winds that each point examines.

    Raises
    ------
    ModelError : a wind outside cut-in to cut-out, or an overlap that leaves no filter; names the
        value and what to do.
    """
    given = {axis.name: axis for axis in axes}
    asked = replace(default_settings(turbine), law=law)
    winds = windows(turbine, given[WIND].values if WIND in given else default_winds(turbine))
    overlaps = (
        given.get(SPEED) or Axis(SPEED, "rad/s", (asked.speed_overlap,)),
        given.get(TORQUE) or Axis(TORQUE, "N m", (asked.torque_overlap,)),
    )
    _require_filters(turbine, *overlaps)
    tell("regional gains")
    base = _law(law, turbine)
    settings = {
        "sets [rad/s]": list(LADDER),
        "model": model_numbers(turbine),
        "law": published_law_data(base),
        "windows": [list(span) for span in winds],
        "versions": provenance({}, {})["versions"],
    }
    beside = (effort_sharing_row(turbine, winds),)
    return SweepMap(law, overlaps, settings, point, turbine, prepare, beside)


def default_winds(turbine: Turbine) -> tuple[float, ...]:
    """Return a wind per m/s from half a metre above cut-in on, and two near rated wind [m/s]."""
    rated = rated_wind(turbine)
    halves = [turbine.cut_in + 0.5 * k for k in range(1, 1000)]
    inside = [v for v in halves if v < turbine.cut_out]
    return tuple(
        round(v, DIGITS) for k, v in enumerate(inside) if k % 2 == 0 or abs(v - rated) <= NEAR_RATED
    )


def windows(turbine: Turbine, winds: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the window of ``WINDOW`` m/s that begins at each wind.

    Raises
    ------
    ModelError : a wind whose window is not between cut-in and cut-out, or overlaps the next one.
    """
    last = round(turbine.cut_out - WINDOW, DIGITS)
    for v in winds:
        if not turbine.cut_in <= v <= last:
            raise ModelError(
                f"axis wind: {v:g} m/s was given; the window from there on, {WINDOW:g} m/s wide, "
                f"must lie between cut-in and cut-out: give winds from {turbine.cut_in:g} to "
                f"{last:g} m/s"
            )
    for low, high in zip(winds, winds[1:], strict=False):
        if high - low < WINDOW:
            raise ModelError(
                f"axis wind: {low:g} and {high:g} m/s are nearer than the windows are wide "
                f"({WINDOW:g} m/s); give fewer winds"
            )
    return tuple((v, round(v + WINDOW, DIGITS)) for v in winds)


def _require_filters(turbine: Turbine, speed: Axis, torque: Axis) -> None:
    """Refuse overlaps without a valid filter, or for which pitch acts at every wind."""
    asked = default_settings(turbine)
    lowest, rated = turbine.minimum_rotor_speed, turbine.rated_rotor_speed
    for value in speed.values:
        start = _filter(turbine, SPEED, value, asked.torque_overlap).speed_ramp.start
        if start <= lowest:
            room = value * (rated - lowest) / (rated - start)
            raise ModelError(
                f"axis {SPEED}: {value:g} rad/s was given; the ramp would begin at {start:.4g} "
                f"rad/s, not above the minimum rotor speed {lowest:.4g} rad/s, and pitch would act "
                f"at every wind from cut-in ({turbine.cut_in:g} m/s) on: give values below "
                f"{room:.3g} rad/s"
            )
    for value in torque.values:
        _filter(turbine, TORQUE, asked.speed_overlap, value)


def _filter(turbine: Turbine, axis: str, speed: float, torque: float) -> CouplingFilter:
    try:
        return coupling_filter(turbine, speed_overlap=speed, torque_overlap=torque)
    except ModelError as error:
        raise ModelError(f"axis {axis}: {error}") from error


# ---------------------------------------------------------------------- in each process
@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """Data that a process keeps: the law with its own overlaps, and the windows [m/s]."""

    law: PublishedLaw
    winds: tuple[tuple[float, float], ...]


def prepare(settings: Mapping[str, Any], turbine: Turbine) -> Prepared:
    """Return the law and the windows; called once per process.

    Raises
    ------
    ModelError : the gains are not those of the settings.
    """
    law = _law(settings["law"]["name"], turbine)
    if published_law_data(law) != settings["law"]:
        raise ModelError(
            "the regional gains of two processes differ; give --workers 1, or other solver settings"
        )
    return Prepared(law, tuple((low, high) for low, high in settings["windows"]))


def point(task: Task) -> dict[str, Any]:
    """Return the result at one pair of overlaps."""
    return overlap_point(
        task.shared.law,
        speed_overlap=task.at[SPEED],
        torque_overlap=task.at[TORQUE],
        winds=task.shared.winds,
    )


def _law(name: str, turbine: Turbine) -> PublishedLaw:
    asked = replace(default_settings(turbine), law=name)
    return designed_law(turbine, asked, regional_design(turbine))
