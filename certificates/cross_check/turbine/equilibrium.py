r"""``equilibrium``: the number of equilibria of a turbine's loop at each constant wind, v_s = v.

At an equilibrium pitch is equal to the law's command, and nothing is fed forward.  Either
x' = -nu e is 0, or x is held at its limit -+X while e pushes it outward.  So each equilibrium is a
zero of

    f = c v^2 c_Q(lambda, beta) - (T_rated n_g / J - m psi(-U))_+,     U = q* + gamma (e - x),
    beta = min(beta_min + psi(U) / b, beta_max),      lambda = R (omega* + e) / v

    inside   e = 0,    x in [-X, X]
    upper    x = X,    e <= 0:  lambda from the table's lower end to lambda* = R omega* / v
    lower    x = -X,   e >= 0:  lambda from lambda* to the table's upper end

The answer holds for any wake.  A wake adds a torque that is 0 at the trim's pitch (U = q*) and does
not increase with pitch: it is not negative for U <= q*, not positive for U >= q*, and does not
decrease with x.  So f > 0 at x >= 0, f < 0 at x <= 0 and df/dx > 0 stay true with a wake.  The
answer is "one" if these three alone show, at every wind of the cell, one zero inside and none at a
limit.  It is "several" if, without a wake, f changes its sign at least twice along curves inside
the table.

Winds and curves are halved until the answer is decided.  All of this follows from the law and the
balance of torques; docs/equilibria.md states what is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from flint import fmpq

from takagi.certificates.cross_check.kernel.obligation import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    NotReplayed,
    Refusal,
    entry,
    line,
    rationals,
)
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside
from takagi.certificates.cross_check.turbine.torque_balance import (
    Balance,
    BalanceSign,
    Looks,
    middle,
    settled,
)

OF_THE_PAPER = {"one at the trim", "one off the trim", "none", "continuum"}  # never of this law
ANSWERS = {"one", "several"} | OF_THE_PAPER
LAWS_OF_THE_PAPER = ("paper", "paper-two-integrators")
# Results that do not contradict an answer, and do not prove it: the claim is then not replayed.
NOT_ONE = "not one"
OPEN = {"one": (None,), "several": (None, NOT_ONE)}
MOST_CELLS = 2000
HALVED_WINDS, HALVED_CURVE = 3, 8
ZERO = fmpq(0)


def equilibrium(claim: Any, model: Any, gains: Any) -> Obligations:
    """Yield, for every cell of winds, that the number of equilibria is the stated one.

    Raises
    ------
    NotReplayed : a published law, or a cell that the allowed halvings do not decide.
    """
    if line(gains, "name") in LAWS_OF_THE_PAPER:
        raise NotReplayed("rests of a published law")
    rotor = Rotor(model, gains)
    cells = entry(claim, "cells")
    if not isinstance(cells, list) or len(cells) not in range(1, MOST_CELLS + 1):
        raise Refusal(f"cells: 1 to {MOST_CELLS} are needed")
    looks = Looks()
    for number, cell in enumerate(cells, start=1):
        low, high = rationals(cell, "wind", 2)
        said = line(cell, "rests")
        if said not in ANSWERS or not rotor.wind[0] <= low < high <= rotor.wind[-1]:
            raise Refusal(f"cell {number}: winds of the law and a known answer are needed")
        places = [
            k for k, v in enumerate(rotor.wind[:-1]) if v <= low and high <= rotor.wind[k + 1]
        ]
        yield Fact(f"cell {number}: winds between two nodes", bool(places))
        for k in places[:1]:
            for found in _found(rotor, k, NumberRange(low, high), looks, HALVED_WINDS):
                if found in OPEN.get(said, ()):
                    raise NotReplayed(f"cell {number} is not decided by so many halvings")
                yield Fact(f"cell {number}: rests as stated", found == said)


Curve: TypeAlias = Callable[[NumberRange], BalanceSign]
Parts: TypeAlias = list[tuple[NumberRange, BalanceSign]]


def _found(
    rotor: Rotor, k: int, winds: NumberRange, looks: Looks, depth: int
) -> Iterator[str | None]:
    """Yield the answer for parts of the winds; None where it is not decided."""
    try:
        found = _rests(Balance(rotor, k, winds, looks))
    except Outside:
        found = None
    if found is not None or depth == 0:
        yield found
        return
    centre = (winds.low + winds.high) / 2
    for half in (NumberRange(winds.low, centre), NumberRange(centre, winds.high)):
        yield from _found(rotor, k, half, looks, depth - 1)


def _rests(at: Balance) -> str | None:
    limit = at.rotor.integral_limit
    halves = [*_parts(at.inside, NumberRange(-limit, ZERO), _kept_below)]
    halves += _parts(at.inside, NumberRange(ZERO, limit), _kept_above)
    zeros, kept = _rising_zeros(at.inside, halves)
    table = at.rotor.surface.x.breaks
    if kept:
        upper = _parts(at.upper, NumberRange(table[0], at.trim_ratio.high), _signed)
        lower = _parts(at.lower, NumberRange(at.trim_ratio.low, table[-1]), _signed)
        alone = all(_no_zero(look, 1) for _, look in upper)
        if alone and all(_no_zero(look, -1) for _, look in lower):
            return "one" if zeros == 1 else "none" if zeros == 0 else NOT_ONE
    changes = _changes(at.inside, NumberRange(-limit, limit), 2)
    changes += _changes(at.upper, NumberRange(table[0], at.trim_ratio.low))
    changes += _changes(at.lower, NumberRange(at.trim_ratio.high, table[-1]))
    if changes > 1:
        return "several"
    return None if zeros in (None, 1) else NOT_ONE


def _signed(look: BalanceSign) -> bool:
    return look.sign != 0 or look.empty


def _kept_below(look: BalanceSign) -> bool:
    """Return whether a part with x <= 0 is decided for every wake."""
    return look.sign < 0 or look.rises or look.empty


def _kept_above(look: BalanceSign) -> bool:
    """Return whether a part with x >= 0 is decided for every wake."""
    return look.sign > 0 or look.rises or look.empty


def _no_zero(look: BalanceSign, sign: int) -> bool:
    return look.empty or look.sign == sign


def _parts(
    curve: Curve,
    span: NumberRange,
    decided: Callable[[BalanceSign], bool],
    halved: int = HALVED_CURVE,
) -> Parts:
    """Return the curve in parts; each is halved until it is decided, ``halved`` times at most."""
    found: Parts = []
    waiting = [(span, halved)]
    while waiting:
        part, left = waiting.pop()
        look = curve(part)
        if decided(look) or left == 0:
            found.append((part, look))
            continue
        centre = (part.low + part.high) / 2
        waiting += [
            (NumberRange(centre, part.high), left - 1),
            (NumberRange(part.low, centre), left - 1),
        ]
    return found


def _rising_zeros(curve: Curve, parts: Parts) -> tuple[int | None, bool]:
    """Return the number of zeros without a wake, and whether it is the same with every wake.

    Each part either has a sign that no wake changes, or f increases on it.  The number is None if
    a part has neither property, or if the sign at an end of an increasing part is not decided.
    """
    zeros, k, kept = 0, 0, True
    while k < len(parts):
        span, look = parts[k]
        if look.empty or settled(span, look.sign):
            k += 1
            continue
        first = k
        while k < len(parts) and parts[k][1].rises:
            k += 1
        if k == first:
            return None, False
        start, end = parts[first][0].low, parts[k - 1][0].high
        left, right = curve(NumberRange(start, start)).sign, curve(NumberRange(end, end)).sign
        if left == 0 or right == 0:
            return None, False
        # f increases on [start, end], so that it has at most one zero there.  A wake keeps f > 0
        # only at x >= 0 and f < 0 only at x <= 0; at other ends it may change the sign.
        zeros += left < right
        kept &= start <= 0 <= end if left < right else end <= 0 if right < 0 else start >= 0
    return zeros, kept


def _changes(curve: Curve, span: NumberRange, halved: int = HALVED_CURVE) -> int:
    """Return a lower bound of the sign changes of f along the parts of a curve inside the table."""
    changes, last = 0, 0
    for part, look in _parts(curve, span, _signed, halved):
        if not look.whole:
            last = 0
            continue
        points = (NumberRange(part.low, part.low), middle(part), NumberRange(part.high, part.high))
        for sign in [look.sign] if look.sign else [curve(point).sign for point in points]:
            changes += sign != 0 and last == -sign
            last = sign or last
    return changes
