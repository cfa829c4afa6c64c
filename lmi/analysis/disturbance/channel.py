"""From disturbance to output: one path through the vertices, checked, and in units of order one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import change_of, vertex_weight
from takagi.lmi.argument_checks import Vertices, sample_time_of, vertex_stack
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, nearest_power, state_units
from takagi.lmi.expressions.expression import Expression, He, Parameter, matrix
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError
from takagi.models.ts.vertex_arrays import vertex_arrays

# What of a gain's size is zero, and the share of its size that is left of an output without one.
ZERO, SHARE = 1e-10, 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class DisturbanceChannel:
    """xdot = sum_i h_i (A_i x + B_i w), y = sum_i h_i (C_i x + D_i w); x+ in discrete time.

    Attributes
    ----------
    A, B, C, D : (r, n, n), (r, n, q), (r, p, n), (r, p, q).
    sample_time : T in s; None for continuous time.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    sample_time: float | None = None

    def at(self, vertices: Indices) -> DisturbanceChannel:
        """Return the path at some of the vertices."""
        A, B, C, D = (stack[vertices] for stack in (self.A, self.B, self.C, self.D))
        return DisturbanceChannel(A, B, C, D, self.sample_time)

    def in_states(self, T: Floats) -> DisturbanceChannel:
        """Return the path in the states xhat of x = T xhat."""
        A, B = (np.asarray(np.linalg.solve(T, stack), np.float64) for stack in (self.A @ T, self.B))
        return DisturbanceChannel(A, B, self.C @ T, self.D, self.sample_time)

    def scaled(self, units: ChannelUnits) -> DisturbanceChannel:
        """Return the path in the given units; each number is multiplied by powers of two."""
        s = units.states
        return DisturbanceChannel(
            self.A * s / s[:, None] / units.rate,
            self.B / s[:, None] * (units.disturbance / units.rate),
            self.C * s / units.output,
            self.D * (units.disturbance / units.output),
            self.sample_time,
        )


@dataclass(frozen=True, slots=True, eq=False)
class ChannelUnits:
    """x = states xhat, w = disturbance what, y = output yhat, and time in 1 / rate.

    Attributes
    ----------
    states : (n,) powers of two, as are the others.
    rate : in 1/s; 1 in discrete time, which counts samples.
    """

    states: Floats
    rate: float
    disturbance: float
    output: float

    @classmethod
    def of(
        cls, channel: DisturbanceChannel, states: Floats, *, noise: bool = False
    ) -> ChannelUnits:
        """Return the units in which |A| is about 1, |B| and |C| alike, and the gain about 1.

        In discrete time V changes by a share |A - I| in a sample, and |w|^2 and |y|^2 in units of
        V are of that size, for P of order one.

        ``noise`` : w is white noise, whose effect in one sample is the root of that share of time.
        """
        s, step = states, channel.sample_time
        speed = float(nearest_power(vertex_weight(motion(channel.A * s / s[:, None], step)) / 2))
        rate = speed if step is None else 1.0
        plain = channel.scaled(cls(states, rate, 1.0, 1.0))
        share = 1.0 if step is None else speed
        reach, shown_size = float(np.abs(plain.B).max()) / share**0.5, float(np.abs(plain.C).max())
        gain, gain_bound = largest_response(plain), reach * shown_size / share**0.5
        if gain <= ZERO * gain_bound or not np.isfinite(gain):
            gain = gain_bound or 1.0
        # w scaled by d and y by c multiply the gain by d / c and P by c / d.
        ratio = np.sqrt(shown_size / reach) if reach and shown_size else 1.0
        disturbance = float(nearest_power(ratio / np.sqrt(gain)))
        output = float(nearest_power(ratio * np.sqrt(gain)))
        if noise:
            disturbance *= float(nearest_power(share**-0.5))
        return cls(states, rate, disturbance, output)


def disturbance_channel(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
) -> DisturbanceChannel:
    """Return the path E (or B, where there is no E) to C, of a model or of matrices.

    With E there is no direct term from w to y: a model's D belongs to its input.

    Parameters
    ----------
    model : A (r, n, n), C (r, p, n), and E (r, n, q) or B (r, n, m) with D (r, p, m); or A itself,
        (r, n, n) or (n, n).
    B, C, D : with A itself only; (r, ., .), or (., .) for the same in every vertex.
    sample_time : T in s of x+ = A x + B w, where arrays cannot say; None for continuous time, or
        the model's own.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, a path that is
        zero at every vertex, or a sample time that is not positive or not the model's.
    """
    A = vertex_stack(model).astype(np.float64)
    step = sample_time_of(model, sample_time)
    matrices = {"B": B, "C": C, "D": D, "E": None}
    if hasattr(model, "A"):
        extra = [letter for letter, value in matrices.items() if value is not None]
        if extra:
            raise ModelError(
                f"a model and {', '.join(extra)} were given; give the model alone, or A, B, C, D "
                "as arrays"
            )
        matrices = {letter: getattr(model, letter, None) for letter in matrices}
    if matrices["C"] is None or 0 in np.shape(matrices["C"]):
        raise ModelError("there is no output; C is needed, (p, n) or one for each vertex")
    disturbed = matrices["E"] is not None and 0 not in np.shape(matrices["E"])
    if not disturbed and (matrices["B"] is None or 0 in np.shape(matrices["B"])):
        raise ModelError("there is no disturbance and no input; E (or B) is needed")
    # D leads from the input to the output, so it is not part of the path from E.
    unused = ("B", "D") if disturbed else ("E",)
    arrays, _ = vertex_arrays(
        A,
        {letter: None if letter in unused else value for letter, value in matrices.items()},
        dict.fromkeys(("states", "inputs", "outputs", "disturbances")),
    )
    C_ = arrays["C"]
    W = arrays["E"] if disturbed else arrays["B"]
    through = np.zeros((len(A), C_.shape[1], W.shape[2])) if disturbed else arrays["D"]
    if not (through.any() or (W.any() and C_.any())):
        name = ("E" if disturbed else "B") if not W.any() else "C"
        raise ModelError(
            f"{name} is zero at every vertex, so nothing reaches the output; the gain is 0"
        )
    return DisturbanceChannel(A, W, C_, through, step)


def moved(
    P: Unknown, path: DisturbanceChannel, rate: Parameter | None = None
) -> tuple[Expression, Expression, Expression | int]:
    """Return the blocks xx, xw, ww of V' = [x; w]' [[xx, xw], [xw', ww]] [x; w], V = x' P x.

    With a rate V' + 2 alpha V; in discrete time V(x+) - V(x), or V(x+) - rho^2 V(x).
    """
    A, B = matrix(path.A, "A_{i}"), matrix(path.B, "B_{i}")
    if path.sample_time is None:
        return He(P @ A) if rate is None else change_of(P, A, rate, None), P @ B, 0
    return A.T @ P @ A - (P if rate is None else rate * P), A.T @ P @ B, B.T @ P @ B


def shown(path: DisturbanceChannel) -> tuple[Expression, Expression]:
    """Return C_i' and D_i' of the output."""
    C, D = path.C.transpose(0, 2, 1), path.D.transpose(0, 2, 1)
    return matrix(C, r"C_{i}^\top"), matrix(D, r"D_{i}^\top")


def hiding_states(channel: DisturbanceChannel) -> Floats | None:
    """Return T of x = T xhat in which the output is small, where no disturbance reaches it.

    The states that w reaches at any vertex are not seen in y; those across them are counted in a
    share of their units, so that a function of order one shows a gain of that share.  None where w
    reaches the output.
    """
    s = state_units(channel.A, None, step=channel.sample_time)
    A, C = channel.A * s / s[:, None], channel.C * s
    reached = np.concatenate(list(channel.B / s[:, None]), axis=1)
    V = np.zeros((len(s), 0))
    while reached.shape[1]:
        directions, sizes, _ = np.linalg.svd(reached - V @ (V.T @ reached), full_matrices=False)
        new = directions[:, sizes > ZERO * max(float(np.linalg.norm(reached, 2)), 1e-300)]
        V = np.linalg.qr(np.hstack([V, new]))[0] if new.shape[1] else V
        reached = np.concatenate(list(A @ new), axis=1)
    if np.abs(C @ V).max(initial=0.0) > ZERO * np.abs(C).max():
        return None
    across = np.linalg.qr(V, mode="complete")[0][:, V.shape[1] :] if V.shape[1] else np.eye(len(s))
    return np.asarray(s[:, None] * np.hstack([V, SHARE * across]))


def largest_response(channel: DisturbanceChannel) -> float:
    """Return the largest singular value of the vertices' responses, at their own frequencies."""
    # It only sets units, so a sample of very many vertices is enough.
    some = slice(None, None, 1 + len(channel.A) // 512)
    A, B, C, D = channel.A[some], channel.B[some], channel.C[some], channel.D[some]
    poles = np.linalg.eigvals(A)
    if channel.sample_time is None:
        rates = np.concatenate([np.zeros((len(A), 1)), np.abs(poles.imag), np.abs(poles)], axis=1)
        points = 1j * rates
    else:
        turns = np.concatenate([[[0.0, np.pi]] * len(A), np.abs(np.angle(poles))], axis=1)
        points = np.exp(1j * turns)
    eye = np.eye(A.shape[1])
    through = float(np.linalg.norm(D, 2, axis=(1, 2)).max())
    with np.errstate(all="ignore"):
        try:
            inside = points[:, :, None, None] * eye - A[:, None]
            response = C[:, None] @ np.linalg.solve(inside, B[:, None]) + D[:, None]
        except np.linalg.LinAlgError:
            return through
    return max(through, float(np.linalg.norm(response, 2, axis=(2, 3)).max()))
