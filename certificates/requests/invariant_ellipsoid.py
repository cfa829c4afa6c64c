"""Requests an invariant ellipsoid in the model's box, and bounds of the inputs on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from takagi.certificates.checker.kinds.input_rate import membership_corners, motion_rows
from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.document.model_data import (
    floats,
    rounded_down,
    rounded_up,
    short,
    stack_of,
)
from takagi.certificates.requests.decay import common_function
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import (
    best_multiplier,
    box_corners,
    box_rows,
    fall_rate,
    input_bounds,
    largest_level,
    state_halves,
)
from takagi.certificates.requests.request import Attempt, Request, first_proved
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer

DIGITS = (6, 9, 12)
# The least share of the disturbances in the model's box that is worth a claim.
LEAST_SHARE = 0.01
# Fraction of the largest decay rate. With rate 0 the set is larger, but solutions in it hardly
# approach the equilibrium.
SHARE_OF_RATE, FASTEST = 0.25, 1e6
LOOSEST = 1e6  # of an input without a limit
# Largest number of pairs of a vertex and a gain whose double sum the solver is given.
MOST_PAIRS = 40


@dataclass(frozen=True, slots=True, eq=False)
class InvariantEllipsoid(Request):
    """{x'Px <= c} lies in the model's box and is invariant: the largest that is found.

    Attributes
    ----------
    P : the ellipsoid's shape, (n, n); None searches, without a disturbance, for the largest
        volume; with one, for a set that is small compared with the box.
    decay_rate : alpha in 1/s for the search of the set; 0 gives the largest set; None takes a
        quarter of the largest rate.  V decays at the rate that P proves.
    disturbance_bounds : (q,) |w_k| <= b_k; None takes w = 0; "box" takes the ranges in the
        model's box, or else the largest share of them for which the set lies in the box of states.
    """

    includes_decay: ClassVar[bool] = True

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
        candidate = candidate_set(loop, self.P, self.decay_rate, self.disturbance_bounds)
        kind = {"name": "invariant ellipsoid in the model's box", "kind": "invariant-ellipsoid"}
        why = "no disturbance, however small, is withstood"
        return _best_set(loop, candidate, self.disturbance_bounds, kind, {}, why)


def candidate_set(
    loop: ClaimedLoop,
    shape: ArrayLike | None,
    decay_rate: float | None,
    bounds: ArrayLike | None,
    limits: Floats | None = None,
) -> tuple[str, Floats | None, str]:
    """Return (solver's words, P or None, diagnosis): the shape of a set in the box.

    ``limits`` : (m,) on the inputs, in addition to those of the box; None for none.
    """
    if shape is not None:
        P = np.asarray(shape, dtype=np.float64)
        if P.shape != (loop.exact.order,) * 2 or not np.allclose(P, P.T):
            raise ModelError(f"P has shape {P.shape}; it must be symmetric, of the states' order")
        return "given", P, ""
    disturbed = bounds is not None
    if decay_rate is None:
        decay_rate = SHARE_OF_RATE * min(common_function(loop).decay_rate or 0.0, FASTEST)
    answer = _filled_least(loop) if disturbed else _largest(loop, max(decay_rate, 0.0), limits)
    status = str(answer.solver.get("status", ""))
    return status, answer.P, answer.diagnosis


def _best_set(
    loop: ClaimedLoop,
    candidate: tuple[str, Floats | None, str],
    bounds: ArrayLike | None,
    kind: dict[str, Any],
    idle: dict[str, Any],
    reason: str,
    completed: Callable[[dict[str, Any]], dict[str, Any]] = dict,
) -> Attempt:
    """Return the first proved claim about a set of the candidate's shape, or an idle one."""
    solver, P, diagnosis = candidate
    sets = claimed_sets(loop, P, bounds) if P is not None else iter(())
    claims = ((words, kind | completed(evidence)) for words, evidence in sets)
    identity_set = {"P": np.eye(loop.exact.order).tolist(), "level": 1.0, "multiplier": 1.0}
    unproved = (diagnosis or reason, kind | identity_set | idle)
    return first_proved(loop, claims, solver, idle=unproved)


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
        w, whole = _bounds(loop, bounds)
        least_level, s = best_multiplier(loop.A, box_corners(loop.E, w), rounded, discrete=discrete)
        if not np.isfinite(least_level):
            continue
        # The least level grows with the square of the disturbances.
        share = 1.0 if whole else min(rounded_down((level / least_level) ** 0.5, 2), 1.0)
        if share < LEAST_SHARE:
            continue
        # The second is for a share at whose end the exact check finds no room.
        for factor in (share,) if whole else (share, 0.9 * share):
            size = [float(f"{factor * b:.6g}") for b in w]
            disturbed = {
                "multiplier": rounded_down(s, 9),
                "disturbance": "disturbances",
                "disturbance_bounds": size,
            }
            words = f"ellipsoid of level {level:.6g} under |w_k| <= {size}, P to {digits} digits"
            yield words, evidence | disturbed


def set_in_floats(loop: ClaimedLoop, limits: Floats | None) -> Floats | None:
    """Return P of the set {x' P x <= 1} that the loop's certificate would claim; None without one.

    It is what ``InputLimits(limits)``, or without limits ``InvariantEllipsoid()``, tries first.
    """
    _, P, _ = candidate_set(loop, None, None, None, limits)
    evidence = None if P is None else next(claimed_sets(loop, P, None), None)
    if evidence is None:
        return None
    shape, level = np.array(evidence[1]["P"]), float(evidence[1]["level"])
    if limits is not None:
        level *= min(1.0, float(np.min(limits / input_bounds(loop, shape, level)))) ** 2
    return np.asarray(shape / level, dtype=np.float64)


def withstood_share(loop: ClaimedLoop) -> float:
    """Return the share of the disturbances in the model's box that a set in the box withstands.

    In floating point; inf where the box has no disturbances.
    """
    names, box = loop.exact.disturbances, loop.exact.other_box or {}
    if not (loop.exact.E and names and all(name in box for name in names)):
        return np.inf
    w, _ = _bounds(loop, "box")
    P = _filled_least(loop).P if np.any(w > 0) else None
    if P is None:
        return 0.0 if np.any(w > 0) else np.inf
    discrete = loop.sample_time is not None
    least_level, _ = best_multiplier(loop.A, box_corners(loop.E, w), P, discrete=discrete)
    return float((largest_level(loop, P) / least_level) ** 0.5)


def _bounds(loop: ClaimedLoop, bounds: ArrayLike) -> tuple[Floats, bool]:
    """Return (q,) bounds on |w_k|, and whether all of them have to be claimed, not a share."""
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
        return np.where(loop.model.E.any(axis=(0, 1)), halves, 0.0), False
    w = np.asarray(bounds, dtype=np.float64)
    if w.shape != (q,) or not np.all(np.isfinite(w) & (w >= 0)):
        raise ModelError(f"disturbance_bounds = {bounds!r}: {q} numbers >= 0 are needed")
    return w, True


def _largest(loop: ClaimedLoop, decay_rate: float, limits: Floats | None) -> Answer:
    """Return P of about the largest volume in the box, and within the limits."""
    from takagi.lmi import attraction_ellipsoid

    halves, inputs = state_halves(loop), bounded_inputs(loop.exact)
    if loop.gains is not None and (inputs or limits is not None):
        narrowed_limits = np.full(loop.gains.shape[1], LOOSEST)
        if limits is not None:
            narrowed_limits = np.where(np.isfinite(limits), limits, LOOSEST)
        for k, side in inputs.items():
            narrowed_limits[k] = min(narrowed_limits[k], float(min(-side[0], side[1])))
        if not loop.exact.shared_weights:
            return _of_own_weights(loop, halves, narrowed_limits, decay_rate)
        return attraction_ellipsoid(
            loop.model,
            gains=loop.gains,
            state_box=halves,
            input_limit=narrowed_limits,
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

    if len(loop.A) > MOST_PAIRS or len(loop.A) != loop.pairs.shape[1]:
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
    E = stack_of(blend.E for blend in loop.searched.blends())
    C = np.broadcast_to(rows, (len(E), *rows.shape))
    return peak_gain(loop.A, E, C, sample_time=loop.sample_time)


# The checker uses the rounded numbers of the file; this margin covers their rounding.
SPARE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class InputLimits(Request):
    """|u_k| <= limits_k, and bounds of the rates of u, for all starts in an invariant ellipsoid.

    u = -K x is the deviation from the input's equilibrium value: an actuator from 0 to 6 V with
    equilibrium 5 V has the limit 1 V.

    Attributes
    ----------
    limits : (m,) on |u_k - u_k*|, in the units of the inputs; None, or inf for an input, takes the
        amplitudes that occur in the largest ellipsoid in the model's box.
    P, decay_rate, disturbance_bounds : of the ellipsoid, as in ``InvariantEllipsoid``.
    rates : True bounds |u_k'| (or the change in one sample) as well.
    membership_rates : (r,) |h_j'| <= phi_j in 1/s, where gains differ in continuous time.
    """

    includes_decay: ClassVar[bool] = True

    limits: ArrayLike | None = None
    P: ArrayLike | None = None
    decay_rate: float | None = None
    disturbance_bounds: ArrayLike | None = None
    rates: bool = False
    membership_rates: ArrayLike | None = None

    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the claim ``input-limits``.

        Raises
        ------
        ModelError : no gains, limits that do not fit, rates without membership rates.
        """
        if loop.gains is None:
            raise ModelError("limits are about u = -K x; give gains")
        m = loop.gains.shape[1]
        limits = None if self.limits is None else np.asarray(self.limits, dtype=np.float64)
        if limits is not None and (limits.shape != (m,) or not np.all(limits > 0)):
            raise ModelError(f"limits = {self.limits!r}: {m} positive numbers are needed")
        bounds = self.disturbance_bounds
        candidate = candidate_set(loop, self.P, self.decay_rate, bounds, limits)
        kind = {"name": "inputs within limits", "kind": "input-limits"}
        finite = np.zeros(m) if limits is None else np.where(np.isfinite(limits), limits, 0.0)
        none = {"input_limits": finite.tolist()}

        def limited(evidence: dict[str, Any]) -> dict[str, Any]:
            return self._limited(loop, evidence, limits)

        return _best_set(loop, candidate, bounds, kind, none, "no set was found", limited)

    def _limited(
        self, loop: ClaimedLoop, evidence: dict[str, Any], limits: Floats | None
    ) -> dict[str, Any]:
        """Return the evidence with limits; requested limits reduce its level."""
        P, level = np.array(evidence["P"]), float(evidence["level"])
        reach = input_bounds(loop, P, level)
        asked = np.full(len(reach), np.inf) if limits is None else limits
        share = float(np.min(asked / np.maximum(reach, 1e-300)))
        if share < 1:
            level = rounded_down((1 - SPARE) * level * share**2)
        input_limits = [
            float(limit) if np.isfinite(limit) else rounded_up(float(value) * (1 + SPARE), 4)
            for limit, value in zip(asked, reach, strict=True)
        ]
        limited = evidence | {"level": level, "input_limits": input_limits}
        return limited | self._rates(loop, limited, P, level) if self.rates else limited

    def _rates(
        self, loop: ClaimedLoop, evidence: dict[str, Any], P: Floats, level: float
    ) -> dict[str, Any]:
        assert loop.gains is not None
        rows = np.array([floats(row) for row in motion_rows(loop.exact, "the model")])
        motion = _rounded(_reach(rows, P, level))
        total = np.array(motion)
        if "disturbance_bounds" in evidence:
            push = np.abs(np.einsum("rmn,snq->rsmq", loop.gains, loop.model.E))
            total = total + (push @ np.array(evidence["disturbance_bounds"])).max(axis=(0, 1))
        shares: dict[str, Any] = {"motion": motion}
        stated: dict[str, Any] = {"rate_shares": shares}
        if len(loop.exact.K) > 1 and loop.sample_time is None:
            phi = self._membership_rates(len(loop.gains))
            corners = np.array(
                [[float(d) for d in c] for c in membership_corners(phi, "membership_rates")]
            )
            shares["memberships"] = _rounded(
                _reach(np.tensordot(corners, loop.gains, axes=1), P, level)
            )
            total = total + shares["memberships"]
            stated["membership_rates"] = [float(rate) for rate in phi]
        limits = [rounded_up(float(value) * (1 + SPARE), 4) for value in total]
        return {"rate_limits": limits} | stated

    def _membership_rates(self, r: int) -> list[Any]:
        from fractions import Fraction

        rates = None if self.membership_rates is None else np.asarray(self.membership_rates)
        if rates is None or rates.shape not in ((), (r,)):
            raise ModelError(
                "the gains differ from rule to rule, so the input moves with the memberships; "
                f"give membership_rates, {r} bounds on |h_j'| in 1/s"
            )
        return [Fraction(repr(float(rate))) for rate in np.broadcast_to(rates, (r,))]


def _reach(rows: Floats, P: Floats, level: float) -> Floats:
    squares = np.einsum("tmi,ij,tmj->tm", rows, np.linalg.inv(P), rows)
    return np.asarray(np.sqrt(level * squares.max(axis=0)))


def _rounded(values: Floats) -> list[float]:
    return [rounded_up(float(value) * (1 + SPARE), 5) for value in values]
