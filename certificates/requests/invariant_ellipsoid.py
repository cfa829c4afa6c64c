"""Requests an invariant ellipsoid in the model's box."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.requests.decay import common_function
from takagi.certificates.requests.loop.decimals import rounded_down, short, stack_of
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.quadratic_motion import (
    best_multiplier,
    box_corners,
    fall_rate,
)
from takagi.certificates.requests.loop.valid_level import box_rows, largest_level, state_halves
from takagi.certificates.requests.request import Attempt, first_proved, or_else
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer

DIGITS = (6, 9, 12)
# Fractions of the disturbance's bounds to try, if these come from the model's box.
SHARES = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
# Fraction of the largest decay rate. With rate 0 the set is larger, but solutions in it hardly
# approach the equilibrium.
SHARE_OF_RATE, FASTEST = 0.25, 1e6
LOOSEST = 1e6  # of an input without a limit
# Pairs of a vertex and a gain, whose own pairs the solver is given.
MOST_OWN = 40


@dataclass(frozen=True, slots=True, eq=False)
class InvariantEllipsoid:
    """{x'Px <= c} lies in the model's box and is invariant: the largest that is found.

    Attributes
    ----------
    P : the ellipsoid's shape, (n, n); None searches, without a disturbance, for the largest
        volume; with one, for a set that is small compared with the box.
    decay_rate : alpha in 1/s for the search of the set; 0 gives the largest set; None takes a
        quarter of the largest rate.  V decays at the rate that P proves.
    disturbance_bounds : (q,) |w_k| <= b_k; None takes w = 0; "box" takes the ranges in the
        model's box, or the largest fraction of them for which the set lies in the box of states.
    """

    P: ArrayLike | None = None
    decay_rate: float | None = None
    disturbance_bounds: ArrayLike | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``invariant-ellipsoid``.

        Raises
        ------
        ModelError : the model has no box, or bounds that do not fit its disturbances.
        """
        if not len(box_rows(loop)):
            raise ModelError(
                f"model {loop.model.name!r} has no box of states, so nothing limits the "
                "ellipsoid: it holds everywhere; ask for Decay instead"
            )
        name = "invariant ellipsoid in the model's box"
        solver, P, found = candidate_set(loop, self.P, self.decay_rate, self.disturbance_bounds)
        claims = claimed_sets(loop, P, self.disturbance_bounds) if P is not None else iter(())
        idle = {"P": np.eye(loop.exact.order).tolist(), "level": 1.0, "multiplier": 1.0}
        why = found or "no disturbance, however small, is withstood"
        kind = {"name": name, "kind": "invariant-ellipsoid"}
        given = ((words, kind | claim) for words, claim in claims)
        return first_proved(loop, or_else(given, (why, kind | idle)), solver)


def candidate_set(
    loop: ClaimedLoop,
    given: ArrayLike | None,
    decay_rate: float | None,
    bounds: ArrayLike | None,
    limits: Floats | None = None,
) -> tuple[str, Floats | None, str]:
    """Return (solver's words, P or None, diagnosis): the shape of a set in the box.

    Parameters
    ----------
    limits : (m,) on the inputs, in addition to those of the box; None for none.
    """
    if given is not None:
        P = np.asarray(given, dtype=np.float64)
        if P.shape != (loop.exact.order,) * 2 or not np.allclose(P, P.T):
            raise ModelError(f"P has shape {P.shape}; it must be symmetric, of the states' order")
        return "given", P, ""
    disturbed = bounds is not None
    if decay_rate is None:
        decay_rate = SHARE_OF_RATE * min(common_function(loop).decay_rate or 0.0, FASTEST)
    answer = _filled_least(loop) if disturbed else _largest(loop, max(decay_rate, 0.0), limits)
    status = str(answer.solver.get("status", ""))
    return status, answer.P, answer.diagnosis


def claimed_sets(
    loop: ClaimedLoop, P: Floats, bounds: ArrayLike | None
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the evidence of the largest sets of shape P that lie in the box."""
    discrete = loop.sample_time is not None
    for digits in DIGITS:
        rounded = short(P, digits)
        if np.linalg.eigvalsh(rounded)[0] <= 0:
            continue
        level = rounded_down(min(largest_level(loop, rounded), 1e12))
        evidence = {"P": rounded.tolist(), "level": level}
        if bounds is None:
            rate = rounded_down(0.99 * fall_rate(loop.A, rounded, discrete=discrete))
            if rate > 0:
                words = f"ellipsoid of level {level:.6g}, rate {rate:.6g}, P to {digits} digits"
                yield words, evidence | {"multiplier": rate}
            continue
        w, shares = _bounds(loop, bounds)
        held, s = best_multiplier(loop.A, box_corners(loop.E, w), rounded, discrete=discrete)
        if not np.isfinite(held):
            continue
        for share in shares:
            size = [float(f"{share * b:.6g}") for b in w]
            if held * share**2 > level and len(shares) > 1:
                continue
            disturbed = {
                "multiplier": rounded_down(s, 9),
                "disturbance": "disturbances",
                "disturbance_bounds": size,
            }
            words = f"ellipsoid of level {level:.6g} under |w_k| <= {size}, P to {digits} digits"
            yield words, evidence | disturbed


def _bounds(loop: ClaimedLoop, bounds: ArrayLike) -> tuple[Floats, tuple[float, ...]]:
    """Return (q,) bounds on |w_k|, and the fractions of them that may be claimed instead."""
    names, box = loop.exact.disturbances, loop.exact.other_box or {}
    q = loop.E.shape[2]
    if not q:
        raise ModelError(f"model {loop.model.name!r} has no disturbance to bound")
    if isinstance(bounds, str):
        if bounds != "box" or not all(name in box for name in names) or not names:
            raise ModelError(
                f"disturbance_bounds = {bounds!r}: give numbers, or 'box' for a model whose box "
                "has a range for every disturbance"
            )
        halves = np.array([max(float(min(-box[k][0], box[k][1])), 0.0) for k in names])
        # A signal that only schedules does not drive the state.
        return np.where(loop.model.E.any(axis=(0, 1)), halves, 0.0), SHARES
    w = np.asarray(bounds, dtype=np.float64)
    if w.shape != (q,) or not np.all(np.isfinite(w) & (w >= 0)):
        raise ModelError(f"disturbance_bounds = {bounds!r}: {q} numbers >= 0 are needed")
    return w, (1.0,)


def _largest(loop: ClaimedLoop, decay_rate: float, limits: Floats | None) -> Answer:
    """Return P of about the largest volume in the box, and within the limits."""
    from takagi.lmi import attraction_ellipsoid

    halves, inputs = state_halves(loop), bounded_inputs(loop.exact)
    if loop.gains is not None and (inputs or limits is not None):
        narrow = np.full(loop.gains.shape[1], LOOSEST) if limits is None else limits.copy()
        for k, side in inputs.items():
            narrow[k] = min(narrow[k], float(min(-side[0], side[1])))
        if not loop.exact.shared_weights:
            return _of_own_weights(loop, halves, narrow, decay_rate)
        return attraction_ellipsoid(
            loop.model,
            gains=loop.gains,
            state_box=halves,
            input_limit=narrow,
            decay_rate=decay_rate,
            # If the claim fails for the pairs of rules, it is proved on pieces of the weights.
            relaxation="liu-zhang" if loop.points else "wang-tanaka-griffin",
        )
    # The blends themselves, so that everything the checker examines is included.
    return attraction_ellipsoid(
        loop.A, state_box=halves, decay_rate=decay_rate, sample_time=loop.sample_time
    )


def _of_own_weights(loop: ClaimedLoop, halves: Floats, limits: Floats, decay_rate: float) -> Answer:
    """Return the same for a law with weights of its own: every vertex is met by every gain."""
    from takagi.lmi import attraction_ellipsoid
    from takagi.models.ts.model import TSModel

    if len(loop.A) > MOST_OWN or len(loop.A) != loop.pairs.shape[1]:
        # The set is then made smaller, until the limits hold in it.
        return attraction_ellipsoid(
            loop.A, state_box=halves, decay_rate=decay_rate, sample_time=loop.sample_time
        )
    assert loop.gains is not None
    vertices, gains = loop.pairs
    # A rule for each pair: pairs of these rules are again pairs of a vertex and a gain.
    return attraction_ellipsoid(
        TSModel(
            np.asarray(loop.model.A)[vertices],
            np.asarray(loop.model.B)[vertices],
            sample_time=loop.sample_time,
        ),
        gains=loop.gains[gains],
        state_box=halves,
        input_limit=limits,
        decay_rate=decay_rate,
    )


def _filled_least(loop: ClaimedLoop) -> Answer:
    """Return P of a set that the disturbed state cannot leave, small compared with the box."""
    from takagi.lmi import peak_gain

    rows = box_rows(loop)
    E = stack_of(blend.E for blend in loop.seen.blends())
    C = np.broadcast_to(rows, (len(E), *rows.shape))
    return peak_gain(loop.A, E, C, sample_time=loop.sample_time)
