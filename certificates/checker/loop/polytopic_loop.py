r"""The loop that claims are about, with exact numbers: vertices, gains and their weights.

    x' = sum_i h_i (A_i x + B_i u + E_i w),   y = sum_i h_i (C_i x + D_i u),   u = -sum_j g_j K_j x

or x+ in place of x' in discrete time, for any weights >= 0 with sum one that may vary freely.
The loop is the double sum of h_i g_j (A_i - B_i K_j).  Pairs whose products of weights are equal
are added up: a matrix inequality that is affine in the matrices of a pair holds along the loop
when it holds for the mean of each such group, a ``Blend``.  Which products are equal:

    (i, j) and (j, i)        where the law has the weights of the model, g = h
    equal corners            where h_i = prod_k w_k,c_ik besides: the corners {c_ik, c_jk} agree
    a pair by itself         where the law has its own weights, or the model's weights depend
                             on the command; and where the weights are averages

One gain for all rules, or one B and one D with g = h, makes the loop affine in the weights. Then it
suffices to check the rules.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from fractions import Fraction
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.matrices import Matrix, mean, read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError

if TYPE_CHECKING:
    # Most laws have no observer: its module is not loaded for them.
    from takagi.certificates.checker.loop.observer_law import ObserverLaw

Stack = tuple[Matrix, ...]
Pairs = tuple[tuple[int, int], ...]
Side = tuple[Fraction, Fraction]
Box = tuple[Side | None, ...]
SHAPES = {"A": "nn", "B": "nm", "C": "pn", "D": "pm", "E": "nq"}
# Weights that are mean slopes from the equilibrium to the state: see ``averaged``.
SECANTS = "secants"
# The time of exact elimination grows as the fourth power of the order: at most two minutes.
MOST_PAIRS, MOST_WORK = 1 << 20, 10**8


@dataclass(frozen=True)
class PolytopicLoop:
    """Vertices and gains; a stack of one matrix applies to all rules, an empty stack means none.

    x and u are deviations from the equilibrium. For a ``plant`` this is the law's trim, which the
    claim ``sector-embedding`` compares; for matrices alone it is the point they refer to.

    ``box`` : per state, its range in the coordinates of x, or None; ``other_box`` : the ranges of
    box variables that are not states.  ``corners`` : c_ik per rule, where weights are products;
    ``weights`` : see ``weights_of``.  ``scheduled_by`` : the variables that the premises depend
    on, or None where the model does not say.  ``stated_rules`` : the number of rules of the model,
    also when a claim leaves some stacks out. ``extra_stacks`` : stacks of a claim, by rule.
    ``resting_elsewhere`` : which of x, u, y, w are deviations from an equilibrium value other than
    0.  ``observer`` : of a law that has outputs alone; C and D then have the measured rows.
    ``at_other_ends`` : the same loop where numbers that are no fractions, which are constant, are
    at the other ends of their bounds; a claim about the loop is shown for each.
    """

    A: Stack
    _: KW_ONLY
    B: Stack = ()
    C: Stack = ()
    D: Stack = ()
    E: Stack = ()
    K: Stack = ()
    sample_time: Fraction | None = None
    states: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()
    box: Box = ()
    other_box: Mapping[str, Side] | None = None
    corners: tuple[tuple[int, ...], ...] | None = None
    weights: str = ""
    scheduled_by: tuple[str, ...] | None = None
    shared_weights: bool = True
    stated_rules: int = 1
    extra_stacks: tuple[Stack, ...] = ()
    resting_elsewhere: str = field(default="", repr=False)
    observer: ObserverLaw | None = field(default=None, repr=False)
    at_other_ends: tuple[PolytopicLoop, ...] = field(default=(), repr=False)

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.A[0].rows)

    @property
    def rules(self) -> int:
        """The number of vertices."""
        return max(self.stated_rules, *map(len, (self.A, self.B, self.C, self.D, self.E)))

    @property
    def is_discrete(self) -> bool:
        return self.sample_time is not None

    @property
    def averaged(self) -> bool:
        """Whether the weights are averages along a segment, which no law can evaluate."""
        return self.weights == SECANTS and self.rules > 1

    def groups(self) -> list[tuple[str, Pairs]]:
        """Return the pairs (vertex, gain) whose products of weights are equal, with a name."""
        r, s, c = self.rules, len(self.K), self.corners
        if r * max(s, 1) > MOST_PAIRS:
            raise CertificateError(f"{r} vertices and {s} gains: at most {MOST_PAIRS} pairs")
        affine = s <= 1 or (len(self.B) <= 1 and len(self.D) <= 1 and self.shared_weights)
        groups: dict[object, list[tuple[int, int]]] = {}
        for i, j in zip(range(r), range(r), strict=True) if affine else product(range(r), range(s)):
            key: object = (i, j)
            if self.shared_weights and not affine:
                first, second = (c[i], c[j]) if c else ((i,), (j,))
                key = tuple(tuple(sorted(ends)) for ends in zip(first, second, strict=True))
            groups.setdefault(key, []).append((i, j))
        bounded(len(groups), self.order)
        return [(f"rules {i + 1} and {j + 1}" if i != j else f"rule {i + 1}", tuple(pairs))
                for pairs in groups.values() for i, j in pairs[:1]]  # fmt: skip

    def blends(self) -> list[Blend]:
        """Return the groups of ``groups``; their matrices are made when they are asked for."""
        return [Blend(self, label, pairs) for label, pairs in self.groups()]


@dataclass(frozen=True)
class Blend:
    """A group of pairs with the mean matrices over the pairs; A and C are of the closed loop."""

    loop: PolytopicLoop
    label: str
    pairs: Pairs

    @property
    def A(self) -> Matrix:
        """A_i - B_i K_j."""
        return self._closed(self.loop.A, self.loop.B)

    @property
    def C(self) -> Matrix:
        """C_i - D_i K_j."""
        return self._closed(self.loop.C, self.loop.D)

    @property
    def E(self) -> Matrix:
        return self.of(self.loop.E)

    @property
    def K(self) -> Matrix:
        return self.of(self.loop.K, 1)

    def of(self, stack: Stack, side: int = 0) -> Matrix:
        """Return the mean of the matrices of the vertices, or of the gains for ``side`` = 1."""
        return mean([_at(stack, pair[side]) for pair in self.pairs])

    def _closed(self, X: Stack, Y: Stack) -> Matrix:
        K = self.loop.K
        if not K or not Y:
            return self.of(X)
        return mean([_at(X, i) - _at(Y, i) @ _at(K, j) for i, j in self.pairs])


def bounded(count: int, order: int) -> None:
    """Refuse a number of inequalities that would take too long to check."""
    if count * order**4 > MOST_WORK:
        raise CertificateError(f"{count} inequalities of order {order}: too many")


def _at(stack: Stack, i: int) -> Matrix:
    if not stack:
        raise CertificateError("the claim needs a matrix that the model does not have")
    return stack[i if len(stack) > 1 else 0]


def vertices(model: Any, where: str) -> PolytopicLoop:
    """Return the model of kind ``takagi-sugeno``; ``PolytopicLoop`` says what may be left out."""
    stacks: dict[str, Any] = {
        x: read_stack(model, x, where) for x in SHAPES if x == "A" or x in model
    }
    axes = [pair for x in stacks for pair in zip(SHAPES[x], stacks[x][0].shape, strict=True)]
    sizes, counts = dict(axes), {len(stack) for stack in stacks.values()} | {1}
    if any(sizes[axis] != size for axis, size in axes) or len(counts) > 2:
        raise CertificateError(f"{where}: {', '.join(stacks)} do not fit together")
    states = _different(model, "state_names", where, sizes["n"])
    box, other_box = _box(model, states, where)
    corners, premises = _corners(model, where, max(counts)), model.get("premises")
    weights = weights_of(premises, corners)
    if corners is not None:
        _require_every_corner(premises, corners, where)
    matrices: dict[str, Any] = {x: _single(M) if x in "BD" else M for x, M in stacks.items()}
    return PolytopicLoop(
        **matrices,
        sample_time=_sample_time(model, where),
        states=states,
        inputs=_names(model, "input_names", sizes.get("m", 0), where),
        disturbances=_names(model, "disturbance_names", sizes.get("q", 0), where),
        box=box,
        other_box=other_box,
        corners=corners,
        weights=weights,
        stated_rules=max(counts),
    )


def _names(model: Any, key: str, count: int, where: str) -> tuple[str, ...]:
    return _different(model, key, where, count) if count and key in model else ()


def _different(owner: Any, key: str, where: str, count: int) -> tuple[str, ...]:
    """Return this number of different names, each one line of text."""
    values = reader.member(owner, key, where)
    listed = values if isinstance(values, list) else []
    names = tuple(reader.text({key: value}, key, where) for value in listed)
    if len(names) != count or len(set(names)) != count:
        raise CertificateError(f"{where}.{key}: {count} different names are needed")
    return names


def _single(stack: Stack) -> Stack:
    """Return one matrix in the place of equal ones."""
    return stack[:1] if all(matrix == stack[0] for matrix in stack) else stack


def _sample_time(owner: Any, where: str) -> Fraction | None:
    stated = reader.member(owner, "sample_time", where)
    step = None if stated is None else reader.number(owner, "sample_time", where)
    if step is not None and step <= 0:
        raise CertificateError(f"{where}.sample_time: a positive number is needed")
    return step


def _box(model: Any, states: tuple[str, ...], where: str) -> tuple[Box, dict[str, Side]]:
    sides = model.get("box", {})
    if not isinstance(sides, dict):
        raise CertificateError(f"{where}.box: an object of ranges is needed")
    ranges = {}
    for name in sides:
        # Sentences and messages print a name unchanged.
        if not name or not name.isprintable():
            raise CertificateError(f"{where}.box: {name[:60]!a} is no name of printable text")
        ends = reader.numbers(sides, name, f"{where}.box", 2)
        reader.increasing(ends, f"{where}.box.{name!a}")
        ranges[name] = (ends[0], ends[1])
    return tuple(ranges.pop(name, None) for name in states), ranges


def _corners(model: Any, where: str, rules: int) -> tuple[tuple[int, ...], ...] | None:
    """Return the corners of every rule, or None where weights are not said to be products."""
    if "rules" not in model:
        return None
    rows = reader.matrix(model, "rules", where)
    corners = tuple(tuple(map(int, row)) for row in rows)
    is_binary = all(corner in (0, 1) for row in rows for corner in row)
    if not is_binary or not len(set(corners)) == len(corners) == rules:
        raise CertificateError(f"{where}.rules: {rules} different rows of 0 and 1 are needed")
    return corners


def weights_of(premises: Any, corners: tuple[tuple[int, ...], ...] | None) -> str:
    """Return the definition of the weights as one text; equal texts mean equal weights.

    Numbers are compared as written. So equal weights may be treated as different, but never
    different weights as equal.
    """
    if not premises and not corners:
        return ""
    if not isinstance(premises or [], list):
        raise CertificateError("premises: a list is needed")
    needed, rows = ("name", "lower", "upper"), [list(map(str, row)) for row in corners or ()]
    definitions = [[*(reader.member(p, key, "premises") for key in needed), p.get("expression")]
            for p in premises or []]  # fmt: skip
    return reader.canonical([definitions, rows])


def closed_by(plain: PolytopicLoop, gains: Any, where: str) -> PolytopicLoop:
    """Return the loop with u = -sum_j g_j K_j x.

    Raises
    ------
    CertificateError : gains for other states, of another shape or sample time.
    """
    K = _single(read_stack(gains, "K", where))
    needed = (plain.B[0].shape[1] if plain.B else 0, plain.order)
    if K[0].shape != needed:
        raise CertificateError(f"{where}.K: {needed[0]} by {needed[1]} is needed, not {K[0].shape}")
    if _sample_time(gains, where) != plain.sample_time:
        raise CertificateError(f"{where}.sample_time is not the model's")
    states = _different(gains, "state_names", where, plain.order)
    inputs = _names(gains, "input_names", needed[0], where) or plain.inputs
    if states != plain.states or (plain.inputs and inputs != plain.inputs):
        raise CertificateError(f"{where}: states or inputs are not the model's, in its order")
    # A gain that is written once applies to all rules of the law, however many these are.
    rows = gains.get("rules")
    count = len(rows if isinstance(rows, list) and len(gains["K"]) == 1 else gains["K"])
    law_corners = _corners(gains, where, count)
    corners = law_corners or plain.corners
    shared = weights_of(gains.get("premises"), corners) == plain.weights
    # A law cannot evaluate weights that depend on its own command.
    circular = len(K) > 1 and not set(plain.inputs).isdisjoint(plain.scheduled_by or ())
    has_model_weights = shared and not circular and len(K) in (1, plain.rules)
    # Equal gains too are one gain only where the law's weights have the sum 1. Without stated
    # premises nothing else is known about them.
    if corners and (law_corners or (gains.get("premises") and len(K) > 1 and not shared)):
        _require_every_corner(gains.get("premises"), corners, where)
    return replace(plain, K=K, inputs=inputs, shared_weights=has_model_weights)


def _require_every_corner(premises: Any, corners: tuple[tuple[int, ...], ...], where: str) -> None:
    """Refuse products of weights that do not cover all corners, because their sum is not 1.

    Where no premises are stated, one that is at the same end in all rules counts as constant.
    """
    if premises:
        sides = [[reader.number(p, end, where) for end in ("lower", "upper")] for p in premises]
        ends = [(0,) if low == high else (0, 1) for low, high in sides]
    else:
        ends = [tuple(set(column)) for column in zip(*corners, strict=True)]
    # The count first: forty premises have more corners than fit into memory.
    if len(corners) != prod(map(len, ends)) or set(corners) != set(product(*ends)):
        raise CertificateError(
            f"{where}.rules: not the corners of its {len(ends)} premises, each of them once"
        )
