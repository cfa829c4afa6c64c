"""A turbine's finished design by wind: of every cell what is proved, gains, shares and margins.

All is read from the design's folder.  Margins are linear and gusts simulated, and they say so.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf, isfinite
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.design.turbine.result import ClaimSummary, TurbineDesign, claim_summary
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.reports.explore.axes import Axis, Steps
from takagi.reports.explore.books import Book
from takagi.reports.explore.plant_cell import Cell
from takagi.reports.margins.margins import Margins
from takagi.reports.margins.running_over_wind import COMMANDS, RunningMargins
from takagi.reports.page.text import at_least, at_most
from takagi.reports.sections.turbine.model import over_rated
from takagi.reports.sections.turbine.summary import (
    LINEAR,
    REFERENCE,
    SIMULATED,
    gain_margin,
    phase_margin,
    proved_claim,
)
from takagi.reports.simulation.measured_loop import NOTHING, MeasuredLoop

NO_SET = "The set and the bound of rotor speed are not proved."


def turbine_book(design: TurbineDesign, folder: Path) -> Book:
    """Return the book of a design that was read from a folder.

    Raises
    ------
    ModelError : a law without wind cells.
    """
    law, summary = design.effort_sharing_law, claim_summary(design)
    if law is None or summary is None:
        raise ModelError(
            f"{folder}: its law has no wind cells to turn; {folder}/report.html has its numbers, "
            "and 'takagi design MODEL --law effort-sharing' makes a law with cells"
        )
    words = tuple(f"{low:g} to {high:g} m/s" for low, high in summary.winds)
    axis = Axis("wind", "Schedule wind", tuple({} for _ in words), words)
    measured = design.measured if isinstance(design.measured, MeasuredLoop) else NOTHING
    cells: dict[Steps, Cell] = {
        (k,): _cell(design, law, summary, measured, k) for k in range(len(words))
    }
    return Book(
        design.name,
        (axis,),
        cells,
        list(cells),
        lambda _: shlex.join(["takagi", "check", str(folder)]),
        _panels(law, summary, measured),
    )


def _cell(
    design: TurbineDesign,
    law: EffortSharingLaw,
    summary: ClaimSummary,
    measured: MeasuredLoop,
    k: int,
) -> Cell:
    low, high = summary.winds[k]
    # A motion may pass through every cell: with one of them open the set holds in none.
    of_set = summary.verdict is Verdict.PROVED and summary.proved[k]
    proved = design.proved and of_set
    error, rate = at_least(summary.wind_error[k]), at_least(summary.wind_rate[k])
    over = 100 * over_rated(design, summary)[k]
    share = at_most(over).removeprefix("-")
    bound = f"at most {share} % above" if over >= 0 else f"at least {share} % below"
    sentence = (
        f"While the wind is within {error} m/s of the law's schedule wind, and that moves at most "
        f"{rate} m/s², rotor speed is proved to stay {bound} rated."
    )
    limits = f"wind within {error} m/s of the schedule wind, which moves at most {rate} m/s²"
    decay = f"at least {at_least(summary.decay_rates[k])} 1/s, constant known wind"
    rows = [
        *([_row("wind limits", limits), _row("decay", decay)] if of_set else []),
        *_claim_rows(design, law, low, high),
        *_margin_rows(measured.margins.rows, (low + high) / 2),
        *_run_rows(measured, (low + high) / 2),
    ]
    shares = [law.pitch_share(wind) for wind in (low, high)]
    table = {
        "share of pitch at the trim [-]": shares,
        "share of torque at the trim [-]": [1 - share for share in shares],
        "proportional gain [1/s]": list(law.gains.proportional[k : k + 2]),
        "integral rate [1/s]": [law.gains.integral_rate[k]] * 2,
        "pitch effectiveness [rad/s^2 per rad]": list(law.schedule.effectiveness[k : k + 2]),
    }
    return {
        "proved": proved,
        "verdict": "PROVED" if proved else f"{design.verdict_words}: not all is proved here",
        "sentence": sentence if of_set else NO_SET,
        "rows": rows,
        "gains": {
            "columns": [f"at {wind:g} m/s" for wind in (low, high)],
            "labels": list(table),
            "rows": [[f"{value:.5g}" for value in values] for values in table.values()],
        },
        "at": [low, high],
        "claims": [[claim.name, claim.verdict.name] for claim in design.checked.claims],
    }


def _claim_rows(
    design: TurbineDesign, law: EffortSharingLaw, low: float, high: float
) -> Iterator[Mapping[str, str]]:
    """Yield what the other proved claims say of a cell."""
    if (known := proved_claim(design, "wind-rate")) is not None:
        limits = known[0]["ranges"][0]
        nodes = zip(limits["wind"], limits["estimate_rate"], strict=True)
        rates = [float(rate) for wind, rate in nodes if low <= float(wind) <= high]
        if rates:
            yield _row("known wind", f"may move at most {at_least(min(rates))} m/s²")
    spans_of_law = list(pairwise(law.schedule.wind.tolist()))
    smooth = proved_claim(design, "bumpless")
    if smooth is not None and (low, high) in spans_of_law:
        # Its cells are those of the law's tables.
        cell = smooth[0]["cells"][spans_of_law.index((low, high))]
        torque, pitch = (at_most(float(cell[f"{of}_rate"])) for of in COMMANDS)
        text = f"no jump; torque moves at most at {torque} N m/s, pitch at {pitch} rad/s"
        yield _row("commands", text)
    if (running := proved_claim(design, "running-loop")) is not None:
        if any(float(a) <= low and high <= float(b) for a, b in running[0]["winds"]):
            rate = at_least(float(running[0]["decay_rate"]))
            yield _row("with observer", f"decays with at least {rate} 1/s, constant wind")


def _margin_rows(rows: Sequence[RunningMargins], middle: float) -> Iterator[Mapping[str, str]]:
    """Yield the margins of the loop that runs nearest to a cell: as the file says, and least."""
    if not rows:
        text = "not in this folder; 'takagi design' without --no-report measures them"
        yield _row("margins", text, LINEAR)
    measured_winds = {row.wind for row in rows if not row.nominal}
    for name, chosen in (
        ("margins", [row for row in rows if row.nominal]),
        ("all plants", [row for row in rows if row.wind in measured_winds]),
    ):
        if chosen:
            wind = min((row.wind for row in chosen), key=lambda at: abs(at - middle))
            pairs = [pair for row in chosen if row.wind == wind for pair in row.loops]
            words = "; ".join(
                f"{loop} {_least([m for name, m in pairs if name == loop])}"
                for loop in dict.fromkeys(loop for loop, _ in pairs)
            )
            yield _row(f"{name} at {wind:g} m/s", words or "no loop", LINEAR)


def _least(margins: Sequence[Margins]) -> str:
    """Return the least gain and phase margin in words."""
    if not all(m.stable for m in margins):
        return "unstable"
    gain, phase = min(map(gain_margin, margins)), min(map(phase_margin, margins))
    words = f"{gain:.3g} dB" if isfinite(gain) else "any gain"
    return f"{words} and {phase:.3g} deg" if isfinite(phase) else words


def _run_rows(measured: MeasuredLoop, wind: float) -> Iterator[Mapping[str, str]]:
    """Yield the nearest gust and turbulence that were simulated."""
    gusts = [run for run in measured.runs if run.name in ("gust", "")]
    if gusts:
        run = min(gusts, key=lambda run: abs(run.wind - wind))
        text = f"{run.law.metrics.overspeed:.1f} % overspeed in the {run.words}"
        if run.reference is not None:
            text += f"; {REFERENCE} {run.reference.metrics.overspeed:.1f} %"
        yield _row("gust", text, SIMULATED)
    mean = min(measured.turbulent, key=lambda mean: abs(mean - wind), default=None)
    if mean is not None and isfinite(share := 100 * measured.turbulent[mean].share_inside):
        text = f"of class B at {mean:g} m/s: within the wind limits {share:.0f} % of the time"
        yield _row("turbulence", text, SIMULATED)


def _row(name: str, text: str, basis: str = "proved") -> Mapping[str, str]:
    return {"name": name, "text": text, "basis": basis, "shortfall": ""}


def _panels(
    law: EffortSharingLaw, summary: ClaimSummary, measured: MeasuredLoop
) -> list[Mapping[str, Any]]:
    """Return the lines that the page draws over wind."""
    wind = law.schedule.wind.tolist()
    middle = [(low + high) / 2 for low, high in summary.winds]
    pitch = [law.pitch_share(value) for value in wind]
    shares = {"pitch": (wind, pitch), "torque": (wind, [1 - p for p in pitch])}
    gains = {
        "proportional": (wind, list(law.gains.proportional)),
        "integral rate": (middle, list(law.gains.integral_rate[: len(middle)])),
    }
    panels = [_panel("Share at the trim", "-", shares), _panel("Gains", "1/s", gains)]
    if summary.verdict is Verdict.PROVED:
        limits = {"|v − v_s|": (middle, summary.wind_error)}
        panels.append(_panel("Proved wind limit", "m/s", limits))
    if nominal := [row for row in measured.margins.rows if row.nominal]:
        lines = {}
        for loop in COMMANDS:
            margins = [dict(row.loops).get(loop) for row in nominal]
            sizes = [inf if m is None or not m.stable else gain_margin(m) for m in margins]
            lines[loop] = [row.wind for row in nominal], sizes
        panels.append(_panel("Gain margin, not proved", "dB", lines))
    return panels


def _panel(
    title: str, unit: str, lines: Mapping[str, tuple[Sequence[float], Sequence[float]]]
) -> Mapping[str, Any]:
    shown = [
        {
            "name": name,
            "x": [float(x) for x in xs],
            "y": [float(f"{y:.4g}") if isfinite(y) else None for y in ys],
        }
        for name, (xs, ys) in lines.items()
    ]
    return {"title": title, "unit": unit, "lines": shown}
