"""The blend of two actuators: the range of each, its uncertainty, and the emitted law."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from takagi.reports.figures.plant.weights import hand_over_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.plant_motion import horizon, motions, starts
from takagi.reports.page.mathml import mathml, readable
from takagi.reports.page.text import DASH, Section, decimal, significant, table
from takagi.reports.sections.plant.plant import equations_latex

if TYPE_CHECKING:
    from takagi.models.blending.blending import Actuator, Blending, RunTimeBlending
    from takagi.reports.loops.plant_loop import PlantLoop
    from takagi.reports.loops.plant_motion import PlantMotion

# Limit of a motion's duration [s]: a plant with time constants of minutes takes hours to settle.
LONGEST = 1e5


def blend_section(loop: PlantLoop, blend: RunTimeBlending) -> Section:
    """Return the section about the blend of a loop."""
    simulated = hand_overs(loop)
    blending = blend.blending
    share = blending.share
    content: dict[str, Any] = {
        "laws": [mathml(line) for line in _laws(blending)],
        "equations": [mathml(readable(line)) for line in equations_latex(blending.plant)],
        "overlap": significant(float(blending.overlap)),
        "unit": blending.effort.unit,
        "ends": [decimal(float(end)) for end in (blending.efforts.lower, blending.efforts.upper)],
        "rest": decimal(float(blending.effort.rest)),
        "share": [significant(float(share.lower)), significant(float(share.upper))],
        "low": blending.low.name,
        "high": blending.high.name,
        "errors": [a.name for a in blending.actuators if a.error],
        "table": table(
            "actuators", (_row(blending, a, k, simulated) for k, a in enumerate(blending.actuators))
        ),
        "motions": captioned_figure(
            hand_over_figure(blend, simulated, float(loop.state[-1])), "hand-over", "blend"
        ),
    }
    return Section("blend", "Two actuators, one effort", content)


def hand_overs(loop: PlantLoop) -> tuple[PlantMotion, ...]:
    """Return motions that start with the first state, or the effort, at its largest or least."""
    named_starts = starts(loop)
    picked = [named_starts[0], named_starts[-1]]
    begin = [(name, x) for name, x in picked]
    begin += [
        (name.replace("largest", "least").replace("= ", "= \u2212"), -x) for name, x in picked
    ]
    return motions(loop, begin, duration=horizon(loop, longest=LONGEST))


def _laws(blending: Blending) -> list[str]:
    formulas = []
    for actuator in blending.actuators:
        sign = "+" if blending.sign(actuator) * actuator.direction > 0 else "-"
        effort = "U" if actuator is blending.high else "-U"
        name, b = actuator.name.replace("_", r"\_"), _latex(actuator.effectiveness)
        idle = actuator.variable.rest
        start = "" if idle == 0 else f"{decimal(float(idle))} {sign} "
        minus = "" if idle != 0 or sign == "+" else "-"
        formulas.append(rf"\mathrm{{{name}}} = {start}{minus}\frac{{\psi({effort})}}{{{b}}}")
    return formulas


def _latex(expression: Any) -> str:
    import sympy as sp

    return readable(str(sp.latex(expression)))


def _row(
    blending: Blending, actuator: Actuator, k: int, simulated: Sequence[PlantMotion]
) -> tuple[str, ...]:
    variable, e = actuator.variable, significant(float(blending.overlap))
    side = variable.range
    limits = DASH
    if side is not None:
        limits = f"{decimal(float(side.lower))} to {decimal(float(side.upper))}"
    commands = [motion.acting[:, k] for motion in simulated if len(motion.acting)]
    lowest = min((float(series.min()) for series in commands), default=float("nan"))
    highest = max((float(series.max()) for series in commands), default=float("nan"))
    return (
        variable.name,
        f"below {e} {blending.effort.unit}"
        if k == 0
        else f"above \u2212{e} {blending.effort.unit}",
        decimal(float(variable.rest)),
        limits,
        variable.unit,
        str(actuator.effectiveness).replace("**", "^"),
        f"\u00b1{significant(100 * float(actuator.error))} %" if actuator.error else "nothing",
        f"{significant(lowest)} to {significant(highest)}",
    )
