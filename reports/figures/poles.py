"""Closed-loop poles over wind, and the decay rate they imply."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.reports.figures.style import COLOURS, GREY, ORDERED, house_style, new_figure, wind_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEPS = 22


def poles_figure(
    winds: ArrayLike,
    poles: Sequence[Complex],
    *,
    decay_rate: float | None = None,
    reach: float = 3.0,
    title: str = "",
) -> Figure:
    """Return the poles in the complex plane, coloured by wind, and -max Re over wind.

    Parameters
    ----------
    winds : (n,) [m/s].
    poles : one array per wind [1/s]; their number may differ.
    decay_rate : proved rate [1/s], drawn as a line in both panels.
    reach : poles further from the origin are left out of the plane [1/s]; the panel says how many.

    Raises
    ------
    ModelError : not as many pole sets as winds, or none.
    """
    v = np.asarray(winds, dtype=np.float64)
    if v.ndim != 1 or len(v) != len(poles) or len(v) == 0:
        raise ModelError(f"winds have shape {v.shape}, with {len(poles)} sets of poles; one each")
    with house_style():
        figure, (plane, rates) = new_figure(1, 2, height=4.2)
        _plane(figure, plane, v, poles, reach)
        slowest = np.array([-np.max(np.real(p)) for p in poles])
        rates.plot(v, slowest, color=COLOURS[0], marker="o", markersize=3.5)
        wind_axis(rates, ticks=6)
        rates.set_ylabel("decay of the slowest pole [1/s]")
        rates.set_ylim(min(0.0, 1.1 * float(slowest.min())), 1.15 * max(float(slowest.max()), 0.01))
        if decay_rate is not None:
            plane.axvline(-decay_rate, color=COLOURS[1], linestyle="--", linewidth=1.2)
            label = f"proved {decay_rate:.3g} 1/s"
            rates.axhline(decay_rate, color=COLOURS[1], linestyle="--", label=label)
            rates.legend(loc="upper left")
        figure.suptitle(title, fontsize=10)
    return figure


def _plane(figure: Figure, axes: Axes, v: Floats, poles: Sequence[Complex], reach: float) -> None:
    from matplotlib import colormaps

    every = np.concatenate([np.asarray(p, dtype=np.complex128) for p in poles])
    wind = np.concatenate([np.full(np.size(p), w) for p, w in zip(poles, v, strict=True)])
    near = np.abs(every) <= reach
    # A scale of few steps stays vector art; a smooth one would be written as an image.
    steps = colormaps[ORDERED].resampled(STEPS)
    dots = axes.scatter(
        every.real[near], every.imag[near], c=wind[near], cmap=steps, s=16, linewidths=0
    )
    axes.axvline(0.0, color=GREY, linewidth=0.9)
    axes.set_xlabel("real part [1/s]")
    axes.set_ylabel("imaginary part [rad/s]")
    hidden = int(np.sum(~near))
    if hidden:
        text = f"{hidden} poles beyond\n{reach:g} 1/s not shown"
        axes.text(0.02, 0.02, text, transform=axes.transAxes, fontsize=9, color=GREY)
    figure.colorbar(dots, ax=axes, label="wind [m/s]", location="top", shrink=0.9, aspect=30)
