r"""The longest time from sample to sample with which a law is run: measured, not proved.

A turbine's, by the parts that its programs have:

    band-stop   six samples in a period of its frequency w:   T <= 2 pi / (6 w)
    observer    an Euler step of half its time constant:      T <= 1 / (2 l_1)
    baseline    the same of its low-pass with corner c:       T <= 1 / (2 c)

A band-stop that is sampled more rarely neither stops the drivetrain's mode nor leads: sampling
turns the mode into a slow one that the law then moves.  On the validation plant the program of the
NREL 5-MW turbine (w = 9.3 rad/s) is quiet up to 0.2 s, and oscillates from 0.3 s on.  The observer
takes Euler steps, and becomes unstable near 2 / l_1; the low-pass of the published baseline
controller likewise at 2 / c.

A plant's, by the linear loop at each vertex of its model with the gains of that vertex: the command
is held from sample to sample (A, B give e^{AT} and its integral), and what the program keeps
itself (estimate, integral, effort) takes Euler steps.  With M(T) from sample to sample and a decay
alpha in continuous time, it is the longest T up to which

    rho(M(T)) <= e^{-alpha T / 2},   T <= 1 / alpha.

So at a vertex the loop decays at least half as fast as in continuous time.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from decimal import ROUND_DOWN, Decimal
from math import pi
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from takagi.models.arrays import Floats
    from takagi.models.plant.plant import Plant
    from takagi.models.ts.model import TSModel

SAMPLES_A_PERIOD = 6
# Of the time constant of what takes Euler steps: the observer's is 1 / l_1.
EULER_SHARE = 0.5
# A plant's: share of the decay in continuous time; shortest time tried, as a share of the fastest
# mode's; the factor from one time to the next, and that at which bisection ends.
DECAY_SHARE, SHORTEST, STEP_FACTOR, CLOSE_RATIO = 0.5, 1e-4, 1.2, 1.002
# The largest number of vertices that are tried, evenly spread: more take seconds.
MOST_VERTICES = 128
TOO_SLOW = (
    "with a longer one the loop at a vertex decays less than half as fast as in continuous time"
)
TIME_CONSTANT = "it is the time constant of the loop's slowest mode"


@dataclass(frozen=True, slots=True)
class LongestSample:
    """The longest sample time: ``time`` [s], two digits, and ``reason`` in words."""

    time: Decimal
    reason: str

    @property
    def words(self) -> str:
        """The meaning of a status bit for a longer one."""
        return f"the sample time is longer than {self.time} s: {self.reason}"

    @property
    def member(self) -> dict[str, Any]:
        """The member ``sampling`` of a gain file."""
        return {"longest": float(self.time), "reason": self.reason}


def longest_of_turbine(
    document: Mapping[str, Any], programs: Collection[str]
) -> LongestSample | None:
    """Return the longest sample time of the programs of a gain file; None without such a part."""
    limits: list[tuple[float, str]] = []
    stop = document.get("measurement", {}).get("torsion_filter")
    if "speed filter" in programs and stop:
        frequency = float(stop["frequency"])
        reason = f"the band-stop at {frequency:g} rad/s needs {SAMPLES_A_PERIOD} samples a period"
        limits.append((2 * pi / (SAMPLES_A_PERIOD * frequency), reason))
    step = "takes steps of at most half its time constant"
    if "observer" in programs:
        gain = float(document["observer"]["l1"])
        limits.append((EULER_SHARE / gain, f"the observer, with l1 = {gain:g} 1/s, {step}"))
    law = document["law"]
    if law["name"] == "baseline" and "law" in programs:
        corner = float(law["speed_filter"])
        limits.append((EULER_SHARE / corner, f"its low-pass at {corner:g} rad/s {step}"))
    return LongestSample(_two_digits(min(limits)[0]), min(limits)[1]) if limits else None


def longest_of_plant(
    plant: Plant, model: TSModel, law: Mapping[str, Any], proved: float | None = None
) -> LongestSample | None:
    """Return the longest sample time of a plant's law; None where no vertex's loop decays.

    It is not below ``proved`` [s], at which the sampled loop is proved.
    """
    import numpy as np

    if model.sample_time is not None:
        return LongestSample(Decimal(repr(model.sample_time)), "the law is in discrete time")
    loops = [loop for loop in _loops(plant, model, law) if loop.decay > 0]
    if not loops:
        return None
    last = 1 / min(loop.decay for loop in loops)
    holding, failing = SHORTEST / max(loop.fastest for loop in loops), 0.0
    while holding < last and not failing or failing > CLOSE_RATIO * holding:
        step = min(STEP_FACTOR * holding, last)
        if failing:
            step = float(np.sqrt(holding * failing))
        if all(loop.holds(step) for loop in loops):
            holding = step
        else:
            failing = step
    if proved is not None and proved >= holding:
        return LongestSample(Decimal(repr(proved)), "the loop is proved at this sample time")
    return LongestSample(_two_digits(holding), TOO_SLOW if failing else TIME_CONSTANT)


def sampling_member(longest: LongestSample | None) -> dict[str, Any]:
    """Return the member ``sampling`` of a plant's gain file."""
    if longest is None:
        return {"longest": None, "reason": "no loop at a vertex decays"}
    return longest.member


@dataclass(frozen=True, slots=True, eq=False)
class _Loop:
    """The linear loop at a vertex.

    Attributes
    ----------
    A, B : of the plant.   K : u = -K x.
    integrated : (n,), the states that the program integrates.
    C, L : of an observer of the other states; None without one.
    decay, fastest : [1/s] of the slowest mode in continuous time; size of the fastest.
    """

    A: Floats
    B: Floats
    K: Floats
    integrated: Any
    C: Floats | None
    L: Floats | None
    decay: float
    fastest: float

    def holds(self, step: float) -> bool:
        """Return whether the loop decays fast enough when it is sampled every ``step`` [s]."""
        import numpy as np

        radius = float(np.abs(np.linalg.eigvals(self._sampled(step))).max())
        return bool(radius <= np.exp(-DECAY_SHARE * self.decay * step))

    def _sampled(self, step: float) -> Floats:
        import numpy as np
        from scipy.linalg import expm

        n, m = self.B.shape
        augmented = np.zeros((n + m, n + m))
        augmented[:n] = np.hstack([self.A, self.B])
        # What the program integrates is constant within a sample.
        augmented[:n][self.integrated] = 0
        transition = expm(step * augmented)[:n]
        transition[self.integrated] += step * np.hstack([self.A, self.B])[self.integrated]
        A, B = transition[:, :n], transition[:, n:]
        if self.C is None or self.L is None:
            return np.asarray(A - B @ self.K)
        # The law takes estimates, but knows what it integrates itself.
        known, estimated = np.diag(self.integrated.astype(float)), np.eye(n)[:, ~self.integrated]
        rate = (self.A - self.B @ self.K)[~self.integrated] - self.L @ self.C
        estimates = np.eye(estimated.shape[1]) + step * rate @ estimated
        measured = step * (rate @ known + self.L @ self.C)
        feedback = [A - B @ self.K @ known, -B @ self.K @ estimated]
        return np.block([feedback, [measured, estimates]])


def _loops(plant: Plant, model: TSModel, law: Mapping[str, Any]) -> list[_Loop]:
    import numpy as np

    K, r = np.asarray(law["K"], dtype=np.float64), len(model.A)
    pairs = [(i, i if len(K) == r else 0) for i in range(r)]
    if len(K) not in (1, r):
        pairs = [(i, j) for i in range(r) for j in range(len(K))]
    integrals = {reference["integral"] for reference in law.get("references", ())}
    integrals |= {law["blending"]["effort"]} if "blending" in law else set()
    integrated = np.array([v.name in integrals for v in plant.states])
    observer, measured, L = law.get("observer"), [], np.zeros((0, 0, 0))
    if observer is not None:
        outputs = [y.name for y in plant.outputs]
        measured = [outputs.index(name) for name in observer["measured"]]
        L = np.asarray(observer["L"], dtype=np.float64)
    loops = []
    for i, j in pairs[:: -(-len(pairs) // MOST_VERTICES)]:
        A, B = model.A[i], model.B[i]
        modes = np.linalg.eigvals(A - B @ K[j])
        C, observer_gain = None, None
        if observer is not None:
            C, observer_gain = model.C[i][measured], L[i if len(L) == r else 0]
            if len(observer_gain) == len(integrated):
                observer_gain = observer_gain[~integrated]
            error = A[~integrated][:, ~integrated] - observer_gain @ C[:, ~integrated]
            modes = np.concatenate([modes, np.linalg.eigvals(error)])
        decay, fastest = -float(modes.real.max()), float(np.abs(modes).max())
        loops.append(_Loop(A, B, K[j], integrated, C, observer_gain, decay, fastest))
    return loops


def _two_digits(time: float) -> Decimal:
    exact = Decimal(repr(time))
    unit = Decimal((0, (1,), exact.adjusted() - 1))
    # As a float prints it, so that a file and a text agree on the digits.
    return Decimal(repr(float(exact.quantize(unit, rounding=ROUND_DOWN))))
