r"""The running loop in moving wind, as rows over states, uncertain products, v' and the residual.

xi is measured from the trim of the tables at the present wind v.  To the rows of ``rates`` come,
at the end, the product of the factor "pitch slope", v', and rho = r / r_max:

    table's torque over J      + r_max rho
    e', m', o', y_1', y_2'     - omega*' v'
    p', eta'                   - [b_0 beta*'] v'
    s', z'                     - v'

The form of the claim is that of ``moving_form``, over (xi, v', rho, w).
"""

from __future__ import annotations

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.turbine.running.moving_form import moving_form
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
        factors = {name: (self.n + i, self.outer[name]) for i, name in enumerate(MOVING_NAMES)}
        inputs = self.width - 2, self.width - 1
        return moving_form(self.rates, inputs, factors, P, tau, shift, weights)
