"""How long many motions of a plant take to settle, integrated side by side.

For choosing between laws: a motion costs a fraction of one in ``runs``, because all motions are
columns of one array.  Nothing is recorded but the time after which every state stays near rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel

SETTLED = 0.02  # of the set's half-width in each state, which counts as rest
FAR = 100.0  # half-widths, at which a motion is given up
SAMPLES = 2000  # of the horizon: the resolution of the time
RELATIVE, ABSOLUTE = 1e-4, 1e-5  # tolerances, the latter in half-widths


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

    def commands(self, gains: Floats, X: Floats) -> Floats:
        """Return u - u* (m, runs) at X (n, runs), for gains (r, m, n)."""
        if np.all(gains == gains[0]):
            U = -gains[0] @ X
        else:
            idle = np.zeros((gains.shape[1], X.shape[1]))
            z = self._values(self.premises, X, idle)
            bounds = np.array([(float(p.lower), float(p.upper)) for p in self.model.premises])
            # A quotient such as sin(x)/x has no value where its state is exactly at rest.
            z = np.where(np.isfinite(z), z, bounds.mean(axis=1)[:, None])
            h = self.model.memberships(np.clip(z, *bounds.T[:, :, None]), clip=True)
            U = -np.einsum("rk,rmn,nk->mk", h, gains, X)
        if self.limits is None:
            return np.asarray(U)
        return np.asarray(np.clip(U, -self.limits[:, None], self.limits[:, None]))

    def settling_times(
        self, gains: Floats, starts: Floats, reach: Floats, horizon: float
    ) -> Floats:
        """Return for each start [s] the time from which every |x_k| <= 2 % of its reach.

        Parameters
        ----------
        gains : K (r, m, n).
        starts : (n, runs).
        reach : (n,) half-widths of the set that the motions start from.
        horizon : time that is simulated [s].

        Returns
        -------
        (runs,); inf for a motion that does not settle within the horizon, or goes astray.
        """
        step = self.model.sample_time
        with np.errstate(all="ignore"):
            if step is not None:
                return self._in_samples(gains, starts, reach, step, horizon)
            return self._in_continuous_time(gains, starts, reach, horizon)

    def _in_continuous_time(
        self, gains: Floats, starts: Floats, reach: Floats, horizon: float
    ) -> Floats:
        from scipy.integrate import solve_ivp

        n, runs = starts.shape

        def rates(_: float, y: Floats) -> Floats:
            X = y.reshape(runs, n).T
            return self._moving(self._next(gains, X), X, reach, 0.0).T.ravel()

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
        if solution.status != 0:
            return np.full(runs, np.inf)
        X = solution.y.reshape(runs, n, -1)
        return _times(np.abs(X) > SETTLED * reach[:, None], solution.t)

    def _in_samples(
        self, gains: Floats, starts: Floats, reach: Floats, step: float, horizon: float
    ) -> Floats:
        motion = [starts]
        for _ in range(min(SAMPLES, int(np.ceil(horizon / step)))):
            X = motion[-1]
            motion.append(self._moving(self._next(gains, X), X, reach, 1.0))
        X = np.array(motion).transpose(2, 1, 0)
        return _times(
            np.abs(X) > SETTLED * reach[:, None], step * np.arange(len(motion), dtype=np.float64)
        )

    def _next(self, gains: Floats, X: Floats) -> Floats:
        return self._values(self.equations, X, self.commands(gains, X))

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
