"""A rigorous no: exact multipliers that rule out every solution.

Let Z_k >= 0 be symmetric multipliers, one for each item, such that sum_k <sign F_k(x), Z_k> has the
same value c for all unknowns x.  If some x satisfied the condition, then

    0 <= sum_k <sign F_k(x), Z_k> = c,     and 0 < c if a strict item has Z_k other than 0.

Therefore c < 0 excludes every x, and c = 0 excludes every x if a strict item has Z_k other than 0.
LMIs with a weight are strict; those without a weight, the normalisations, hold with equality
allowed.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2.3 (theorems of alternatives).

The multipliers of a solver are tried first. If these are singular, others are computed that are as
far from singular as possible: among the multipliers with sum_k <sign F_k(x), Z_k> + zeta = 0 for
all x and zeta >= 0, those with Z_k >= s g_k I, zeta >= s g_0 and s largest.  As an LMI problem of
the size of the condition's own, in x, x_0 and tau:

    minimise tau  with  A_k(x) + x_0 C_k + tau w_k I >= 0,  x_0 + tau w_0 >= 0,
                        sum_k g_k trace(.) + g_0 (.) >= 1,

where sign F_k(x) = A_k(x) + C_k and g = 1 / w; its multipliers and that of the last row give Z_k.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import chain
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.answer import Answer, Design
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.condition.statements import StatedCondition, condition_of, lmi_of
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.cone.cone_program import Assembled, Cone, ConeProgram, assemble, unpack
from takagi.lmi.expressions.expression import Expression, added, expression_of, matrix
from takagi.lmi.refutation.exact_algebra import (
    Adjoint,
    adjoint,
    fault_of_function,
    function_that_decays,
    is_semidefinite,
    over_one_denominator,
    packed_places,
)
from takagi.lmi.refutation.exact_multipliers import Face, exact_near, faces_near, open_face
from takagi.lmi.solver.solve import attempts
from takagi.models.arrays import Floats, Indices, ShortRepr
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Alternative(ShortRepr):
    """A proof that no unknowns satisfy a condition: exact multipliers, or a function that decays.

    The proof is about the numbers that the condition stores.  A float counts as the exact dyadic
    number that it represents; rounding by the builder of the condition is part of the condition.

    Attributes
    ----------
    condition : the condition without a solution.
    multipliers : LMI -> (items, size, size) of Fractions; the multipliers of other LMIs are zero.
    function : the unknown -> (1, n, n) of Fractions: a value that satisfies one item but is not
        positive definite (``indefinite``).  It is used if there are no multipliers.
    """

    condition: Condition
    multipliers: Mapping[str, Array] = field(default_factory=dict)
    function: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("multipliers", "function"):
            exact = {key: fractions(value) for key, value in getattr(self, name).items()}
            object.__setattr__(self, name, MappingProxyType(exact))

    @property
    def holds(self) -> bool:
        """Return whether it is a proof; each call checks everything again in exact arithmetic."""
        return not self.fault()

    def fault(self) -> str:
        """Return the reason why it is not a proof; an empty text if it is one.

        Raises
        ------
        ModelError : a multiplier of an LMI that is not there, or of another shape.
        """
        if self.function and not self.multipliers:
            return fault_of_function(self.condition, self.function)
        read = adjoint(self.condition)
        z = multiplier_entries(read, self.multipliers)
        for block in read.blocks:
            name = self.condition.lmis[block.lmi].name
            if name in self.multipliers:
                Z = self.multipliers[name][block.item]
                if np.any(Z != Z.T):
                    return f"the multiplier of {read.name(block)} is not symmetric"
                if not is_semidefinite(Z):
                    return f"the multiplier of {read.name(block)} is not positive semidefinite"
        # One denominator for all: sums of integers are quicker than sums of fractions.
        z, denominator = over_one_denominator(z)
        nonzero = np.flatnonzero(read.products(z))
        if len(nonzero):
            return f"the sum depends on {_number_name(self.condition, int(nonzero[0]))}"
        constant = Fraction(int(read.constant @ z), denominator * read.denominator)
        if constant > 0:
            return f"the sum is {float(constant):.3g}; it must not be positive"
        strict = any(z[block.index].any() for block in read.blocks if read.strict(block))
        return "" if constant < 0 or strict else "the multipliers of the strict LMIs are all zero"

    def __str__(self) -> str:
        fault = self.fault()
        if fault:
            return (
                f"{self.condition.name}: nothing is shown by these multipliers, because {fault}; "
                "take them from exact_no, whose are exact"
            )
        if not self.multipliers:
            return (
                f"{self.condition.name}: no unknowns satisfy it; an exact function that decays at "
                "one vertex without being positive definite rules it out by that vertex alone"
            )
        count = sum(int(np.any(Z != 0)) for Zs in self.multipliers.values() for Z in Zs)
        return (
            f"{self.condition.name}: no unknowns satisfy it; {count} exact multipliers show that "
            "its inequalities contradict one another"
        )


def multiplier_entries(read: Adjoint, multipliers: Mapping[str, Array]) -> Array:
    """Return z, (columns,): the entries of the multipliers on and above the diagonal.

    Raises
    ------
    ModelError : a multiplier of an LMI that is not there, or of another shape.
    """
    names = [lmi.name for lmi in read.condition.lmis]
    for name, value in multipliers.items():
        if name not in names:
            raise ModelError(
                f"there is no LMI {name!r} in {read.condition.name}; it has {', '.join(names)}"
            )
        lmi = read.condition.lmis[names.index(name)]
        if np.shape(value) != (lmi.count, lmi.size, lmi.size):
            raise ModelError(
                f"the multipliers of {name!r} have shape {np.shape(value)}; "
                f"{(lmi.count, lmi.size, lmi.size)} is needed"
            )
    z = np.zeros(read.columns, dtype=object)
    for block in read.blocks:
        name = names[block.lmi]
        if name in multipliers:
            Z = multipliers[name][block.item]
            # The entries below the diagonal count as those above it.
            z[block.index] = np.where(np.tri(len(Z), k=-1, dtype=bool), Z.T, Z)
    return z


def _number_name(condition: Condition, number: int) -> str:
    for unknown in condition.unknowns:
        if number < unknown.length:
            member, entry = divmod(number, unknown.entries)
            row, column = np.argwhere(unknown.entry_index() == entry)[0]
            member_text = f"{member + 1}" if unknown.count > 1 else ""
            return f"{unknown.name}{member_text}[{row}, {column}]"
        number -= unknown.length
    raise AssertionError("no unknown has that number")


TRIES = 2
# How far the sum should be below zero, as a share of the size of the constants, if the multipliers
# are of order one.
ROOM = 0.1


def rigorous_no(answer: Answer | Design) -> Alternative | None:
    """Return a proof that the answer's condition has no solution; None where none exists.

    Of a ``Design``: no gains by this relaxation, with these numbers.

    Returns
    -------
    None for a candidate, for an answer without a condition, and if the multipliers could not be
    made exact. That happens if a condition has a solution only just, or if the multipliers are
    unique and irrational. None does not show that a solution exists.
    """
    checked_answer = answer.answer if isinstance(answer, Design) else answer
    if checked_answer.status == "candidate" or checked_answer.condition is None:
        return None
    return exact_no(checked_answer.condition, checked_answer.multipliers)


def exact_no(
    condition: StatedCondition,
    multipliers: Mapping[str, Floats] | None = None,
    *,
    parameters: Mapping[str, Fraction] | None = None,
) -> Alternative | None:
    """Return exact multipliers that rule out every solution; None where none were found.

    Parameters
    ----------
    condition : LMIs with a weight are strict, the others may be touched.
    multipliers : LMI -> (items, size, size) in floating point, to begin with; LMIs that are left
        out have zeros.
    parameters : exact values; None takes the condition's own, as the dyadics they store.

    Returns
    -------
    An ``Alternative`` that has been checked.  The solver is called when the given multipliers do
    not do.

    Raises
    ------
    ModelError : a multiplier of an LMI that is not there, or of another shape; an entry of the
        condition that is not a finite number.
    """
    condition = condition_of(condition, "exact_no")
    numbers: dict[str, Any] = {**condition.parameters, **(parameters or {})}
    exact = replace(condition, parameters=numbers)
    read = adjoint(exact)
    if not read.columns:
        # A condition without LMIs always has a solution.
        return None
    face = open_face(read)
    if not face.columns:
        return None
    z = multiplier_entries(read, multipliers or {}).astype(np.float64)
    begin = [z] if multipliers and np.isfinite(z).all() else []
    floats = {name: float(value) for name, value in exact.parameters.items()}
    for z in chain(begin, _interior(face, exact.with_parameters(**floats))):
        alternative = _checked(face, z)
        if alternative is not None:
            return alternative
    function = function_that_decays(read)
    return None if function is None else Alternative(condition=exact, function=function)


def _checked(face: Face, z: Floats) -> Alternative | None:
    """Return exact multipliers next to z, where they exist and rule every solution out."""
    largest = np.abs(z).max(initial=0.0)
    if largest == 0.0:
        return None
    # Multipliers may be scaled by any positive factor; entries of order one are rounded best.
    s = face.drop(z / largest)
    z = face.lift(s)
    # Singular multipliers are definite on a smaller face, and only definite ones can be rounded.
    smaller = ((smaller_face, smaller_face.drop(z)) for smaller_face in faces_near(face, z))
    for smaller_face, entries in chain([(face, s)], smaller):
        alternative = _on_face(smaller_face, entries)
        if alternative is not None:
            return alternative
    return None


def _on_face(face: Face, s: Floats) -> Alternative | None:
    exact = exact_near(face, s, _sizes(face, s)) if face.columns else None
    if exact is None:
        return None
    z = face.lift(exact)
    multipliers: dict[str, Array] = {}
    for block in face.read.blocks:
        lmi = face.read.condition.lmis[block.lmi]
        shape = (lmi.count, lmi.size, lmi.size)
        members = multipliers.setdefault(lmi.name, np.full(shape, Fraction(0), dtype=object))
        members[block.item] = z[block.index]
    alternative = Alternative(condition=face.read.condition, multipliers=multipliers)
    return alternative if alternative.holds else None


def _sizes(face: Face, s: Floats) -> Floats:
    """Return how far each entry may be moved: the distance of its multiplier from singular."""
    size = np.full(len(s), 1e-12)
    for block, U in enumerate(face.bases):
        if U.shape[1]:
            values = np.linalg.eigvalsh(face.member(block, s))
            positive_values = values[values > 1e-14]
            start = face.starts[block]
            size[start : start + triangle(U.shape[1])] = (
                positive_values[0] if len(positive_values) else 1e-12
            )
    return size


def _interior(face: Face, condition: Condition) -> Iterator[Floats]:
    """Yield multipliers in floating point that are as far from singular as they can be."""
    data = assemble(condition)
    read, rows, cones = face.read, *_open_rows(face, data)
    matrix = data.matrix()[rows]
    constant, weight, inside = data.constant[rows], np.zeros(len(rows)), np.zeros(len(rows))
    open_blocks = [block for block, U in enumerate(face.bases) if U.shape[1]]
    for block, cone in zip(open_blocks, cones, strict=True):
        natural = condition.lmis[read.blocks[block].lmi].weight or 1.0
        diagonal = cone.start + np.diag(packed_places(cone.size))
        weight[diagonal], inside[diagonal] = natural, 1.0 / natural
    # Columns x, x_0, tau; the row of x_0 and the sum of traces before the cones.
    G = sp.hstack([matrix, sp.csc_array(np.column_stack([constant, weight]))], format="csc")
    head = np.zeros((2, G.shape[1]))
    head[0, -2] = 1.0
    head[1] = inside @ G
    room = ROOM * float(np.abs(constant).max()) * float(inside.max())
    if room > 0:
        head[0, -1] = 1.0 / room
        head[1] += room * head[0]
    program = ConeProgram(
        np.eye(G.shape[1])[-1],
        sp.csc_array(-sp.vstack([sp.csc_array(head), G], format="csc")),
        np.concatenate([[0.0, -1.0], np.zeros(len(rows))]),
        2,
        cones,
    )
    for raw, _ in zip(attempts(program), range(TRIES), strict=False):
        if len(raw.z) == len(program.b) and np.isfinite(raw.z).all():
            packed = raw.z[2:] + max(raw.z[1], 0.0) * inside
            yield face.lift(np.concatenate([_plain(packed, cone) for cone in cones]))


def _open_rows(face: Face, data: Assembled) -> tuple[Indices, tuple[Cone, ...]]:
    """Return the rows of the cone data on a face of coordinates, and their cones."""
    rows, cones, start = [], [], 0
    for block, U in zip(face.read.blocks, face.bases, strict=True):
        if not U.shape[1]:
            continue
        open_entries = np.flatnonzero(U.any(axis=1))
        high, low = np.tril_indices(len(open_entries))
        block_rows = data.cones[block.lmi].start + block.item * triangle(block.size)
        rows.append(block_rows + packed_places(block.size)[open_entries[low], open_entries[high]])
        cones.append(Cone(len(open_entries), 1, start))
        start += triangle(len(open_entries))
    return np.concatenate(rows), tuple(cones)


def _plain(packed: Floats, cone: Cone) -> Floats:
    """Return the upper triangle, column by column, without the factors sqrt(2)."""
    high, low = np.tril_indices(cone.size)
    return np.asarray(unpack(packed[cone.rows], cone.size)[0][low, high])


def objective_below(asked: Condition | Answer | Design, value: float | Fraction) -> Condition:
    """Return the condition with its objective < value as one more LMI, and no objective.

    If ``exact_no`` proves that it has no solution, the least objective of the condition is at least
    the value. This is a rigorous lower bound on the cost or the norm that this condition can show.

    Parameters
    ----------
    asked : an answer or a design that minimised something: the value is its gain or its cost, in
        the units of the model, y over w or that of the weights.  Or a condition: the value is its
        objective as it is posed, without any units.
    value : of an answer converted to the units in which its condition is posed, by a product in
        floating point; what is proved is about the condition that is returned.

    Raises
    ------
    ModelError : a condition without an objective, an answer that minimised nothing, or a value that
        is no finite number, or that no objective has.
    """
    value = number("value", value)
    if isinstance(asked, Design):
        asked = asked.answer
    if isinstance(asked, Answer):
        unit = asked.objective_unit
        if asked.condition is None or unit is None or not asked.condition.objective:
            raise ModelError(
                f"this answer ({asked.status}) minimised no gain and no cost in a condition, so "
                "there is no least value to bound; give one of hinf_norm, h2_norm, hinf_pdc, "
                "h2_pdc, peak_pdc or lqr_pdc, or a condition with an objective"
            )
        posed = _below(asked.condition, unit.objective(float(value)))
        return replace(posed, name=f"{asked.condition.name}, {unit.quantity} below {value:.6g}")
    return _below(asked, value)


def _below(condition: Condition, value: float | Fraction) -> Condition:
    """Return the condition with its objective, as it is posed, below a value."""
    if not condition.objective:
        raise ModelError(
            f"{condition.name} has no objective, and so no least value to bound; give a condition "
            "that minimises something, or ask exact_no about this one as it is"
        )
    by_name = {unknown.name: unknown for unknown in condition.unknowns}
    costs = (_cost(by_name[name], cost) for name, cost in condition.objective.items())
    below = sum(costs, start=expression_of(np.array([[-value]]))) << 0
    limit = lmi_of(below.named("objective", weight=abs(float(value)) or 1.0))
    return replace(
        condition,
        name=f"{condition.name}, objective below {float(value):.6g}",
        lmis=(*condition.lmis, limit),
        objective={},
    )


def _cost(unknown: Unknown, cost: Array) -> Expression:
    """Return the sum of entrywise products, column by column: c_j' X e_j."""
    members = np.repeat(np.arange(unknown.count), unknown.cols)
    c = matrix(cost.transpose(0, 2, 1).reshape(-1, 1, unknown.rows), r"c_j^\top")
    e = matrix(np.tile(np.eye(unknown.cols)[:, :, None], (unknown.count, 1, 1)), "e_j")
    return added(c @ unknown.members(members, unknown.symbol) @ e, latex=r"\sum_j")
