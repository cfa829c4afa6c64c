"""The blending weights h^a_m over rotor speed and generator torque: four contour panels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.figures.style import SEQUENTIAL, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure

RPM = 30 / np.pi
LEVELS = np.linspace(0.0, 1.0, 11)


def membership_figure(
    rotor_speed: ArrayLike,
    torque: ArrayLike,
    memberships: ArrayLike,
    *,
    titles: Sequence[str] = ("$h^a_1$", "$h^a_2$", "$h^a_3$", "$h^a_4$"),
    path: tuple[ArrayLike, ArrayLike] | None = None,
    title: str = "",
) -> Figure:
    """Return h^a_m(omega, T_g) as filled contours with one colour scale from 0 to 1.

    Parameters
    ----------
    rotor_speed : (n,) [rad/s]; shown in rpm.
    torque : (k,) high-speed shaft [N m]; shown in kN m.
    memberships : (4, k, n), torque along rows.
    titles : one per panel, such as the filter's corner ``"$h^a_1$: diag(0, 1)"``.
    path : (rotor speed, torque) of the trim curve, drawn over each panel.

    Raises
    ------
    ModelError : shapes that do not fit.
    """
    omega = np.asarray(rotor_speed, dtype=np.float64) * RPM
    load = np.asarray(torque, dtype=np.float64) / 1e3
    weights = np.asarray(memberships, dtype=np.float64)
    if weights.shape != (4, load.size, omega.size) or len(titles) != 4:
        raise ModelError(
            f"memberships have shape {weights.shape} and {len(titles)} titles; needed: "
            f"(4, {load.size}, {omega.size}), four titles"
        )
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
        figure.suptitle(title, fontsize=10)
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
