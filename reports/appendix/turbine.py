"""The appendix of a turbine: notation, plant, law, blending, margins of the loop, figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.result import TurbineDesign, claim_summary
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import optimal_tip_speed_ratio, rated_wind
from takagi.reports.appendix.tex import (
    NONE,
    Tex,
    decimal,
    escape,
    matrix,
    scientific,
    unit,
    with_decimals,
)
from takagi.reports.figures.operation import power_surface_figure, trim_figure
from takagi.reports.margins.margins import Margins
from takagi.reports.margins.running_search import SearchedMargins, wind_ranges
from takagi.reports.sections.turbine.cells import cells_drawing, filter_of, memberships_drawing
from takagi.reports.sections.turbine.model import region_starts, trim_curve
from takagi.reports.sections.turbine.responses import response_drawing
from takagi.reports.sections.turbine.running import margins_drawing
from takagi.reports.simulation.measured_loop import measured_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.reports.simulation.design_runs import DesignRun

DEGREES = 180 / np.pi
_SYMBOLS = {
    "rotor.radius": "R",
    "rotor.inertia": "J_r",
    "rotor.rated_speed": r"\omega_\mathrm{rated}",
    "rotor.air_density": r"\rho",
    "drivetrain.gear_ratio": "n_g",
    "generator.inertia": "J_g",
    "generator.rated_torque": r"T_\mathrm{rated}",
    "generator.maximum_torque": r"T_\mathrm{top}",
    "pitch.minimum": r"\beta_\mathrm{min}",
    "pitch.maximum": r"\beta_\mathrm{max}",
    "pitch.rate_limit": r"\dot\beta_\mathrm{max}",
    "pitch.time_constant": r"\tau_\beta",
    "operation.cut_in": r"v_\mathrm{in}",
    "operation.cut_out": r"v_\mathrm{out}",
}
# Sections of a turbine's file with published results and with another controller's numbers: nothing
# in the appendix depends on them.
_LEFT_OUT = ("reference", "baseline")


def _filters(design: TurbineDesign) -> Tex:
    """Return the filters of the measured speed in words; "" for none."""
    filters = design.speed_filter
    if filters is None:
        return Tex("")
    words = f"a low-pass of {decimal(filters.corner)}~rad/s"
    if filters.stop:
        stop, passed = decimal(filters.stop), decimal(filters.passed)
        words += f" behind a band-stop at {stop}~rad/s that passes {passed} of the amplitude"
    return Tex(words)


def plant_context(design: TurbineDesign) -> dict[str, object]:
    """Return the values for the sections on plant, surface, trim and observer."""
    turbine, setpoint = design.turbine, design.settings.speed_setpoint
    ratios, pitches = turbine.torque.x_range, [end * DEGREES for end in turbine.torque.y_range]
    # Cited here and nowhere else.
    reference = r" \cite{takagi-jonkman}" if "NREL 5-MW" in turbine.name else ""
    return {
        "parameter_caption": Tex(f"Figures of the turbine {escape(turbine.name)}, as its data file "
                                 f"gives them{reference}"),
        "turbine": turbine,
        "filters": _filters(design),
        "parameters": _parameters(turbine),
        "ratio_range": Tex(rf"$[{ratios[0]:g},\ {ratios[1]:g}]$"),
        "pitch_range": Tex(rf"$[{pitches[0]:.4g}^\circ,\ {pitches[1]:.4g}^\circ]$"),
        "setpoint": setpoint,
        "rated_wind": rated_wind(turbine, speed_setpoint=setpoint),
        "optimal_ratio": optimal_tip_speed_ratio(turbine),
        "observer": design.observer,
        "observer_gain": matrix([[gain] for gain in design.observer.gains]),
    }  # fmt: skip


def _parameters(turbine: Turbine) -> list[list[Tex]]:
    return [
        [
            escape(path.replace(".", ": ", 1).replace("_", " ")),
            Tex(f"${_SYMBOLS[path]}$") if path in _SYMBOLS else Tex(""),
            scientific(figure.value, 8),
            unit(figure.unit),
            escape(figure.source),
        ]
        for path, figure in turbine.figures.items()
        if path.partition(".")[0] not in _LEFT_OUT
    ]


def law_context(design: TurbineDesign) -> dict[str, Any]:
    """Return the law, its coupling filter with the count of rules, and a table of its gains."""
    law = design.effort_sharing_law
    context = {
        "law": design.law,
        "coherent": law is not None,
        "paper_law": isinstance(design.law, PublishedLaw),
        "coupling": filter_of(design),
        "n_b": len(design.partial_load.rules),
        "n_c": len(design.full_load.rules),
    }
    if law is None:
        return context
    nodes = range(len(law.schedule.wind))
    return context | {
        "gain_rows": [_gain_row(design, law, k) for k in nodes],
        "limited": design.effort is not None and bool(design.effort.torque_limited.any()),
    }


def _gain_row(design: TurbineDesign, law: EffortSharingLaw, k: int) -> list[Tex]:
    table, gains, turbine = law.schedule, law.gains, design.turbine
    wind = float(table.wind[k])
    last = k == len(table.wind) - 1
    limited = design.effort is not None and bool(design.effort.torque_limited[k])
    return [
        escape(k + 1),
        with_decimals(wind, 4),
        with_decimals(table.rotor_speed[k], 4),
        with_decimals(table.trim_effort[k], 5),
        with_decimals(table.pitch(wind, turbine) * DEGREES, 2),
        with_decimals(table.torque(wind, turbine) / 1e3, 2),
        with_decimals(law.pitch_share(wind), 3),
        with_decimals(table.effectiveness[k], 4),
        with_decimals(table.effectiveness_limit[k], 4),
        Tex(with_decimals(gains.proportional[k], 5) + (r"\rlap{$^\dagger$}" if limited else "")),
        NONE if last else with_decimals(gains.integral_rate[k], 6),
    ]


def margins_context(design: TurbineDesign) -> dict[str, Any]:
    """Return the margins of the loop that runs: at whole winds, and where one is least."""
    searched = measured_loop(design).margins
    every = sorted({row.wind for row in searched.rows})
    unstable = sorted({row.wind for row in searched.rows if row.decay_rate <= 0})
    winds = sorted((*searched.whole, *searched.least))
    rows = [_margin_row(searched, wind, loop) for wind in winds for loop in ("torque", "pitch")]
    return {
        "margin_rows": [row for row in rows if row is not None],
        "unstable": wind_ranges(unstable, every) if unstable else "",
        "without_equilibrium": wind_ranges(searched.none, [*searched.none, *every])
        if searched.none
        else "",
    }


def _margin_row(searched: SearchedMargins, wind: float, loop: str) -> list[Tex] | None:
    """Return gain [dB], phase [deg], delay [s] and disk margin; None where the loop is open."""
    plants = [dict(row.loops).get(loop) for row in searched.rows if row.wind == wind]
    if plants[0] is None:
        return None
    every = [_four(m) for m in plants if m is not None]
    cells = []
    for column, digits in zip(zip(*every, strict=True), (1, 1, 3, 2), strict=True):
        first, minimum = (with_decimals(value, digits) for value in (column[0], min(column)))
        cells.append(Tex(f"{first} ({minimum})"))
    return [decimal(wind), escape(loop), *cells]


def _four(m: Margins) -> tuple[float, float, float, float]:
    gain = 20 * np.log10(m.gain_increase) if m.gain_increase > 0 else 0.0
    return float(gain), m.phase * DEGREES, m.delay, m.disk.alpha


# The runs of the report that the appendix shows.
RESPONSES = ("gust", "step-up", "ramp")


def shown_runs(design: TurbineDesign) -> dict[str, DesignRun]:
    """Return the runs by name, as far as the design has them."""
    runs = measured_loop(design).drawn
    return {name: runs[name] for name in RESPONSES if name in runs}


def drawn_figures(design: TurbineDesign) -> dict[str, Figure]:
    """Return name -> figure; a figure without content is left out."""
    turbine, curve = design.turbine, trim_curve(design)
    ratio = np.linspace(*turbine.power.x_range, 90)
    pitch = np.linspace(*turbine.power.y_range, 80)
    figures = {
        "surface": power_surface_figure(turbine, curve, ratio=ratio, pitch=pitch),
        "trim": trim_figure(design, curve, region_starts(design)),
    }
    if design.effort_sharing_law is None:
        figures["memberships"] = memberships_drawing(design, filter_of(design))
    summary = claim_summary(design)
    if summary is not None and design.checked.verdict is Verdict.PROVED:
        figures["cells"] = cells_drawing(design, summary)
    margins = measured_loop(design).margins
    if margins.rows:
        figures["running-margins"] = margins_drawing(margins)
    runs = shown_runs(design).items()
    return figures | {f"response-{name}": response_drawing(design, run) for name, run in runs}
