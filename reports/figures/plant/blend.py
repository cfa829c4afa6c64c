"""Two actuators behind a blend: over the effort, and over a motion through the hand-over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ramps import effort_ramp, effort_ramp_slope
from takagi.reports.figures.plant.responses import finish_over_time
from takagi.reports.figures.style import COLOURS, GREY, STYLES, decimate, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from takagi.models.blending.blending import Actuator
    from takagi.models.blending.run_time import RunTimeBlending
    from takagi.reports.loops.plant_motion import PlantMotion

LINE = 401
SHADE = "#eeeeee"


@dataclass(frozen=True, slots=True, eq=False)
class BlendCurve:
    """A blend over the effort, the other states at rest.

    Attributes
    ----------
    effort : (k,) over its range.
    delivered, commands : (k, 2) of the low and the high actuator.
    slope : (k,) psi', the high actuator's share of a small change of effort.
    """

    effort: Floats
    delivered: Floats
    commands: Floats
    slope: Floats


def blend_curve(blend: RunTimeBlending, rest: Floats) -> BlendCurve:
    """Return the curves of a blend; ``rest`` (n,) is where the other states are."""
    efforts, e = blend.blending.efforts, float(blend.blending.overlap)
    effort = np.linspace(float(efforts.lower), float(efforts.upper), LINE)
    states = np.tile(np.asarray(rest, dtype=np.float64), (LINE, 1))
    states[:, -1] = effort
    return BlendCurve(
        effort,
        np.column_stack((-effort_ramp(-effort, e), effort_ramp(effort, e))),
        np.array([blend.commands(x) for x in states]),
        effort_ramp_slope(effort, e),
    )


def actuators_figure(blend: RunTimeBlending, curve: BlendCurve) -> Figure:
    """Return four panels over the effort: what each actuator delivers, shares, and commands."""
    given = blend.blending
    unit, e = given.effort.unit, float(given.overlap)
    names = [a.name for a in given.actuators]
    with house_style():
        figure, panels = new_figure(4, 1, height=8.0, share_x=True)
        for axes in panels:
            axes.axvspan(-e, e, color=SHADE, zorder=0)
            axes.axvline(float(given.effort.rest), color=GREY, lw=0.8, ls=":")
        for k, name in enumerate(names):
            style: Any = {"color": COLOURS[k], "linestyle": STYLES[k], "label": name}
            panels[0].plot(curve.effort, curve.delivered[:, k], **style)
            share = curve.slope if k else 1 - curve.slope
            panels[1].plot(curve.effort, share, **style)
            panels[2 + k].plot(curve.effort, curve.commands[:, k], **style)
            _limits(panels[2 + k], given.actuators[k])
        panels[0].plot(curve.effort, curve.effort, color=GREY, lw=0.8, label="both together")
        panels[0].set_ylabel(f"delivered\n[{unit}]")
        panels[1].set_ylabel("share of a\nchange [-]")
        panels[3].set_xlabel(f"effort [{unit}]")
        panels[3].set_xlim(curve.effort[0], curve.effort[-1])
        figure.align_ylabels(panels)
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def hand_over_figure(
    blend: RunTimeBlending, motions: Sequence[PlantMotion], effort_rest: float
) -> Figure:
    """Return the effort and both actuators over time, a line for each motion.

    Raises
    ------
    ModelError : no motions.
    """
    if not motions:
        raise ModelError("no motions were given; at least one is needed")
    given, e = blend.blending, float(blend.blending.overlap)
    lines = list(zip(motions, COLOURS, STYLES, strict=False))
    with house_style():
        figure, panels = new_figure(3, 1, height=6.0, share_x=True)
        panels[0].axhspan(-e, e, color=SHADE, zorder=0)
        for motion, colour, style in lines:
            rows = np.column_stack((motion.state[:, -1] + effort_rest, motion.acting))
            for axes, series in zip(panels, rows.T, strict=True):
                axes.plot(
                    *decimate(motion.time, series), color=colour, linestyle=style, label=motion.name
                )
        panels[0].set_ylabel(f"effort\n[{given.effort.unit}]")
        for axes, actuator in zip(panels[1:], given.actuators, strict=True):
            axes.set_ylabel(f"{actuator.name}\n[{actuator.variable.unit}]")
        finish_over_time(figure, panels, motions)
    return figure


def _limits(axes: Axes, actuator: Actuator) -> None:
    variable = actuator.variable
    axes.set_ylabel(f"{variable.name}\n[{variable.unit}]")
    if variable.range is not None:
        for end in (variable.range.lower, variable.range.upper):
            axes.axhline(float(end), color=GREY, lw=0.8, ls="--")
