"""Simulations over time: steps and gusts, and the scenario of the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.simulation.closed_loop import History
from takagi.models.turbine.data import Turbine
from takagi.reports.figures.style import (
    COLOURS,
    GREY,
    STYLES,
    columns,
    decimate,
    house_style,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# quantity: factor to the shown unit, label
QUANTITIES = {
    "wind": (1.0, "wind\n[m/s]"),
    "pitch": (180 / np.pi, "pitch\n[°]"),
    "torque": (1e-3, "torque\n[kN m]"),
    "rotor_speed": (30 / np.pi, "rotor speed\n[rpm]"),
    "power": (1e-6, "power\n[MW]"),
}


@dataclass(frozen=True, slots=True, eq=False)
class ResponseLine:
    """One simulated case, each array (n,) over the common time.

    Attributes
    ----------
    label : of the legend, such as the law's name.
    wind [m/s]; pitch [rad]; torque, high-speed shaft [N m]; rotor_speed [rad/s]; power [W].
    """

    label: str
    wind: Floats
    pitch: Floats
    torque: Floats
    rotor_speed: Floats
    power: Floats

    @classmethod
    def of(cls, label: str, run: History) -> ResponseLine:
        """Return the line of a simulated run."""
        return cls(label, run.wind, run.pitch, run.torque, run.rotor_speed, run.electrical_power)


def response_figure(
    time: ArrayLike,
    lines: Sequence[ResponseLine],
    *,
    title: str = "",
    rated: Mapping[str, float] | None = None,
) -> Figure:
    """Return five panels over time [s], one line per case in each.

    Parameters
    ----------
    time : (n,) [s].
    rated : figures drawn as thin horizontal lines, by quantity ("torque", "rotor_speed", "power",
        SI units).
    """
    t = np.asarray(time, dtype=np.float64)
    with house_style():
        figure, panels = new_figure(len(QUANTITIES), 1, height=7.0, share_x=True)
        for axes, (quantity, (factor, label)) in zip(panels, QUANTITIES.items(), strict=True):
            _panel(axes, t, lines, quantity, factor)
            axes.set_ylabel(label)
            if rated and quantity in rated:
                axes.axhline(factor * rated[quantity], color=GREY, linewidth=0.9, linestyle=":")
        panels[-1].set_xlabel("time [s]")
        panels[-1].set_xlim(t[0], t[-1])
        panels[0].set_title(title)
        if len(lines) > 1:
            handles, labels = panels[1].get_legend_handles_labels()
            per_row = 2 if len(lines) == 4 else 3
            figure.legend(handles, labels, loc="outside lower center", ncols=per_row)
    return figure


def _panel(
    axes: Axes, t: Floats, lines: Sequence[ResponseLine], quantity: str, factor: float
) -> None:
    values = columns(quantity, [getattr(line, quantity) for line in lines], len(t))
    if quantity == "wind" and all(np.array_equal(values[0], other) for other in values[1:]):
        # The same wind for all is one line, in no law's colour.
        axes.plot(*decimate(t, values[0]), color="#333333")
        return
    for line, value, colour, style in zip(lines, values, COLOURS, STYLES, strict=False):
        axes.plot(*decimate(t, factor * value), color=colour, linestyle=style, label=line.label)


ROWS = {
    "wind": "wind\n[m/s]",
    "pitch": "pitch\n[°]",
    "torque": "torque\n[p.u.]",
    "rotor_speed": "speed\n[p.u.]",
    "electrical_power": "power\n[p.u.]",
    "tower_displacement": "tower top\n[p.u.]",
}


def scenario_figure(
    runs: Sequence[tuple[str, str, History]], turbine: Turbine, *, title: str, total_points: int
) -> Figure:
    """Return six rows of panels with one column per law; one line per wind, one scale per row.

    Parameters
    ----------
    runs : (law, wind, series); laws and winds appear in the order of their first run.
    turbine : whose rated values are 1 p.u.
    total_points : shared by all lines: more show faster oscillations, and weigh more.
    """
    laws = list(dict.fromkeys(law for law, _, _ in runs))
    winds = dict.fromkeys(wind for _, wind, _ in runs)
    colours = dict(zip(winds, COLOURS, strict=False))
    points = max(80, min(1000, total_points // (len(ROWS) * len(runs))))
    drawn = [
        (law, wind, run.time, {**run.per_unit(turbine), "wind": run.wind, "pitch": run.pitch})
        for law, wind, run in runs
    ]
    with house_style():
        figure, panels = new_figure(len(ROWS), len(laws), height=8.2, share_x=True)
        for row, (quantity, label) in enumerate(ROWS.items()):
            factor = 180 / np.pi if quantity == "pitch" else 1.0
            strip = dict(zip(laws, panels[row * len(laws) :], strict=False))
            for law, wind, time, values in drawn:
                x, y = decimate(time, factor * values[quantity], points=points)
                strip[law].plot(x, y, color=colours[wind], linewidth=0.9, label=wind)
            _same_scale(list(strip.values()))
            strip[laws[0]].set_ylabel(label)
        _finish(figure, panels, laws, title)
    return figure


def _same_scale(strip: Sequence[Axes]) -> None:
    low = min(axes.get_ylim()[0] for axes in strip)
    high = max(axes.get_ylim()[1] for axes in strip)
    for k, axes in enumerate(strip):
        axes.set_ylim(low, high)
        if k:
            axes.tick_params(labelleft=False)


def _finish(figure: Figure, panels: Sequence[Axes], laws: Sequence[str], title: str) -> None:
    across = len(laws)
    for axes, law in zip(panels[:across], laws, strict=True):
        axes.set_title(law)
    for axes in panels[-across:]:
        axes.set_xlabel("time [s]")
        axes.margins(x=0)
    figure.suptitle(title, fontsize=10)
    named: dict[str, Artist] = {}
    for axes in panels[:across]:
        handles, labels = axes.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            named.setdefault(label, handle)
    figure.legend(
        list(named.values()), list(named), loc="outside lower center", ncols=min(len(named), 4)
    )
