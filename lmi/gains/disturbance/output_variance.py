"""Gains with the least variance of the output (H2 norm) under white noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from takagi.lmi.analysis.disturbance.output_variance import infinite_variance
from takagi.lmi.answer import Design
from takagi.lmi.condition.term import Condition
from takagi.lmi.gains.disturbance.coordinates import DisturbanceCoordinates
from takagi.lmi.gains.disturbance.design import Meaning, designed
from takagi.lmi.gains.disturbance.disturbed_plant import Disturbed, Performance
from takagi.lmi.gains.disturbance.output_variance_sums import h2_pdc_condition
from takagi.lmi.gains.disturbance.request import DisturbanceRequest, disturbance_request
from takagi.lmi.gains.disturbance.riccati_bound import regulated
from takagi.lmi.gains.requirements.given_limits import GivenLimits
from takagi.lmi.solver.time_limit import limited
from takagi.models.errors import ModelError


@limited
def h2_pdc(
    model: Disturbed,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    gain_bound: float | None = None,
    tolerance: float = 1e-4,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least bound sqrt(nu), mean |z|^2 <= nu.

    For white noise w, every blend of the vertices, however fast it varies; nu bounds the energies
    of z after an impulse in each w_k at one instant, too.  What is meant where the memberships
    vary, and what is not bounded, is as for ``h2_norm``.  Of one rule sqrt(nu) is the least H2 norm
    that state feedback can reach, in continuous time without a program: see ``riccati_bound``.

    Parameters
    ----------
    model, performance : the plant, as for ``hinf_pdc``.
    relaxation : as for ``pdc``.
    decay_rate : alpha in 1/s that the undisturbed loop must also show.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition.
    tolerance : how far above the least sqrt(nu) the gains may be, relative; see ``hinf_pdc``.
    sample_time : T in s where the model cannot say.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    A ``Design``; its ``answer.gain`` is sqrt(nu), in units of z over units of w per sqrt(s), or per
    sample in discrete time, as for ``h2_norm``.  Every LMI was checked by eigenvalues with the
    gains as they are returned; V = x' P x falls by |z|^2 at least.  Nothing is proved here.

    Not promised: as for ``hinf_pdc``.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, no disturbance, no output, inputs that are
        dependent or do nothing, a vertex with an unstable mode that no input moves, a direct path
        from w to z in continuous time.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4; Tanaka and Wang
    (2001).
    """
    task = disturbance_request(
        model,
        GivenLimits(gain_bound=gain_bound, sample_time=sample_time),
        performance=performance,
        relaxation=relaxation,
        decay_rate=decay_rate,
        tolerance=tolerance,
    )
    why = infinite_variance(task.plant.D11, task.plant.sample_time)
    if why:
        raise ModelError(why)
    # The objective is nu, the square.
    task = replace(task, tolerance=2 * task.tolerance, noise=True)
    known = regulated(task, _condition)
    return designed(task, _condition, Meaning(gain=_deviation, size=_cost), known)


def _condition(task: DisturbanceRequest, units: DisturbanceCoordinates) -> Condition:
    return h2_pdc_condition(
        units.scaled_plant(task.plant),
        relaxation=task.relaxation,
        decay_rate=task.decay_rate / units.rate,
        limits=task.inside(units),
    )


def _deviation(units: DisturbanceCoordinates, objective: float) -> float:
    return float(np.sqrt(objective * units.rate)) * units.output / units.disturbance


def _cost(units: DisturbanceCoordinates) -> float:
    """Return the unit of V: |z|^2 times seconds, or samples."""
    return units.output**2 / units.rate
