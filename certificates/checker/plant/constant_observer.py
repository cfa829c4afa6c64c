r"""The observer with constant matrices of a law with references and measured outputs.

    s' = A s + B (u - u*) + L (y - y* - C s),    u = u* - K (s, xi),

where s estimates the deviations of the plant's own states and xi are the integrals, which the law
has itself.  ``gains.observer`` states A, B, C and L; the columns of K are in the order of the
model's states, those of own states act on s.  With Z = (X, s), X = (x, xi), differences between two
motions at equal signals are blends of

    Z' = [ A_i      0      ] Z + [ B_i ] (-K' Z),    K' = K with the columns of own states at s,
         [ L C_i    A - L C]     [ B   ]

because the slopes of f and y are means along one segment.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import member, read_matrix, text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, at
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.reading import PlantNodes
from takagi.certificates.checker.plant.references import Following
from takagi.certificates.checker.replay.observer_reading import measured_outputs

CONSTANT = "constant"


@dataclass(frozen=True)
class ConstantObserver:
    """The matrices; ``rows`` are the measured outputs, ``states`` the places of own states."""

    A: Matrix
    B: Matrix
    C: Matrix
    L: Matrix
    rows: list[int]
    states: list[int]

    def joint(self, loop: PolytopicLoop) -> PolytopicLoop:
        """Return the loop of plant, integrals and estimate, z = (X, s)."""
        if any(any(map(any, D.rows)) for D in loop.D):
            raise Refused("a measured output depends on an input")
        n, k = loop.order, len(self.states)
        none, inner = Matrix.zeros(n, k), self.A - self.L @ self.C
        measured = [Matrix([C.rows[row] for row in self.rows], C.below) for C in loop.C]
        A = tuple(
            Matrix.blocks([[at(loop.A, i), none], [self.L @ at(tuple(measured), i), inner]])
            for i in range(loop.rules)
        )
        B = tuple(Matrix.blocks([[B], [self.B]]) for B in loop.B)
        K = tuple(map(self.moved, loop.K))
        return replace(loop, A=A, B=B, C=(), D=(), E=(), K=K, states=(), box=())

    def moved(self, K: Matrix) -> Matrix:
        """Return K' of u - u* = -K' z."""
        here = [[0 if j in self.states else v for j, v in enumerate(row)] for row in K.rows]
        there = [[row[j] for j in self.states] for row in K.rows]
        return Matrix([a + b for a, b in zip(here, there, strict=True)], K.below)

    def rates(
        self, plant: PlantNodes, state_nodes: dict[str, int], estimate: list[int], push: list[int]
    ) -> list[int]:
        """Return the nodes of s' at s = ``estimate``, u - u* = ``push`` and x of ``places``."""
        g = plant.graph
        measured = [plant.outputs[row] for row in self.rows]
        gaps = [g.subtract(substituted(g, y, state_nodes), plant.at_rest(y)) for y in measured]
        products = ((self.A - self.L @ self.C, estimate), (self.B, push), (self.L, gaps))
        return [
            g.total(
                g.multiply(g.constant(M[i, j]), node)
                for M, nodes in products
                for j, node in enumerate(nodes)
            )
            for i in range(len(self.states))
        ]


def read_constant_observer(
    model: Any, gains: Any, plant: PlantNodes, follow: list[Following], where: str
) -> ConstantObserver:
    """Return the observer of ``gains``.

    Raises
    ------
    CertificateError : another kind of observer, matrices of another shape, an unknown output.
    Refused : what follows a reference is not measured.
    """
    observer = member(gains, "observer", "gains")
    if text(observer, "weights", where) != CONSTANT:
        raise CertificateError(f"{where}.weights: a law with references has {CONSTANT!r} ones")
    rows = measured_outputs(observer, model, where)
    integrals = {following.row for following in follow}
    states = [k for k in range(len(plant.states)) if k not in integrals]
    n, m, p = len(states), len(plant.inputs), len(rows)
    shapes = {"A": (n, n), "B": (n, m), "C": (p, n), "L": (n, p)}
    matrices = {key: read_matrix(observer, key, where, shape) for key, shape in shapes.items()}
    _check_known(plant, follow, [plant.outputs[row] for row in rows])
    return ConstantObserver(**matrices, rows=rows, states=states)


def _check_known(plant: PlantNodes, follow: list[Following], measured: list[int]) -> None:
    """Refuse an h(x) that is no measured output, and no function of states that are measured."""
    algebra, g = Algebra(plant.graph, plant.tables), plant.graph
    measured_states = {
        v.symbol for v in plant.states if any(algebra.equal(y, plant.value_of(v)) for y in measured)
    }
    for following in follow:
        is_measured = g.variables(following.follow) <= measured_states
        if not is_measured and not any(algebra.equal(following.follow, y) for y in measured):
            raise Refused(f"what follows {following.signal.name} is not measured")
