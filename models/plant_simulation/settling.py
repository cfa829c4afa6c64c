"""How long many motions of a plant take to settle, integrated side by side.

For choosing between laws: a motion costs a fraction of one in ``runs``, because all motions are
columns of one array.  Nothing is recorded but the time after which every state stays near rest.
An observer's estimates are further rows of that array.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.laws.pdc import OutputFeedback, seen_directly

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel

SETTLED = 0.02  # of the set's half-width in each state, which counts as rest
FAR = 100.0  # half-widths, at which a motion is given up
SAMPLES = 2000  # of the horizon: the resolution of the time
RELATIVE, ABSOLUTE = 1e-4, 1e-5  # tolerances, the latter in half-widths

Following = Callable[[Floats], Floats]  # states of all runs -> their rates, or the next


@dataclass(frozen=True, slots=True, eq=False)
class ManyMotions:
    """x' = f(x, u), or x(t + T) = f(x, u), in deviations from rest; u = -sum_i h_i(z) K_i x, cut.

    Parameters are in the middle of their ranges, and disturbances at rest.

    Attributes
    ----------
    model : of ``sector_model``, whose equations and premises are evaluated.
    limits : (m,) at which |u - u*| is cut; None for no limits.
    equations, premises : of arrays, one for each state and input.
    """

    model: TSModel
    limits: Floats | None
    equations: Any
    premises: Any

    @classmethod
    def of(cls, model: TSModel, limits: Floats | None) -> ManyMotions | None:
        """Return the motions; None for a model without symbols, or with tables behind it."""
        from sympy import S, lambdify

        from takagi.models.splines.table_function import TableFunction

        form = None if model.derivation is None else model.derivation.form
        if form is None:
            return None
        problem, signals = form.problem, form.problem.equations
        arguments = [*signals.states, *signals.inputs]
        at_rest = dict.fromkeys(signals.disturbances, S.Zero)
        formulas = [
            [expression.xreplace(problem.middles).xreplace(at_rest) for expression in expressions]
            for expressions in (signals.f, form.factored.premises.values())
        ]
        if any(e.atoms(TableFunction) for group in formulas for e in group):
            return None
        equations, premises = (lambdify(arguments, f, "numpy", cse=True) for f in formulas)
        return cls(model, limits, equations, premises)

    def settling_times(
        self, law: Floats | OutputFeedback, starts: Floats, reach: Floats, horizon: float
    ) -> Floats:
        """Return for each start [s] the time from which every |x_k| <= 2 % of its reach.

        Parameters
        ----------
        law : K (r, m, n) of u - u* = -sum_i h_i(z) K_i x, or gains with an observer.
        starts : (n, runs); with an observer (2 n, runs), its estimates behind the states.
        reach : (n,) half-widths of the set that the motions start from.
        horizon : time that is simulated [s].

        Returns
        -------
        (runs,); inf for a motion that does not settle within the horizon, or goes astray.
        """
        step = self.model.sample_time
        if isinstance(law, OutputFeedback):
            following, sizes = partial(self._observed, law), np.tile(reach, 2)
        else:
            following, sizes = partial(self._fed_back, law), reach
        with np.errstate(all="ignore"):
            if step is None:
                motion, time = self._in_continuous_time(following, starts, sizes, horizon)
            else:
                motion, time = self._in_samples(following, starts, sizes, step, horizon)
        if motion is None:
            return np.full(starts.shape[1], np.inf)
        return _times(np.abs(motion[:, : len(reach)]) > SETTLED * reach[:, None], time)

    def _fed_back(self, gains: Floats, X: Floats) -> Floats:
        """Return x' (n, runs), or x(t + T), for gains (r, m, n) on all states."""
        if np.all(gains == gains[0]):
            U = -gains[0] @ X
        else:
            U = -np.einsum("rk,rmn,nk->mk", self._weights(X, gains.shape[1]), gains, X)
        return self._values(self.equations, X, self._cut(U))

    def _observed(self, law: OutputFeedback, Z: Floats) -> Floats:
        """Return (x, s)' (2 n, runs), or the next, for the estimates s of an observer."""
        model, rows, K = self.model, list(law.rows), law.feedback.gains
        n = len(Z) // 2
        X, S = Z[:n], Z[n:]
        known = S.copy()
        if not law.at_estimate:
            for state in seen_directly(model, law.rows):
                known[state] = X[state]
        h, h_plant = (self._weights(point, K.shape[1]) for point in (known, X))
        U = self._cut(-np.einsum("rk,rmn,nk->mk", h, K, S))

        def mixed(weights: Floats, stack: Floats, signals: Floats) -> Floats:
            return np.asarray(np.einsum("rk,rmn,nk->mk", weights, stack, signals))

        C, D = model.C[:, rows], model.D[:, rows]
        off = mixed(h_plant, C, X) + mixed(h_plant, D, U) - mixed(h, C, S) - mixed(h, D, U)
        estimated = mixed(h, model.A, S) + mixed(h, model.B, U) + mixed(h, law.L, off)
        return np.concatenate([self._values(self.equations, X, U), estimated])

    def _weights(self, X: Floats, inputs: int) -> Floats:
        """Return h (r, runs) at X (n, runs)."""
        if not self.model.premises:
            return np.ones((1, X.shape[1]))
        z = self._values(self.premises, X, np.zeros((inputs, X.shape[1])))
        bounds = np.array([(float(p.lower), float(p.upper)) for p in self.model.premises])
        # A quotient such as sin(x)/x has no value where its state is exactly at rest.
        z = np.where(np.isfinite(z), z, bounds.mean(axis=1)[:, None])
        return self.model.memberships(np.clip(z, *bounds.T[:, :, None]), clip=True)

    def _cut(self, U: Floats) -> Floats:
        if self.limits is None:
            return np.asarray(U)
        return np.asarray(np.clip(U, -self.limits[:, None], self.limits[:, None]))

    def _in_continuous_time(
        self, following: Following, starts: Floats, reach: Floats, horizon: float
    ) -> tuple[Floats | None, Floats]:
        from scipy.integrate import solve_ivp

        n, runs = starts.shape

        def rates(_: float, y: Floats) -> Floats:
            X = y.reshape(runs, n).T
            return self._moving(following(X), X, reach, 0.0).T.ravel()

        # State by state within each run, so that the Jacobian is a band of blocks.
        solution = solve_ivp(
            rates,
            (0.0, horizon),
            starts.T.ravel(),
            method="LSODA",
            lband=n - 1,
            uband=n - 1,
            rtol=RELATIVE,
            atol=np.tile(ABSOLUTE * reach, runs),
            t_eval=np.linspace(0.0, horizon, SAMPLES + 1),
        )
        return None if solution.status != 0 else solution.y.reshape(runs, n, -1), solution.t

    def _in_samples(
        self, following: Following, starts: Floats, reach: Floats, step: float, horizon: float
    ) -> tuple[Floats, Floats]:
        motion = [starts]
        for _ in range(min(SAMPLES, int(np.ceil(horizon / step)))):
            X = motion[-1]
            motion.append(self._moving(following(X), X, reach, 1.0))
        return np.array(motion).transpose(2, 1, 0), step * np.arange(len(motion), dtype=np.float64)

    @staticmethod
    def _moving(values: Floats, X: Floats, reach: Floats, held: float) -> Floats:
        """Return the values; a run that is far away, or has none, is held where it is."""
        lost = (np.abs(X) > FAR * reach[:, None]).any(axis=0) | ~np.isfinite(values).all(axis=0)
        return np.where(lost, held * X, values)

    @staticmethod
    def _values(functions: Any, X: Floats, U: Floats) -> Floats:
        rows = functions(*X, *U)
        return np.array([np.broadcast_to(row, X.shape[1:]) for row in rows], dtype=np.float64)


def _times(off: Any, time: Floats) -> Floats:
    """Return the first time after the last that any state is off; inf if that is the end.

    ``off`` : (runs, n, samples), whether a state is away from rest.
    """
    away = off.any(axis=1)
    last = away.shape[1] - 1 - np.argmax(away[:, ::-1], axis=1)
    settled = np.append(time[1:], np.inf)[last]
    return np.asarray(np.where(away.any(axis=1), settled, 0.0), dtype=np.float64)
