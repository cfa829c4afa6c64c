r"""Controllers of a given order, static ones among them, with the least H-infinity norm found.

A controller of order k, x_K' = A_K x_K + B_K y, u = D_K y + C_K x_K, is the static gain

    F = [ D_K  C_K ]
        [ B_K  A_K ]

of the plant with k integrators beside it, (u, x_K') = F (y, x_K).  No convex form of the least norm
over F is known; so the norm itself is minimised, by descent from many starts (``gains/descent``).

F is then rounded to as many digits as leave the matrices of the loop's claim exact decimals: with
u = -K x + F D21 w, K = -F C2, the disturbance enters by B1 + B2 F D21, and z has the direct term
D11 + D12 F D21.  The claim of ``L2Gain`` about these is then one about this very F.

Source: Burke, Henrion, Lewis, Overton (2006), 5th IFAC Symposium on Robust Control Design; Apkarian
and Noll (2006), IEEE Trans. Automatic Control 51(1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import block_diag

from takagi.lmi.analysis.disturbance.loop_norm import largest_gain
from takagi.lmi.answer import Status
from takagi.lmi.argument_checks import fixed_mode, whole_number
from takagi.lmi.gains.descent.gain_loops import GainLoops
from takagi.lmi.gains.descent.many_starts import best_gains
from takagi.lmi.gains.structured.structure import pattern_of
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class GeneralisedPlant(ShortRepr):
    """x' = A x + B1 w + B2 u, z = C1 x + D11 w + D12 u, y = C2 x + D21 w, in continuous time.

    Attributes
    ----------
    A, B1, B2 : (n, n), (n, q), (n, m).
    C1, D11, D12 : (p, n), (p, q), (p, m).
    C2, D21 : (k, n), (k, q); u does not reach y directly.
    """

    A: Floats
    B1: Floats
    B2: Floats
    C1: Floats
    C2: Floats
    D11: Floats
    D12: Floats
    D21: Floats

    def __post_init__(self) -> None:
        for name in ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21"):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            if value.ndim != 2 or not np.isfinite(value).all():
                raise ModelError(
                    f"{name} has shape {value.shape}; a matrix of finite numbers is needed"
                )
            object.__setattr__(self, name, value)
        n, q, m = self.A.shape[0], self.B1.shape[1], self.B2.shape[1]
        p, k = self.C1.shape[0], self.C2.shape[0]
        needed = {"A": (n, n), "B1": (n, q), "B2": (n, m), "C1": (p, n), "C2": (k, n)}
        needed |= {"D11": (p, q), "D12": (p, m), "D21": (k, q)}
        for name, shape in needed.items():
            if getattr(self, name).shape != shape or 0 in shape:
                raise ModelError(
                    f"{name} is {getattr(self, name).shape}; {shape} is needed, none of them 0"
                )

    def closed(self, controller: StateSpace) -> StateSpace:
        """Return the loop from w to z with u = K(s) y."""
        Ak, Bk, Ck, Dk = controller.A, controller.B, controller.C, controller.D
        A = np.block([[self.A + self.B2 @ Dk @ self.C2, self.B2 @ Ck], [Bk @ self.C2, Ak]])
        B = np.vstack([self.B1 + self.B2 @ Dk @ self.D21, Bk @ self.D21])
        C = np.hstack([self.C1 + self.D12 @ Dk @ self.C2, self.D12 @ Ck])
        return StateSpace(A, B, C, self.D11 + self.D12 @ Dk @ self.D21)


@dataclass(frozen=True, slots=True, eq=False)
class StateSpace:
    """x' = A x + B u, y = C x + D u: (n, n), (n, m), (p, n), (p, m); n may be 0."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats

    @property
    def order(self) -> int:
        """Return n."""
        return len(self.A)


# Digits of F, from the most on, and how much larger the norm may get by the rounding, relative.
DIGITS, LOST = (9, 8, 7, 6, 5, 4, 3), 1e-3
# Digits where no shorter F leaves exact decimals.
LONG = 15


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class FixedOrderDesign(ShortRepr):
    """A controller of given order, and the loop that a claim is about.

    Attributes
    ----------
    controller : x_K' = A_K x_K + B_K y, u = C_K x_K + D_K y; None unless found.
    gain : the H-infinity norm of the loop with it, by Hamiltonian matrices in floating point: in
        units of z over units of w; None unless found.
    plant : the generalised plant.
    status : "candidate", there is a controller; "infeasible", no controller of any order stabilises
        the plant; "unknown", neither.
    start : the name of the start that led there.
    exact : K, E and the direct term of ``model`` and ``output`` are exactly those of the printed
        controller; else they are rounded to 17 digits.
    diagnosis : why there is none; empty if there is one.
    """

    controller: StateSpace | None = None
    gain: float | None = None
    plant: GeneralisedPlant
    status: Status = "unknown"
    start: str = ""
    exact: bool = False
    diagnosis: str = ""

    @property
    def found(self) -> bool:
        """Return whether there is a controller."""
        return self.controller is not None

    def require(self) -> StateSpace:
        """Return the controller.

        Raises
        ------
        ModelError : there is none; the message is the diagnosis.
        """
        if self.controller is None:
            raise ModelError(f"no controller was found ({self.status}): {self.diagnosis}")
        return self.controller

    @property
    def model(self) -> TSModel:
        """Return the plant with the controller's states, its disturbance with the noise of y."""
        wide, law = self._claimed()
        return TSModel(wide.A[None], wide.B2[None], E=law.E[None])

    @property
    def gains(self) -> Floats:
        """Return K of (u, x_K') = -K (x, x_K), (1, m + k, n + k)."""
        return self._claimed()[1].K[None]

    @property
    def output(self) -> tuple[Floats, Floats, Floats]:
        """Return (C, D, F) of z = C (x, x_K) + D (u, x_K') + F w, as ``L2Gain`` takes it."""
        wide, law = self._claimed()
        return wide.C1, wide.D12, law.direct

    def _claimed(self) -> tuple[GeneralisedPlant, LawParts]:
        controller = self.require()
        wide = with_integrators(self.plant, controller.order)
        return wide, law_parts(wide, static_gain(controller))


class LawParts(NamedTuple):
    """u = -K x + F D21 w in the plant: K, the disturbance's E and z's direct term.

    ``exact`` says whether each is the decimal of its float.
    """

    K: Floats
    E: Floats
    direct: Floats
    exact: bool


def hinf_fixed_order(
    plant: GeneralisedPlant,
    order: int = 0,
    *,
    pattern: ArrayLike | None = None,
    starts: int = 10,
    seed: int = 0,
) -> FixedOrderDesign:
    """Return a controller of the given order with |z|_2 <= gamma |w|_2, gamma least of many starts.

    Parameters
    ----------
    plant : the generalised plant, in continuous time; u does not reach y directly.
    order : k, the number of the controller's states; 0 for static output feedback, u = D_K y.
    pattern : (m + k, p + k), True where [[D_K, C_K], [B_K, A_K]] may differ from zero (m inputs, p
        measurements); None for no zeros.
    starts : the number of random starts, besides no control.  More take longer and may find less
        gain.
    seed : of the random numbers: the same seed, the same starts.

    Returns a ``FixedOrderDesign``.  Its norm is a local minimum, as a rule, of a problem that is
    not convex: there may be better controllers, and none found does not mean that there are none.
    Nothing is proved here; ``certify(design.model, design.gains, claims=[L2Gain(output=
    design.output)])`` is a proof.

    Raises ModelError: an order, starts or a seed that are not whole numbers from 0 on; a pattern
    that does not fit.

    Source: Burke, Henrion, Lewis, Overton (2006), 5th IFAC Symposium on Robust Control Design.
    """
    order, starts, seed = (
        whole_number(name, value)
        for name, value in (("order", order), ("starts", starts), ("seed", seed))
    )
    wide = with_integrators(plant, order)
    m, p = wide.B2.shape[1], len(wide.C2)
    free = pattern_of(np.ones((m, p), dtype=bool) if pattern is None else pattern, m, p)
    why = unmoved_mode(plant)
    if why:
        return FixedOrderDesign(plant=plant, status="infeasible", diagnosis=why)
    for local_best in best_gains(_loops_of(wide, free), [], starts=starts, seed=seed):
        design = _rounded(plant, wide, local_best.F[0], local_best.start)
        if design is not None:
            return design
    return FixedOrderDesign(
        plant=plant,
        diagnosis=(
            f"none of {starts + 1} starts led to a stable loop: try more starts, a higher order, "
            "or another measurement"
        ),
    )


def unmoved_mode(plant: GeneralisedPlant) -> str:
    """Return which mode that is not stable no controller changes; empty where none is."""
    for A, B, why in (
        (plant.A, plant.B2, "u does not move it"),
        (plant.A.T, plant.C2.T, "y does not see it"),
    ):
        mode = fixed_mode(A[None], B[None], 0.0)
        if mode is not None:
            return (
                f"no controller stabilises the plant: the mode {mode[1]:.4g} is not stable, and "
                f"{why}; an unstable or integrating weight has to be made stable, any other such "
                "mode needs another input or measurement"
            )
    return ""


def with_integrators(plant: GeneralisedPlant, order: int) -> GeneralisedPlant:
    """Return the plant with ``order`` integrators whose inputs are controls and states measured."""
    q, z = plant.B1.shape[1], len(plant.C1)
    eye = np.eye(order)
    return replace(
        plant,
        A=block_diag(plant.A, np.zeros((order, order))),
        B1=np.vstack([plant.B1, np.zeros((order, q))]),
        B2=block_diag(plant.B2, eye),
        C1=np.hstack([plant.C1, np.zeros((z, order))]),
        C2=block_diag(plant.C2, eye),
        D12=np.hstack([plant.D12, np.zeros((z, order))]),
        D21=np.vstack([plant.D21, np.zeros((order, q))]),
    )


def static_gain(controller: StateSpace) -> Floats:
    """Return [[D_K, C_K], [B_K, A_K]]."""
    return np.block([[controller.D, controller.C], [controller.B, controller.A]])


def controller_of_gain(F: Floats, order: int) -> StateSpace:
    """Return the controller of the static gain F of the plant with integrators."""
    m, p = F.shape[0] - order, F.shape[1] - order
    return StateSpace(F[m:, p:], F[m:, :p], F[:m, p:], F[:m, :p])


def _loops_of(plant: GeneralisedPlant, pattern: NDArray[np.bool_]) -> GainLoops:
    return GainLoops(
        A=plant.A[None],
        B1=plant.B1[None],
        B2=plant.B2[None],
        C1=plant.C1[None],
        C2=plant.C2[None],
        D11=plant.D11[None],
        D12=plant.D12[None],
        D21=plant.D21[None],
        pattern=pattern,
        group=np.zeros(1, dtype=np.intp),
    )


def _rounded(
    plant: GeneralisedPlant, wide: GeneralisedPlant, F: Floats, start: str
) -> FixedOrderDesign | None:
    """Return the design with F to few digits; None where its loop is not stable in any."""
    full_norm = _norm(wide, F)
    order = len(wide.A) - len(plant.A)
    for digits in (*DIGITS, LONG):
        short = np.array([[float(f"{entry:.{digits - 1}e}") for entry in row] for row in F])
        exact = digits != LONG and law_parts(wide, short).exact
        gain = _norm(wide, short)
        good = exact and gain <= (1.0 + LOST) * full_norm
        if np.isfinite(gain) and (good or digits == LONG):
            return FixedOrderDesign(
                controller=controller_of_gain(short, order),
                gain=gain,
                plant=plant,
                status="candidate",
                start=start,
                exact=exact,
            )
    return None


def _norm(plant: GeneralisedPlant, F: Floats) -> float:
    return largest_gain(
        plant.A + plant.B2 @ F @ plant.C2,
        plant.B1 + plant.B2 @ F @ plant.D21,
        plant.C1 + plant.D12 @ F @ plant.C2,
        plant.D11 + plant.D12 @ F @ plant.D21,
    ).gain


def law_parts(plant: GeneralisedPlant, F: Floats) -> LawParts:
    """Return -F C2, B1 + B2 F D21 and D11 + D12 F D21, each entry rounded once."""
    B2, C2, D12, D21, gain = (
        _decimals(matrix) for matrix in (plant.B2, plant.C2, plant.D12, plant.D21, F)
    )
    noise = gain @ D21
    exact = (-(gain @ C2), _decimals(plant.B1) + B2 @ noise, _decimals(plant.D11) + D12 @ noise)
    K, E, direct = (matrix.astype(np.float64) for matrix in exact)
    same = all(
        bool((matrix == _decimals(rounded)).all())
        for matrix, rounded in zip(exact, (K, E, direct), strict=True)
    )
    return LawParts(K, E, direct, same)


def _decimals(array: Floats) -> NDArray[np.object_]:
    """Return the entries as the fractions that their shortest decimals are."""
    return np.array(
        [[Fraction(repr(float(entry))) for entry in row] for row in array], dtype=object
    )
