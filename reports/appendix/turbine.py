"""The appendix of a turbine: notation, plant, law, regional models, conditions, margins."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.claims.turbine.cell_loop import EffortSharingCandidate
from takagi.certificates.design.turbine.result import TurbineDesign, claim_summary
from takagi.lmi.analysis.invariant_ellipsoid import invariant_ellipsoid_condition
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.typeset import formula_lines, plain_label
from takagi.lmi.gains.cost.regulator import guaranteed_cost_condition
from takagi.lmi.gains.observer import observer_condition
from takagi.lmi.turbine.effort import EffortSettings
from takagi.lmi.turbine.regional import RegionGains
from takagi.models.laws.effort_sharing.law import EffortSharingLaw, loop_vertices
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import optimal_tip_speed_ratio, rated_wind
from takagi.reports.appendix.tex import (
    NONE,
    Tex,
    decimal,
    escape,
    listed,
    matrix,
    scientific,
    unit,
    with_decimals,
)
from takagi.reports.figures.operation import power_surface_figure, trim_figure
from takagi.reports.margins.running_over_wind import SearchedMargins, wind_ranges
from takagi.reports.output import read_words
from takagi.reports.sections.turbine.model import (
    cells_drawing,
    filter_of,
    memberships_drawing,
    region_starts,
    trim_curve,
)
from takagi.reports.sections.turbine.running import margins_drawing, response_drawing
from takagi.reports.simulation.measured_loop import DesignRun, measured_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.lmi import Design

DEGREES = 180 / np.pi
_WORDS = read_words("appendix/words.toml")
_SYMBOLS, _REMARKS = _WORDS["symbols"], _WORDS["remarks"]
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
    every = [
        (20 * np.log10(m.gain_increase), m.phase * DEGREES, m.delay, m.disk.alpha)
        for m in plants
        if m is not None
    ]
    cells = []
    for column, digits in zip(zip(*every, strict=True), (1, 1, 3, 2), strict=True):
        first, minimum = (with_decimals(value, digits) for value in (column[0], min(column)))
        cells.append(Tex(f"{first} ({minimum})"))
    return [decimal(wind), escape(loop), *cells]


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


_NAMED = re.compile(r"^(.*) \[(.*)\]$")
# sympy puts the dot over symbol and index together; it belongs over the symbol.
_DOTTED = re.compile(r"\\dot\{([^{}]+)_\{([^{}]+)\}\}")


def region_context(model: TSModel, gains: RegionGains, letter: str) -> dict[str, object]:
    """Return derivation, premises, vertices, rules and gains of one region.

    Parameters
    ----------
    letter : superscript of its memberships, "b" or "c".
    """
    return {
        "letter": letter,
        "model": model,
        "result": gains,
        "steps": [
            {"title": _title(step.title), "latex": _display(step.latex)}
            for step in (() if model.derivation is None else model.derivation.steps)
        ],
        "states": [_with_unit(name) for name in model.states],
        "box": [
            [_with_unit(name), *(scientific(float(end), 6) for end in ends)]
            for name, ends in model.box.items()
        ],
        "vertices": list(vertex_lines(model)),
        "gains": _region_gains(model, gains),
        "with_pitch": len(model.states) == 3,
    }


def vertex_lines(model: TSModel, *, measured: bool = False) -> Iterator[Tex]:
    """Yield the vertices as formulas: what is the same in all rules first, then rule by rule.

    Parameters
    ----------
    measured : with the output matrices C.
    """
    names = [name for name in "ABE" if np.any(getattr(model, name))] + ["C"] * measured
    varying = [name for name in names if np.ptp(getattr(model, name), axis=0).any()]
    same = [name for name in names if name not in varying]
    several = len(model.rules) > 1
    if same:
        index, span = ("i", rf", \quad i = 1, \dots, {len(model.rules)}") if several else ("1", "")
        equations = [rf"{name}_{index} = {matrix(getattr(model, name)[0])}" for name in same]
        yield Tex(r",\quad ".join(equations) + span)
    for i in range(len(model.rules) if varying else 0):
        equations = [rf"{name}_{{{i + 1}}} = {matrix(getattr(model, name)[i])}" for name in varying]
        yield Tex(r",\quad ".join(equations))


def _display(formula: str) -> Tex:
    """Return a formula with fractions at full size, also inside vectors, and dots on symbols."""
    dotted = _DOTTED.sub(r"\\dot{\1}_{\2}", formula)
    enlarged = dotted.replace(r"\frac", r"\dfrac").replace(r"\\", r"\\[8pt] ")
    first, _, bounds = enlarged.partition(r", \qquad ")
    # A premise and its bounds on two lines: they need not be shrunk in a narrow column.
    return Tex(rf"\begin{{gathered}}{first},\\ {bounds}\end{{gathered}}" if bounds else enlarged)


def _title(words: str) -> Tex:
    text = str(escape(words))
    for plain, symbols in _WORDS["derivatives"].items():
        text = text.replace(plain, symbols)
    return Tex(re.sub(r"^Premise (\w+);", r"Premise $\1$;", text))


def _with_unit(name: str) -> Tex:
    match = _NAMED.match(name)
    return escape(name) if match is None else Tex(f"{escape(match[1])} [{unit(match[2])}]")


def _region_gains(model: TSModel, gains: RegionGains) -> list[list[Tex]]:
    if gains.k_x is None or gains.k_I is None:
        return []
    return [
        [
            escape(i),
            *(decimal(p.corners[c]) for p, c in zip(model.premises, rule, strict=True)),
            *(scientific(float(k), 6) for k in (*k_x, k_I)),
        ]
        for i, (rule, k_x, k_I) in enumerate(
            zip(model.rules, gains.k_x, gains.k_I, strict=True), start=1
        )
    ]


def conditions(design: TurbineDesign) -> Iterator[dict[str, object]]:
    """Yield every condition as a list of labelled formulas, with a remark on its symbols."""
    coherent = design.effort_sharing_law is not None
    for region in () if coherent else (design.regional.partial, design.regional.full):
        yield posed(
            f"Gains of the {region.region} region",
            region.condition,
            numbers=[Tex(rf"$\alpha = {decimal(region.requirement.decay_rate)}$~1/s")],
            remark=_REMARKS["regional"],
        )
    yield posed(
        "Gains of the wind observer",
        _observer_problem(design),
        numbers=[Tex(rf"$\alpha = {decimal(float(design.observer.decay_rate))}$~1/s")],
        remark=_REMARKS["observer"],
    )
    if coherent and design.effort is not None:
        yield posed("Gains of the effort-sharing law", _effort(design), remark=_REMARKS["effort"])
    if design.candidate is not None and design.candidate.P is not None:
        yield posed(
            "Joint analysis of the blended loop",
            _invariance(design.candidate),
            remark=_REMARKS["invariance"],
            renamed={r"\alpha_{k}": r"\vartheta_{k}", "d_{k}": r"\bar w_k", "h_{i}": r"\ell_i"},
        )


def _observer_problem(design: TurbineDesign) -> Condition:
    return observer_condition(
        design.observer.model, decay_rate=design.observer.decay_rate, relaxation="common-gain"
    )


def _effort(design: TurbineDesign) -> Condition:
    """Return the guaranteed-cost condition of the first wind node; all nodes share its form."""
    if design.effort is None:
        raise ValueError("a design without effort gains has no guaranteed-cost condition")
    settings = design.settings.effort or EffortSettings()
    stiffness = design.effort.stiffness[0]
    A = [[[a, 0.0], [-1.0, 0.0]] for a in stiffness for _ in settings.inertia]
    B = [[[-1 / inertia], [0.0]] for _ in stiffness for inertia in settings.inertia]
    return guaranteed_cost_condition(np.array(A), np.array(B))


def _invariance(candidate: EffortSharingCandidate) -> Condition:
    """Return the invariance condition over all corners, at the claim's winds and multipliers."""
    corners = [loop_vertices(cell) for cell in candidate.cells]
    d = [
        v.fixed + candidate.wind_error[k] * v.per_wind_error
        for k, v in enumerate(corners)
    ]  # fmt: skip
    box = candidate.box
    e, z, y = (float(b) for b in (box.speed_error, box.effort_lag, box.speed_signal))
    return invariant_ellipsoid_condition(
        np.concatenate([v.A for v in corners]),
        np.concatenate(d),
        np.repeat(candidate.multipliers, [len(v.A) for v in corners]),
        np.array([[1 / e, 0, 0], [0, 1 / z, 0], [1 / y, 0, -1 / y]]),
    )


_POWER = re.compile(r"(\d)e([+-]\d+)")
_RELAXATIONS = {"wang-tanaka-griffin": "all pairs", "common-gain": "one gain for all rules"}


def posed(
    title: str,
    condition: Condition,
    *,
    numbers: Sequence[Tex] = (),
    remark: str = "",
    renamed: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Any]:
    """Return the values of one condition in the templates: what it says, line by line.

    Parameters
    ----------
    numbers : of the data that were used.
    remark : what is to be said of its symbols; "" takes those that are known.
    renamed : symbol of the builder -> symbol of the appendix, where that has another meaning for
        the first.
    """
    lines = formula_lines(condition)
    for symbol, replacement in renamed.items():
        lines = [(label, formula.replace(symbol, replacement)) for label, formula in lines]
    everything = " ".join(formula for _, formula in lines)
    explanations = [words for token, words in _WORDS["explained"].items() if token in everything]
    return {
        "title": title,
        "source": condition.source,
        "numbers": list(numbers),
        "remark": Tex(remark or f"Here {'; '.join(explanations)}."),
        "lines": [
            (
                escape(plain_label(label)),
                Tex(_POWER.sub(lambda m: rf"{m[1]} \cdot 10^{{{int(m[2])}}}", formula)),
            )
            for label, formula in lines
        ],
    }


def posed_design(title: str, design: Design | None, *, dual: bool = False) -> list[dict[str, Any]]:
    """Return the same for gains with the numbers used; [] for gains that were given.

    Parameters
    ----------
    dual : whether they are an observer's, found by the dual problem.
    """
    if design is None or design.answer.condition is None:
        return []
    name, scales = design.relaxation, design.answer.coordinates
    relaxation = f"{_RELAXATIONS[name]} ({name})" if name in _RELAXATIONS else name
    numbers = [Tex(f"relaxation of the double sum: {escape(relaxation)}")]
    if design.decay_rate:
        numbers.insert(0, Tex(rf"$\alpha = {decimal(design.decay_rate)}$~1/s"))
    if scales is not None:
        numbers.append(Tex(f"states in units of $({listed(map(float, scales))})$"))
    remark = _REMARKS["dual"] if dual else ""
    return [posed(title, design.answer.condition, numbers=numbers, remark=remark)]
