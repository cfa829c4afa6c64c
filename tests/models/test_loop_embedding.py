"""The nonlinear loop against its interval family, at random points, two independent ways.

The loop is the plant's torque, the law's own ``command`` and the limited first-order pitch drive;
its derivative in (e, zeta, x) is taken by differences along the vector field, so that no formula
of the embedding is used.  The family is a box of coefficients: membership is decided exactly by
two intervals, and again by computing each mean value and comparing it with its range.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.models.embedding.coherent import coherent_cells
from takagi.models.embedding.jet import Jet
from takagi.models.embedding.loop_cell import LoopBox, LoopCell, Uncertainty
from takagi.models.embedding.vertices import loop_vertices
from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError
from takagi.models.law.coherent import CoherentLaw, EffortGains
from takagi.models.law.effort import effort_ramp, effort_ramp_slope
from takagi.models.law.feedforward import Feedforward, known_rate_feedforward
from takagi.models.law.law import Command, Measurement
from takagi.models.law.schedule import EffortSchedule, effort_schedule
from takagi.models.turbine.aerodynamics import rotor_torque, rotor_torque_gradient
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw

Floats = NDArray[np.float64]

BOX = LoopBox(Fraction("0.045"), Fraction("0.015"), Fraction("0.04"), Fraction("0.03"))
WIDE = Uncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)
# A lag that asks for several times the pitch rate limit.
FAST = LoopBox(Fraction("0.045"), Fraction("0.04"), Fraction("0.04"), Fraction("0.03"))
# Of the differences along the vector field.  Exactly, the loop lies in its family.
ROUNDING = 2e-8
# Wind rates [m/s^2] that reach every limit of the feed-forward: g, rated torque, the lower pitch
# limit and the pitch drive's rate.
RATES_OVER = ((3.0, 10.6, 11.5, 12.5, 13.0, 25.0), (0.1, 0.2, 0.3, 1.0, 1.5, 2.0))


@dataclass(frozen=True)
class Point:
    """One point of the loop, its uncertainties, and its derivative, all floats."""

    k: int
    e: float
    zeta: float
    x: float
    schedule_wind: float
    schedule_rate: float
    wind: float
    kappa: float
    wake: float


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def law(turbine: Turbine) -> CoherentLaw:
    """Return the law with plain gains: as much as torque in reserve allows."""
    schedule = effort_schedule(turbine)
    gamma, nu = plain_gains(turbine, schedule)
    return CoherentLaw.of(turbine, schedule, EffortGains(gamma, nu))


def plain_gains(turbine: Turbine, schedule: EffortSchedule) -> tuple[Floats, Floats]:
    full = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    reserve = full - effort_ramp(-schedule.trim_effort, schedule.overlap)
    gamma = np.asarray(np.round(np.minimum(0.5, 0.6 * reserve / 0.04), 5), dtype=np.float64)
    nu = np.asarray(np.round(0.05 * np.minimum(gamma[:-1], gamma[1:]), 6), dtype=np.float64)
    return gamma, nu


def rates_of(law: CoherentLaw) -> list[float]:
    """Return the wind rate of each cell."""
    nodes = law.schedule.wind
    middle = (nodes[1:] + nodes[:-1]) / 2
    return [round(float(rate), 3) for rate in np.interp(middle, *RATES_OVER)]


@pytest.fixture(scope="module")
def cells(turbine: Turbine, law: CoherentLaw) -> list[LoopCell]:
    return list(coherent_cells(turbine, law, BOX, WIDE, rates_of(law)))


def column(law: CoherentLaw, name: str, wind: float) -> float:
    table = law.gains.proportional if name == "gamma" else getattr(law.schedule, name)
    return float(np.interp(wind, law.schedule.wind, table))


def points(
    law: CoherentLaw, box: LoopBox, count: int, seed: int, cells: range | None = None
) -> Iterator[Point]:
    """Yield points of the box, half of them on faces and corners; pitch is not below its limit."""
    rng = np.random.default_rng(seed)

    def draw() -> float:
        return float(rng.choice([-1.0, 1.0]) if rng.random() < 0.5 else rng.uniform(-1, 1))

    rates, held = rates_of(law), law.schedule.wind[[0, -1]]
    e_max, zeta_max, y_max, share = (float(getattr(box, f.name)) for f in fields(box))
    found = 0
    while found < count:
        k = int(rng.choice(cells) if cells else rng.integers(len(law.schedule.wind) - 1))
        low, high = law.schedule.wind[k : k + 2]
        v = float(low + (high - low) * (0.5 + 0.4999 * draw()))
        e, y, zeta = e_max * draw(), y_max * draw(), zeta_max * draw()
        effort = column(law, "trim_effort", v) + column(law, "gamma", v) * y
        if zeta > float(effort_ramp(effort, law.schedule.overlap)):
            continue
        found += 1
        kappa = 1 / (1 + 0.1 * draw())
        wind = v + share * float(low) * draw()
        # The law holds the estimate inside its table, and with it the rate.
        seen = np.clip(v + law.wind_filter * rates[k] * draw(), *held)
        rate = float(seen - v) / (law.wind_filter or 1.0)
        yield Point(k, e, zeta, e - y, v, rate, wind, kappa, 0.5 + 0.5 * draw())


def wake_torque(turbine: Turbine, law: CoherentLaw, p: Point, pitch: float) -> float:
    """Return what a wake between equilibrium and frozen adds: zero at the trim, steeper in pitch.

    -d/dbeta of it is the share ``wake`` of what the frozen wake's effectiveness has over the
    surface's own slope at omega*, where it has more.
    """
    omega, v = column(law, "rotor_speed", p.schedule_wind), p.schedule_wind
    trim = law.schedule.pitch(v, turbine)
    beta = trim + (pitch - trim) * (np.arange(64) + 0.5) / 64
    own = -rotor_torque_gradient(turbine, omega, beta, v)[1]
    frozen = turbine.inertia * column(law, "effectiveness_limit", v)
    return float(-p.wake * np.mean(np.maximum(frozen - own, 0.0)) * (pitch - trim))


def physical(law: CoherentLaw, p: Point) -> tuple[float, float, float]:
    """Return (omega, beta, U) of a point."""
    v = p.schedule_wind
    omega = column(law, "rotor_speed", v) + p.e
    effort = column(law, "trim_effort", v) + column(law, "gamma", v) * (p.e - p.x)
    owed = float(effort_ramp(effort, law.schedule.overlap)) - p.zeta
    return omega, law.pitch_min + owed / column(law, "effectiveness", v), effort


def lag(law: CoherentLaw, omega: float, beta: float, x: float, v: float) -> float:
    """Return zeta = b (beta_ref - beta), with the law's own command in a wind that rests."""
    command = law.command([x, v], Measurement(omega, beta, v))
    return column(law, "effectiveness", v) * (command.pitch - beta)


def commanded(law: CoherentLaw, p: Point, omega: float, beta: float) -> Command:
    """Return the law's command while its schedule wind moves."""
    seen = p.schedule_wind + law.wind_filter * p.schedule_rate
    return law.command([p.x, p.schedule_wind], Measurement(omega, beta, seen))


def derivative(turbine: Turbine, law: CoherentLaw, p: Point) -> tuple[float, float, float]:
    """Return (e', zeta', x') of the nonlinear loop, e' and zeta' by differences along the field."""
    omega, beta, _ = physical(law, p)
    v = p.schedule_wind
    command = commanded(law, p, omega, beta)
    torque = float(rotor_torque(turbine, omega, beta, p.wind)) + wake_torque(turbine, law, p, beta)
    speed = p.kappa / turbine.inertia * (torque - turbine.gear_ratio * command.torque)
    limit = turbine.pitch_rate_limit
    turn = float(np.clip((command.pitch - beta) / turbine.pitch_time_constant, -limit, limit))
    x_rate = float(law.state_rate([p.x, v], Measurement(omega, beta, v))[0])
    h = 1e-6
    ahead, behind = (
        lag(law, omega + s * speed, beta + s * turn, p.x + s * x_rate, v + s * p.schedule_rate)
        for s in (h, -h)
    )
    reference = (
        column(law, "rotor_speed", v + h * p.schedule_rate)
        - column(law, "rotor_speed", v - h * p.schedule_rate)
    ) / (2 * h)
    return speed - reference, (ahead - behind) / (2 * h), x_rate


def ends(interval: Interval) -> Floats:
    return np.array([float(interval.lower), float(interval.upper)])


def spread(factor: float, interval: Interval) -> Floats:
    """Return the range of factor times the interval, ends in order."""
    return np.sort(factor * ends(interval))


def distance(cell: LoopCell, p: Point, rates: tuple[float, float, float]) -> float:
    """Return how far a derivative is outside {A xi + d}; exact, for e' enters zeta' as it is.

    e' = a e - G (e - x) + S zeta + w_e: independent coefficients, an interval.  Given e',
    zeta' = f (e' + nu e) - (T - (b'/b) v_s') zeta + w_zeta: an interval again.
    """
    e_rate, zeta_rate, x_rate = rates
    w = float(cell.inertia_gain) * (
        float(cell.residual) + float(cell.wind_gain) * abs(p.wind - p.schedule_wind)
    ) + float(cell.reference_slope) * abs(p.schedule_rate)
    speed = spread(p.e, cell.stiffness) + spread(p.x - p.e, cell.loop_gain)
    speed = speed + spread(p.zeta, cell.lag_gain) + w * np.array([-1, 1])
    nu = float(cell.integral_rate.lower)
    turning = float(cell.effectiveness_slope) * abs(p.schedule_rate * p.zeta)
    owed = spread(e_rate + nu * p.e, cell.share_gain) + spread(-p.zeta, cell.lag_rate)
    owed = owed + (turning + float(cell.lag_disturbance)) * np.array([-1, 1])
    return max(outside(e_rate, speed), outside(zeta_rate, owed), abs(x_rate + nu * p.e))


def outside(value: float, interval: Floats) -> float:
    return float(max(interval[0] - value, value - interval[1]))


def mean_values(turbine: Turbine, law: CoherentLaw, p: Point) -> dict[str, float]:
    """Return each coefficient of the module's decomposition at one point, as a difference."""
    omega, beta, effort = physical(law, p)
    v = p.schedule_wind
    star, b, q, gamma, eps = (
        column(law, "rotor_speed", v),
        column(law, "effectiveness", v),
        column(law, "trim_effort", v),
        column(law, "gamma", v),
        law.schedule.overlap,
    )

    def torque(speed: float, pitch: float, wind: float) -> float:
        own = float(rotor_torque(turbine, speed, pitch, wind))
        return (own + wake_torque(turbine, law, p, pitch)) / turbine.inertia

    def curve(s: float) -> float:
        held = law.rated_torque - law.effort_torque * float(effort_ramp(-s, eps))
        pitch = law.pitch_min + float(effort_ramp(s, eps)) / b
        return torque(star, pitch, v) - turbine.gear_ratio * held / turbine.inertia

    reached = law.pitch_min + float(effort_ramp(effort, eps)) / b
    share = float(effort_ramp_slope(effort, eps))
    trim = curve(q)
    return {
        "stiffness": p.kappa * (torque(omega, beta, v) - torque(star, beta, v)) / p.e,
        "loop_gain": p.kappa * gamma * (curve(effort) - trim) / (q - effort),
        "lag_gain": p.kappa * (torque(star, beta, v) - torque(star, reached, v)) / p.zeta,
        "share_gain": share * gamma,
        "residual": trim,
        "wind_gain": (torque(omega, beta, p.wind) - torque(omega, beta, v)) / (p.wind - v),
    }


def excess(cell: LoopCell, values: dict[str, float]) -> dict[str, float]:
    """Return how far each mean value is outside its stated range or size."""
    found = {}
    for name, value in values.items():
        stated = getattr(cell, name)
        bounds = ends(stated) if isinstance(stated, Interval) else float(stated) * np.array([-1, 1])
        found[name] = outside(value, bounds)
    return found


def campaign(
    turbine: Turbine, law: CoherentLaw, cells: list[LoopCell], box: LoopBox, count: int, seed: int
) -> list[tuple[Point, float]]:
    """Return points with their distance to the family."""
    return [
        (p, distance(cells[p.k], p, derivative(turbine, law, p)))
        for p in points(law, box, count, seed)
    ]


def test_the_loop_lies_in_its_family(
    turbine: Turbine, law: CoherentLaw, cells: list[LoopCell]
) -> None:
    """Two thousand points of all cells, any inertia, wake and wind of the class: all inside."""
    assert max(d for _, d in campaign(turbine, law, cells, BOX, 2000, seed=1)) < ROUNDING


def test_every_mean_value_lies_in_its_range(
    turbine: Turbine, law: CoherentLaw, cells: list[LoopCell]
) -> None:
    """The decomposition of the docstring, coefficient by coefficient."""
    for p in points(law, BOX, 800, seed=2):
        if min(abs(p.e), abs(p.zeta), abs(p.e - p.x), abs(p.wind - p.schedule_wind)) > 1e-4:
            found = excess(cells[p.k], mean_values(turbine, law, p))
            assert max(found.values()) < ROUNDING, (p, found)


def test_the_rate_limit_is_a_sector(turbine: Turbine, law: CoherentLaw) -> None:
    """With a lag box so large that the drive saturates the loop still lies in its family."""
    cells = list(coherent_cells(turbine, law, FAST, WIDE, rates_of(law)))
    found = campaign(turbine, law, cells, FAST, 500, seed=3)

    assert max(d for _, d in found) < ROUNDING
    assert max(float(cell.pitch_rate) for cell in cells) > 4 * turbine.pitch_rate_limit
    assert min(cell.lag_rate.lower / cell.lag_rate.upper for cell in cells) < 0.3


def left_over(turbine: Turbine, law: CoherentLaw, p: Point) -> tuple[float, float]:
    """Return what the feed-forward leaves of a moving schedule: in speed, and in effort owed.

    From the law's own commands, with and without the rate: omega*' v_s' less what torque takes of
    it, and v_s' times the slope of psi(U) / b (by differences, e - x held) less what pitch does.
    """
    omega, beta, _ = physical(law, p)
    v, rate = p.schedule_wind, p.schedule_rate
    still = law.command([p.x, v], Measurement(omega, beta, v))
    moved = commanded(law, p, omega, beta)
    taken = turbine.gear_ratio * (still.torque - moved.torque) / turbine.inertia
    table, k = law.schedule, p.k
    slope = float((np.diff(table.rotor_speed) / np.diff(table.wind))[k])

    def asked(wind: float) -> float:
        speed = column(law, "rotor_speed", wind) + p.e
        return law.command([p.x, wind], Measurement(speed, beta, wind)).pitch

    h = 1e-6
    bent = column(law, "effectiveness", v) * (asked(v + h) - asked(v - h)) / (2 * h)
    pitched = column(law, "effectiveness", v) * (moved.pitch - still.pitch)
    return slope * rate - p.kappa * taken, bent * rate - pitched / turbine.pitch_time_constant


def leads(turbine: Turbine, law: CoherentLaw, lead: float, inertia: float) -> CoherentLaw:
    """Return the law with another pitch lead [s] and share of the torque's feed-forward."""
    ahead = known_rate_feedforward(turbine, law.schedule, inertia_share=inertia)
    return replace(law, feedforward=Feedforward(ahead.inertia, ahead.effort_limit, lead))


@pytest.mark.parametrize(("lead", "inertia"), [(0.2, 1.0), (0.1, 0.5), (0.0, 0.0), (0.3, 0.0)])
def test_what_the_feedforward_leaves_is_bounded(
    lead: float, inertia: float, turbine: Turbine, law: CoherentLaw
) -> None:
    """Both remainders from the law's commands, inside their bounds and close to them somewhere."""
    other = leads(turbine, law, lead, inertia)
    cells = list(coherent_cells(turbine, other, BOX, WIDE, rates_of(law)))
    speed, owed = [], []
    for p in points(other, BOX, 3000, seed=7):
        nodes = other.schedule.wind[p.k : p.k + 2]
        if min(abs(nodes - p.schedule_wind)) < 1e-5:
            continue
        left, lag_left = left_over(turbine, other, p)
        cell = cells[p.k]
        bound = float(cell.reference_slope * cell.wind_rate)
        assert abs(left) <= bound + 1e-12
        assert abs(lag_left) <= float(cell.lag_disturbance) + ROUNDING
        speed.append(abs(left) / bound if bound else 0.0)
        owed.append(abs(lag_left) / float(cell.lag_disturbance) if cell.lag_disturbance else 0.0)
    assert max(speed) > 0.9 and max(owed) > 0.5


@pytest.mark.parametrize(("lead", "inertia"), [(0.1, 0.5), (0.0, 0.0), (0.3, 1.0)])
def test_another_feedforward_has_its_own_family(
    lead: float, inertia: float, turbine: Turbine, law: CoherentLaw, cells: list[LoopCell]
) -> None:
    """The loop lies in the family of its own law, and not in that of the law it was before."""
    other = leads(turbine, law, lead, inertia)
    own = list(coherent_cells(turbine, other, BOX, WIDE, rates_of(law)))
    found = [(p, derivative(turbine, other, p)) for p in points(other, BOX, 1000, seed=8)]

    assert max(distance(own[p.k], p, rates) for p, rates in found) < ROUNDING
    assert max(distance(cells[p.k], p, rates) for p, rates in found) > 100 * ROUNDING


SHRUNK = (
    "stiffness",
    "loop_gain",
    "lag_gain",
    "share_gain",
    "lag_rate",
    "wind_gain",
    "effectiveness_slope",
    "reference_slope",
)


@pytest.fixture(scope="module")
def sampled(turbine: Turbine, law: CoherentLaw) -> list[tuple[Point, tuple[float, float, float]]]:
    """Return points with their derivatives, for tests that break the family."""
    return [(p, derivative(turbine, law, p)) for p in points(law, BOX, 3000, seed=4)]


@pytest.mark.parametrize("name", SHRUNK)
def test_a_family_without_one_term_is_left(
    name: str,
    cells: list[LoopCell],
    sampled: list[tuple[Point, tuple[float, float, float]]],
) -> None:
    """Each coefficient is needed: pinned to its middle, or to zero, some point falls outside."""
    pinned = []
    for cell in cells:
        change: dict[str, Any] = {name: Fraction(0)}
        if isinstance(stated := getattr(cell, name), Interval):
            change[name] = Interval(stated.centre, stated.centre)
        pinned.append(replace(cell, **change))

    assert max(distance(pinned[p.k], p, rates) for p, rates in sampled) > 100 * ROUNDING


@pytest.mark.parametrize(
    "smaller",
    [
        Uncertainty(Interval.of("0.9", "1.1"), frozen_wake=False),
        Uncertainty(Interval.of(1, 1), frozen_wake=True),
    ],
    ids=["equilibrium wake", "nominal inertia"],
)
def test_a_family_with_less_uncertainty_is_left(
    smaller: Uncertainty,
    turbine: Turbine,
    law: CoherentLaw,
    sampled: list[tuple[Point, tuple[float, float, float]]],
) -> None:
    """A frozen wake or another inertia is not inside the family that leaves it out."""
    narrow = list(coherent_cells(turbine, law, BOX, smaller, rates_of(law)))

    assert max(distance(narrow[p.k], p, rates) for p, rates in sampled) > 100 * ROUNDING


def test_corners_span_the_family(cells: list[LoopCell]) -> None:
    """Random coefficients give a loop that is a convex blend of the corners: weights by product."""
    rng = np.random.default_rng(5)
    names = ("stiffness", "loop_gain", "lag_gain", "share_gain", "lag_rate")
    cell = next(
        c for c in cells if all(getattr(c, n).width > 0 for n in names) and c.lag_disturbance
    )
    corners, nu = loop_vertices(cell), float(cell.integral_rate.lower)
    rate = float(cell.wind_rate)
    steady = float(cell.inertia_gain * cell.residual) + float(cell.reference_slope) * rate
    turning = float(cell.effectiveness_slope) * rate
    for moving in (0.0, 1.0):
        for _ in range(20):
            shares = rng.uniform(size=5)
            a, g, s, f, t = (
                (ends(getattr(cell, n)) + wider * np.array([-1, 1])) @ [1 - t, t]
                for n, t, wider in zip(names, shares, [0, 0, 0, 0, moving * turning], strict=True)
            )
            expected = [[a - g, s, g], [f * (a - g + nu), f * s - t, f * g], [-nu, 0, 0]]
            weights = np.ones(1)
            for share in [*shares, 0.5] if moving else shares:
                weights = np.outer(weights, [1 - share, share]).ravel()
            found = corners.A if moving else corners.at_rest
            assert np.tensordot(weights, found, 1) == pytest.approx(np.array(expected))
            if moving:
                assert weights @ corners.fixed == pytest.approx([steady, f * steady, 0], abs=1e-12)
    signs = corners.fixed[:, 1] - corners.A[:, 1, 2] / corners.A[:, 0, 2] * steady
    assert np.abs(signs) == pytest.approx(float(cell.lag_disturbance))


def test_a_schedule_that_moves_too_fast_is_misuse(turbine: Turbine, law: CoherentLaw) -> None:
    """40 m/s^2 asks for more than the pitch rate limit by itself; so many rates as cells."""
    fast = [40.0 for _ in rates_of(law)]

    with pytest.raises(ModelError, match="wind cell .* pitch rate .* lower the wind rate"):
        list(coherent_cells(turbine, law, BOX, WIDE, fast))
    with pytest.raises(ModelError, match="wind rates for"):
        list(coherent_cells(turbine, law, BOX, WIDE, fast[1:]))


def test_residual_between_nodes_is_inside_its_bound(
    turbine: Turbine, law: CoherentLaw, cells: list[LoopCell]
) -> None:
    """width^2/8 times the enclosed curvature holds at forty winds of every cell, without waste."""
    table, ratio = law.schedule, []
    for k, cell in enumerate(cells):
        winds = np.linspace(table.wind[k], table.wind[k + 1], 40)
        left = []
        for v in winds:
            omega = column(law, "rotor_speed", v)
            driving = float(rotor_torque(turbine, omega, table.pitch(v, turbine), v))
            held = turbine.gear_ratio * table.torque(v, turbine)
            left.append(abs(driving - held) / turbine.inertia)
        assert max(left) <= float(cell.residual)
        ratio.append(max(left) / float(cell.residual))
    assert max(ratio) > 0.3


def test_jets_are_taylor_coefficients() -> None:
    """(f / g)'' of lines, by the quotient rule and by differences."""
    f = Jet.linear(Fraction(1), Fraction(3), Fraction(1))
    g = Jet.linear(Fraction(2), Fraction(5), Fraction(1))
    t, h = np.linspace(0.01, 0.99, 50), 1e-4

    def quotient(s: Floats) -> Floats:
        return np.asarray((1 + 2 * s) / (2 + 3 * s))

    bent = (quotient(t + h) - 2 * quotient(t) + quotient(t - h)) / h**2
    both = f / g
    assert float(both.curvature.lower) - 1e-6 <= bent.min()
    assert bent.max() <= float(both.curvature.upper) + 1e-6
    assert (f * g).curvature == Interval.of(12)
    assert (f + g).slope == Interval.of(5)
    assert (f * f).scaled(Fraction(1, 2)).rounded(3).curvature == Interval.of(4)


@pytest.mark.parametrize(
    ("box", "words"),
    [
        (LoopBox(Fraction("0.045"), Fraction("0.015"), Fraction(2), Fraction("0.03")), "torque"),
        (LoopBox(Fraction("0.045"), Fraction(9), Fraction("0.04"), Fraction("0.03")), "pitch"),
        (LoopBox(Fraction(9), Fraction("0.015"), Fraction("0.04"), Fraction("0.03")), "box"),
    ],
)
def test_a_box_beyond_actuators_or_tables_is_misuse(
    box: LoopBox, words: str, turbine: Turbine, law: CoherentLaw
) -> None:
    """The message names the wind cell and what to reduce."""
    with pytest.raises(ModelError, match="wind cell") as raised:
        list(coherent_cells(turbine, law, box, WIDE, rates_of(law)))
    assert words in str(raised.value)
