r"""The exact channel from a disturbance to an output through the loop, blend by blend.

    x' = A x + B w,   y = C x + D w        (x+ in the place of x' in discrete time)

A and C are those of the closed loop. The claim selects the channel:

    "disturbance": "disturbances"   B = E_i, D = 0
    "disturbance": "inputs"         B = B_i, D = D_i: w is added to the input, u = -K x + w
    "entering": names               of "disturbances": w consists of these, the others are at rest
    "output": absent                C = C_i - D_i K_j of the model
    "output": {"C", "D", "F"}       y = C x + D u + F w, an output of the claim, as stacks of one or
                                    r matrices; D and F may be left out; only one of each for a
                                    secant embedding, because its weights cannot be evaluated

The mean over the pairs of a ``Blend`` is taken for A, B, C and D with the same weights, so that the
loop is a blend of these channels.  A condition that is convex in (A, B, C, D) holds for the loop if
it holds for each channel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import listed, member, read_stack, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.averages import refuse_averages
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded

Stack = tuple[Matrix, ...]


@dataclass(frozen=True, slots=True)
class DisturbanceChannel:
    """The channel of one blend; ``D`` is None if there is no direct feedthrough from w to y."""

    label: str
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix | None

    @property
    def through(self) -> Matrix:
        """D, as a matrix of zeros where there is no feedthrough."""
        return Matrix.zeros(self.C.shape[0], self.B.shape[1]) if self.D is None else self.D


def disturbance_channels(
    claim: Any, loop: PolytopicLoop, where: str
) -> Iterator[DisturbanceChannel]:
    """Yield the channel of every blend.

    Raises
    ------
    CertificateError : an unknown disturbance, or a matrix that is missing or does not fit.
    """
    with_output, entering_stack, direct = channel_stacks(claim, loop, where)
    blends = blends_of(replace(with_output, extra_stacks=(entering_stack, *direct)), claim, where)
    bounded(len(blends), with_output.order + entering_stack[0].shape[1])
    for blend in blends:
        B, *through = map(blend.of, blend.loop.extra_stacks)
        D = sum(through[1:], through[0]) if through else None
        yield DisturbanceChannel(blend.label, blend.A, B, blend.C, D)


def entrance(claim: Any, loop: PolytopicLoop, where: str) -> tuple[str, Stack]:
    """Return "disturbances" or "inputs", as the claim states, and the matrices of w: E, or B.

    Raises
    ------
    CertificateError : an unknown kind of disturbance, or one that the model does not have.
    """
    source = text(claim, "disturbance", where)
    if source not in ("disturbances", "inputs"):
        raise CertificateError(f"{where}.disturbance: {source!a} is not 'disturbances' or 'inputs'")
    stack = loop.E if source == "disturbances" else loop.B
    if not stack:
        raise CertificateError(f"{where}.disturbance: the model has no {source}")
    return source, stack


def entering_columns(claim: Any, loop: PolytopicLoop, where: str) -> tuple[int, ...]:
    """Return the numbers of the model's disturbances that w consists of; () for all.

    Raises
    ------
    CertificateError : ``entering`` beside w at the inputs, an unknown name, or one twice.
    """
    if "entering" not in claim:
        return ()
    place = f"{where}.entering"
    if text(claim, "disturbance", where) != "disturbances":
        raise CertificateError(f"{place}: only the model's disturbances have names")
    names = listed(claim, "entering", where, 1, len(loop.disturbances))
    for name in names:
        if name not in loop.disturbances:
            raise CertificateError(f"{place}: {name!a} is no disturbance of the model")
        if names.count(name) > 1:
            raise CertificateError(f"{place}: {name!a} stands in it twice")
    return tuple(loop.disturbances.index(name) for name in names)


def with_columns(stack: Stack, columns: tuple[int, ...]) -> Stack:
    """Return the matrices with these columns alone; with all for ()."""
    if not columns:
        return stack
    return tuple(Matrix([[row[k] for k in columns] for row in M.rows], M.below) for M in stack)


def channel_stacks(
    claim: Any, loop: PolytopicLoop, where: str
) -> tuple[PolytopicLoop, Stack, list[Stack]]:
    """Return the loop with the claim's output, the matrices of w, and those of w in y.

    Conditions that are polynomials in the weights need the matrices of the rules.  The matrices of
    w in y are to be added up.

    Raises
    ------
    CertificateError : as ``disturbance_channels``.
    """
    source, all_entering = entrance(claim, loop, where)
    entering = with_columns(all_entering, entering_columns(claim, loop, where))
    with_output, F = _with_output(claim, loop, entering[0].shape[1], where)
    if not with_output.C:
        raise CertificateError(f"{where}: the model has no output, and the claim gives none")
    direct: list[Stack] = [F] if F else []
    if source == "inputs" and with_output.D:
        direct.append(with_output.D)
    return with_output, entering, direct


def _with_output(
    claim: Any, loop: PolytopicLoop, width: int, where: str
) -> tuple[PolytopicLoop, Stack]:
    """Return the loop with the claim's output instead of the model's, and F; see the module."""
    if "output" not in claim:
        return loop, ()
    output_place = f"{where}.output"
    output = member(claim, "output", where)
    C = read_stack(output, "C", output_place)
    D = read_stack(output, "D", output_place) if "D" in output else ()
    F = read_stack(output, "F", output_place) if "F" in output else ()
    height, inputs = C[0].shape[0], loop.B[0].shape[1] if loop.B else 0
    for key, stack, columns in (("C", C, loop.order), ("D", D, inputs), ("F", F, width)):
        if stack and (stack[0].shape != (height, columns) or len(stack) not in (1, loop.rules)):
            raise CertificateError(
                f"{output_place}.{key}: {height} by {columns} is needed, one or {loop.rules} "
                "of them"
            )
    if any(len(stack) > 1 for stack in (C, D, F)):
        refuse_averages(loop, "output", output_place)
    return replace(loop, C=C, D=D), F


def quadratic_change(
    A: Matrix, B: Matrix, P: Matrix, *, discrete: bool
) -> tuple[Matrix, Matrix, Matrix]:
    """Return (F, G, H): V' or V(x+) - V(x) = -x'Fx + 2 x'Gw + w'Hw for V = x'Px."""
    PA, PB = P @ A, P @ B
    if not discrete:
        return -(PA + PA.T), PB, Matrix.zeros(B.shape[1], B.shape[1])
    return P - A.T @ PA, A.T @ PB, B.T @ PB
