r"""The sampled functions of ``turbulence_exit_nonlinear`` with what a proof must include.

    python benchmarks/turbulence_exit_uncertain.py GAINS.json [--only NUMBER]

FLOATING POINT AND SAMPLED, NOT PROVED.  Inertia, the pitch's effect before the wake follows and the
wake's length are at the worst of the ends of their ranges at every point, independently of other
points, as in a proof with one function for all plants.  A number that is printed here is so an
upper bound of what such a proof can give with P(v_s), up to the conservatism of the search.
"""

from __future__ import annotations

import argparse
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from turbulence_exit_about_schedule import ETA, Loop, P, Reach
from turbulence_exit_loop import TURBINE, Law
from turbulence_exit_nonlinear import (
    EACH,
    ENOUGH,
    HORIZON,
    ROUNDS,
    Function,
    Search,
    _told,
    drawn,
    schedule_nodes,
    worst,
)

from takagi.models.turbine import rotor_torque_gradient

Floats = NDArray[np.float64]
# tau_f [s], mean wind [m/s], a [1/s], overspeed; and the families.
CASES = (
    (12.0, 18.0, 0.03, 0.30), (12.0, 20.0, 0.03, 0.30), (12.0, 18.0, 0.03, 0.50),
    (12.0, 20.0, 0.03, 0.50), (5.0, 18.0, 0.04, 0.30), (5.0, 20.0, 0.04, 0.30),
)  # fmt: skip
INERTIA, LATE, LENGTH = (0.9, 1.1), (0.0, 1.0), (40.0, 80.0)
NOMINAL_LENGTH = 63.0
FAMILIES = {
    "none": ((1.0,), (1.0,), (NOMINAL_LENGTH,)),
    "inertia": (INERTIA, (1.0,), (NOMINAL_LENGTH,)),
    "wake": ((1.0,), LATE, LENGTH),
    "all": (INERTIA, LATE, LENGTH),
}


class Family(Loop):
    """The loop whose plant is, at every state, the one of a family that is worst there.

    ``judge`` says which is worst: the plant with the largest drift of V.  ``rates`` are that
    plant's.
    """

    def __init__(self, law: Law, mean: float, members: tuple[tuple[float, ...], ...]) -> None:
        super().__init__(law, mean)
        self.members = list(product(*members))
        self.judge: Function | None = None

    def rates(self, z: Floats) -> Floats:
        found = super().rates(z)
        if self.judge is None:
            return found
        gradient = self.gradient(z)
        best, value = found, np.full(z.shape[1], -np.inf)
        for inertia, late, length in self.members:
            one = self._of(z, found, inertia, late, length)
            pushed = (gradient * one).sum(axis=0)
            better = pushed > value
            best = np.where(better, one, best)
            value = np.where(better, pushed, value)
        return np.asarray(best)

    def gradient(self, z: Floats) -> Floats:
        """Return dV/dz without the part of P's change, which no plant's number moves."""
        if self.judge is None:
            return np.zeros_like(z)
        at, _ = self.judge.at(self.mean + z[8] - z[3])
        return np.asarray(2 * np.einsum("nij,jn->in", at, z))

    def _of(self, z: Floats, nominal: Floats, inertia: float, late: float, length: float) -> Floats:
        """Return the rates of one plant from those of the nominal one, which has the whole h."""
        found = nominal.copy()
        held = np.clip(self.mean + z[8] - z[3], self.law.tables["wind"][0], None)
        b, effort, omega = (
            np.interp(held, self.law.tables["wind"], self.law.tables[name])
            for name in ("effectiveness", "trim_effort", "rotor_speed")
        )
        v = np.maximum(self.mean + z[8], 1.0)
        rest = self.psi(effort)
        pitch, wake = np.maximum((z[P] + rest) / b, 0), (z[ETA] + rest) / b
        steep = -rotor_torque_gradient(TURBINE, omega + z[0], pitch, v, clip=True)[1]
        limit = np.interp(v, self.law.tables["wind"], self.law.tables["effectiveness_limit"])
        h = np.maximum(limit - steep / TURBINE.inertia, 0)
        # e' of the nominal plant holds h (pitch - wake) and, as a rate of the trim, -omega*' v_s'.
        k = np.clip(
            np.searchsorted(self.law.tables["wind"], held, side="right") - 1,
            0,
            len(self.law.tables["wind"]) - 2,
        )
        seen = np.clip(held + z[6], self.law.tables["wind"][0], self.law.tables["wind"][-1])
        moved = self.slopes["rotor_speed"][k] * (seen - (self.mean + z[8] - z[3])) / self.law.filter
        torque = nominal[0] + moved + (1 - late) * h * (pitch - wake)
        found[0] = torque / inertia - moved
        found[ETA] += v * (z[P] - z[ETA]) * (1 / length - 1 / NOMINAL_LENGTH)
        return found


class FamilySearch(Search):
    """Conditions at points keep the plant that was worst when the point was added."""

    def __init__(self, loop: Family, nodes: Floats, overspeed: float, rate: float) -> None:
        super().__init__(loop, nodes, overspeed, rate)
        self.kept = np.zeros((10, 0))

    def add(self, points: Floats, rates: Floats) -> None:
        self.kept = np.concatenate([self.kept, self.loop.rates(points)], axis=1)
        super().add(points, rates)

    def _forms(self, S: Floats) -> tuple[Floats, Floats]:
        loop = self.loop
        self.loop = _Held(loop, self.kept)  # type: ignore[assignment]
        try:
            return super()._forms(S)
        finally:
            self.loop = loop


class _Held:
    """A loop whose rates at the stored points are known."""

    def __init__(self, loop: Loop, rates: Floats) -> None:
        self.mean, self.known = loop.mean, rates

    def rates(self, z: Floats) -> Floats:
        return self.known


def of_points(loop: Family, overspeed: float, rate: float) -> tuple[Function | None, float]:
    """Return the function, and the largest excess that is left; None where there is none."""
    reach = Reach.of(loop.mean, loop.law.filter, HORIZON, EACH)
    loop.judge = None
    search = FamilySearch(loop, schedule_nodes(loop, reach), overspeed, rate)
    first = np.repeat([search.back.T @ search.back], len(search.nodes), axis=0)
    loop.judge = Function(search.nodes, first, 1.0, rate)
    points = drawn(loop.judge, loop, reach, np.random.default_rng(0))[:, :300]
    search.add(points, np.full(points.shape[1], rate))
    one, left = search.best(10.0, 2), np.inf
    for turn in range(ROUNDS):
        if one is None:
            break
        loop.judge = one
        z, found = worst(one, loop, reach, turn)
        left, bad = float(found.max()), found > 1e-4
        if not bad.any() or turn == ROUNDS - 1:
            break
        V = one.value(loop, z[:, bad])[0]
        search.add(z[:, bad], np.minimum(rate, ENOUGH * one.level(loop) / V))
        one = search.best(max(one.exponent * (1 - one.level(loop) / rate), 0.5), 2)
    return one, left


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path)
    reader.add_argument("--only", type=int, help="number of the case, from 0", default=None)
    given = reader.parse_args()
    print("FLOATING POINT, SAMPLED, NOT PROVED; ten minutes from rest")
    for tau, mean, rate, overspeed in CASES if given.only is None else [CASES[given.only]]:
        for told, members in FAMILIES.items():
            loop = Family(Law.read(given.gains, tau), mean, members)
            one, left = of_points(loop, overspeed, rate)
            row = f"| {tau:g} | {mean:g} | {100 * overspeed:g} % | {told} | {_told(one, loop)}"
            print(f"{row} | {left:.2g} |", flush=True)


if __name__ == "__main__":
    main()
