"""Linear loops: Bode plots, margins over wind of the loop that runs, poles, motions of a plant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Complex, Floats
from takagi.reports.figures.style import (
    COLOURS,
    GREY,
    STYLES,
    columns,
    decimate,
    house_style,
    marks_above,
    new_figure,
    shades,
    wind_axis,
)
from takagi.reports.loops.plant_loop import PlantLoop
from takagi.reports.loops.plant_motion import PlantMotion
from takagi.reports.margins.margins import Margins
from takagi.reports.margins.response import LoopResponse

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LEGEND_COLUMNS = 2
# Below this gain the loop is treated as open: -200 dB is not a gain.
SILENT = 1e-10


class BodeLine(NamedTuple):
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
    frequency: ArrayLike, lines: Sequence[BodeLine], *, marks: Mapping[str, float] | None = None
) -> Figure:
    """Return magnitude [dB] and phase [deg] over frequency [rad/s].

    Parameters
    ----------
    frequency : (n,) [rad/s], increasing.
    lines : from low to high wind; coloured from dark to light.  A filled dot is the crossover with
        its phase margin, an open one the phase crossover with its gain margin; both figures stand
        in the legend.
    marks : labelled vertical lines [rad/s], such as ``{"tower 0.32 Hz": 2.04, "3P": 3.80}``.
    """
    omega = np.asarray(frequency, dtype=np.float64)
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
    return figure


def _draw(top: Axes, bottom: Axes, omega: Floats, line: BodeLine, colour: str) -> None:
    decibels = 20 * np.log10(np.maximum(np.abs(line.response), SILENT))
    phase = np.degrees(np.unwrap(np.angle(line.response)))
    # Whole turns are free: the crossover, or the lowest frequency, lies in [-360, 0) degrees.
    known = [w for w in (line.crossover, omega[0]) if w and omega[0] <= w <= omega[-1]]
    phase -= 360.0 * (np.floor(np.interp(known[0], omega, phase) / 360.0) + 1.0)
    label = f"{line.label}:"
    for where, filled in ((line.crossover, True), (line.phase_crossover, False)):
        if where is None or not omega[0] <= where <= omega[-1]:
            continue
        gain = float(np.interp(where, omega, decibels))
        angle = float(np.interp(where, omega, phase))
        style: Any = {"color": colour, "marker": "o", "markersize": 5.0, "linestyle": "none"}
        for axes, value in ((top, gain), (bottom, angle)):
            axes.plot([where], [value], markerfacecolor=colour if filled else "white", **style)
        label += f" PM {abs(angle % 360.0 - 180.0):.0f}°" if filled else f" GM {-gain:.1f} dB"
    top.plot(*decimate(omega, decibels), color=colour, label=label.rstrip(":"))
    bottom.plot(*decimate(omega, phase), color=colour)


def _finish(figure: Figure, top: Axes, bottom: Axes, omega: Floats) -> None:
    from matplotlib.ticker import MultipleLocator

    top.set_xscale("log")
    top.set_xlim(omega[0], omega[-1])
    top.set_ylabel("|L| [dB]")
    bottom.set_ylabel("phase of L [°]")
    bottom.set_xlabel("frequency [rad/s]")
    low, high = bottom.get_ylim()
    bottom.yaxis.set_major_locator(MultipleLocator(90.0 * max(1, round((high - low) / 540.0))))
    top.axhline(0.0, color=GREY, linewidth=0.8)
    bottom.axhline(-180.0, color=GREY, linewidth=0.8)
    figure.legend(loc="outside lower center", ncols=LEGEND_COLUMNS)


# Where a margin has no bound its line ends; more than these is more than enough.
PANELS = {
    "gain": ("gain may grow by [-]", (1.0, 10.0)),
    "phase": ("phase [°]", (0.0, 120.0)),
    "delay": ("delay [s]", (0.01, 20.0)),
    "disk": ("disk $\\alpha$ [-]", (0.0, 2.0)),
}
LOGARITHMIC = ("gain", "delay")


class MarginLine(NamedTuple):
    """One loop over wind: panel -> margins (n,), nan where it does not act.

    ``nominal`` are those of the machine as its file says, ``least`` the least of all, nan where the
    others were not examined.
    """

    label: str
    nominal: Mapping[str, Floats]
    least: Mapping[str, Floats]


def running_margins_figure(winds: Floats, lines: Sequence[MarginLine]) -> Figure:
    """Return four panels over wind: gain, phase, delay, disk; bands reach to the least."""
    with house_style():
        figure, panels = new_figure(2, 2, height=5.2, share_x=True)
        for axes, (name, (label, (low, high))) in zip(panels, PANELS.items(), strict=True):
            for line, colour in zip(lines, COLOURS, strict=False):
                both = [line.nominal[name], line.least[name]]
                shown, least = columns(f"{line.label}, {name}", both, len(winds))
                known = ~np.isnan(least)
                axes.plot(winds, np.clip(shown, low, high), color=colour, label=line.label)
                axes.fill_between(
                    winds[known],
                    np.clip(least[known], low, high),
                    np.clip(shown[known], low, high),
                    color=colour,
                    alpha=0.25,
                    linewidth=0,
                )
            axes.set_ylabel(label)
            if name in LOGARITHMIC:
                axes.set_yscale("log")
            axes.set_ylim(low, high)
            wind_axis(axes, ticks=6)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def equilibrium_poles(loop: PlantLoop) -> tuple[Complex, Complex]:
    """Return the poles where the plant rests: without the law, and with it (empty if none)."""
    matrices, K = loop.at_rest()
    alone = np.linalg.eigvals(matrices.A).astype(np.complex128)
    if K is None:
        return alone, np.zeros(0, dtype=np.complex128)
    if loop.observed is not None:
        return alone, loop.observed.poles_at(loop.memberships(np.zeros(len(loop.names))))
    return alone, np.linalg.eigvals(matrices.A - matrices.B @ K).astype(np.complex128)


MOST_PANELS = 10


class Panel(NamedTuple):
    """A quantity over time: its label, a series for each motion, and whether it is held."""

    label: str
    series: Sequence[Floats]
    held: bool = False


def responses_figure(loop: PlantLoop, motions: Sequence[PlantMotion]) -> Figure:
    """Return one panel per state (deviation), per input, and one for V over its level."""
    labels = [*loop.model.states, *(f"{v.name} [{v.unit}]" for v in loop.plant.inputs)]
    if loop.gains is None:
        labels = labels[: len(loop.names)]
    values = [np.column_stack((motion.state, motion.input)) for motion in motions]
    panels = [
        Panel(label.replace(" [", "\n["), [each[:, k] for each in values], loop.discrete)
        for k, label in enumerate(labels[:MOST_PANELS])
    ]

    def at_rest(axes: Axes, k: int) -> None:
        if k < len(panels):
            axes.axhline(0.0, color=GREY, lw=0.7)

    return motions_figure(motions, panels, at_rest)


def motions_figure(
    motions: Sequence[PlantMotion],
    panels: Sequence[Panel],
    finish: Callable[[Axes, int], None],
    *,
    height: float = 1.25,
    legend_columns: int = 3,
) -> Figure:
    """Return the panels over time with a line for each motion, and one for V where it is known.

    Parameters
    ----------
    finish : called with the axes of each panel and its number, that of V the last.
    height : of a panel [in].
    """
    lines = list(zip(motions, COLOURS, STYLES, strict=False))
    valued = bool(motions[0].value.size)
    rows = len(panels) + valued
    with house_style():
        figure, every = new_figure(rows, 1, height=height * rows + 1.0, share_x=True)
        for k, (axes, panel) in enumerate(zip(every, panels, strict=False)):
            for (motion, colour, style), series in zip(lines, panel.series, strict=False):
                axes.plot(
                    *decimate(motion.time, series),
                    color=colour, linestyle=style, label=motion.name,
                    drawstyle="steps-post" if panel.held else "default",
                )  # fmt: skip
            finish(axes, k)
            axes.set_ylabel(panel.label)
        if valued:
            for motion, colour, style in lines:
                keep = motion.value > 1e-9
                every[-1].semilogy(
                    motion.time[keep], motion.value[keep], color=colour, linestyle=style
                )
            finish(every[-1], len(panels))
            every[-1].set_ylabel("V / level\n[-]")
        every[-1].set_xlim(0.0, max(float(motion.time[-1]) for motion in motions))
        every[-1].set_xlabel("time [s]")
        handles, names = every[0].get_legend_handles_labels()
        columns = min(len(names), legend_columns)
        figure.legend(handles, names, loc="outside lower center", ncols=columns)
    return figure
