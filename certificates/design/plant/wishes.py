"""The decay rate of a design for which none was asked: rates that double, until one costs too much.

Inputs with limits: the rates go from 1/32 to 2 of the box's crossing rate, the least over the
states of (largest rate of change in the box, with inputs at their limits) / (half-width).  It
depends on the ranges of states and inputs only: a fast pole, for example of a winding, has no
effect.  The set is the largest ellipsoid in which all limits hold.  The last rate is taken before
one at which some state with a range, alone, may start less than three fifths as far off rest as in
the largest set of all (another share by ``PRICES``).  States without a range do not count,
because the slowest law may allow them any start, which was not asked for.

Other plants: the rates go from 1/128 to 1/2 of the plant's own fastest pole at a vertex (in
discrete time, of 1/T), and a doubling may at most double the commands: with gains K and V = x' P x
of the slower rate, the command of rule i to input k on {x' P x <= 1} is at most |K_ik P^(-1/2)|.

A plant of integrators alone has no poles to go by.  Where its inputs are limited and a state has no
range, the largest set belongs to a law that is as slow as numbers allow: such a law is left for
rates from 1/32 to 2 of 1/t, with t the time in which the inputs, at their limits, bring the last of
the states with a range from rest to its end (``reach_rates``).

None of these measures depends on units.

Starts for a design that needs some, where none were given.

A damping, a fastest pole, a bound on gains, or the largest decay rate with limited inputs: each
means something only together with the states from which the limits are to be kept.  The starts
taken are a share of the largest box, in the proportions of the states' ranges, from which any
gains keep all limits.

The words small, moderate and large effort, in numbers.

small      inputs may use half of their ranges; a rate is taken only if it leaves four fifths of the
           largest set; without limits of inputs gains of half the norm are tried at the same rate
moderate   inputs may use their ranges, a rate may cost two fifths of the set (or double commands)
large      a rate may cost seven tenths of the set (or make commands four times as large); without
           limits of inputs rates four times as high are tried

A limit that is given by name, ``input_limit``, is kept as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.plant.design_settings import NORMS

if TYPE_CHECKING:
    from takagi.lmi import Design
    from takagi.models.plant.design_settings import Effort, PlantSettings
    from takagi.models.ts.model import TSModel

HALVINGS = 7
REACH_STEPS, REACH_DOUBLINGS = 64, 40  # of a time, and of the times that are tried about 1 s
NO_RATE = "decay rate not given"  # with which the note begins that says what was used
TRIED_RATES = "the rates that were tried"  # with which its advice about ranges begins
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
        return best, f"{NO_RATE}; the target is 0: {why}"
    cost = f"makes the commands more than {price.commands:g} times as large"
    if for_set or price.commands == 2:
        shrinks = f"shrinks the set below {price.starts_kept:.0%}"
        cost = shrinks if for_set else "more than doubles the commands"
    note = f"{NO_RATE}; {best.decay_rate:.4g} 1/s was used as the target"
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

    ``box``: (n,) half-widths of the states, inf for none; ``input_limit``: (m,).
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
    ``box`` and ``input_limit`` as in ``crossing_rates``.
    """
    from scipy.linalg import expm

    A, B = _floats(model.A).mean(axis=0), _floats(model.B).mean(axis=0)
    ranged = np.flatnonzero(np.isfinite(box))

    def reach(t: float) -> Floats:
        step, distance = expm(A * t / REACH_STEPS), np.zeros(len(A))
        pushed = expm(A * t / REACH_STEPS / 2) @ B  # the middle of each step
        for _ in range(REACH_STEPS):
            distance += np.abs(pushed) @ input_limit * t / REACH_STEPS
            pushed = step @ pushed
        return distance

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


# Tried in this order, until there are gains.
SHARES = (0.5, 0.25, 0.125)


def needs_starts(settings: PlantSettings) -> bool:
    """Return whether limited inputs need starts for what is asked, and none were given."""
    wishes = (settings.damping, settings.fastest, settings.gain_bound)
    return not settings.initial and (
        settings.decay_rate == "max"
        or settings.objective in (*NORMS, "effort")
        or any(wish is not None for wish in wishes)
    )


def largest_set(model: TSModel, box: Floats, input_limit: Floats) -> Design:
    """Return the design whose set holds the largest multiple of the box.

    Raises
    ------
    ModelError : a state has no range, and so nothing says in which proportion it may start.
    """
    from takagi.lmi import attraction_pdc

    missing = [name for name, half in zip(model.states, box, strict=True) if np.isinf(half)]
    if missing:
        first = missing[0].partition(" [")[0]
        raise ModelError(
            f"state {first} has neither a range nor a start, and with limited inputs damping, "
            f'fastest, gain_bound, an objective and decay_rate = "max" need one; give {first} a '
            f"range, or initial = {{ {first} = half-width }}"
        )
    return attraction_pdc(
        model, input_limit=input_limit, state_box=box, saturation=None, measure=box
    )


def largest_multiple(design: Design, box: Floats) -> float:
    """Return a number whose multiple of the box is inside {x' P x <= 1}, the largest within it."""
    from takagi.lmi.gains.requirements.limits import corners_of_box

    corners = corners_of_box(box)
    values = np.einsum("ki,ij,kj->k", corners, np.asarray(design.require()[1]), corners)
    return float(1 / np.sqrt(values.max()))


def held_from(model: TSModel, initial: list[float], input_limit: Floats, gains: Floats) -> bool:
    """Return whether a proved set, in which the inputs keep their limits, holds the initial box.

    ``initial`` : (n,) half-widths.
    """
    from takagi.certificates.requests.invariant_ellipsoid import InputLimits
    from takagi.certificates.requests.loop.loop import ClaimedLoop
    from takagi.lmi.gains.requirements.limits import corners_of_box

    starts = corners_of_box(np.asarray(initial))
    attempt = InputLimits(input_limit).attempt(ClaimedLoop.of(model, gains))
    P, level = np.asarray(attempt.claim["P"], dtype=np.float64), float(attempt.claim["level"])
    values = np.einsum("ki,ij,kj->k", starts, P, starts)
    return attempt.proved and bool(np.all(values <= level))


@dataclass(frozen=True, slots=True)
class Price:
    """What a wish allows.

    Attributes
    ----------
    room : share of an input's range that commands may use.
    starts_kept : share of the largest set's starts that a faster loop must leave.
    commands : how many times as large a doubled rate may make the commands.
    """

    room: float
    starts_kept: float
    commands: float


PRICES: dict[Effort, Price] = {
    "small": Price(room=0.5, starts_kept=0.8, commands=1.5),
    "moderate": Price(room=1.0, starts_kept=0.6, commands=2.0),
    "large": Price(room=1.0, starts_kept=0.3, commands=4.0),
}
# Shares of the largest gain's norm that a small effort tries, least first.
SMALLER = (0.5, 0.7, 0.85)


def gain_size(design: Design) -> float:
    """Return the largest spectral norm of a gain, in the units of the model."""
    gains = np.asarray(design.require()[0])
    return float(np.linalg.norm(gains, 2, axis=(1, 2)).max())
