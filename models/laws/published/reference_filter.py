r"""The reference filter G_f(s) of the published laws: a low-pass on the region-dependent speed.

The reference omega_ref(v_hat) has kinks where a region ends and follows every movement of the wind
estimate.  With r the filtered reference, a published law takes e = omega - r instead:

    order 1    tau r' = omega_ref(v_hat) - r               G_f = 1 / (1 + tau s)
    order 2    r'' = w^2 (omega_ref - r) - 2 zeta w r'     G_f = w^2 / (s^2 + 2 zeta w s + w^2)

with w = 1 / tau.

G_f(0) = 1, so the filter does not change the law's equilibrium. It filters the reference speed; the
filter of the effort-sharing law acts on the wind estimate instead.  Where omega_ref is a line in
the wind (region 2) or constant (1.5, 2.5, 3) the two are the same.

Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, which names the filter and
does not specify it; docs/laws.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, isfinite

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.laws.published.law import PublishedLaw


@dataclass(frozen=True, slots=True)
class ReferenceFilter:
    """G_f(s) as a value.

    Attributes
    ----------
    time_constant : tau [s].
    order : 1 or 2.
    damping : zeta of order 2 [-].

    Raises
    ------
    ModelError : a time or damping that is not positive, another order.
    """

    time_constant: float
    order: int = 1
    damping: float = 1.0

    def __post_init__(self) -> None:
        for name in ("time_constant", "damping"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise ModelError(
                    f"reference filter with {name} = {value!r} was given; a positive number is "
                    "needed (for no filter take the law itself)"
                )
        if self.order not in (1, 2):
            raise ModelError(f"reference filter of order {self.order!r} was given; take 1 or 2")

    def rest(self, reference: float) -> Floats:
        """Return the state at which the output is ``reference`` [rad/s] and stays there."""
        return np.array([reference, 0.0][: self.order])

    def rate(self, state: ArrayLike, reference: float) -> Floats:
        """Return the state's derivative for an input ``reference`` [rad/s]."""
        return np.asarray(self._matrix() @ (np.asarray(state) - self.rest(reference)))

    def after(self, state: ArrayLike, reference: float, time: float) -> Floats:
        """Return the state ``time`` [s] later, the input held: exactly, by the exponential."""
        rest = self.rest(reference)
        away = np.asarray(state, dtype=np.float64) - rest
        if self.order == 1:
            return np.asarray(rest + exp(-time / self.time_constant) * away)
        return np.asarray(rest + expm(time * self._matrix()) @ away)

    def _matrix(self) -> Floats:
        w = 1 / self.time_constant
        if self.order == 1:
            return np.array([[-w]])
        return np.array([[0.0, 1.0], [-w * w, -2 * self.damping * w]])


@dataclass(frozen=True, slots=True, eq=False)
class FilteredReferenceLaw:
    """A published law with a reference filter; it can be simulated, but not certified.

    A certificate of a published law is about the law without the filter. At a constant wind both
    laws are the same once the filter has settled.

    Attributes
    ----------
    law : Schulte's law.   filter : G_f.
    """

    law: PublishedLaw
    filter: ReferenceFilter

    @property
    def name(self) -> str:
        """The law's name, with the filter's time constant."""
        return f"{self.law.name}, reference filter {self.filter.time_constant:g} s"

    @property
    def state_names(self) -> tuple[str, ...]:
        """The law's integrals, then the filter's states."""
        filter_names = ("filtered reference speed [rad/s]", "its rate [rad/s^2]")
        return (*self.law.state_names, *filter_names[: self.filter.order])

    def initial_state(self, wind: float) -> Floats:
        """Return the law's own rest state, and the filter's at the reference of this wind [m/s]."""
        rest = self.filter.rest(self.law.reference_speed(wind))
        return np.concatenate([self.law.initial_state(wind), rest])

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return torque [N m, high-speed shaft] and pitch reference [rad], within the limits."""
        law_state, filtered = self._parts(state)
        return self.law.limited(
            self.law.blended(law_state, measurement, reference=float(filtered[0]))
        )

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> Floats:
        """Return the rates of the integrals and of the filter."""
        law_state, filtered = self._parts(state)
        reference = self.law.reference_speed(measurement.wind_estimate)
        integrals = self.law.state_rate(law_state, measurement, reference=float(filtered[0]))
        return np.concatenate([integrals, self.filter.rate(filtered, reference)])

    def sample(
        self, state: ArrayLike, measurement: Measurement, time: float
    ) -> tuple[Command, Floats]:
        """Return the command, and the state ``time`` [s] later: the filter exactly, else Euler."""
        law_state, filtered = self._parts(state)
        reference = self.law.reference_speed(measurement.wind_estimate)
        rate = self.law.state_rate(law_state, measurement, reference=float(filtered[0]))
        later = np.concatenate(
            [law_state + time * rate, self.filter.after(filtered, reference, time)]
        )
        return self.command(state, measurement), later

    def _parts(self, state: ArrayLike) -> tuple[Floats, Floats]:
        full_state = np.asarray(state, dtype=np.float64)
        return full_state[: -self.filter.order], full_state[-self.filter.order :]
