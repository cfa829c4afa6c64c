r"""The loop about the trim at v_s as rows over (xi, v', rho, w); see docs/schedule-rate.md.

A factor of [l, u] times a row y is (l + u)/2 y + w_i with w_i^2 <= z_i^2, z_i = (u - l)/2 y.
The form of the claim is ``moving_form``.
"""

from __future__ import annotations

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.turbine.running.moving_form import moving_form
from takagi.certificates.cross_check.turbine.scheduled.scheduled_cell import ScheduledCell
from takagi.certificates.cross_check.turbine.surface import NumberRange

Row = list[fmpq]
NAMES = (
    "stiffness",
    "pitch gain",
    "wind gain",
    "late pitch gain",
    "inertia",
    "pitch per signal",
    "lead",
    "pitch slope",
    "observed stiffness",
    "observed wind gain",
    "observer inertia",
    "wake rate",
)


class ScheduledRates:
    """xi' of one cell; every factor has its own w, the last columns."""

    def __init__(self, cell: ScheduledCell, factors: dict[str, NumberRange]) -> None:
        self.cell, self.spans = cell, factors
        self.n = cell.machine.states
        self.width = self.n + 2 + len(NAMES)
        self.outer: dict[str, Row] = {}
        self.rates = self._equations()

    def _unit(self, i: int) -> Row:
        return [fmpq(int(i == j)) for j in range(self.width)]

    def _times(self, name: str, row: Row) -> Row:
        span = self.spans[name]
        half = (span.high - span.low) / 2
        self.outer[name] = [half * y for y in row]
        found = [(span.low + half) * y for y in row]
        found[self.n + 2 + NAMES.index(name)] += 1
        return found

    def _equations(self) -> list[Row]:
        cell, machine, times = self.cell, self.cell.machine, self._times
        e, p, x, lag, m, o, q, eta = (self._unit(i) for i in range(8))
        wind_rate = self._unit(self.n)
        rho = _by(cell.residual, self._unit(self.n + 1))
        moved = _by(1 / machine.lag, q)
        turned = times("pitch slope", moved)
        A = _sum(times("stiffness", e), times("wind gain", lag), rho)
        A = _less(A, times("pitch gain", p))
        wake = _less(p, eta)
        y = _less(
            _sum(times("pitch per signal", _less(m, x)), times("lead", moved)),
            p,
        )
        seen = _sum(
            A,
            times("observed stiffness", _less(m, e)),
            times("observed wind gain", _less(q, lag)),
        )
        gap = _less(m, o)
        found = [
            times("inertia", _less(A, times("late pitch gain", wake))),
            _less(_by(1 / cell.rotor.drive, y), turned),
            _by(-cell.rotor.integral_rates[cell.k], m),
            _less(wind_rate, moved),
            self.filtered_rate(),
            _sum(times("observer inertia", seen), _by(machine.l1, gap)),
            _less(_by(machine.l2, gap), moved),
            _less(times("wake rate", wake), turned),
        ]
        if machine.stop is not None:
            w, first, second = machine.stop[0], self._unit(8), self._unit(9)
            found += [_by(w, _less(e, first)), _by(w, _less(first, second))]
        return found

    def filtered_rate(self) -> Row:
        """Return m' = c_l (e - 2 (1 - p_t) (y_1 - y_2) - m)."""
        machine, into = self.cell.machine, self._unit(0)
        if machine.stop is not None:
            left = 2 * (1 - machine.stop[1])
            into = _less(into, _by(left, _less(self._unit(8), self._unit(9))))
        return _by(machine.corner, _less(into, self._unit(4)))

    def sides(self) -> list[tuple[str, Row, fmpq]]:
        """Return (side, row over the states, bound): the box needs |row xi| below the bound."""
        cell, box = self.cell, self.cell.box
        e, p, x, lag, m, o, q, _ = (self._unit(i)[: self.n] for i in range(8))
        gain, lead = self.spans["pitch per signal"], self.spans["lead"]
        signal = _less(m, x)
        y = _sum(
            _by((gain.low + gain.high) / 2, signal),
            _by((lead.low + lead.high) / 2 / cell.machine.lag, q),
        )
        spread = (gain.high - gain.low) / 2 * box["signal"]
        spread += (lead.high - lead.low) / 2 * cell.rho
        return [
            ("speed", e, box["speed"]),
            ("measured", m, box["measured"]),
            ("pitch", p, box["pitch"]),
            ("signal", signal, box["signal"]),
            ("integral", x, cell.rotor.integral_limit),
            ("wind", lag, box["wind"]),
            ("estimate", q, box["estimate"]),
            ("measured_rate", self.filtered_rate()[: self.n], box["measured_rate"]),
            ("innovation", _less(m, o), box["innovation"]),
            ("drive", _less(y, p), box["drive"] - spread),
        ]

    def form(
        self, P: fmpq_mat, tau: dict[str, fmpq], shift: fmpq_mat, weights: tuple[fmpq, fmpq]
    ) -> fmpq_mat:
        """Return the matrix of the module; ``shift`` is 2 alpha P + D."""
        first = self.n + 2
        factors = {name: (first + i, self.outer[name]) for i, name in enumerate(NAMES)}
        inputs = self.n, self.n + 1
        return moving_form(self.rates, inputs, factors, P, tau, shift, weights)


def _sum(*rows: Row) -> Row:
    return [sum(column, fmpq(0)) for column in zip(*rows, strict=True)]


def _less(a: Row, b: Row) -> Row:
    return [x - y for x, y in zip(a, b, strict=True)]


def _by(factor: fmpq, row: Row) -> Row:
    return [factor * y for y in row]
