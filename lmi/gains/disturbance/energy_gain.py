"""Gains with the least energy gain (H-infinity norm) from disturbance to output."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Design
from takagi.lmi.condition.term import Condition
from takagi.lmi.gains.disturbance.coordinates import DisturbanceCoordinates
from takagi.lmi.gains.disturbance.design import Meaning, designed
from takagi.lmi.gains.disturbance.disturbed_plant import Disturbed, Performance
from takagi.lmi.gains.disturbance.energy_gain_sums import hinf_pdc_condition
from takagi.lmi.gains.disturbance.request import DisturbanceRequest, disturbance_request, positive
from takagi.lmi.gains.requirements.given_limits import GivenLimits
from takagi.lmi.solver.time_limit import limited
from takagi.models.errors import ModelError


@limited
def hinf_pdc(
    model: Disturbed,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    disturbance_energy: float | None = None,
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    initial_ball: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    tolerance: float = 1e-4,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least gamma in |z|_2 <= gamma |w|_2.

    For every blend of the vertices, however fast it varies, and x(0) = 0.  Of one rule it is the
    least H-infinity norm that state feedback can reach.

    Parameters
    ----------
    model : A (r, n, n), B (r, n, m), and the disturbance's E (r, n, q).  Without ``performance``
        z = C x + D u, and nothing leads from w to z directly.
    performance : (C1, D12, D11) of z = C1 x + D12 u + D11 w, (r, ., .) or (., .), where the
        model's y is not what is to be kept small; the last ones may be None or left out.
    relaxation : as for ``pdc``.
    decay_rate : alpha in 1/s that the undisturbed loop must also show.
    disturbance_energy : integral (or sum) of |w|^2 for which the limits below must hold.
    input_limit, initial_box, initial_ball, state_box : as for ``pdc``, on x' P x <= 1, which holds
        all states that disturbances of that energy reach from rest, and those that the undisturbed
        loop reaches from the initial box and ball.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition.
    tolerance : how far above the least gamma the gains may be, relative.  The least one is often
        approached only as the gains grow without bound; 1e-2 usually makes them a thousand times
        smaller.  Of many rules or states it may be a thousandth where less was asked for.
    sample_time : T in s where the model cannot say.  Energies are then sums over samples.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    A ``Design``; its ``answer.gain`` is gamma in units of z over units of w, for which every LMI
    was checked by eigenvalues with the gains as they are returned; P is that of the LMIs.  Without
    gains its answer says why none were found.  The answer's condition is posed in coordinates
    where a regulator's cost is |x|^2, so it has no ``coordinates``.  Nothing is proved here.

    Not promised: with one relaxation gamma may be larger, or there may be no gains, where a
    richer one does better; of several rules none reaches the least gamma of the nonlinear loop.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, no disturbance, no output, inputs that are
        dependent or do nothing, a vertex with an unstable mode that no input moves, limits
        without an energy.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5; Tanaka and Wang (2001).
    """
    given = GivenLimits(
        input_limit=input_limit,
        initial_box=initial_box,
        initial_ball=initial_ball,
        state_box=state_box,
        gain_bound=gain_bound,
        sample_time=sample_time,
    )
    task = disturbance_request(
        model,
        given,
        performance=performance,
        relaxation=relaxation,
        decay_rate=decay_rate,
        tolerance=tolerance,
    )
    task = replace(
        task,
        energy=_energy(disturbance_energy, task.level),
        # The objective is gamma^2 where limits are to hold on the ellipsoid.
        tolerance=(2 if task.level else 1) * task.tolerance,
    )
    meaning = Meaning(
        gain=partial(_energy_gain, squared=task.level), size=_unit_size if task.level else _storage
    )
    return designed(task, _condition, meaning)


def _condition(task: DisturbanceRequest, units: DisturbanceCoordinates) -> Condition:
    return hinf_pdc_condition(
        units.scaled_plant(task.plant),
        relaxation=task.relaxation,
        decay_rate=task.decay_rate / units.rate,
        limits=task.inside(units),
    )


def _energy_gain(units: DisturbanceCoordinates, objective: float, *, squared: bool) -> float:
    gamma = float(np.sqrt(objective)) if squared else objective
    return gamma * units.output / units.disturbance


def _storage(units: DisturbanceCoordinates) -> float:
    """Return the unit of V: |z|^2 / gamma times seconds, or samples."""
    return units.output * units.disturbance / units.rate


def _unit_size(units: DisturbanceCoordinates) -> float:
    return 1.0


def _energy(given: float | None, level: bool) -> float | None:
    if given is None:
        if level:
            raise ModelError(
                "limits were given, but not the disturbance for which they must hold; give "
                "disturbance_energy, the integral (or sum) of |w|^2"
            )
        return None
    if not level:
        raise ModelError(
            "disturbance_energy was given, but no limit that must hold for it; give input_limit, "
            "state_box, initial_box or initial_ball, or leave it out"
        )
    return positive("disturbance_energy", given)
