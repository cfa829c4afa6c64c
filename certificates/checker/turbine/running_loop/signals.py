r"""Linear signals of a loop with uncertain factors, which are treated one by one.

A signal is a row over the states xi and over w_1 .. w_k.  ``times`` multiplies a signal y by an
uncertain factor of [low, high] = c +- r: it returns c y + w_i, where w_i = delta z_i, z_i = r y
and |delta| <= 1.  For every delta, w_i^2 <= z_i^2.  So for a positive matrix P and numbers
tau_i > 0

    -(2 xi'P (xi)' + 2 alpha xi'P xi + sum tau_i (z_i^2 - w_i^2)) > 0   for all (xi, w) but zero

proves that V = xi'P xi decays at least as exp(-2 alpha t).  The left side is one quadratic form in
(xi, w); ``decay_form`` returns its matrix.  A factor may change with time in any way.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm

Signal = dict[int, Fraction]
Span = tuple[Fraction, Fraction]
Rows = list[list[Fraction]]


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
