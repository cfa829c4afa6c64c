"""Steady operation over wind, and the weights that blend torque and pitch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.reports.figures.style import (
    COLOURS,
    SEQUENTIAL,
    columns,
    house_style,
    new_figure,
    region_axes,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure

RPM, DEGREES = 30 / np.pi, 180 / np.pi


def trim_figure(
    wind: ArrayLike,
    *,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    torque: ArrayLike,
    power: ArrayLike,
    regions: Mapping[str, float] | None = None,
    published_pitch: tuple[ArrayLike, ArrayLike] | None = None,
) -> Figure:
    """Return rotor speed [rpm], pitch [deg], torque [kN m] and power [MW] over wind.

    Parameters
    ----------
    wind : (n,) [m/s].
    rotor_speed [rad/s], pitch [rad], torque (high-speed shaft) [N m], electrical power [W] : (n,).
    regions : wind at which each region begins [m/s], such as ``{"2": 4.7, "3": 11.45}``.
    published_pitch : (wind [m/s], pitch [rad]) of a reference, drawn as dots.
    """
    v = np.asarray(wind, dtype=np.float64)
    omega, beta, load, energy = columns("trim", [rotor_speed, pitch, torque, power], len(v))
    shown = (
        (omega * RPM, "rotor speed [rpm]"),
        (beta * DEGREES, "pitch [°]"),
        (load / 1e3, "torque [kN m]"),
        (energy / 1e6, "electrical power [MW]"),
    )
    with house_style():
        figure, panels = new_figure(2, 2, height=4.8, share_x=True)
        for axes, (values, label) in zip(panels, shown, strict=True):
            axes.plot(v, values, color=COLOURS[0])
            axes.set_ylabel(label)
            axes.set_ylim(bottom=min(0.0, float(values.min())))
        if published_pitch is not None:
            winds, angles = (np.asarray(part, dtype=np.float64) for part in published_pitch)
            panels[1].plot(
                winds, angles * DEGREES, "o", color=COLOURS[1], markersize=3.5, label="published"
            )
            panels[1].legend(loc="lower right")
        region_axes(panels, v, regions or {})
    return figure


def power_surface_figure(
    tip_speed_ratio: ArrayLike,
    pitch: ArrayLike,
    power_coefficient: ArrayLike,
    *,
    trim: tuple[ArrayLike, ArrayLike] | None = None,
    band: float | None = None,
) -> Figure:
    """Return c_P >= 0 over tip-speed ratio and pitch [deg], with the trim and its band.

    Parameters
    ----------
    tip_speed_ratio : (n,) [-];  pitch : (k,) [rad].
    power_coefficient : (k, n) [-], pitch along rows.
    trim : (tip-speed ratio, pitch [rad]) along the wind.
    band : half-width of the band around the trim in pitch [rad].
    """
    ratio = np.asarray(tip_speed_ratio, dtype=np.float64)
    beta = np.asarray(pitch, dtype=np.float64) * DEGREES
    surface = np.asarray(power_coefficient, dtype=np.float64)
    with house_style():
        figure, (axes,) = new_figure()
        levels = np.arange(0.0, max(0.05, float(surface.max())) + 0.05, 0.05)
        filled = axes.contourf(ratio, beta, surface, levels=levels, cmap=SEQUENTIAL)
        filled.set_edgecolor("face")
        filled.set_linewidth(0.4)
        if trim is not None:
            _trim_line(axes, trim, band)
        axes.set_facecolor("#f4f4f4")
        axes.set_xlabel("tip-speed ratio [-]")
        axes.set_ylabel("pitch [°]")
        axes.set_xlim(ratio[0], ratio[-1])
        axes.set_ylim(beta[0], beta[-1])
        axes.grid(False)
        figure.colorbar(filled, ax=axes, label="power coefficient [-]")
    return figure


def _trim_line(axes: Axes, trim: tuple[ArrayLike, ArrayLike], band: float | None) -> None:
    ratio, pitch = (np.asarray(part, dtype=np.float64) for part in trim)
    degrees = pitch * DEGREES
    axes.plot(ratio, degrees, color="white", linewidth=3.2)
    axes.plot(ratio, degrees, color=COLOURS[1], linewidth=1.8, label="trim over wind")
    if band is not None:
        for side, label in ((1, "band"), (-1, "_nolegend_")):
            shifted = degrees + side * band * DEGREES
            axes.plot(ratio, shifted, color=COLOURS[1], linestyle="--", linewidth=1.2, label=label)
    axes.legend(loc="upper right", frameon=True, framealpha=0.9)


LEVELS = np.linspace(0.0, 1.0, 11)


def membership_figure(
    rotor_speed: ArrayLike,
    torque: ArrayLike,
    memberships: ArrayLike,
    *,
    titles: Sequence[str],
    path: tuple[ArrayLike, ArrayLike] | None = None,
) -> Figure:
    """Return h^a_m(omega, T_g) as filled contours with one colour scale from 0 to 1.

    Parameters
    ----------
    rotor_speed : (n,) [rad/s]; shown in rpm.
    torque : (k,) high-speed shaft [N m]; shown in kN m.
    memberships : (4, k, n), torque along rows.
    titles : one per panel, such as the filter's corner ``"$h^a_1$: diag(0, 1)"``.
    path : (rotor speed, torque) of the trim curve, drawn over each panel.
    """
    omega = np.asarray(rotor_speed, dtype=np.float64) * RPM
    load = np.asarray(torque, dtype=np.float64) / 1e3
    weights = np.asarray(memberships, dtype=np.float64)
    with house_style():
        figure, panels = new_figure(2, 2, height=5.0)
        for k, (axes, text) in enumerate(zip(panels, titles, strict=True)):
            filled = _panel(axes, omega, load, weights[k])
            axes.set_title(text)
            if path is not None:
                _path(axes, *(np.asarray(part, dtype=np.float64) for part in path))
            if k >= 2:
                axes.set_xlabel("rotor speed [rpm]")
            if k % 2 == 0:
                axes.set_ylabel("torque [kN m]")
        figure.colorbar(filled, ax=panels, label="weight [-]", aspect=30)
    return figure


def _panel(axes: Axes, omega: Floats, load: Floats, weights: Floats) -> QuadContourSet:
    filled = axes.contourf(omega, load, np.clip(weights, 0.0, 1.0), levels=LEVELS, cmap=SEQUENTIAL)
    # Neighbouring patches would let the paper show between them.
    filled.set_edgecolor("face")
    filled.set_linewidth(0.4)
    axes.set_xlim(omega[0], omega[-1])
    axes.set_ylim(load[0], load[-1])
    axes.grid(False)
    return filled


def _path(axes: Axes, speeds: Floats, loads: Floats) -> None:
    axes.plot(speeds * RPM, loads / 1e3, color="white", linewidth=2.6)
    axes.plot(speeds * RPM, loads / 1e3, color="black", linewidth=1.2)
