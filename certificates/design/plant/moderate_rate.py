"""The decay rate of a design for which none was asked: rates that double, until one costs too much.

Inputs with limits: the rates go from 1/32 to 2 of the box's crossing rate, the least over the
states of (largest rate of change in the box, with inputs at their limits) / (half-width).  It
depends on the ranges of states and inputs only: a fast pole, for example of a winding, has no
effect.  The set is the largest ellipsoid in which all limits hold.  The last rate is taken before
one at which some state with a range, alone, may start less than three fifths as far off rest as in
the largest set of all (another share by ``wished_effort``).  States without a range do not count,
because the slowest law may allow them any start, which was not asked for.

Other plants: the rates go from 1/128 to 1/2 of the plant's own fastest pole at a vertex (in
discrete time, of 1/T), and a doubling may at most double the commands: with gains K and V = x' P x
of the slower rate, the command of rule i to input k on {x' P x <= 1} is at most |K_ik P^(-1/2)|.

A plant of integrators alone has no poles to go by.  Where its inputs are limited and a state has no
range, the largest set belongs to a law that is as slow as numbers allow: such a law is left for
rates from 1/32 to 2 of 1/t, with t the time in which the inputs, at their limits, bring the last of
the states with a range from rest to its end (``reach_rates``).

None of these measures depends on units.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.certificates.design.plant.wished_effort import Price
    from takagi.lmi import Design
    from takagi.models.ts.model import TSModel

HALVINGS = 7
REACH_STEPS, REACH_DOUBLINGS = 64, 40  # of a time, and of the times that are tried about 1 s
ABSURD = 100  # times slower than the inputs could be


def moderate(
    ask: Callable[[float], Design],
    rates: list[float],
    *,
    for_set: bool,
    price: Price,
    counted: NDArray[np.bool_] | None = None,
) -> tuple[Design, str]:
    """Return the design at the last of ``rates`` that does not cost too much, and a note about it.

    Parameters
    ----------
    rates : slowest first.
    for_set : whether designs are made for the largest set; else for starts that are given.
    price : what a faster loop may cost.
    counted : (n,) states whose starts count for the set, those with a range; None for all.
    """
    best = slowest = ask(0.0)
    if not slowest.found:
        return slowest, ""

    def worth(faster: Design) -> bool:
        if not for_set:
            return _commands_suit(faster, best, price)
        enough = starts_alone(faster) >= price.starts_kept * starts_alone(slowest)
        return bool(np.all(enough if counted is None else enough[counted]))

    for rate in rates:
        faster = ask(rate)
        if not faster.found:
            break
        if best.decay_rate > 0 and not worth(faster):
            break
        best = faster
    if best.decay_rate == 0:
        why = "none that was tried has gains" if rates else "its poles give the plant no time scale"
        return best, f"no decay rate was asked for: rate 0, {why}"
    cost = f"shrinks the set below {price.starts_kept:.0%}" if for_set else _dearer(price)
    note = f"no decay rate was asked for: {best.decay_rate:.4g} 1/s"
    if faster is not best:
        note += f"; twice as fast {cost if faster.found else 'has no gains'}"
    return best, note


def pole_rates(model: TSModel) -> list[float]:
    """Return rates to try, slowest first; none for a plant whose poles are all at zero."""
    if model.sample_time is not None:
        return _doubling(1.0 / model.sample_time / 2)
    return _doubling(float(np.abs(np.linalg.eigvals(_floats(model.A))).max()) / 2)


def crossing_rates(model: TSModel, box: Floats, input_limit: Floats) -> list[float]:
    """Return rates to try, slowest first, from ranges alone; those of poles where a state has none.

    Parameters
    ----------
    box : (n,) half-widths of the states, inf for none.
    input_limit : (m,).
    """
    if model.sample_time is not None or not np.isfinite(box).all():
        return pole_rates(model)
    fastest = (np.abs(_floats(model.A)) @ box + np.abs(_floats(model.B)) @ input_limit).max(axis=0)
    return _doubling(2 * float((fastest / box).min()))


def reach_rates(model: TSModel, box: Floats, input_limit: Floats) -> tuple[list[float], float]:
    """Return rates to try, slowest first, and the time t [s] of the inputs at their limits.

    t is the largest, over the states with a range, of the time after which
    sum_k |u_k|max int_0^t |(e^{A s} B)_ik| ds reaches the half-width of state i, for the mean A and
    B of the vertices.  No rates and inf where the inputs do not move a state with a range.

    Parameters
    ----------
    box : (n,) half-widths of the states, inf for none.
    input_limit : (m,).
    """
    from scipy.linalg import expm

    A, B = _floats(model.A).mean(axis=0), _floats(model.B).mean(axis=0)
    ranged = np.flatnonzero(np.isfinite(box))

    def reach(t: float) -> Floats:
        step, found = expm(A * t / REACH_STEPS), np.zeros(len(A))
        moved = expm(A * t / REACH_STEPS / 2) @ B  # the middle of each step
        for _ in range(REACH_STEPS):
            found += np.abs(moved) @ input_limit * t / REACH_STEPS
            moved = step @ moved
        return found

    times = [2.0**k for k in range(-REACH_DOUBLINGS, REACH_DOUBLINGS)]
    arrived = (t for t in times if np.all(reach(t)[ranged] >= box[ranged]))
    high = next(arrived, np.inf)
    if not np.isfinite(high):
        return [], high
    low = high / 2
    while high > 1.01 * low:
        middle = np.sqrt(low * high)
        there = np.all(reach(middle)[ranged] >= box[ranged])
        low, high = (low, middle) if there else (middle, high)
    return _doubling(2 / high), float(high)


def slowest_mode(model: TSModel, design: Design) -> float:
    """Return the least decay rate [1/s] of the poles of A_i - B_i K_i, over the vertices."""
    gains = _floats(design.require()[0])
    loops = _floats(model.A) - _floats(model.B) @ gains
    return float(-np.linalg.eigvals(loops).real.max())


def _doubling(top: float) -> list[float]:
    # Two digits are enough, because the rate is a choice and not a result.
    return [float(f"{top / 2**k:.2g}") for k in range(HALVINGS - 1, -1, -1)] if top > 0 else []


def _dearer(price: Price) -> str:
    if price.commands == 2:
        return "more than doubles the commands"
    return f"makes the commands more than {price.commands:g} times as large"


def _commands_suit(faster: Design, than: Design, price: Price) -> bool:
    reach = np.linalg.inv(_floats(than.require()[1]))
    sizes = [
        np.sqrt(np.einsum("rmi,ij,rmj->rm", K, reach, K)).max(axis=0)
        for K in (_floats(faster.require()[0]), _floats(than.require()[0]))
    ]
    return bool(np.all(sizes[0] <= price.commands * sizes[1]))


def starts_alone(design: Design) -> Floats:
    """Return (n,): how far each state alone may start off rest in {x' P x <= 1}."""
    return np.asarray(1 / np.sqrt(np.diag(_floats(design.require()[1]))), dtype=np.float64)


def _floats(values: object) -> Floats:
    return np.asarray(values, dtype=np.float64)
