"""The files of a tuned law: the front as table, data and figure, and the command of its best."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict

from takagi.reports.figures.style import COLOURS, GREY, figure_to_svg, house_style, new_figure
from takagi.reports.output import markdown_table, rows_csv
from takagi.reports.study.tuning import LEVERS, QUANTITIES, Candidate, Quantity, Tuning

FILES = ("front.md", "front.csv", "tuning.json")
FIGURE = "figures/front.svg"


def summary(tuning: Tuning, model: str) -> list[str]:
    """Return what came out, a sentence a line."""
    best, name = tuning.best, tuning.minimised.name
    asked = ", ".join(map(str, tuning.requirements)) or "nothing else"
    lines = [f"{tuning.tried} settings simulated; least {name} wanted, with {asked}"]
    if best is None:
        return [*lines, "No point of the front is PROVED: " + tuning.default.reason]
    if best.missed:
        missed = [
            f"{a.quantity.name} is {best.values[a.quantity.name]:.3g} {a.quantity.unit}".rstrip()
            for a in tuning.requirements
            if a.missed(best.values[a.quantity.name])
        ]
        lines.append("No PROVED point meets every requirement; nearest: " + ", ".join(missed))
    value, before = best.values[name], tuning.default.values[name]
    unit = f" {tuning.minimised.unit}".rstrip()
    lines.append(f"PROVED, {name} {value:.3g}{unit} (default {before:.3g}{unit}):")
    return [*lines, f"  takagi design {model} {best.command}"]


def tuning_files(tuning: Tuning, model: str) -> dict[str, str]:
    """Return relative name -> content."""
    points = (tuning.default, *tuning.front)
    rows = [_row(point, "default" if i == 0 else str(i)) for i, point in enumerate(points)]
    legend = "\n".join(
        f"- **{q.name}**{f' [{q.unit}]' if q.unit else ''}: {q.words}" for q in QUANTITIES
    )
    page = "\n\n".join(
        [
            f"# The effort-sharing law of {model}, tuned",
            "\n".join(f"    {line}" for line in summary(tuning, model)),
            f"![The front: {tuning.minimised.name} over what is required]({FIGURE})",
            markdown_table(rows),
            "Ratios are over the reference controller in the same winds, on the validation plant. "
            "A simulation proves nothing; *verdict* is that of the design with these settings.",
            legend,
        ]
    )
    data = {
        "minimised": tuning.minimised.name,
        "requirements": [str(asked) for asked in tuning.requirements],
        "tried": tuning.tried,
        "default": _plain(tuning.default),
        "front": [_plain(point) for point in tuning.front],
    }
    return {
        "front.md": page + "\n",
        "front.csv": rows_csv(rows),
        "tuning.json": json.dumps(data, indent=2) + "\n",
        FIGURE: _figure(tuning),
    }


def _row(point: Candidate, name: str) -> dict[str, str]:
    settings = {f"{v.option}{f' [{v.unit}]'}": f"{point.at[v.option]:g}" for v in LEVERS}
    values = {_label(q): f"{point.values[q.name]:.4g}" for q in QUANTITIES}
    return {"point": name, **settings, **values, "verdict": point.verdict or ""}


def _label(quantity: Quantity) -> str:
    return f"{quantity.name} [{quantity.unit or '-'}]"


def _plain(point: Candidate) -> Mapping[str, object]:
    return {**asdict(point), "values": dict(point.values)}


def _figure(tuning: Tuning) -> str:
    """Return the front: the minimised quantity over each required one."""
    others = [asked.quantity for asked in tuning.requirements] or [QUANTITIES[0]]
    limits = {asked.quantity.name: asked.limit for asked in tuning.requirements}
    with house_style():
        figure, axes = new_figure(1, len(others), width=2.6 * len(others), height=2.8)
        for axis, other in zip(axes, others, strict=True):
            for verdict, colour, marker in (("PROVED", COLOURS[0], "o"), ("", GREY, "x")):
                shown = [p for p in tuning.front if (p.verdict == "PROVED") == bool(verdict)]
                axis.plot(
                    [p.values[other.name] for p in shown],
                    [p.values[tuning.minimised.name] for p in shown],
                    marker,
                    color=colour,
                    label=verdict or "not proved",
                )
            default = tuning.default.values
            axis.plot(
                default[other.name], default[tuning.minimised.name], "s", color=COLOURS[1],
                label="default",
            )  # fmt: skip
            if other.name in limits:
                axis.axvline(limits[other.name], color=GREY, linestyle="--", label="required")
            axis.set_xlabel(_label(other))
        axes[0].set_ylabel(_label(tuning.minimised))
        axes[0].legend()
        return figure_to_svg(figure, name="front", description="The front of a tuned law")
