"""Bode plots of one loop at several winds: crossover, margins, and modes to avoid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.reports.figures.style import (
    GREY,
    decimate,
    house_style,
    marks_above,
    new_figure,
    shades,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.reports.margins import LoopResponse, Margins

LEGEND_COLUMNS = 2
# Below this gain the loop is treated as open: -200 dB is not a gain.
SILENT = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class BodeLine:
    """One loop of a Bode plot.

    Attributes
    ----------
    label : such as ``"12 m/s"``.
    response : L(j omega) (n,) complex, negative-feedback convention.
    crossover : where |L| = 1 and the phase margin is read [rad/s]; None or nan draws no mark.
    phase_crossover : where L is negative real and the gain margin is read [rad/s]; likewise.
    """

    label: str
    response: Complex
    crossover: float | None = None
    phase_crossover: float | None = None


def bode_line(label: str, loop: LoopResponse, margins: Margins, omega: Floats) -> BodeLine:
    """Return a loop at the frequencies omega [rad/s], with the places of its margins."""
    places = (margins.phase_frequency, margins.gain_increase_frequency)
    if not margins.stable:
        # An unstable loop has crossings too, but no margins: none are marked.
        label, places = f"{label}, unstable", (np.nan, np.nan)
    marked = (float(w) if np.isfinite(w) else None for w in places)
    return BodeLine(label, loop.evaluate(omega)[:, 0, 0], *marked)


def bode_figure(
    frequency: ArrayLike,
    lines: Sequence[BodeLine],
    *,
    title: str = "",
    marks: Mapping[str, float] | None = None,
) -> Figure:
    """Return magnitude [dB] and phase [deg] over frequency [rad/s].

    Parameters
    ----------
    frequency : (n,) [rad/s], increasing.
    lines : from low to high wind; coloured from dark to light.  A filled dot is the crossover with
        its phase margin, an open one the phase crossover with its gain margin; both figures stand
        in the legend.
    marks : labelled vertical lines [rad/s], such as ``{"tower 0.32 Hz": 2.04, "3P": 3.80}``.

    Raises
    ------
    ModelError : a response of another length than the frequencies, or no lines.
    """
    omega = np.asarray(frequency, dtype=np.float64)
    _check(omega, lines)
    with house_style():
        figure, (top, bottom) = new_figure(2, 1, share_x=True, height=5.0)
        active = [line for line in lines if np.any(np.abs(line.response) >= SILENT)]
        for line, colour in zip(active, shades(len(active)), strict=True):
            _draw(top, bottom, omega, line, colour)
        idle = [line.label for line in lines if line not in active]
        if idle:
            top.plot([], [], " ", label=f"loop does not act: {', '.join(idle)}")
        _finish(figure, top, bottom, omega)
        marks_above(top, marks or {})
        for where in (marks or {}).values():
            bottom.axvline(where, color=GREY, linestyle=":", linewidth=1.0)
        figure.suptitle(title, fontsize=10)
    return figure


def _check(omega: Floats, lines: Sequence[BodeLine]) -> None:
    if not lines:
        raise ModelError("no lines were given; a Bode plot needs at least one loop")
    for line in lines:
        if np.shape(line.response) != omega.shape:
            raise ModelError(
                f"{line.label}: response has shape {np.shape(line.response)}, but "
                f"{omega.shape} frequencies were given"
            )


def _draw(top: Axes, bottom: Axes, omega: Floats, line: BodeLine, colour: str) -> None:
    decibels = 20 * np.log10(np.maximum(np.abs(line.response), SILENT))
    unwrapped = np.degrees(np.unwrap(np.angle(line.response)))
    label = f"{line.label}:"
    for where, filled in ((line.crossover, True), (line.phase_crossover, False)):
        if where is None or not omega[0] <= where <= omega[-1]:
            continue
        gain = float(np.interp(where, omega, decibels))
        angle = float(np.interp(where, omega, unwrapped)) % 360.0 - 360.0
        style: Any = {"color": colour, "marker": "o", "markersize": 5.0, "linestyle": "none"}
        for axes, value in ((top, gain), (bottom, angle)):
            axes.plot([where], [value], markerfacecolor=colour if filled else "white", **style)
        label += f" PM {abs(angle + 180.0):.0f}°" if filled else f" GM {-gain:.1f} dB"
    top.plot(*decimate(omega, decibels), color=colour, label=label.rstrip(":"))
    # One turn of phase is shown, so -180 degrees is one line even if a resonance adds whole turns.
    for turn in range(int(unwrapped.min() // 360), int(unwrapped.max() // 360) + 1):
        part = unwrapped - 360.0 * (turn + 1)
        shown = (part >= -400.0) & (part <= 40.0)
        near = np.convolve(shown, [1, 1, 1], mode="same") > 0
        bottom.plot(omega, np.where(near, part, np.nan), color=colour)


def _finish(figure: Figure, top: Axes, bottom: Axes, omega: Floats) -> None:
    top.set_xscale("log")
    top.set_xlim(omega[0], omega[-1])
    top.set_ylabel("|L| [dB]")
    bottom.set_ylabel("phase of L [°]")
    bottom.set_xlabel("frequency [rad/s]")
    bottom.set_yticks(np.arange(-360, 1, 90))
    bottom.set_ylim(-360.0, 0.0)
    top.axhline(0.0, color=GREY, linewidth=0.8)
    bottom.axhline(-180.0, color=GREY, linewidth=0.8)
    figure.legend(loc="outside lower center", ncols=LEGEND_COLUMNS)
