"""The loop of a plant whose law has outputs: plant and estimate, as sections and figures need it.

The certificate's function is V = z'Pz, with z = (x, e) or (xhat, e) and e = x - xhat.  The state
alone never leaves the shadow of {V <= c}; it may start where V <= c for the estimate as the law
starts it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Complex, Floats

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.laws.pdc import OutputFeedback
    from takagi.models.plant.plant import Plant


@dataclass(frozen=True, slots=True, eq=False)
class ObservedMotion:
    """A law with an observer, and the proved function of plant and estimate.

    Attributes
    ----------
    law : the law.
    outputs : (x, u) -> y of the measured outputs, SI.
    resting : y* (p,).
    P : (2n, 2n) of the proved V; None where none is proved.
    level : c of the proved set.
    """

    law: OutputFeedback
    outputs: Callable[[Floats, Floats], Floats]
    resting: Floats
    P: Floats | None
    level: float | None

    def seen(self, state: Floats, command: Floats) -> Floats:
        """Return y - y* at x (n,) and u (m,)."""
        return np.asarray(self.outputs(state, command) - self.resting, dtype=np.float64)

    def start(self, deviation: Floats) -> Floats:
        """Return the estimate (n,) of x - x* at the first sample: measured states, else 0."""
        found = np.zeros(len(deviation))
        for state in self.measured_states():
            found[state] = deviation[state]
        return found

    def command(self, state: Floats, estimate: Floats) -> Floats:
        """Return u (m,) at x (n,), for outputs without an input in the premises."""
        rest = self.law.feedback.input_rest
        return self.law.command(estimate, self.seen(state, rest))

    def following(self, state: Floats, estimate: Floats, command: Floats) -> Floats:
        """Return the rate of the estimate; in discrete time the next estimate."""
        return self.law.following(estimate, self.seen(state, command), command)

    def coordinates(self, deviation: Floats, estimate: Floats) -> Floats:
        """Return z (k, 2n) of x - x* and its estimate, (k, n) each."""
        first = estimate if self.law.at_estimate else deviation
        return np.concatenate([first, deviation - estimate], axis=-1)

    def measured_states(self) -> list[int]:
        """Return the places of the states that an output shows by themselves."""
        from takagi.models.laws.pdc import seen_directly

        seen = seen_directly(self.law.model, self.law.rows)
        return [state for state, (_, factor) in seen.items() if factor == 1.0]

    def shapes(self) -> tuple[Floats, Floats] | None:
        """Return the (n, n) matrices of the shadow of the set and of its starts; None without one.

        {x'Sx <= c} is where x may start, {x'Rx <= c} what x never leaves.
        """
        if self.P is None:
            return None
        n = len(self.P) // 2
        one = np.eye(n)
        state = np.hstack([one, one if self.law.at_estimate else np.zeros((n, n))])
        shadow = np.linalg.inv(state @ np.linalg.inv(self.P) @ state.T)
        known = np.zeros((n, n))
        known[self.measured_states(), self.measured_states()] = 1.0
        N = np.vstack([known if self.law.at_estimate else one, one - known])
        return np.asarray((shadow + shadow.T) / 2), np.asarray(N.T @ self.P @ N)

    def largest_commands(self) -> Floats | None:
        """Return (m,): the largest |u - u*| of any gain on the set; None without one."""
        if self.P is None or self.level is None:
            return None
        K = self.law.feedback.gains
        rows = np.concatenate([K, 0.0 * K if self.law.at_estimate else -K], axis=2)
        squares = np.einsum("imn,nk,imk->im", rows, np.linalg.inv(self.P), rows)
        return np.asarray(np.sqrt(self.level * squares.max(axis=0)), dtype=np.float64)

    def controller_at(self, h: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, L, K of s' = F s + L (y - y*), u - u* = -K s with the weights h (r,)."""
        model, rows = self.law.model, list(self.law.rows)
        A, B, C, D, K, L = (
            np.tensordot(h, stack, axes=1)
            for stack in (
                model.A,
                model.B,
                model.C[:, rows],
                model.D[:, rows],
                self.law.feedback.gains,
                self.law.L,
            )
        )
        return A - B @ K - L @ (C - D @ K), L, K

    def poles_at(self, h: Floats) -> Complex:
        """Return the poles of plant and observer with constant weights h (r,): both parts."""
        model, rows = self.law.model, list(self.law.rows)
        A, B, C, K, L = (
            np.tensordot(h, stack, axes=1)
            for stack in (model.A, model.B, model.C[:, rows], self.law.feedback.gains, self.law.L)
        )
        found = [np.linalg.eigvals(A - B @ K), np.linalg.eigvals(A - L @ C)]
        return np.concatenate(found).astype(np.complex128)


def observed_motion(design: PlantDesign) -> ObservedMotion | None:
    """Return the observer of a design with its proved function; None for a law of all states."""
    from fractions import Fraction

    from takagi.reports.loops.proved_kinds import proved_claims

    law = design.output_law
    if law is None:
        return None
    outputs = measured_outputs(design.plant)
    resting = outputs(law.feedback.state_rest, law.feedback.input_rest)
    claim = next(iter(proved_claims(design.document, design.checked, "observed-loop")), None)
    if claim is None:
        return ObservedMotion(law, outputs, resting, None, None)
    P = np.array([[float(Fraction(str(entry))) for entry in row] for row in claim["P"]])
    return ObservedMotion(law, outputs, resting, P, float(Fraction(str(claim["level"]))))


def measured_outputs(plant: Plant) -> Callable[[Floats, Floats], Floats]:
    """Return (x, u) -> y of what is measured, from the plant's own expressions."""
    import sympy as sp

    assert plant.measured is not None  # only such a law has an observer
    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    symbols = [v.symbol for v in (*plant.states, *plant.inputs)]
    given = {y.name: y.expression for y in plant.outputs}
    rows = [sp.sympify(given[name]).subs(values) for name in plant.measured]
    found = sp.lambdify(symbols, rows, modules=["scipy", "numpy"])

    def outputs(x: Floats, u: Floats) -> Floats:
        return np.array(found(*map(float, x), *map(float, u)), dtype=np.float64)

    return outputs
