"""What a turbine's design is worth, as figures: made once from claims, margins and simulations.

Terminal, report and JSON show the same rows.  A row follows from one proved claim, whose name and
assumptions it has, or it says that its figures are linear or simulated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import degrees, inf, isnan, log10, pi
from typing import Any

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.claims.turbine.published import gaps
from takagi.certificates.design.turbine.result import TurbineDesign, claim_summary
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.reports.loops.plant_claims import (
    SETTLED,
    gap_words,
    norm_settling_time,
    overlap_claims,
    span_words,
    wind_words,
)
from takagi.reports.margins.margins import Margins
from takagi.reports.margins.running_over_wind import RunningMargins
from takagi.reports.page.text import at_least, at_most
from takagi.reports.sections.plant.summary import NORM, Number, SummaryRow
from takagi.reports.simulation.measured_loop import DesignRun, measured_loop

RPM = 30 / pi
# From this difference on an overspeed is called worse [% of rated].
WORSE_BY = 1.0
# Margins that are usually asked for [dB], [deg]: Astrom & Murray (2021), Feedback Systems, ch. 10.
USUAL_GAIN, USUAL_PHASE = 6.0, 30.0
REFERENCE = "reference controller"
LINEAR, SIMULATED = "linear loop that runs, not proved", "simulated"


def summary_rows(design: TurbineDesign) -> list[SummaryRow]:
    """Return the rows on a design; claims that are not proved have none but ``not proved``."""
    of_set, measured = list(_set_rows(design)), measured_loop(design)
    open_ = [claim.name for claim in design.checked.claims if claim.verdict is not Verdict.PROVED]
    return [
        *_overlaps(design),
        *of_set[:2],
        *_turbulence(measured.turbulent),
        *_overspeed(measured.runs, measured.drawn.get("gust")),
        *of_set[2:3],
        *_observer(design),
        *_margins(measured.margins.rows),
        *of_set[3:],
        *_wind_rate(design),
        *_setpoints(design),
        *_actuators(design),
        *_gains(design.effort_sharing_law),
        *([_row("not proved", open_, basis="claimed", shortfall="open")] if open_ else []),
        _not_covered(design),
    ]


def summary_sentence(design: TurbineDesign) -> str:
    """Return what is proved, and what is not, in a sentence or two of plain English."""
    rows = {row.name: row for row in summary_rows(design)}
    if "rotor speed" in rows:
        low, high = (number.value for number in rows["rotor speed"].numbers[2:])
        sentences = [
            f"At winds of {low:g} to {high:g} m/s rotor speed is proved to be "
            f"{rows['rotor speed'].parts[0]}, while the wind keeps the proved wind limits."
        ]
        if "overspeed" in rows:
            largest = max(n.value for n in rows["overspeed"].numbers if REFERENCE not in n.quantity)
            sentences.append(
                f"In gusts nothing is proved; up to {largest:.1f} % overspeed is simulated."
            )
        return " ".join(sentences)
    if "proved winds" in rows:
        return (
            f"At constant winds of {rows['proved winds'].parts[0]} that the law knows, the loop is "
            "proved to settle at one equilibrium, from a set around it. Nothing is proved about a "
            "changing wind."
        )
    proved = [claim.name for claim in design.checked.claims if claim.verdict is Verdict.PROVED]
    named = f": {', '.join(proved)}" if proved else ""
    return f"{len(proved)} of {len(design.checked.claims)} claims are proved{named}."


def proved_claim(design: TurbineDesign, kind: str) -> tuple[Mapping[str, Any], Claim] | None:
    """Return the first proved claim of a kind, as the file states it and as the checker names it.

    None where none is proved.
    """
    pairs = zip(design.document["claims"], design.checked.claims, strict=False)
    proved = ((a, b) for a, b in pairs if a["kind"] == kind and b.verdict is Verdict.PROVED)
    return next(proved, None)


def _row(
    name: str,
    phrases: Sequence[str],
    numbers: Sequence[Number] = (),
    claim: Claim | None = None,
    *,
    basis: str = "",
    shortfall: str = "",
    beside: str = "",
) -> SummaryRow:
    return SummaryRow(
        name,
        tuple(phrase for phrase in phrases if phrase),
        tuple(numbers),
        beside,
        basis,
        partial=bool(shortfall),
        shortfall=shortfall,
        claim=claim.name if claim else "",
        assumes=claim.assumes if claim else (),
    )


def _set_rows(design: TurbineDesign) -> Iterator[SummaryRow]:
    """Yield the rows of the claim about the invariant set and the wind limits."""
    proved, summary = proved_claim(design, "coherent-loop"), claim_summary(design)
    if proved is None or summary is None:
        return
    claim, low, high = proved[1], summary.edges[0], summary.edges[-1]
    over, rated = 100 * summary.overspeed, design.turbine.rated_rotor_speed * RPM
    speed = rated * (1 + summary.overspeed)
    side, share = "above" if over >= 0 else "below", at_most(over).removeprefix("-")
    words = f"at most {at_most(speed, 4)} rpm, {share} % {side} the rated {rated:.4g} rpm"
    bounds = Number("overspeed", over, "% of rated"), Number("rotor speed", speed, "rpm")
    winds = Number("lowest wind", low, "m/s"), Number("highest wind", high, "m/s")
    phrases = [words, f"{low:g} to {high:g} m/s", "within the wind limits"]
    yield _row("rotor speed", phrases, [*bounds, *winds], claim)
    error = f"wind within {_span(summary.wind_error)} m/s of the law's schedule wind"
    rate = f"which moves at most {_span(summary.wind_rate)} m/s^2"
    ends = (
        *_ends("wind error", summary.wind_error, "m/s"),
        *_ends("rate of the schedule wind", summary.wind_rate, "m/s^2"),
    )
    yield _row("wind limits", [error, rate, "by wind"], ends, claim)
    decay = summary.common_rate
    phrases = [_time_words(decay), "constant known wind", _rate(decay)]
    yield _row("settling", phrases, [Number("decay rate", decay, "1/s")], claim)
    lowest, highest = summary.power_coefficient
    wake = "up to the frozen wake's" if summary.frozen_wake else "of the equilibrium wake"
    phrases = [
        "inertia {:g} to {:g} of nominal".format(*summary.inertia),
        f"c_P {lowest:g} to {highest:g} of the table's" if lowest < highest else "",
        f"pitch effectiveness {wake}",
    ]
    numbers = [
        *_ends("inertia", summary.inertia, "of nominal"),
        *_ends("power coefficient", summary.power_coefficient, "of the table's"),
        Number("frozen wake covered", float(summary.frozen_wake), ""),
    ]
    yield _row("plants", phrases, numbers, claim)


def _observer(design: TurbineDesign) -> Iterator[SummaryRow]:
    """Yield what is proved with the wind observer in the loop, and the winds that are left out."""
    proved = proved_claim(design, "running-loop")
    if proved is None:
        return
    winds = [(float(low), float(high)) for low, high in proved[0]["winds"]]
    ends = design.turbine.cut_in, design.turbine.cut_out
    slowest, rate = slowest_mode(design), float(proved[0]["decay_rate"])
    uncovered = ", ".join(span_words(span, inward=False) for span in gaps(ends, winds))
    covered = sum(high - low for low, high in winds)
    share = min(covered / (ends[1] - ends[0]), 1.0)
    constant = f"constant wind of {', '.join(span_words(s, inward=True) for s in winds)} m/s"
    yield _row(
        "observer",
        [_time_words(rate), constant, _rate(rate)],
        [Number("decay rate", rate, "1/s"), Number("winds covered", covered, "m/s", share)],
        proved[1],
        shortfall=f"not {uncovered} m/s" if uncovered else "",
        beside=slowest and f"linear, slowest mode {slowest}",
    )


def slowest_mode(design: TurbineDesign) -> str:
    """Return in which time to 2 % the slowest linear mode of the loop that runs falls, and where.

    Of all plants and winds; "" for an unstable loop or none.
    """
    slowest = min(measured_loop(design).margins.rows, key=lambda row: row.decay_rate, default=None)
    if slowest is None or slowest.decay_rate <= 0:
        return ""
    return f"{norm_settling_time(slowest.decay_rate):.3g} s at {slowest.wind:g} m/s"


def _wind_rate(design: TurbineDesign) -> Iterator[SummaryRow]:
    """Yield the allowed rate of a wind that is known, through the law's own filter."""
    if (proved := proved_claim(design, "wind-rate")) is not None:
        rates = [float(rate) for rate in proved[0]["ranges"][0]["estimate_rate"]]
        time = float(design.document["gains"].get("wind_filter", 0))
        source = f"of a wind that is measured, through the law's filter of {time:g} s"
        phrases = [f"|v'| up to {_span(rates)} m/s^2", source]
        yield _row("known wind", phrases, _ends("rate of the wind", rates, "m/s^2"), proved[1])


def _setpoints(design: TurbineDesign) -> Iterator[SummaryRow]:
    """Yield the set-points of speed and power at which the loop is proved to settle."""
    proved, law = proved_claim(design, "set-points"), design.effort_sharing_law
    if proved is None or law is None or law.setpoints is None:
        return
    setpoints, rated = law.setpoints, float(law.schedule.rotor_speed[-1])
    speeds = setpoints.lowest_speed * RPM, rated * RPM
    low, high = setpoints.lowest_speed * setpoints.lowest_torque, rated * law.rated_torque
    powers = [setpoints.power_per_torque * product / 1e6 for product in (low, high)]
    rate = min(float(cell["decay_rate"]) for cell in proved[0]["cells"])
    words = f"speed {speeds[0]:.4g} to {speeds[1]:.4g} rpm, power {powers[0]:.3g} to "
    words += f"{powers[1]:.3g} MW, at run time"
    ends = *_ends("speed set-point", speeds, "rpm"), *_ends("power set-point", powers, "MW")
    phrases = [words, _time_words(rate), "each constant, and a constant known wind"]
    yield _row("set-points", phrases, [*ends, Number("decay rate", rate, "1/s")], proved[1])


def _actuators(design: TurbineDesign) -> Iterator[SummaryRow]:
    """Yield the jumps and rates of pitch and torque that are proved, beside the drives' limits."""
    proved = proved_claim(design, "bumpless")
    if proved is None:
        return
    cells, turbine = proved[0]["cells"], design.turbine
    pitch, torque = (
        max(float(cell[name]) for cell in cells) for name in ("pitch_rate", "torque_rate")
    )
    within = sum(float(cell["torque_rate"]) <= turbine.torque_rate_limit for cell in cells)
    limits = degrees(turbine.pitch_rate_limit), turbine.torque_rate_limit / 1e3
    # Of Schulte's law the bound is about the command.
    moving = "pitch moves" if design.effort_sharing_law else "pitch command moves"
    phrases = [
        "neither command jumps",
        f"{moving} at most at {at_most(degrees(pitch))} deg/s (limit {limits[0]:.3g})",
        f"torque at most at {at_most(torque / 1e3)} kN m/s (limit {limits[1]:.3g})",
    ]
    rates = (
        Number("pitch rate", degrees(pitch), "deg/s"),
        Number("torque rate", torque / 1e3, "kN m/s", within / len(cells)),
    )
    short = f"torque within its limit in {within} of {len(cells)} wind cells"
    shortfall = short if within < len(cells) else ""
    yield _row("actuators", phrases, rates, proved[1], shortfall=shortfall)


def _overlaps(design: TurbineDesign) -> Iterator[SummaryRow]:
    """Yield the rows of the claim about Schulte's law."""
    chosen = next(iter(overlap_claims(design)), None)
    if chosen is None or not chosen.proved:
        return
    claim = next(result for result in design.checked.claims if result.name == chosen.name)
    shortfall = f"not {gap_words(chosen)}" if chosen.unproved else ""
    covered = sum(high - low for low, high in chosen.proved)
    every = covered + sum(high - low for low, high in chosen.unproved)
    winds = Number("winds covered", covered, "m/s", covered / every)
    phrases = [wind_words(chosen), f"overlaps of {chosen.label}"]
    yield _row("proved winds", phrases, [winds], claim, shortfall=shortfall)
    if chosen.decay:
        decay = [float(rate) for rate in chosen.decay]
        width, share = chosen.half_width, chosen.speed_share
        phrases = [
            _time_words(min(decay)),
            f"decay rate >= {' to '.join(chosen.decay)} 1/s, by wind",
            "constant wind that the law knows",
            f"from {width} rad/s around it or less" if width else "",
            f"speed settles within {share} % of rated from its reference" if share else "",
        ]
        yield _row("settling", phrases, _ends("decay rate", decay, "1/s"), claim)


def _overspeed(runs: Sequence[DesignRun], rated: DesignRun | None) -> Iterator[SummaryRow]:
    """Yield the largest overspeed, the gust's, and the worst beside the reference controller's."""
    if rated is None:
        return
    by_size = sorted(runs, key=lambda run: -run.law.metrics.overspeed)
    worse = sorted((run for run in runs if _excess(run) > WORSE_BY), key=_excess)
    phrases = [_run_words(run) for run in dict.fromkeys([by_size[0], rated, *worse[-1:]])]
    numbers = [number for run in runs for number in _run_numbers(run)]
    short = f"worse than the {REFERENCE} in {len(worse)} of {len(runs)} runs" if worse else ""
    yield _row("overspeed", phrases, numbers, basis=SIMULATED, shortfall=short)


def _run_words(run: DesignRun) -> str:
    law, reference = run.law.metrics.overspeed, run.reference
    beside = f" (reference {reference.metrics.overspeed:.1f} %)" if reference else ""
    return f"{law:.1f} % in the {run.words}{beside}"


def _run_numbers(run: DesignRun) -> list[Number]:
    results = {"": run.law, f", {REFERENCE}": run.reference}
    return [
        Number(f"overspeed, {run.words}{who}", result.metrics.overspeed, "% of rated")
        for who, result in results.items()
        if result is not None
    ]


def _excess(run: DesignRun) -> float:
    """Return by how much the overspeed is above the reference controller's [% of rated]."""
    if run.reference is None:
        return -inf
    return run.law.metrics.overspeed - max(run.reference.metrics.overspeed, 0.0)


def _turbulence(runs: Mapping[float, DesignRun]) -> Iterator[SummaryRow]:
    """Yield the share of time that class-B turbulence is within the proved wind limits."""
    shares = {wind: run.share_inside for wind, run in runs.items() if not isnan(run.share_inside)}
    if not shares:
        return
    numbers = [
        Number(f"time within the wind limits, mean wind {wind:g} m/s", 100 * share, "%", share)
        for wind, share in shares.items()
    ]
    lowest, highest = (100 * of(shares.values()) for of in (min, max))
    first, *following = (f"{100 * share:.0f} % at {wind:g}" for wind, share in shares.items())
    words = f"IEC class B keeps the wind limits {lowest:.0f} to {highest:.0f} % of the time"
    phrases = [words, ", ".join([f"{first} m/s", *following])]
    short = "less than class B" if lowest < 100 else ""
    yield _row("turbulence", phrases, numbers, basis=SIMULATED, shortfall=short)


def _margins(measured: Sequence[RunningMargins]) -> Iterator[SummaryRow]:
    """Yield the least gain and phase margin of the loop that runs, of all plants and winds."""
    rows = [row for row in measured if row.loops]
    if any(row.decay_rate <= 0 for row in rows):
        unstable = "the loop that runs is not stable at every wind, see the report"
        yield _row("margins", [unstable], basis=LINEAR, shortfall="unstable")
        return
    phrases: list[str] = []
    numbers: list[Number] = []
    low: list[str] = []
    kinds = ("gain", "dB", gain_margin, USUAL_GAIN), ("phase", "deg", phase_margin, USUAL_PHASE)
    for name, unit, size, usual in kinds if rows else ():
        value, row, loop = min(
            ((size(margins), row, loop) for row in rows for loop, margins in row.loops),
            key=lambda candidate: candidate[0],
        )
        phrases.append(f"{name} {value:.3g} {unit} ({loop} at {row.wind:g} m/s)")
        low += [f"{usual:g} {unit}"] if value < usual else []
        numbers.append(Number(f"least {name} margin", value, unit))
        numbers.append(Number(f"wind of the least {name} margin", row.wind, "m/s"))
    if rows:
        shortfall = f"less than the usual {' and '.join(low)}" if low else ""
        yield _row("margins", phrases, numbers, basis=LINEAR, shortfall=shortfall)


def gain_margin(margins: Margins) -> float:
    """Return the factor, up or down, to which a gain may change [dB]."""
    lower = inf if margins.gain_decrease == 0 else 1 / margins.gain_decrease
    return 20 * log10(min(margins.gain_increase, lower))


def phase_margin(margins: Margins) -> float:
    """Return the phase margin [deg]."""
    return degrees(margins.phase)


def _gains(law: EffortSharingLaw | None) -> Iterator[SummaryRow]:
    """Yield the ranges of the law's gains over the schedule wind."""
    if law is not None:
        spans = {
            ("proportional", "1/s"): law.gains.proportional.tolist(),
            ("integral rate", "1/s"): law.gains.integral_rate.tolist(),
        }
        phrases = [f"{n} {min(v):.3g} to {max(v):.3g} {unit}" for (n, unit), v in spans.items()]
        numbers = [end for (name, unit), v in spans.items() for end in _ends(name, v, unit)]
        yield _row("gains", phrases, numbers, basis="in gains.json")


def _not_covered(design: TurbineDesign) -> SummaryRow:
    """Return what no claim speaks of."""
    changing = "wind outside the limits" if design.effort_sharing_law else "a changing wind"
    phrases = (changing, "sampling", "tower, shaft and blades", "c_P errors", "faults")
    return _row("not covered", phrases, basis="no claim")


def _time_words(rate: float) -> str:
    return f"{at_most(norm_settling_time(rate))} s to {100 * SETTLED:g} % in {NORM}"


def _rate(rate: float) -> str:
    return f"decay rate >= {at_least(rate)} 1/s"


def _span(values: Sequence[float]) -> str:
    return f"{at_least(min(values))} to {at_least(max(values))}"


def _ends(quantity: str, values: Sequence[float], unit: str) -> tuple[Number, Number]:
    return (
        Number(f"{quantity}, least", float(min(values)), unit),
        Number(f"{quantity}, largest", float(max(values)), unit),
    )
