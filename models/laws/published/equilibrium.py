r"""The equilibrium of the published law, and whether that is the turbine's trim.

Shared integrator.  x_I' = 0 forces omega = omega_ref.  With f_1 = f_1(omega_ref) > 0 the pitch
channel at the equilibrium gives

    x_I = (1 + f_1 k^c_p) b / (f_1 k^c_I)                                              (1)

and one balance is left, T_r(omega_ref, b, v) = n_g T(k^b_I x_I(b)).  Below rated torque, (1) gives
a pitch angle above the trim's, in proportion to f_1. With f_1 = 0 the pitch command is zero, and
above rated wind there is no equilibrium. If f_1(omega_rated) is a few thousandths, the equilibrium
is near the trim in both regions, but by (1) the integral must then change about 1/f_1 times as
much. So no placement of the ramp suits regions 2.5 and 3 at once.

Two integrators. At rest each one balances the speed error against its channel's tracking term:

    e = (u_1 - T)/(tau |k^b_I|) = (u_2 - beta_ref)/(tau |k^c_I|),

so both channels have the same small overspeed e, which follows from the torque balance (a small
underspeed if ``sector`` raises torque above its command). If f_1(omega_ref) = 1, both are at rest
with e = 0 and any split of torque and pitch: there is a continuum of equilibria.

All this is floating point, for a constant wind with v_hat = v.
"""

from __future__ import annotations

from takagi.models.laws.published.equilibrium_point import Equilibrium, LawFigures
from takagi.models.laws.published.one_integrator import one_integrator_equilibrium
from takagi.models.laws.published.two_integrators import two_integrators_equilibrium


def equilibrium(law: LawFigures, wind: float) -> Equilibrium:
    """Return where the law rests at a constant wind [m/s], estimate exact.

    Of several equilibria of the shared integrator the one with least pitch is returned.

    Raises
    ------
    ModelError : no trim at this wind.
    """
    return (
        one_integrator_equilibrium(law, wind)
        if law.name == "paper"
        else two_integrators_equilibrium(law, wind)
    )
