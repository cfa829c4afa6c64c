r"""Where the published law comes to rest, and whether that is the turbine's trim.

Shared integrator.  x_I' = 0 forces omega = omega_ref.  With f_1 = f_1(omega_ref) > 0 the pitch
channel at rest says

    x_I = (1 + f_1 k^c_p) b / (f_1 k^c_I)                                              (1)

and one balance is left, T_r(omega_ref, b, v) = n_g T(k^b_I x_I(b)).  Below rated torque (1) spends
pitch that nobody asked for, in proportion to f_1; with f_1 = 0 no pitch is given at all, and above
rated wind there is no equilibrium.  A placement with f_1(omega_rated) of a few thousandths comes
near the trim in both regions on paper, but by (1) its integral must then travel some 1/f_1 as far:
so none serves regions 2.5 and 3 at once.

Two integrators.  At rest each tracks what its channel carries out:

    e = (u_1 - T)/(tau |k^b_I|) = (u_2 - beta_ref)/(tau |k^c_I|),

so both channels carry a small overspeed e together, found from the same balance (a small
underspeed, where ``sector`` raises torque above its command).  Where
f_1(omega_ref) = 1 both are content with e = 0 and any split of torque and pitch: a continuum.

All this is floating point, for a constant wind with v_hat = v.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import radians
from typing import Literal, TypeAlias

import numpy as np
from scipy.optimize import brentq

from takagi.models.law.coupling_filter import coupling_filter
from takagi.models.law.paper import PaperLaw, PaperLawName, paper_law
from takagi.models.simulation.fast_surface import scalar_surface
from takagi.models.turbine.trim import TrimPoint, trim

__all__ = [
    "Equilibrium",
    "PlacementRow",
    "equilibria",
    "equilibrium",
    "placement_rows",
    "torque_of",
]

Kind: TypeAlias = Literal["intended", "shifted", "continuum", "none"]

# "Intended" means trim up to these: far below what a turbine would notice.
SPEED_TOLERANCE = 1e-3  # of rated speed
PITCH_TOLERANCE = radians(0.1)
TORQUE_TOLERANCE = 1e-3  # of rated torque
GRID = 60
NO_ROOT = float("nan")


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """Where a law rests at one wind, beside the trim that it was meant to hold.

    Attributes
    ----------
    wind : [m/s].
    kind : "intended", the trim up to the tolerances; "shifted", elsewhere; "continuum", the trim
        is one of infinitely many (the one with most torque is given); "none".
    rotor_speed [rad/s], pitch [rad], torque [N m] : the equilibrium; NaN for "none".
    integrals : the law's state there, [rad]; for "none" the one that gives the trim's torque.
    trim : the turbine's trim.
    pitch_share : f_1 at the reference speed.
    """

    wind: float
    kind: Kind
    rotor_speed: float
    pitch: float
    torque: float
    integrals: tuple[float, ...]
    trim: TrimPoint
    pitch_share: float

    @property
    def speed_offset(self) -> float:
        """Rotor speed minus the trim's [rad/s]."""
        return self.rotor_speed - self.trim.rotor_speed

    @property
    def pitch_offset(self) -> float:
        """Pitch minus the trim's [rad]."""
        return self.pitch - self.trim.pitch

    @property
    def power_ratio(self) -> float:
        """Speed times torque over that of the trim [-]."""
        return self.rotor_speed * self.torque / (self.trim.rotor_speed * self.trim.torque)


@dataclass(frozen=True, slots=True)
class PlacementRow:
    """Which regions one placement of the ramp serves.

    Attributes
    ----------
    placement : share of the overlap above rated speed.
    kinds : region -> (winds at the intended equilibrium, winds tried), for "1.5", "2", "2.5", "3".
    worst_pitch : largest pitch offset [rad]; worst_power : smallest power ratio, where it rests.
    integral_travel : how far an integral moves over the winds that were tried [rad].
    """

    placement: float
    kinds: dict[str, tuple[int, int]]
    worst_pitch: float
    worst_power: float
    integral_travel: float

    @property
    def served(self) -> tuple[str, ...]:
        """Regions in which every wind that was tried has the intended equilibrium."""
        return tuple(region for region, (good, tried) in self.kinds.items() if good == tried)


def equilibrium(law: PaperLaw, wind: float) -> Equilibrium:
    """Return where the law rests at a constant wind [m/s], estimate exact.

    Of several equilibria of the shared integrator the one with least pitch is returned.

    Raises
    ------
    ModelError : no trim at this wind.
    """
    return _shared(law, wind) if law.name == "paper" else _separate(law, wind)


def equilibria(law: PaperLaw, winds: Iterable[float]) -> tuple[Equilibrium, ...]:
    """Return ``equilibrium`` at every wind."""
    return tuple(equilibrium(law, float(v)) for v in winds)


def placement_rows(
    law: PaperLaw,
    *,
    placements: Sequence[float] = (0.0, 0.25, 0.5, 0.75, 1.0),
    winds: Sequence[float],
    speed_overlap: float | None = None,
    name: PaperLawName | None = None,
) -> tuple[PlacementRow, ...]:
    """Return which regions each placement of the speed ramp serves.

    Parameters
    ----------
    law : everything but the placement is taken from it.
    placements : shares of the overlap above rated speed.
    winds : [m/s].
    speed_overlap : [rad/s]; None takes the law's.
    name : None takes the law's.
    """
    coupling = law.coupling
    rows = []
    for placement in placements:
        moved = coupling_filter(
            law.turbine,
            speed_overlap=coupling.speed_ramp.width if speed_overlap is None else speed_overlap,
            torque_overlap=coupling.torque_overlap,
            variant=coupling.variant,
            placement=placement,
            minimum_torque=coupling.minimum_torque,
            shape=coupling.speed_ramp.shape,
            torque_shape=coupling.shape,
            speed_setpoint=law.speed_setpoint,
        )
        tried = paper_law(
            law.turbine,
            partial=law.partial,
            full=law.full,
            coupling=moved,
            name=law.name if name is None else name,
            tracking_time=5.0 if law.tracking_time is None else law.tracking_time,
            speed_setpoint=law.speed_setpoint,
        )
        rows.append(_row(placement, equilibria(tried, winds)))
    return tuple(rows)


def _row(placement: float, found: Sequence[Equilibrium]) -> PlacementRow:
    kinds = {}
    for region in ("1.5", "2", "2.5", "3"):
        here = [point for point in found if point.trim.region == region]
        if here:
            kinds[region] = (sum(point.kind == "intended" for point in here), len(here))
    resting = [point for point in found if point.kind != "none"]
    pitches = [abs(point.pitch_offset) for point in resting]
    powers = [point.power_ratio for point in resting]
    travel = max(
        (np.ptp(x) for x in zip(*(p.integrals for p in resting), strict=True)), default=0.0
    )
    worst = max(pitches, default=0.0), min(powers, default=1.0)
    return PlacementRow(placement, kinds, *worst, float(travel))


def _shared(law: PaperLaw, wind: float) -> Equilibrium:
    speed, point = law.reference_speed(wind), _trim(law, wind)
    f_1 = law.coupling.speed_ramp.at(speed)
    rotor, lowest = _rotor(law, speed, wind), law.turbine.pitch_min
    if f_1 == 0.0:
        return _torque_alone(law, wind, point, max(lowest, 0.0), f_1)

    def integral(pitch: float) -> float:
        gains = law.full.gains_at(speed, pitch, wind)
        return (1 / f_1 + gains.pitch) * pitch / gains.integral

    def torque(pitch: float) -> float:
        gain = law.partial.gains_at(speed, pitch, wind).integral
        return torque_of(law, gain * integral(pitch))

    def balance(pitch: float) -> float:
        return rotor(pitch) - torque(pitch)

    if balance(lowest) <= 0:
        return _torque_alone(law, wind, point, lowest, f_1)
    pitch = _first_root(balance, lowest, _highest_pitch(law))
    if np.isnan(pitch):
        return _nowhere(law, wind, point, f_1)
    return _named(law, wind, point, f_1, speed, pitch, torque(pitch), (integral(pitch),))


def _torque_alone(
    law: PaperLaw, wind: float, point: TrimPoint, pitch: float, f_1: float
) -> Equilibrium:
    """Return the equilibrium at a fixed pitch, or none where torque does not suffice."""
    speed = law.reference_speed(wind)
    needed = _rotor(law, speed, wind)(pitch)
    top = law.turbine.rated_torque + law.coupling.torque_overlap
    command = _first_root(lambda u: needed - torque_of(law, u), 0.0, top)
    if np.isnan(command):
        return _nowhere(law, wind, point, f_1)
    x = command / law.partial.gains_at(speed, pitch, wind).integral
    return _named(law, wind, point, f_1, speed, pitch, torque_of(law, command), (x,))


def _separate(law: PaperLaw, wind: float) -> Equilibrium:
    speed, point = law.reference_speed(wind), _trim(law, wind)
    f_1, lowest = law.coupling.speed_ramp.at(speed), law.turbine.pitch_min
    passing, rotor = _passing_torque(law), _rotor(law, speed, wind)
    if point.torque <= passing and point.pitch == lowest:
        kind: Kind = "intended" if f_1 < 1.0 else "continuum"
        return _resting(law, point, f_1, kind, 0.0, point.pitch, point.torque)
    if f_1 >= 1.0:
        held = _held_torque(law) if rotor(lowest) >= _held_torque(law) else passing
        pitch = _first_root(lambda b: rotor(b) - held, lowest, _highest_pitch(law))
        return _resting(law, point, f_1, "continuum", 0.0, pitch, held)

    def balance(error: float) -> float:
        pitch, command = _carried(law, speed + error, wind, error)
        return _rotor(law, speed + error, wind)(pitch) - torque_of(law, command)

    if balance(0.0) < 0:
        return _raised(law, point, f_1)
    # Past the ramp's end f_1 = 1 leaves no overspeed to carry; the pitch grows without bound there.
    last = law.coupling.speed_ramp.end - speed
    error = _first_root(balance, 0.0, last * (1 - 1e-9))
    if np.isnan(error):
        return _nowhere(law, wind, point, f_1)
    return _resting(law, point, f_1, None, error, *_carried(law, speed + error, wind, error))


def _raised(law: PaperLaw, point: TrimPoint, f_1: float) -> Equilibrium:
    """Return the equilibrium below the reference speed, where ``sector`` gives more than u_1."""
    wind, speed = point.wind, law.reference_speed(point.wind)
    gain = abs(law.partial.gains_at(speed, point.pitch, wind).integral)

    def error_at(command: float) -> float:
        return (command - torque_of(law, command)) / (float(law.tracking_time or 0.0) * gain)

    def balance(command: float) -> float:
        rotor = _rotor(law, speed + error_at(command), wind)
        return rotor(law.turbine.pitch_min) - torque_of(law, command)

    command = _first_root(balance, _passing_torque(law), law.coupling.minimum_torque)
    if np.isnan(command):
        return _nowhere(law, wind, point, f_1)
    return _resting(law, point, f_1, None, error_at(command), law.turbine.pitch_min, command)


def _carried(law: PaperLaw, speed: float, wind: float, error: float) -> tuple[float, float]:
    """Return (pitch, torque command u_1) at which both integrators rest with this error."""
    tau, highest = float(law.tracking_time or 0.0), _highest_pitch(law)
    f_1 = law.coupling.speed_ramp.at(speed)
    lever = f_1 * tau * error / (1.0 - f_1) if f_1 < 1.0 else np.inf

    def pitch_gap(pitch: float) -> float:
        return pitch - lever * abs(law.full.gains_at(speed, pitch, wind).integral)

    lowest = law.turbine.pitch_min
    if pitch_gap(lowest) >= 0:
        pitch = lowest
    else:
        pitch = highest if pitch_gap(highest) <= 0 else brentq(pitch_gap, lowest, highest)
    excess = tau * error * abs(law.partial.gains_at(speed, pitch, wind).integral)
    low = _held_torque(law)
    high = law.turbine.rated_torque + law.coupling.torque_overlap + excess
    if excess <= 0:
        return float(pitch), low
    return float(pitch), float(brentq(lambda u: u - torque_of(law, u) - excess, low, high))


def _resting(
    law: PaperLaw,
    point: TrimPoint,
    f_1: float,
    kind: Kind | None,
    error: float,
    pitch: float,
    command: float,
) -> Equilibrium:
    """Return the equilibrium of the two integrators with the integrals that give it."""
    speed = law.reference_speed(point.wind) + error
    b = law.partial.gains_at(speed, pitch, point.wind)
    c = law.full.gains_at(speed, pitch, point.wind)
    here = law.coupling.speed_ramp.at(speed)
    pitching = here > 0 and error >= 0
    angle = pitch / here if pitching else float(law.tracking_time or 0.0) * error * abs(c.integral)
    torque = torque_of(law, command)
    integrals = (
        (command + b.speed * error + b.pitch * pitch) / b.integral,
        (angle + c.speed * error + c.pitch * pitch) / c.integral,
    )
    found = _named(law, point.wind, point, f_1, speed, pitch, torque, integrals)
    if kind is None:
        return found
    return Equilibrium(point.wind, kind, speed, pitch, torque, integrals, point, f_1)


def torque_of(law: PaperLaw, command: float) -> float:
    """Return the torque that a torque command u_1 becomes: f_2 u_1 within 0..T_rated [N m]."""
    f_2, _ = law.coupling.factors_at(law.speed_setpoint, command)
    return min(max(f_2 * command, 0.0), law.turbine.rated_torque)


def _passing_torque(law: PaperLaw) -> float:
    """Return the largest torque command that passes unchanged."""
    coupling = law.coupling
    if coupling.variant == "sector":
        return coupling.minimum_torque - coupling.torque_overlap
    return coupling.rated_torque - coupling.torque_overlap / 2


def _held_torque(law: PaperLaw) -> float:
    """Return the largest torque command that is carried out as it is: rated, or near it."""
    if law.coupling.variant == "sector":
        return law.coupling.rated_torque
    return _passing_torque(law)


def _rotor(law: PaperLaw, speed: float, wind: float) -> Callable[[float], float]:
    """Return the rotor torque over pitch, as torque on the high-speed shaft [N m]."""
    table, turbine = scalar_surface(law.turbine.torque), law.turbine
    scale = turbine.torque_constant * wind**2 / turbine.gear_ratio
    return lambda pitch: scale * table(speed * turbine.rotor_radius / wind, pitch)


def _trim(law: PaperLaw, wind: float) -> TrimPoint:
    setpoint = None if law.speed_setpoint == law.turbine.rated_rotor_speed else law.speed_setpoint
    return trim(law.turbine, wind, speed_setpoint=setpoint)


def _highest_pitch(law: PaperLaw) -> float:
    return min(law.turbine.pitch_max, law.turbine.torque.y_range[1])


def _first_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the first zero on a grid from low to high, refined; NaN without a sign change."""
    places = np.linspace(low, high, GRID)
    values = [function(float(x)) for x in places]
    for k in range(GRID - 1):
        if values[k] == 0.0:
            return float(places[k])
        if values[k] * values[k + 1] < 0:
            return float(brentq(function, places[k], places[k + 1], xtol=1e-13))
    return NO_ROOT


def _named(
    law: PaperLaw,
    wind: float,
    point: TrimPoint,
    f_1: float,
    speed: float,
    pitch: float,
    torque: float,
    integrals: tuple[float, ...],
) -> Equilibrium:
    turbine = law.turbine
    near = (
        abs(speed - point.rotor_speed) <= SPEED_TOLERANCE * turbine.rated_rotor_speed
        and abs(pitch - point.pitch) <= PITCH_TOLERANCE
        and abs(torque - point.torque) <= TORQUE_TOLERANCE * turbine.rated_torque
    )
    kind: Kind = "intended" if near else "shifted"
    return Equilibrium(wind, kind, speed, pitch, torque, integrals, point, f_1)


def _nowhere(law: PaperLaw, wind: float, point: TrimPoint, f_1: float) -> Equilibrium:
    b = law.partial.gains_at(point.rotor_speed, point.pitch, wind).integral
    c = law.full.gains_at(point.rotor_speed, point.pitch, wind)
    integrals: tuple[float, ...] = (point.torque / b,)
    if law.name != "paper":
        integrals += ((1 + c.pitch) * point.pitch / c.integral,)
    return Equilibrium(wind, "none", NO_ROOT, NO_ROOT, NO_ROOT, integrals, point, f_1)
