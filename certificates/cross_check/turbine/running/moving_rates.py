r"""The running loop in moving wind, as rows over states, uncertain products, v' and the residual.

xi is measured from the trim of the tables at the present wind v.  To the rows of ``rates`` come,
at the end, the product of the factor "pitch slope", v', and rho = r / r_max:

    table's torque over J      + r_max rho
    e', m', o', y_1', y_2'     - omega*' v'
    p', eta'                   - [b_0 beta*'] v'
    s', z'                     - v'

With F over (xi, v', rho, w), Z and T as there, B = diag(b_1, b_2) and D the rate of P, the form of
the claim is

    diag(-2 alpha P - D, B, T)  -  [ P F; 0 ]  -  [ P F; 0 ]'  -  Z' T Z .
"""

from __future__ import annotations

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import entries
from takagi.certificates.cross_check.turbine.running.rates import NAMES, Row, RunningRates

MOVING = "pitch slope"
MOVING_NAMES = (*NAMES, MOVING)
# States by what their reference point moves with.
WITH_SPEED, WITH_PITCH, WITH_WIND = (0, 4, 5, 8, 9), (1, 7), (3, 6)


class MovingRates(RunningRates):
    """xi' of one cell in moving wind; ``spans`` has the factor "pitch slope", too."""

    beyond = 3

    def imbalance(self) -> Row:
        row = [fmpq(0)] * self.width
        row[-1] = self.cell.residual
        return row

    def _equations(self) -> list[Row]:
        found = super()._equations()
        span = self.spans[MOVING]
        middle, half = (span.low + span.high) / 2, (span.high - span.low) / 2
        self.outer[MOVING] = [fmpq(0)] * self.width
        self.outer[MOVING][-2] = half
        slope = self.cell.own_slope("speed")
        for i, row in enumerate(found):
            if i in WITH_SPEED:
                row[-2] -= slope
            elif i in WITH_PITCH:
                row[-2] -= middle
                row[-3] -= 1
            elif i in WITH_WIND:
                row[-2] -= 1
        return found

    def form(
        self,
        P: fmpq_mat,
        tau: dict[str, fmpq],
        shift: fmpq_mat,
        weights: tuple[fmpq, fmpq],
    ) -> fmpq_mat:
        """Return the matrix of the module; ``shift`` is 2 alpha P + D."""
        used = [name for name in MOVING_NAMES if any(self.outer[name])]
        place = {name: self.n + i for i, name in enumerate(MOVING_NAMES)}
        inputs = [self.width - 2, self.width - 1]
        kept = [*range(self.n), *inputs, *(place[name] for name in used)]
        size, first = len(kept), self.n + 2
        PF = entries(P * fmpq_mat([[row[j] for j in kept] for row in self.rates]))
        M = [[fmpq(0)] * size for _ in range(size)]
        for i in range(self.n):
            for j in range(self.n):
                M[i][j] -= shift[i, j]
            for j in range(size):
                M[i][j] -= PF[i][j]
                M[j][i] -= PF[i][j]
        for i, weight in enumerate(weights):
            M[self.n + i][self.n + i] += weight
        for i, name in enumerate(used):
            M[first + i][first + i] += tau[name]
            z = [(a, self.outer[name][j]) for a, j in enumerate(kept) if self.outer[name][j] != 0]
            for a, x in z:
                for b, y in z:
                    M[a][b] -= tau[name] * x * y
        return fmpq_mat(M)
