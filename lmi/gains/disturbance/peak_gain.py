r"""Gains with the least peak-to-peak gain from disturbance to output, by an invariant ellipsoid.

With Q = P^-1, M_j = K_j Q, u = -sum_j h_j K_j x, Z_ij = C_i Q - D12_i M_j, one alpha > 0, and
sigma = 2 alpha, or 1 - rho^2 with rho = e^(-alpha T),

    continuous   Theta_ij = [ He(G_ij) + sigma Q   E_i / sqrt(sigma) ]
                            [ .                    -I                ]

    discrete     Theta_ij = [ He(G_ij) + sigma Q   E_i / sqrt(sigma)   G_ij'              ]
                            [ .                    -I                  E_i' / sqrt(sigma) ]
                            [ .                    .                   -Q                 ]

    both           Phi_ij = [ -Q   Z_ij'    ]
                            [ .    -kappa I ]

with G_ij, and a scaling of the first two block rows, as in ``disturbed_plant``.
sum_ij h_i h_j Theta_ij < 0 gives V' <= sigma (|w|^2 - V), or V(x+) <= rho^2 V + sigma |w|^2, for
V = x' P x: for |w| <= 1 nothing leaves x' P x <= 1, and a trajectory from x = 0 stays inside.
sum_ij h_i h_j Phi_ij < 0 gives |C x + D12 u|^2 <= kappa there, and
|z| <= sqrt(kappa) + max_i |D11_i|.

Source: Abedor, Nagpal, Poolla (1996), Int. J. Robust and Nonlinear Control 6; Boyd, El Ghaoui,
Feron, Balakrishnan (1994), sections 6.1.3 and 7.3, for one gain; Tanaka and Wang (2001).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.disturbance.peak_to_peak import positive_rate
from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import positive_number
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, block, identity, matrix
from takagi.lmi.gains.disturbance.design import asked_or_least, below, designed, hidden, tamed
from takagi.lmi.gains.disturbance.disturbed_plant import (
    Disturbed,
    DisturbedPlant,
    LoopBlocks,
    Performance,
    disturbed_condition,
    plant_of,
    root_share,
    sum_of,
)
from takagi.lmi.gains.disturbance.request import (
    DisturbanceCoordinates,
    DisturbanceRequest,
    Norm,
    disturbance_request,
    guessed_regulator,
    is_definite,
)
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits
from takagi.lmi.gains.zero_gains import warns_of_zero_gains
from takagi.lmi.parameter_search.parameter_sweep import least_over_rate, unknowns_near_least
from takagi.lmi.solver.time_limit import out_of_time
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.models.arrays import Floats

SOURCE = (
    "Abedor, Nagpal, Poolla (1996); Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.3; "
    "Tanaka and Wang (2001)"
)


def peak_pdc_condition(
    model: Disturbed | DisturbedPlant,
    *,
    decay_rate: float,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    limits: Limits | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0, sum_ij h_i h_j Phi_ij < 0, Q > 0; kappa is least.

    Parameters
    ----------
    model, performance : the plant, as for ``peak_pdc``.
    decay_rate : alpha in 1/s, positive.  Not a parameter of the condition: it appears in a constant
        too, so another rate is another condition.
    relaxation : how the double sums are made LMIs; see ``relaxations``.
    limits : on inputs, states and gains, in the model's coordinates; those on the ellipsoid hold
        for |w| <= 1.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns the condition in the model's coordinates as they are, with the unknowns ``Q``, ``M``,
    ``kappa`` and those of the relaxation.  Nothing is solved.

    Raises ModelError: shapes, entries that are not finite, no disturbance, no output, an unknown
    relaxation, a decay rate that is not positive.
    """
    plant = plant_of(model, performance, sample_time)
    rate = positive_rate(decay_rate)
    r, n, m = plant.B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    kappa = Unknown("kappa", 1, 1, latex=r"\kappa")
    return disturbed_condition(
        plant,
        Q,
        M,
        (_loop(plant, Q, M, rate), _output(plant, Q, M, kappa)),
        relaxation=relaxation,
        limits=limits,
        minimise=kappa,
        unknowns=(kappa,),
        name="peak-to-peak gain",
        source=SOURCE,
    )


def _loop(plant: DisturbedPlant, Q: Unknown, M: Unknown, rate: float) -> DoubleSum:
    step, root, loop = plant.sample_time, root_share(plant), LoopBlocks.of(plant, Q, M)
    sigma = 2.0 * rate if step is None else -float(np.expm1(-2.0 * rate * step))
    share = sigma / root**2
    latex = r"\sigma" if step is None else r"\tfrac{\sigma}s"
    # Divided so that the disturbance's block is I however slow the decay.
    shared, over = float(np.sqrt(share)), rf"\tfrac1{{\sqrt{{{latex}}}}}"
    name = f"{over} E_{{i}}" if step is None else rf"{over} \tfrac1{{\sqrt s}} \bar E_{{i}}"
    E = matrix(plant.E / (root**2 * shared), name, over="i")
    decaying = He(loop.G) + matrix([[share]], latex) * Q
    minus_one = -identity(plant.E.shape[2])
    if loop.next_G is None:
        return sum_of(plant, block([[decaying, E], [None, minus_one]]))
    next_E = matrix(plant.E / (root * shared), rf"{over} \bar E_{{i}}", over="i")
    theta = block([[decaying, E, None], [None, minus_one, None], [loop.next_G, next_E, -Q]])
    return sum_of(plant, theta)


def _output(plant: DisturbedPlant, Q: Unknown, M: Unknown, kappa: Unknown) -> DoubleSum:
    Z, p = LoopBlocks.of(plant, Q, M).output, plant.C.shape[1]
    return sum_of(plant, block([[-Q, None], [Z, -kappa * identity(p)]]), "output")


# Rates are looked for from the slowest over this to the fastest times it.
AROUND = 10.0
# Rates around that of plain compensation, and how many.
SLOWER, FASTER, SLOW = 20.0, 5.0, 9
# A rate is tried in states of up to this many sizes.
RESIZED_LOOKS = 5
# States of another size are tried while all eigenvalues of Q are above the first number, and the
# largest is above the second or the LMIs are nearly met.
SMALL_Q, LARGE_Q = 0.05, 100.0
# A smaller margin is far from feasible; a negative one of this size is rounding.
FAR_FROM_FEASIBLE, ROUNDING_MARGIN = -0.05, 1e-5
# Number of tried rates for which gains are designed, the best first, until there are gains.
RATES_DESIGNED = 4
# So many in a decade.
COARSE, FINE = 2, 12
# Steps of the golden section stop here, relative to the rate; the gain is flat at its least.
RATE_TOLERANCE = 1e-2


@warns_of_zero_gains
def peak_pdc(
    model: Disturbed,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float | None = None,
    disturbance_peak: float = 1.0,
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    norm_below: float | None = None,
    tolerance: float = 1e-6,
    sample_time: float | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least gamma in sup |z| <= gamma sup |w|.

    From rest, for every blend of the vertices, however fast it varies; |.| is the Euclidean norm at
    one instant.  gamma is an upper bound on the peak-to-peak gain of the loop.

    Parameters
    ----------
    model, performance : the plant, as for ``hinf_pdc``.
    relaxation : as for ``pdc``.
    decay_rate : alpha in 1/s of V in the LMIs, which the undisturbed loop shows; None looks for the
        best one, by a grid and the golden section: some thirty solves.  Where limits are so tight
        that no rate was found the status is "unknown".
    disturbance_peak : the |w| for which the limits below must hold; it does not change gamma
        where there are none.
    input_limit, initial_box, state_box : as for ``pdc``, on x' P x <= 1, which no
        state leaves for |w| <= disturbance_peak.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition.
    norm_below : gamma of at most this is enough: the gains are those with the largest margin, and
        "infeasible" means that by this relaxation none reach it; None asks for the least.
    tolerance : how far above the least gamma of its alpha the gains may be, relative; see
        ``hinf_pdc``.
    sample_time : T in s where the model cannot say.

    Returns a ``Design``; its ``answer.gain`` is gamma in units of z over units of w, for which
    every LMI was checked by eigenvalues with the gains as they are returned; ``decay_rate`` is
    alpha.  A direct path D11 is added with its norm, which is exact for one output and one
    disturbance.  Nothing is proved here.

    Not promised: as for ``hinf_pdc``; nor that no other alpha gives less.

    Raises ModelError: shapes, numbers, an unknown relaxation, no disturbance, no output, inputs
    that are dependent or do nothing, a vertex with an unstable mode that no input moves.

    Source: Abedor, Nagpal, Poolla (1996), Int. J. Robust and Nonlinear Control 6; Boyd, El Ghaoui,
    Feron, Balakrishnan (1994), sections 6.1.3 and 7.3; Tanaka and Wang (2001).
    """
    rate = None if decay_rate is None else positive_rate(decay_rate)
    limits = GivenLimits(
        input_limit=input_limit,
        initial_box=initial_box,
        state_box=state_box,
        gain_bound=gain_bound,
        sample_time=sample_time,
    )
    task = disturbance_request(
        model,
        limits,
        Norm(peak_pdc_condition, _peak_gain, lambda task, units: 1.0),
        performance=performance,
        relaxation=relaxation,
        decay_rate=rate or 0.0,
        tolerance=tolerance,
    )
    peak = positive_number("disturbance_peak", disturbance_peak)
    # The objective is kappa, the square.
    task = replace(task, tolerance=2 * task.tolerance, peak=peak)
    if rate is not None:
        return asked_or_least(task, norm_below)
    apart = hidden(task) if norm_below is None else None
    if apart is not None:
        return apart
    search = _Search(task)
    if norm_below is not None:
        return _below(search, positive_number("norm_below", norm_below))
    if search.best() is None:
        return _without_rate(task, search.rates(FINE))
    return tamed(task, _least(search), lambda value: _below(search, value))


def _least(search: _Search) -> Design:
    """Return gains with the least peak of the rates that were looked at."""
    tried: list[Design] = []
    # Gains with the least bound of all may be too large to be told: then others are near it.
    for rate_result in sorted(search.seen, key=lambda rate_result: rate_result.gain)[
        :RATES_DESIGNED
    ]:
        tried.append(designed(search.task_at(rate_result)))
        if tried[-1].found or out_of_time():
            return tried[-1]
    return tried[0]


def _below(search: _Search, value: float) -> Design:
    """Return gains with at most this peak, at the rate whose least one is nearest to it."""
    if not search.seen:
        search.best()
    direct = _direct(search.task)
    by_gain = sorted(search.seen, key=lambda rate_result: rate_result.gain)
    candidates = [rate_result for rate_result in by_gain if rate_result.gain + direct <= value][
        ::-1
    ] or by_gain[:1]
    for rate_result in candidates[:RATES_DESIGNED]:
        design = below(search.task_at(rate_result), value)
        if design.found or out_of_time():
            return design
    return design if candidates else _without_rate(search.task, search.rates(FINE))


class _Look(NamedTuple):
    """The least gain that was found at a rate [1/s], and the P and growth to look from next."""

    gain: float
    rate: float
    P: Floats
    growth: float


class _Search:
    """Search for the best decay rate, each time in coordinates where the last P was |x|^2."""

    def __init__(self, task: DisturbanceRequest) -> None:
        self.task = task
        self._regulator = guessed_regulator(task.plant)
        n = task.plant.A.shape[1]
        self.growth = 1.0
        # The rate [1/s] that ``growth`` is for; None where it is the same for all.
        self.near: float | None = None
        self.feedback: Floats | None = None
        self.P = np.eye(n) if self._regulator is None else self._regulator.P
        self.begun = self.P
        self.seen: list[_Look] = []

    def best(self) -> float | None:
        """Return about the rate with the least gain in 1/s; None where none was found.

        Rules that can hardly be stabilised decay slowly, at about the rate that plain compensation
        shows; limits may leave a narrow range of rates, so a finer grid is tried last.
        """
        for tried in range(3):
            self.seen.clear()
            if tried == 1:
                rates = self._slow_rates()
            else:
                self.P, self.growth, self.feedback, self.near = self.begun, 1.0, None, None
                rates = self.rates(FINE if tried else COARSE)
            rate = least_over_rate(self.value, rates, tolerance=RATE_TOLERANCE) if rates else None
            if rate is not None:
                self.value(rate)
                return rate
        return None

    def task_at(self, rate_result: _Look) -> DisturbanceRequest:
        """Return the task at a look's rate, from there."""
        return replace(
            self.task,
            decay_rate=rate_result.rate,
            guess=rate_result.P,
            growth=rate_result.growth,
            feedback=self.feedback,
        )

    def _go_to_best(self) -> None:
        """Go where the least gain so far was found: from elsewhere a rate may show far more."""
        best = min(self.seen, key=lambda rate_result: rate_result.gain)
        self.P, self.growth = best.P, best.growth
        self.near = None if self.near is None else best.rate

    def _slow_rates(self) -> list[float]:
        """Return rates around that of plain compensation, and begin from its function."""
        plain = self.task.plain()
        rate = plain.answer.decay_rate or 0.0
        if plain.P is None or plain.gains is None or not rate > 0:
            return []
        self.P, self.feedback = plain.P, self.task.mean_of(plain)
        # A constant push moves the states as far as it lasts: about the time in which V falls.
        units = DisturbanceCoordinates.of(
            self.task.plant, self.P, feedback=self.feedback, limits=self.task.limits
        )
        step = self.task.plant.sample_time
        self.growth, self.near = max(1.0, units.rate / (2.0 * rate * (step or 1.0))), rate
        return [
            float(rate_value) for rate_value in np.geomspace(rate / SLOWER, rate * FASTER, SLOW)
        ]

    def value(self, rate: float) -> float:
        """Return about the least gain at a rate, and go where its P is |x|^2.

        Of rules that can hardly be stabilised a disturbance builds up for long: then in states of
        that size too, unless limits are posed in those of their own.
        """
        if self.seen:
            self._go_to_best()
        gain = self._looked(rate, self.P, self.growth)
        if not np.isfinite(gain) and self.near is None and self.P is not self.begun:
            # What another rate left may be so ill-conditioned that nothing is found from it.
            gain = self._looked(rate, self.begun, 1.0)
        return gain

    def _looked(self, rate: float, P: Floats, growth: float) -> float:
        """Return about the least gain at a rate, looked for where this P is |x|^2."""
        task = replace(self.task, decay_rate=rate)
        growth = growth if self.near is None else growth * float(np.sqrt(self.near / rate))
        for _ in range(RESIZED_LOOKS):
            units = DisturbanceCoordinates.of(
                task.plant,
                P,
                feedback=self.feedback,
                limits=task.limits,
                peak=task.peak,
                growth=growth,
            )
            condition = task.condition(units)
            unknowns = unknowns_near_least(condition)
            if not unknowns:
                return np.inf
            values = np.linalg.eigvalsh(unknowns["Q"][0])
            checked_margin = margin(condition, unknowns)
            # Nothing is claimed here, so a slight violation of the LMIs is accepted in the search.
            if checked_margin > (0.0 if self.near is None else -ROUNDING_MARGIN):
                closer = units.quadratic(unknowns["Q"][0])
                if is_definite(closer):
                    self.P, self.growth = closer, growth
                self.near = None if self.near is None else rate
                gain = float(np.sqrt(unknowns["kappa"][0, 0, 0])) * units.output
                self.seen.append(_Look(gain, rate, self.P, self.growth))
                return gain
            if task.limits is not None or not SMALL_Q < values[0]:
                break
            if checked_margin < FAR_FROM_FEASIBLE and values[-1] < LARGE_Q:
                break
            P, growth = units.quadratic(unknowns["Q"][0]), growth * float(np.sqrt(values[-1]))
            if not is_definite(P):
                break
        return np.inf

    def rates(self, density: int) -> list[float]:
        """Return rates around those of the regulated mean vertex, so many in a decade."""
        step = self.task.plant.sample_time
        if self._regulator is None:
            poles = np.linalg.eigvals(self.task.plant.A).ravel()
        else:
            poles = self._regulator.poles
        with np.errstate(divide="ignore"):
            rates = np.abs(poles.real if step is None else np.log(np.abs(poles)) / step)
        rates = rates[(rates > 0) & np.isfinite(rates)]
        slow, fast = (rates.min(), rates.max()) if len(rates) else (1.0, 1.0)
        count = int(np.ceil(density * np.log10(AROUND**2 * fast / slow))) + 1
        return [float(rate) for rate in np.geomspace(slow / AROUND, fast * AROUND, count)]


def _without_rate(task: DisturbanceRequest, rates: list[float]) -> Design:
    """Return the no of plain compensation, or doubt: other rates were not tried."""
    plain = task.plain()
    if not plain.found:
        return plain
    where = (
        f"at none of {len(rates)} decay rates from {rates[0]:.3g} to {rates[-1]:.3g} 1/s, nor at "
        "about that of gains without disturbance,"
    )
    if task.limits is None:
        diagnosis = (
            f"gains exist, but {where} was a bound on the peak found; give a decay rate, or take a "
            "richer relaxation"
        )
    else:
        diagnosis = (
            f"gains keep the limits without disturbance, but {where} were any found that keep them "
            "with it; allow for less disturbance, widen the limits, give a decay rate, or take a "
            "richer relaxation"
        )
    answer = replace(
        plain.answer, status="unknown", P=None, decay_rate=None, margin=0.0, diagnosis=diagnosis
    )
    return replace(plain, gains=None, P=None, margin=0.0, answer=answer)


def _peak_gain(task: DisturbanceRequest, units: DisturbanceCoordinates, objective: float) -> float:
    return float(np.sqrt(objective)) * units.output / units.disturbance + _direct(task)


def _direct(task: DisturbanceRequest) -> float:
    """Return what the direct path adds."""
    return float(np.linalg.norm(task.plant.D11, 2, axis=(1, 2)).max())
