r"""The running loop at the constant winds of one cell, as signals with uncertain factors.

States, each as its distance from the rest at the wind v:

    e = omega - omega*(v)         p = b0 (beta - beta_rest)      x  the law's integral
    s = v_s - v                   m = omega_m - omega*(v)        o = omegahat - omega*(v)
    z = vhat - v                  eta = b0 (the wake's pitch - beta_rest)
    y1, y2  the two poles of the band-stop, where there is one, less omega*(v)

with kappa nominal over true inertia, and all of [.] a factor from a range:

    error = m - [omega*'] s
    u    = [q*'] s + [gamma] (error - x)                     U - U_rest
    g    = [f] u                                             psi(U) - psi(U_rest)
    rate = ([1; 0 to 1 at a table's end] z - s) / tau_f
    E    = m_E (u - g)                                       the generator's torque over J
    A    = [a] e - [sigma] p                                 the table's torque over J
    e'   = [kappa] (A - [h] (p - eta) - E)
    p'   = [drive] ([b0 / b] g - [psi b0 b'/ b^2] s - p) / tau
    x'   = -[nu] error,   s' = rate
    m'   = c (e - 2 (1 - passed) (y1 - y2) - m),   y1' = w (e - y1),   y2' = w (y1 - y2)
    o'   = [J / J_o] (A + [a2] (m - e) + [d] z - E) + l_1 (m - o),   z' = l_2 (m - o)
    eta' = [wake's rate] (p - eta)

The factors are secants between the state and the rest, so they lie in the ranges of the derivatives
over the box.  In the second line [q*'] is q*' and |gamma'| |x_rest| of both signs, since

    U - U_rest = q*(v_s) - q*(v) + gamma(v_s) (error - x) - (gamma(v_s) - gamma(v)) x_rest .

A signal is a row over the states xi and over w_1 .. w_k.  ``times`` multiplies a signal y by an
uncertain factor of [low, high] = c +- r: it returns c y + w_i, where w_i = delta z_i, z_i = r y
and |delta| <= 1.  For every delta, w_i^2 <= z_i^2.  So for a positive matrix P and numbers
tau_i > 0

    -(2 xi'P (xi)' + 2 alpha xi'P xi + sum tau_i (z_i^2 - w_i^2)) > 0   for all (xi, w) but zero

proves that V = xi'P xi decays at least as exp(-2 alpha t).  The left side is one quadratic form in
(xi, w); ``decay_form`` returns its matrix.  A factor may change with time in any way; the share f
lies at every instant in one of its pieces, each with multipliers of its own, and P is the same for
all.  By side^2 P > h'h the closed set {V <= 1} lies inside the open box; V is absolutely continuous
and decreases in the box, so a motion leaves neither.  Where nu jumps at a node of the tables,
motions are Filippov's: the inequality holds for both fields, and for their convex combinations.

The ranges of the factors, and what the theorem assumes, stand in docs/running-loop.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import lcm

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.turbine.effort_sharing.wind_cell import FULL
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Span

Signal = dict[int, Fraction]
Rows = list[list[Fraction]]
(E, P, X, S, M, SEEN, Z, ETA, FIRST, SECOND) = range(10)
Factors = Mapping[str, Span]
# The names of the factors; each is used once.
FACTORS = frozenset({
    "speed slope", "effort slope", "gamma", "share", "held estimate", "stiffness", "pitch gain",
    "late pitch gain", "pitch per effort", "pitch by schedule", "observed stiffness", "wind gain",
    "inertia", "drive", "integral rate", "observer inertia", "wake rate",
})  # fmt: skip


def combined(*parts: tuple[Fraction | int, Signal]) -> Signal:
    """Return the sum of factor times signal."""
    found: Signal = {}
    for factor, signal in parts:
        for place, value in signal.items():
            found[place] = found.get(place, Fraction(0)) + factor * value
    return found


class Signals:
    """The states, and the uncertain factors that have been used so far."""

    def __init__(self, states: int) -> None:
        self.states = states
        self.outer: list[Signal] = []
        self.names: list[str] = []

    def state(self, place: int) -> Signal:
        return {place: Fraction(1)}

    def times(self, name: str, span: Span, signal: Signal) -> Signal:
        """Return the signal times an uncertain factor from the interval."""
        low, high = span
        middle, radius = (low + high) / 2, (high - low) / 2
        if radius == 0 or not signal:
            return combined((middle, signal))
        self.outer.append(combined((radius, signal)))
        self.names.append(name)
        return combined((middle, signal), (1, {self._size() - 1: Fraction(1)}))

    def row(self, signal: Signal) -> list[Fraction]:
        """Return the signal's row over states and all w."""
        return [signal.get(place, Fraction(0)) for place in range(self._size())]

    def _size(self) -> int:
        return self.states + len(self.outer)


def states(machine: Machine) -> int:
    """Return the number of states: ten with a band-stop, eight without."""
    return 10 if machine.stop else 8


def equations(cell: Cell, span: Factors, held: Span) -> tuple[Signals, list[Signal]]:
    """Return the signals and the states' rates for a share of pitch from ``held``."""
    machine = cell.machine
    signals = Signals(states(machine))

    def times(name: str, signal: Signal) -> Signal:
        return signals.times(name, span[name], signal)

    e, p, x, s, m, o, z, eta = (signals.state(i) for i in range(8))
    error = combined((1, m), (-1, times("speed slope", s)))
    u = combined((1, times("effort slope", s)), (1, times("gamma", combined((1, error), (-1, x)))))
    g = signals.times("share", held, u)
    seen = times("held estimate", z)
    rate = combined((1 / machine.wind_filter, seen), (-1 / machine.wind_filter, s))
    unit = cell.effort_unit
    braking = combined((unit, u), (-unit, g))
    table = combined((1, times("stiffness", e)), (-1, times("pitch gain", p)))
    late = times("late pitch gain", combined((1, p), (-1, eta)))
    distance = combined(
        (1, times("pitch per effort", g)),
        (-1, times("pitch by schedule", s)),
        (-1, p),
    )
    seen_torque = combined(
        (1, table),
        (1, times("observed stiffness", combined((1, m), (-1, e)))),
        (1, times("wind gain", z)),
        (-1, braking),
    )
    apart = combined((1, m), (-1, o))
    rates = [
        times("inertia", combined((1, table), (-1, late), (-1, braking))),
        combined((1 / cell.plant.lag, times("drive", distance))),
        combined((-1, times("integral rate", error))),
        rate,
        measured_rate(machine),
        combined((1, times("observer inertia", seen_torque)), (machine.l1, apart)),
        combined((machine.l2, apart)),
        times("wake rate", combined((1, p), (-1, eta))),
    ]
    if machine.stop:
        w, first, second = machine.stop[0], signals.state(FIRST), signals.state(SECOND)
        rates += [combined((w, e), (-w, first)), combined((w, first), (-w, second))]
    return signals, rates


def measured_rate(machine: Machine) -> Signal:
    """Return m', which has no uncertain factor."""
    c = machine.corner
    found = {E: c, M: -c}
    if machine.stop:
        left = 2 * (1 - machine.stop[1]) * c
        found |= {FIRST: -left, SECOND: left}
    return found


def rows(cell: Cell, span: Factors) -> dict[str, tuple[list[Fraction], Fraction]]:
    """Return, by side of the box, the row h and the bound of |h xi| that must hold on the set.

    Signal and effort have uncertain factors.  Each is replaced by the middle of its range, and the
    bound is the side less the largest effect of the deviation from the middle.
    """
    sides, machine = cell.sides, cell.machine
    (w, dw), (gamma, dgamma), (q, dq) = (
        ((low + high) / 2, (high - low) / 2)
        for low, high in (span[name] for name in ("speed slope", "gamma", "effort slope"))
    )
    signal = combined((1, {M: FULL}), (-1, {X: FULL}), (-w, {S: FULL}))
    effort = combined((q, {S: FULL}), (gamma, signal))
    away = dw * sides.schedule
    spread = dq * sides.schedule + dgamma * sides.signal + gamma * away
    wanted: dict[str, tuple[Signal, Fraction]] = {
        "speed": ({E: FULL}, sides.speed),
        "measured": ({M: FULL}, sides.measured),
        "pitch": ({P: FULL}, sides.pitch),
        "signal": (signal, sides.signal - away),
        "effort": (effort, sides.effort - spread),
        "schedule": ({S: FULL}, sides.schedule),
        "estimate": ({Z: FULL}, sides.estimate),
        "integral": ({X: FULL}, sides.integral),
        "measured_rate": (measured_rate(machine), sides.measured_rate),
    }
    count = states(machine)
    return {
        name: ([row.get(i, Fraction(0)) for i in range(count)], bound)
        for name, (row, bound) in wanted.items()
    }


def decay_form(
    signals: Signals, rates: list[Signal], P: Rows, tau: list[Fraction], alpha: Fraction
) -> list[list[int]]:
    """Return the module's matrix times a positive integer; ``rates`` are the states' derivatives.

    It is computed over integers with one common denominator: fractions would take ten times as
    long.
    """
    n, size = signals.states, signals.states + len(signals.outer)
    F, of_F = _whole([signals.row(rate) for rate in rates])
    whole_P, of_P = _whole(P)
    outer = [_whole([signals.row(one)]) for one in signals.outer]
    weights = [weight / of_z**2 for weight, (_, of_z) in zip(tau, outer, strict=True)]
    common = lcm(of_P * of_F, of_P * alpha.denominator, *(w.denominator for w in weights))
    common = lcm(common, *(weight.denominator for weight in tau))
    form = [[0] * size for _ in range(size)]
    times, shift = common // (of_P * of_F), 2 * alpha.numerator * common // alpha.denominator
    for i in range(n):
        for j in range(size):
            left = times * sum(whole_P[i][k] * F[k][j] for k in range(n))
            form[i][j] -= left
            form[j][i] -= left
        for j in range(n):
            form[i][j] -= shift * whole_P[i][j] // of_P
    for k, (weight, scaled, (rows, _)) in enumerate(zip(tau, weights, outer, strict=True)):
        form[n + k][n + k] += weight.numerator * (common // weight.denominator)
        factor = scaled.numerator * (common // scaled.denominator)
        filled = [(i, a) for i, a in enumerate(rows[0]) if a]
        for i, a in filled:
            for j, b in filled:
                form[i][j] -= factor * a * b
    return form


def _whole(rows: Rows) -> tuple[list[list[int]], int]:
    """Return rows times their least common denominator, and that."""
    scale = lcm(*(entry.denominator for row in rows for entry in row))
    return [
        [entry.numerator * (scale // entry.denominator) for entry in row] for row in rows
    ], scale


BITS = 64  # of the diagonal of a rounded form


def rounded_form(matrix: Sequence[Sequence[int]]) -> Matrix:
    """Return a matrix with short entries that is positive definite only if M is.

    With D = diag(2^-e_i), entries of D M D are rounded down to integers: D M D = R + E, E symmetric
    with entries from 0 to 1, so its eigenvalues are at most n in size.  If R - n I > 0 then M > 0.
    The e_i make the diagonal of D M D about 2^BITS, so that n is negligible.
    """
    n = len(matrix)
    shifts = [(matrix[i][i].bit_length() - BITS) // 2 for i in range(n)]
    return Matrix(
        [
            [_shifted(matrix[i][j], shifts[i] + shifts[j]) - n * (i == j) for j in range(n)]
            for i in range(n)
        ]
    )


def _shifted(value: int, places: int) -> int:
    """Return value / 2^places, rounded down."""
    return value >> places if places >= 0 else value << -places
