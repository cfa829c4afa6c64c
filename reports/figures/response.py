"""Step and gust responses: wind, pitch, torque, speed, power under one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
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
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.models.simulation.closed_loop import History

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

    Raises
    ------
    ModelError : an array of another length than time, an unknown quantity in ``rated``, no or more
        than seven lines.
    """
    t = np.asarray(time, dtype=np.float64)
    unknown = set(rated or {}) - set(QUANTITIES)
    if unknown:
        raise ModelError(f"rated: unknown {sorted(unknown)}; known are {sorted(QUANTITIES)}")
    if not 1 <= len(lines) <= len(COLOURS):
        raise ModelError(f"{len(lines)} lines were given; 1 to {len(COLOURS)} can be told apart")
    with house_style():
        figure, panels = new_figure(len(QUANTITIES), 1, height=7.0, share_x=True)
        for axes, (quantity, (factor, label)) in zip(panels, QUANTITIES.items(), strict=True):
            _panel(axes, t, lines, quantity, factor)
            axes.set_ylabel(label)
            if rated and quantity in rated:
                axes.axhline(factor * rated[quantity], color=GREY, linewidth=0.9, linestyle=":")
        panels[-1].set_xlabel("time [s]")
        panels[-1].set_xlim(t[0], t[-1])
        figure.align_ylabels(panels)
        panels[0].set_title(title)
        if len(lines) > 1:
            handles, labels = panels[1].get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=min(len(lines), 4))
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
