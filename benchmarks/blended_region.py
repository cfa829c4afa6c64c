r"""One quadratic function for the blended region of Schulte's law; its results are in docs/laws.md.

    python benchmarks/blended_region.py

The paper's law is u = sum_m sum_i sum_j h_m h_i h_j F_m [K^b_i; K^c_j] xi with xi = (omega -
omega_ref, beta, x).  Three families of matrices are asked for a common P:

    printed    A_p + B F_m [K^b_i; K^c_j]: the paper's sum, vertex by vertex
    slopes     the Jacobians of the loop at its equilibria, and those of the same wind in which the
               coupling takes other slopes: torque alone, both, pitch alone
    equilibria the Jacobians at the equilibria alone

With (p, c, s) for the slope of the passed torque over u_1, the share f_1, and f_1' u_2, a Jacobian
in (omega, beta, x) is

    [a, b, 0; 0, -1/tau, 0; -1, 0, 0] + p B_1 K^b + c B_2 K^c + B_2 (s, 0, 0).

A yes is checked in exact arithmetic (leading minors of rationals), and a no by exact multipliers.
The last table is the checker's own verdict, of a certificate whose cells all have one P.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np
from exact_truth import determinant
from measure import table

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.published import (
    UNITS,
    FoundCell,
    PublishedCandidate,
    PublishedSearch,
    published_candidate,
    published_claim,
    wind_breaks,
)
from takagi.certificates.design.turbine.published_law import designed_law, regional_design
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.document.certificate_file import (
    certificate_document,
    published_law_data,
    turbine_data,
)
from takagi.lmi import (
    He,
    Unknown,
    common_lyapunov,
    common_lyapunov_condition,
    decide,
    exact_no,
    matrix,
    max_decay_rate,
    pose,
)
from takagi.models.arrays import Floats
from takagi.models.laws.published.law import PublishedLaw, equilibrium
from takagi.models.laws.published.regional_schedule import regional_schedule
from takagi.models.turbine.data import rotor_torque_gradient
from takagi.models.turbine.loader import load_turbine
from takagi.reports.simulation.laws import ChosenLaws, chosen_laws
from takagi.reports.simulation.runs import run_simulation
from takagi.reports.simulation.winds import requested_winds

# Decimals of the matrices that are asked about, and of P.
DIGITS = 9
STEP = 0.1
WINDS = (11.5, 18.0)
# Slopes of the coupling at one wind: torque alone, both, pitch alone.
TORQUE, BOTH, PITCH = (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)
# Below this wind pitch alone cannot hold the rotor; torque is not saturated there.
FIRST_PITCH = 10.9
OVERLAPS = ((0.5, 0.0), (0.25, 0.0), (0.5, 0.25), (0.5, 0.5), (0.6, 0.75), (0.1, 0.5))
SIZES = (0.001, 0.0005)
NARROWEST = 0.0005
ROUNDS = 40
# Units of the commands in the synthesis: torque [N m], pitch [rad].
COMMANDS = np.array([1e4, 0.1])
Gains = Floats


@dataclass(frozen=True, slots=True)
class Rest:
    """The loop at rest at a wind: slopes of the rotor over J, slopes of the coupling, weights."""

    wind: float
    a: float
    b: float
    coupling: tuple[float, float, float]
    partial: Floats
    full: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A law's equilibria over wind, and the gains of its rules: (rules, 3) of omega, beta, x."""

    law: PublishedLaw
    rests: list[Rest]
    partial: Gains
    full: Gains

    @classmethod
    def of(cls, law: PublishedLaw) -> Line:
        """Return the equilibria at every ``STEP`` from cut-in to cut-out."""
        low, high = law.turbine.cut_in, law.turbine.cut_out
        count = round((high - low) / STEP)
        winds = [round(low + (high - low) * k / count, 6) for k in range(count + 1)]
        rows = [np.column_stack([s.k_x, s.k_I]) for s in (law.partial, law.full)]
        return cls(law, [_rest(law, v) for v in winds], *rows)

    def jacobian(self, rest: Rest, coupling: Sequence[float], gains: Sequence[Floats]) -> Floats:
        """Return the Jacobian with these slopes of the coupling, in ``UNITS``."""
        plant, inputs, ramp = self.parts(rest, coupling)
        rows = np.stack([row * (-1.0, -1.0, 1.0) for row in gains])
        whole: Floats = plant + ramp + inputs @ rows
        return np.asarray(np.round(whole * UNITS / UNITS[:, None], DIGITS), np.float64)

    def parts(self, rest: Rest, coupling: Sequence[float]) -> tuple[Floats, Floats, Floats]:
        """Return the plant (3, 3), its inputs behind the coupling (3, 2), and the ramp's term."""
        turbine, (passed, share, steep) = self.law.turbine, coupling
        lag = turbine.pitch_time_constant
        plant = np.array([[rest.a, rest.b, 0.0], [0.0, -1 / lag, 0.0], [-1.0, 0.0, 0.0]])
        inputs = np.zeros((3, 2))
        inputs[0, 0] = -passed * turbine.gear_ratio / turbine.inertia
        inputs[1, 1] = share / lag
        ramp = np.zeros((3, 3))
        ramp[1, 0] = steep / lag
        return plant, inputs, ramp

    def matrices(self, couplings: Callable[[Rest], list[tuple[float, float, float]]]) -> Floats:
        """Return (winds, couplings, 3, 3), each wind with its own gains."""
        rows = []
        for rest in self.rests:
            gains = (rest.partial @ self.partial, rest.full @ self.full)
            rows.append([self.jacobian(rest, c, gains) for c in couplings(rest)])
        return np.array(rows)


def _rest(law: PublishedLaw, wind: float) -> Rest:
    point = equilibrium(law, wind)
    speed, pitch, turbine = point.rotor_speed, point.pitch, law.turbine
    slopes = rotor_torque_gradient(turbine, np.array([speed]), np.array([pitch]), wind)
    a, b = (float(np.ravel(slope)[0]) / turbine.inertia for slope in slopes[:2])
    ramp, coupling = law.coupling.speed_ramp, law.coupling
    share, h = ramp.at(speed), 1e-6
    steep = (ramp.at(speed + h) - ramp.at(speed - h)) / (2 * h)
    torque = law.partial.gains_at(speed, pitch, wind).integral * point.integral
    above = coupling.rated_torque + coupling.torque_overlap / 2 - torque
    passed = min(max(above / coupling.torque_overlap, 0.0), 1.0)
    weights = [np.array(s.memberships_at(speed, pitch, wind)) for s in (law.partial, law.full)]
    return Rest(wind, a, b, (passed, share, steep * pitch / share if share else 0.0), *weights)


def resting(rest: Rest) -> list[tuple[float, float, float]]:
    """Return the coupling's slopes at the equilibrium."""
    return [rest.coupling]


def every(rest: Rest) -> list[tuple[float, float, float]]:
    """Return the coupling's slopes at the equilibrium, and all others that are asked for."""
    third = PITCH if rest.wind >= FIRST_PITCH else BOTH
    return [TORQUE, BOTH, third, rest.coupling]


# ------------------------------------------------------------------ verdicts
def common(A: Floats) -> tuple[str, float]:
    """Return "PROVED" and a rate, "NO" and nan, or "open" and nan, for a stack of matrices."""
    answer = common_lyapunov(A)
    if answer.status != "candidate":
        refuted = exact_no(common_lyapunov_condition(A)) is not None
        return ("NO" if refuted else "open"), float("nan")
    fast = max_decay_rate(A)
    proved = any(exactly_common(A, _square(x.P)) for x in (answer, fast))
    return ("PROVED" if proved else "open"), float(fast.decay_rate or 0.0)


def exactly_common(A: Floats, P: Floats) -> bool:
    """Say whether P > 0 and A'P + PA < 0 for all matrices, by leading minors of rationals."""
    rows = _fractions(np.round((P + P.T) / 2 / np.abs(P).max(), DIGITS))
    if not _definite(rows):
        return False
    for vertex in A:
        cells = _fractions(vertex)
        product_ = [
            [sum((rows[i][k] * cells[k][j] for k in range(3)), Fraction(0)) for j in range(3)]
            for i in range(3)
        ]
        if not _definite([[-product_[i][j] - product_[j][i] for j in range(3)] for i in range(3)]):
            return False
    return True


def _square(P: Floats | None) -> Floats:
    return np.reshape(np.asarray(P), (3, 3))


def _fractions(values: Floats) -> list[list[Fraction]]:
    return [[Fraction(repr(float(value))) for value in row] for row in values]


def _definite(rows: list[list[Fraction]]) -> bool:
    return all(determinant([row[:k] for row in rows[:k]]) > 0 for k in (1, 2, 3))


def cover(stacks: Floats, winds: Sequence[float]) -> list[str]:
    """Return the fewest ranges of wind, from the lowest on, that have a common P each."""
    ranges, first = [], 0
    while first < len(stacks):
        good, bad = first, first + 1
        while good < len(stacks) and _has(stacks[first:bad]):
            good, bad = bad, min(len(stacks), bad + (bad - first))
            if good == len(stacks):
                break
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if _has(stacks[first:middle]) else (good, middle)
        if good == first:
            ranges.append(f"none at {winds[first]:g}")
            good += 1
        else:
            ranges.append(f"{winds[first]:g} to {winds[good - 1]:g}")
        first = good
        if len(ranges) > 3:
            return [*ranges, "..."]
    return ranges


def _has(stacks: Floats) -> bool:
    return common_lyapunov(stacks.reshape(-1, 3, 3)).status == "candidate"


# ------------------------------------------------------------------ tables
def printed(line: Line, corners: Sequence[tuple[float, float]]) -> Iterator[tuple[str, ...]]:
    """Yield a row a filter: the LMIs as the paper has them."""
    turbine, window = line.law.turbine, line.law.coupling.torque_overlap
    rated = turbine.rated_torque
    for name, other in (
        ("saturated", rated / turbine.maximum_torque),
        ("sector", rated / (rated - window)),
    ):
        gains = [np.unique(rows, axis=0) for rows in (line.partial, line.full)]
        A = np.array(
            [
                line.jacobian(Rest(0.0, a, b, BOTH, *gains), (f_2, f_1, 0.0), pair)
                for (a, b), f_2, f_1 in product(corners, (1.0, other), (0.0, 1.0))
                for pair in product(*gains)
            ]
        )
        verdict, rate = common(A)
        yield name, f"{len(A)}", verdict, f"{rate:.3f}"


def over_overlaps(laws: dict[tuple[float, float], PublishedLaw]) -> Iterator[tuple[str, ...]]:
    """Yield a row an overlap: the ranges that one P covers."""
    for (overlap, placement), law in laws.items():
        line = Line.of(law)
        row = [f"{overlap:g}, {placement:g}"]
        for couplings in (resting, every):
            stacks = line.matrices(couplings)
            verdict, rate = common(stacks.reshape(-1, 3, 3))
            winds = [rest.wind for rest in line.rests]
            row += [
                f"{verdict}, {rate:.4f}" if verdict == "PROVED" else verdict,
                "; ".join(cover(stacks, winds)),
            ]
        yield tuple(row)


def checked(law: PublishedLaw, P: Floats) -> Iterator[tuple[str, ...]]:
    """Yield a row a size of set: what the checker says of a claim with one P in every cell."""
    search = PublishedSearch.of(law)
    low, high = law.turbine.cut_in, law.turbine.cut_out
    for size in SIZES:
        cells: list[FoundCell] = []
        missing = 0.0
        for wind in _pieces(wind_breaks(search.stated, search.plant.radius, low, high)):
            for piece, cell in _halved(search, wind, P, size):
                if cell is None:
                    missing += piece[1] - piece[0]
                else:
                    cells.append(cell)
        row = (f"{size:g}", f"{len(cells)}", f"{missing:.3f}")
        if missing:
            yield *row, "not claimed", ""
            continue
        functions = {cell.P.tobytes() for cell in cells}
        claim = published_claim(PublishedCandidate(law, ((low, high),), tuple(cells), ()))
        document = certificate_document(
            model=turbine_data(law.turbine, ()),
            gains=published_law_data(law),
            claims=[claim],
            provenance={"solver": {}},
        )
        (answer,) = check_document(document).claims
        slowest = min(cell.decay_rate for cell in cells)
        yield *row, f"{answer.verdict.name}, {len(functions)} P", f"{slowest:.5f}"


def _pieces(breaks: list[float]) -> Iterator[tuple[float, float]]:
    for low, high in zip(breaks, breaks[1:], strict=False):
        count = max(1, int(np.ceil((high - low) / 0.5 - 1e-9)))
        nodes = [round(float(v), 9) for v in np.linspace(low, high, count + 1)]
        yield from zip(nodes, nodes[1:], strict=False)


def _halved(
    search: PublishedSearch, wind: tuple[float, float], P: Floats, size: float
) -> Iterator[tuple[tuple[float, float], FoundCell | None]]:
    ends = [search.rest(v) for v in wind]
    lowest = search.law.turbine.pitch_min
    centre = np.round([[p.rotor_speed, max(p.pitch, lowest), p.integral] for p in ends], 9)
    try:
        bound = search.field_at(wind, centre)
        cell = search._with(wind, centre, UNITS, P, size, bound)
    except Refused:
        cell = None
    if cell is not None or wind[1] - wind[0] < 2 * NARROWEST:
        kinds = {p.kind for p in ends}
        kind = kinds.pop() if len(kinds) == 1 else "shifted"
        yield wind, None if cell is None else FoundCell(*cell, kind)
        return
    middle = round((wind[0] + wind[1]) / 2, 9)
    yield from _halved(search, (wind[0], middle), P, size)
    yield from _halved(search, (middle, wind[1]), P, size)


# ------------------------------------------------------------------ one step
def synthesised(line: Line, *, free_integral: bool) -> Line:
    """Return the line with gains of all rules that are sought together.

    Gains and P are improved in turn; each half is an LMI.  No gain may exceed the designed one in
    size, and torque has no gain on pitch.

    Parameters
    ----------
    free_integral : whether the torque's integral gain may shrink by more than a fifth.
    """
    every_fifth = Line(line.law, line.rests[::5], line.partial, line.full)
    A = every_fifth.matrices(every).reshape(-1, 3, 3)
    answer = max_decay_rate(A)
    rate = float(answer.decay_rate or 0.0)
    P, best = _square(answer.P), every_fifth
    for share in (-1.0, 0.0, 0.5, *(0.9,) * ROUNDS):
        # Below the best rate of this P, so that the gains move to the middle of what it allows.
        gains = _step(best, line, P, rate * share, free_integral)
        if gains is None:
            continue
        changed = Line(line.law, best.rests, *gains)
        answer = max_decay_rate(changed.matrices(every).reshape(-1, 3, 3))
        faster = float(answer.decay_rate or 0.0)
        if answer.status != "candidate" or faster <= rate * (1 + 1e-3):
            continue
        best, rate, P = changed, faster, _square(answer.P)
    return Line(line.law, line.rests, best.partial, best.full)


def _step(
    line: Line, designed: Line, P: Floats, rate: float, free_integral: bool
) -> tuple[Gains, Gains] | None:
    """Return gains of all rules with which V = x'Px decays at the rate, or None."""
    rules = (_distinct(line.partial), _distinct(line.full))
    unknowns = [
        [Unknown(f"k{region}{i}", 1, columns) for i in range(len(groups))]
        for region, (groups, columns) in enumerate(zip(rules, (2, 3), strict=True))
    ]
    pick = (np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.eye(3))
    statements = []
    for rest in line.rests:
        weights = (rest.partial, rest.full)
        for c in every(rest):
            plant, inputs, ramp = line.parts(rest, c)
            still = (plant + ramp) * UNITS / UNITS[:, None]
            motion = matrix(P @ still + rate * P, "A")
            for region, (groups, share) in enumerate(zip(rules, weights, strict=True)):
                column = P @ (inputs[:, region : region + 1] * COMMANDS[region] / UNITS[:, None])
                if not column.any():
                    continue
                for unknown, group in zip(unknowns[region], groups, strict=True):
                    weighed = matrix(float(share[group].sum()) * column, "b")
                    motion = motion + weighed @ unknown @ matrix(pick[region], "S")
            statements.append(He(motion) << 0)
    for region, base in enumerate((designed.partial, designed.full)):
        scale = (-1.0, -1.0, 1.0) * UNITS / COMMANDS[region]
        for unknown, group in zip(unknowns[region], rules[region], strict=True):
            for k, limit in enumerate(pick[region] @ (base[group[0]] * scale)):
                select = matrix(np.eye(unknown.cols)[:, k : k + 1], "e")
                fixed = region == 0 and k == 1 and not free_integral
                ends = (limit * 0.8, limit) if fixed else (-abs(limit), abs(limit))
                statements.append(unknown @ select - matrix([[min(ends)]], "l") >> 0)
                statements.append(matrix([[max(ends)]], "u") - unknown @ select >> 0)
    answer = decide(pose(*statements, name="gains of all rules for one P"))
    if answer.status != "candidate":
        return None
    results = []
    for region, base in enumerate((line.partial, line.full)):
        scale = (-1.0, -1.0, 1.0) * UNITS / COMMANDS[region]
        rows = np.array(base)
        for unknown, group in zip(unknowns[region], rules[region], strict=True):
            rows[group] = (answer.values[unknown.name][0] @ pick[region]) / scale
        results.append(rows)
    return results[0], results[1]


def _distinct(rows: Gains) -> list[list[int]]:
    """Return the rules that share their gains."""
    groups: dict[bytes, list[int]] = {}
    for i, row in enumerate(rows):
        groups.setdefault(row.tobytes(), []).append(i)
    return list(groups.values())


def main() -> int:
    """Print the tables of printed LMIs, of slopes, of the loop, and of gains in one step."""
    turbine = load_turbine("nrel5mw")
    settings = replace(default_settings(turbine), law="paper")
    models = regional_design(turbine)
    laws = {
        (overlap, placement): designed_law(
            turbine, replace(settings, speed_overlap=overlap, ramp_placement=placement), models
        )
        for overlap, placement in OVERLAPS
    }
    line = Line.of(laws[OVERLAPS[0]])
    premises = {p.name: (float(p.lower), float(p.upper)) for p in models[1].premises}
    corners = list(product(premises["a"], premises["b"]))
    print(table(("filter", "LMIs", "common P", "decay [1/s]"), list(printed(line, corners))))
    head = ("overlap, placement", "equilibria", "ranges [m/s]", "all slopes", "ranges [m/s]")
    print(table(head, list(over_overlaps(laws))), flush=True)
    P = _square(max_decay_rate(line.matrices(resting).reshape(-1, 3, 3)).P)
    head = ("set [rad/s]", "cells", "without [m/s]", "checker", "slowest decay [1/s]")
    print(table(head, list(checked(line.law, P))), flush=True)
    variants = {"designed": line.law}
    rows = [["designed, region by region", f"{common(_stack(line))[1]:.4f}", *_proved(line.law)]]
    for name, free in (("together, torque integral within 20 %", False), ("together", True)):
        changed = synthesised(line, free_integral=free)
        variants[name] = _with_gains(line.law, changed)
        verdict, rate = common(_stack(changed))
        rows.append([name, f"{verdict}, {rate:.4f}", *_proved(variants[name])])
    for row, figures in zip(rows, simulated(variants), strict=True):
        row += figures
    columns = (f"{v:g} m/s: power, tower DEL, overspeed" for v in WINDS)
    print(
        table(
            (
                "gains",
                "common P, decay [1/s]",
                "cells, without [m/s]",
                "slowest cell [1/s]",
                *columns,
            ),
            [tuple(row) for row in rows],
        )
    )
    return 0


def _stack(line: Line) -> Floats:
    return line.matrices(every).reshape(-1, 3, 3)


def _with_gains(law: PublishedLaw, line: Line) -> PublishedLaw:
    schedules = [
        regional_schedule(
            law.turbine,
            region.model,
            k_x=np.round(rows[:, :2], digits),
            k_I=np.round(rows[:, 2], digits),
        )
        for region, rows, digits in ((law.partial, line.partial, 1), (law.full, line.full, 6))
    ]
    return replace(law, partial=schedules[0], full=schedules[1])


def _proved(law: PublishedLaw) -> list[str]:
    candidate = published_candidate(law)
    missing = sum(gap.wind[1] - gap.wind[0] for gap in candidate.unproved)
    slowest = min(cell.decay_rate for cell in candidate.cells)
    return [f"{len(candidate.cells)}, {missing:.3g}", f"{slowest:.4f}"]


def simulated(laws: dict[str, PublishedLaw]) -> Iterator[tuple[str, ...]]:
    """Yield a row a law: 600 s of class B a wind, on the validation plant with the observer."""
    turbine = next(iter(laws.values())).turbine
    chosen = chosen_laws(turbine, ("paper",))
    filters = dict.fromkeys(laws, chosen.speed_filters["paper"])
    winds = requested_winds(turbine, [f"turbulent:{v:g}:B:1" for v in WINDS])
    loops = ChosenLaws(laws, chosen.observer, filters)
    runs = run_simulation(turbine, loops, winds, series=False).runs
    for first in range(0, len(runs), len(winds)):
        yield tuple(
            f"{m.mean_power:.0f} kW, {m.tower_del:.1f} MN m, {m.overspeed:.1f} %"
            for m in (run.metrics for run in runs[first : first + len(winds)])
            if m is not None
        )


if __name__ == "__main__":
    sys.exit(main())
