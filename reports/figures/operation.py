"""Steady operation over wind, and the weights that blend torque and pitch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.arrays import Floats
from takagi.models.laws.published.regional_schedule import CouplingFilter
from takagi.models.turbine.data import Turbine, tip_speed_ratio
from takagi.models.turbine.trim import TrimPoint
from takagi.reports.figures.style import (
    COLOURS,
    SEQUENTIAL,
    columns,
    house_style,
    new_figure,
    region_axes,
    wind_axis,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure


RPM, DEGREES = 30 / np.pi, 180 / np.pi


def trim_figure(
    design: TurbineDesign, points: Sequence[TrimPoint], regions: Mapping[str, float]
) -> Figure:
    """Return rotor speed [rpm], pitch [deg], torque [kN m] and power [MW] of the trim over wind.

    Parameters
    ----------
    regions : wind at which each region begins [m/s], such as ``{"2": 4.7, "3": 11.45}``.

    Dots are the published pitch, where the speed is not de-rated.
    """
    turbine = design.turbine
    wind, omega, pitch, torque = (
        np.array([getattr(point, name) for point in points])
        for name in ("wind", "rotor_speed", "pitch", "torque")
    )
    power = turbine.generator_efficiency * turbine.gear_ratio * torque * omega
    shown = (
        (omega * RPM, "rotor speed [rpm]"),
        (pitch * DEGREES, "pitch [°]"),
        (torque / 1e3, "torque [kN m]"),
        (power / 1e6, "electrical power [MW]"),
    )
    with house_style():
        figure, panels = new_figure(2, 2, height=4.8, share_x=True)
        for axes, (values, label) in zip(panels, shown, strict=True):
            axes.plot(wind, values, color=COLOURS[0])
            axes.set_ylabel(label)
            axes.set_ylim(bottom=min(0.0, float(values.min())))
        if design.settings.speed_setpoint is None:
            published = turbine.frozen_wake
            angles = np.asarray(published.pitch) * DEGREES
            panels[1].plot(
                published.wind, angles, "o", color=COLOURS[1], markersize=3.5, label="published"
            )
            panels[1].legend(loc="lower right")
        region_axes(panels, wind, regions)
    return figure


def power_surface_figure(
    turbine: Turbine,
    points: Sequence[TrimPoint],
    *,
    ratio: Floats,
    pitch: Floats,
    band: float | None = None,
) -> Figure:
    """Return c_P >= 0 over tip-speed ratio and pitch [deg], with the trim and its band.

    Parameters
    ----------
    ratio : (n,) tip-speed ratios [-];  pitch : (k,) [rad].
    band : half-width of the band around the trim in pitch [rad].
    """
    beta, surface = pitch * DEGREES, turbine.power(ratio[None, :], pitch[:, None])
    with house_style():
        figure, (axes,) = new_figure()
        levels = np.arange(0.0, max(0.05, float(surface.max())) + 0.05, 0.05)
        filled = _filled(axes, ratio, beta, surface, levels)
        along = np.array([tip_speed_ratio(turbine, p.rotor_speed, p.wind) for p in points])
        _trim_line(axes, along, np.array([p.pitch for p in points]) * DEGREES, band)
        axes.set_facecolor("#f4f4f4")
        axes.set_xlabel("tip-speed ratio [-]")
        axes.set_ylabel("pitch [°]")
        axes.set_xlim(ratio[0], ratio[-1])
        axes.set_ylim(beta[0], beta[-1])
        axes.grid(False)
        figure.colorbar(filled, ax=axes, label="power coefficient [-]")
    return figure


def _filled(axes: Axes, x: Floats, y: Floats, z: Floats, levels: Floats) -> QuadContourSet:
    filled = axes.contourf(x, y, z, levels=levels, cmap=SEQUENTIAL)
    # Neighbouring patches would let the paper show between them.
    filled.set_edgecolor("face")
    filled.set_linewidth(0.4)
    return filled


def _trim_line(axes: Axes, ratio: Floats, degrees: Floats, band: float | None) -> None:
    axes.plot(ratio, degrees, color="white", linewidth=3.2)
    axes.plot(ratio, degrees, color=COLOURS[1], linewidth=1.8, label="trim over wind")
    if band is not None:
        for side, label in ((1, "band"), (-1, "_nolegend_")):
            shifted = degrees + side * band * DEGREES
            axes.plot(ratio, shifted, color=COLOURS[1], linestyle="--", linewidth=1.2, label=label)
    axes.legend(loc="upper right", frameon=True, framealpha=0.9)


LEVELS = np.linspace(0.0, 1.0, 11)
GRID = (121, 101)  # of the memberships


def membership_figure(
    coupling: CouplingFilter, turbine: Turbine, trim: Sequence[TrimPoint]
) -> Figure:
    """Return h^a_m(omega, T_g) of the filter's four corners as filled contours, with the trim."""
    ramp = coupling.speed_ramp
    margin = max(0.15, 1.5 * ramp.width)
    speed = np.linspace(ramp.start - margin, ramp.end + margin, GRID[0])
    low = turbine.rated_torque - max(6 * coupling.torque_overlap, 0.2 * turbine.rated_torque)
    torque = np.linspace(low, coupling.top_torque, GRID[1])
    inside = [p for p in trim if speed[0] <= p.rotor_speed and low <= p.torque]
    weights = coupling.memberships(speed[None, :], torque[:, None])
    with house_style():
        figure, panels = new_figure(2, 2, height=5.0)
        for k, (axes, corner) in enumerate(zip(panels, coupling.corners, strict=True)):
            filled = _panel(axes, speed * RPM, torque / 1e3, weights[k])
            f2, f1 = float(corner[0, 0]), float(corner[1, 1])
            axes.set_title(f"$h^a_{k + 1}$: $f_2$ = {f2:.3f}, $f_1$ = {f1:.0f}")
            if inside:
                speeds = np.array([p.rotor_speed for p in inside]) * RPM
                loads = np.array([p.torque for p in inside]) / 1e3
                axes.plot(speeds, loads, color="white", linewidth=2.6)
                axes.plot(speeds, loads, color="black", linewidth=1.2)
            if k >= 2:
                axes.set_xlabel("rotor speed [rpm]")
            if k % 2 == 0:
                axes.set_ylabel("torque [kN m]")
        figure.colorbar(filled, ax=panels, label="weight [-]", aspect=30)
    return figure


def _panel(axes: Axes, omega: Floats, load: Floats, weights: Floats) -> QuadContourSet:
    filled = _filled(axes, omega, load, np.clip(weights, 0.0, 1.0), LEVELS)
    axes.set_xlim(omega[0], omega[-1])
    axes.set_ylim(load[0], load[-1])
    axes.grid(False)
    return filled


def cells_figure(
    edges: ArrayLike,
    proved: ArrayLike,
    *,
    decay_rate: ArrayLike,
    wind_error: ArrayLike,
    wind_rate: ArrayLike,
    overspeed: ArrayLike,
) -> Figure:
    """Return decay rate, wind limits and overspeed bound per wind cell.

    Parameters
    ----------
    edges : (n + 1,) of the cells [m/s], increasing.
    proved : (n,) of bool; a cell that is not proved is hatched and shows no figure.
    decay_rate : (n,) [1/s].
    wind_error, wind_rate : (n,) largest |v - v_s| [m/s] and |v_s'| [m/s^2] of the wind limits.
    overspeed : (n,) bound on omega above its reference, as a share of rated [-]; shown in percent.
    """
    v = np.asarray(edges, dtype=np.float64)
    sound = np.asarray(proved, dtype=bool)
    figures = columns("cells", [decay_rate, wind_error, wind_rate, overspeed], len(sound))
    labels = (
        "decay rate\n[1/s]",
        "|v \u2212 v$_s$| up to\n[m/s]",
        "|v$_s$'| up to\n[m/s²]",
        "overspeed bound\n[%]",
    )
    with house_style():
        figure, panels = new_figure(4, 1, height=6.2, share_x=True)
        factors = (1.0, 1.0, 1.0, 100.0)
        for axes, values, label, factor in zip(panels, figures, labels, factors, strict=True):
            shown = cells_panel(axes, v, factor * values, sound)
            if sound.any():
                axes.set_ylim(0.0, 1.15 * max(float(np.nanmax(shown)), 1e-9))
            axes.set_ylabel(label)
        wind_axis(panels[-1])
        panels[-1].set_xlim(v[0], v[-1])
        if not sound.all():
            handles, texts = panels[0].get_legend_handles_labels()
            figure.legend(handles, texts, loc="outside lower center")
    return figure


def cells_panel(axes: Axes, edges: Floats, values: ArrayLike, sound: NDArray[np.bool_]) -> Floats:
    """Draw a step per cell, hatched where it is not proved; return the values, nan there."""
    heights = np.where(sound, values, np.nan)
    if sound.any():
        axes.stairs(heights, edges, baseline=0.0, fill=True, color=COLOURS[0], alpha=0.25)
        axes.stairs(heights, edges, baseline=None, color=COLOURS[0], linewidth=1.6)
    label = "not proved"
    for low, high, fine in zip(edges[:-1], edges[1:], sound, strict=True):
        if not fine:
            hatched: Any = {"facecolor": "none", "edgecolor": COLOURS[1], "hatch": "////"}
            axes.axvspan(low, high, linewidth=0.0, label=label, **hatched)
            label = "_nolegend_"
    return heights


# Narrower than this share of the axis a range could not be seen.
NARROWEST_SHARE = 0.014
# Any: the properties of a patch have as many types as there are of them.
PROVED: dict[str, Any] = {"facecolor": COLOURS[0], "edgecolor": COLOURS[0], "linewidth": 0.0}
UNPROVED: dict[str, Any] = {
    "facecolor": "white",
    "edgecolor": COLOURS[1],
    "linewidth": 0.8,
    "hatch": "//////",
}


class OverlapRow(NamedTuple):
    """One bar: its label, and the winds [m/s] proved, and those examined but not proved."""

    label: str
    proved: tuple[tuple[float, float], ...]
    unproved: tuple[tuple[float, float], ...]


def overlaps_figure(rows: Sequence[OverlapRow], *, wind: tuple[float, float]) -> Figure:
    """Return horizontal bars over wind [m/s]: proved ranges filled, other examined ones hatched.

    A range too narrow to be seen is drawn lower and wider than it is, about its middle.  What is
    not proved lies on top, so that no widened bar hides it.

    Parameters
    ----------
    rows : from top to bottom.
    wind : the ends of the axis [m/s].
    """
    from matplotlib.patches import Patch, Rectangle

    with house_style():
        figure, (axes,) = new_figure(height=1.15 + 0.3 * len(rows))
        narrowest = NARROWEST_SHARE * (wind[1] - wind[0])
        for index, row in enumerate(rows):
            for spans, style in ((row.proved, PROVED), (row.unproved, UNPROVED)):
                for low, high in spans:
                    tall = 0.62 if high - low >= narrowest else 0.42
                    width, middle = max(high - low, narrowest), (low + high) / 2
                    corner = (middle - width / 2, index - tall / 2)
                    axes.add_patch(Rectangle(corner, width, tall, **style))
        axes.set_yticks(range(len(rows)), [row.label for row in rows])
        axes.set_ylim(len(rows) - 0.4, -0.6)
        # Room for a widened bar at either end.
        axes.set_xlim(wind[0] - narrowest, wind[1] + narrowest)
        axes.set_ylabel("overlaps\n\u03b5$_\u03c9$ [rad/s], \u03b5$_T$ [N m]")
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
        wind_axis(axes)
        handles = [
            Patch(label="proved", **PROVED),
            Patch(label="looked at, not proved", **UNPROVED),
        ]
        axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure
