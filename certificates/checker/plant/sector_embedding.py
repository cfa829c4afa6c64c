r"""Claims of kind ``sector-embedding``: the plant is the blend of the certificate's vertices.

    M(x) x' = f(x, u, w)  and  y = g(x, u)  on the box  imply
    dx' = sum_i h_i (A_i dx + B_i du + E_i dw),   dy = sum_i h_i (C_i dx + D_i du),

where h_i are the products of the premises' weights.  The proof uses the equations in the file,
their trim, and the entries A(z), B(z), ... of the embedding.  It has five steps:

1. Every part of the equations, of M and of the premises is defined on the box: no denominator
   vanishes, the arguments of roots, logarithms and tables stay in their domains, and det M has no
   zero.
2. M(x) [A(z(x)) dx + B(z(x)) du + E(z(x)) dw] = f(x, u, w) (in discrete time f - M x*), row by
   row, as quotients of polynomials in the functions that occur in them.
3. lower <= z_k(x) <= upper on the box, by outward-rounded intervals and bisection.
4. Each entry is a polynomial of degree at most one in each premise.  Step 2 uses this polynomial.
5. So A(z) is the blend of the vertices A_i, which the checker computes at the bounds' corners.

Entries may have ``numbers`` c that are no fractions, as pi or a rest that was solved for.  Step 3
bounds these too.  They are constant: the plant is one blend A(z, c), of degree one in each c.  An
inequality whose left side is affine, or concave, in the vertices holds for the c of the plant if it
holds at all ends of their bounds, which a claim about the loop is tried at.

If the plant has numbers that are not decimals (``balls``), these are proved first.  Step 2 then
uses f minus its value at rest instead of f; ``balls`` proves that this value is 0.

A signal marked ``unknown`` is an uncertain parameter: steps 1 to 3 hold for every value in its
range.  Its column of E is 0, and rules that differ only in premises with it have equal gains
(``check_known``), so the claims about the loop hold for every value, constant or moving.

Step 1 has one exception: a variable x_j whose range contains 0 and that divides, as in sin(x)/x, or
a sum of multiples of variables in its place, as in sin(x + y)/(x + y) (``linear_sum``).  Where it
vanishes, the premise is defined by its limit; step 3 proves that the limit exists (Taylor's
formula, see ``quotient_form``).  The identity of step 2 holds where it is not 0, which is dense in
the box; both sides are continuous, so that it holds on the whole box.  An equation with such a
quotient is also defined by its limit there.

A second exception is |v|/v or v/|v| of a state v that rests at 0, which is sign(v) except at v = 0.
A premise with it jumps there.  It is bounded on both sides, with sign(v) anywhere in [-1, 1], and
is an entry in the column of v alone.  So A(z) dx is continuous across v = 0, where the entry is
multiplied by 0 and any value in the bounds gives the equation, also the one that the law computes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any, ClassVar, TypeAlias

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kernel.reader import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.loop.polytopic_loop import SECANTS, PolytopicLoop
from takagi.certificates.checker.loop.product_weights import weights_of
from takagi.certificates.checker.loop.stated_matrices import closed_by
from takagi.certificates.checker.plant.balls import prove_balls, relations, residuals
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import Enclosure, PlantClaim
from takagi.certificates.checker.plant.quotient_form import jumps, with_signs
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, Premise, Rows, read_plant
from takagi.certificates.checker.plant.trim import compared_trim
from takagi.certificates.checker.plant.vertices import (
    MultiAffine,
    corners_of,
    entry_node,
    multi_affine_entries,
    vertex_stack,
)
from takagi.certificates.checker.words.embedding import embedding_in_words

MOST_MINORS = 4_000
Entries: TypeAlias = list[list[MultiAffine]]


def plant_loop(model: Any, where: str = "model") -> PolytopicLoop:
    """Return the exact vertices of a model of kind ``plant``, from its entries and bounds.

    The rules are the corners of the premises; the last premise changes first, and a premise with
    equal bounds has one corner.  The claim ``sector-embedding`` says that the plant is their blend.
    Numbers are at the ends of their bounds: ``at_other_ends`` has the loops beside the first.

    Raises
    ------
    CertificateError : the model is malformed, or an entry is not multi-affine.
    """
    plant = read_plant(model, where)
    entries = multi_affine_entries(plant)
    corners = corners_of(plant.premises)
    stacks: list[dict[str, Any]] = [
        {
            letter: tuple(Matrix.of(rows) for rows in vertex_stack(matrix, corners, ends))
            for letter, matrix in entries.items()
        }
        for ends in corners_of(plant.numbers)
    ]
    for stack in stacks[1:]:
        _require_same_signs(stacks[0], stack, where)
    loop = _loop(plant, model, corners, stacks[0])
    return replace(loop, at_other_ends=tuple(replace(loop, **matrices) for matrices in stacks[1:]))


def _require_same_signs(first: dict[str, Any], at_other_end: dict[str, Any], where: str) -> None:
    """Refuse numbers whose bounds give an entry different signs, or 0 at one end only.

    Entries that are 0 or 1 say what a disturbance reaches and which states an output shows.  This
    has to hold for all values between the ends.  An entry is of degree one in each number: if it
    has one sign at all ends, it has this sign between them.
    """
    for letter, matrices in first.items():
        shows = letter in "CD"
        for here, there in zip(matrices, at_other_end[letter], strict=True):
            for index in product(*map(range, here.shape)):
                a, b = here[index], there[index]
                if (a == 0) != (b == 0) or (shows and (a * b < 0 or (a == 1) != (b == 1))):
                    raise CertificateError(
                        f"{where}.embedding.numbers: an entry of {letter} is {a} at one end of "
                        f"their bounds and {b} at another; let it be a premise"
                    )


def _loop(
    plant: PlantNodes,
    model: Any,
    corners: list[dict[str, tuple[int, Fraction]]],
    stacks: dict[str, Any],
) -> PolytopicLoop:
    numbers = tuple(tuple(pick for pick, _ in corner.values()) for corner in corners)
    outer_variables = (*plant.inputs, *plant.disturbances)
    return PolytopicLoop(
        **stacks,
        sample_time=plant.sample_time,
        states=tuple(v.label for v in plant.states),
        inputs=tuple(v.label for v in plant.inputs),
        disturbances=tuple(v.label for v in plant.disturbances),
        box=tuple(v.side for v in plant.states),
        other_box={v.label: v.side for v in outer_variables if v.side is not None},
        corners=numbers,
        weights=_weights(plant, model, numbers),
        scheduled_by=_scheduling(plant),
        # Counted here: a claim may put aside the only matrices that differ between the rules.
        stated_rules=max(map(len, stacks.values())),
        resting_elsewhere=_resting_elsewhere(plant),
    )


def _resting_elsewhere(plant: PlantNodes) -> str:
    """Return the letters of x, u, w, y whose equilibrium value is not known to be 0."""
    g = plant.graph
    groups = {"x": plant.states, "u": plant.inputs, "w": plant.disturbances}
    letters = "".join(a for a, group in groups.items() if any(g.value(v.rest) != 0 for v in group))
    try:
        at_rest = [g.value(plant.at_rest(node)) for node in plant.outputs]
    except CertificateError:  # 0/0 there; the limit is not needed
        at_rest = [None]
    return letters + ("y" if any(value != 0 for value in at_rest) else "")


def _weights(plant: PlantNodes, model: Any, corners: tuple[tuple[int, ...], ...]) -> str:
    """Return a text that defines the weights; no law can evaluate those of a secant model."""
    if plant.form == "secant":
        return SECANTS
    return weights_of(model["embedding"]["premises"], corners)


def _scheduling(plant: PlantNodes) -> tuple[str, ...]:
    """Return the labels of the variables in premises that are not constant."""
    varying = [premise.node for premise in plant.premises if premise.lower < premise.upper]
    scheduling_symbols = set().union(*(plant.graph.variables(node) for node in varying))
    return tuple(v.label for v in plant.variables if v.symbol in scheduling_symbols)


@dataclass(frozen=True)
class SectorEmbedding(PlantClaim):
    """The plant is the blend of its vertices on the box; see the module."""

    form: ClassVar[str] = "sector"

    def obligations(self) -> Obligations:
        plant, model, gains = self.plant, self.model, self.gains
        entries = multi_affine_entries(plant)
        compared_trim(plant, gains)
        check_unknown(plant, model, gains)
        if isinstance(gains, dict) and "references" in gains:
            # Imported here: most laws follow no reference.
            from takagi.certificates.checker.plant.references import check_followed

            check_followed(model, plant, gains, Algebra(plant.graph, plant.tables))
        ranges = _proved(plant, entries)
        yield from premises_in_bounds((*plant.premises, *plant.numbers), ranges)
        self.removable.update(ranges.removable)

    def sentence(self) -> str:
        off = compared_trim(self.plant, self.gains)
        return embedding_in_words(self.plant, self.removable, off)


def premises_in_bounds(premises: Sequence[Premise], ranges: Ranges) -> Obligations:
    """Yield the bounds of every premise on the box."""
    for premise in premises:
        subject = f"premise {premise.name}"
        yield Enclosure(ranges, premise.node, premise.lower, premise.upper, subject)


def check_unknown(plant: PlantNodes, model: Any, gains: Any) -> None:
    """Refuse an unknown signal with a column of E that is not 0, and gains that depend on one.

    With a column of 0 the rest does not move with the signal, and a claim without disturbance
    holds for all its values, however it changes.
    """
    symbols = set()
    for column, signal in enumerate(plant.disturbances):
        if not signal.unknown:
            continue
        symbols.add(signal.symbol)
        if any(plant.graph.value(row[column]) != 0 for row in plant.entries.get("E", [])):
            raise Refused(f"{signal.name} moves the state as a disturbance does, not in A or B")
    if symbols and gains is not None:
        unknown_signal = "an uncertain parameter"
        check_known(plant, plant_loop(model), symbols, gains, unknown_signal)


def check_known(
    plant: PlantNodes, loop: PolytopicLoop, unknown: Collection[str], gains: Any, subject: str
) -> None:
    """Refuse gains that depend on signals which the law does not know.

    If a premise depends on one, the law cannot compute its weights; so rules that differ only in
    such premises need equal gains.  Then the unknown weights cancel: sum_i h_i K_i is a sum over
    the corners of the other premises only.

    Parameters
    ----------
    loop : the vertices of the plant's model, without gains.
    unknown : symbols of these signals.
    subject : what these signals are, in words, such as ``"an error of an actuator"``.

    Raises
    ------
    Refused : rules that differ only in premises with such a signal have different gains, or the
        gains of several rules have other weights than the model's.
    CertificateError : another number of gains than of rules.
    """
    K = read_stack(gains, "K", "gains")
    if len(K) == 1:
        return
    known_premises = [
        k for k, p in enumerate(plant.premises) if not set(unknown) & plant.graph.variables(p.node)
    ]
    corners = list(corners_of(plant.premises))
    if len(corners) != len(K):
        raise CertificateError(f"gains.K: {len(corners)} gains are needed")
    first: dict[tuple[int, ...], int] = {}
    for i, corner in enumerate(corners):
        picks = [pick for pick, _ in corner.values()]
        j = first.setdefault(tuple(picks[k] for k in known_premises), i)
        # Equal gains are read as equal rows over one denominator.
        if K[i] != K[j]:
            raise Refused(
                f"gains {j + 1} and {i + 1} differ, and the rules differ only in {subject}, which "
                "the law does not know"
            )
    if not closed_by(loop, gains, "gains").shared_weights:
        raise Refused("the law's gains go by other weights than the model's rules")


def _proved(plant: PlantNodes, entries: Mapping[str, Entries]) -> Ranges:
    """Return the ranges used in the proof; Refused names the step that could not be proved."""
    algebra = Algebra(plant.graph, plant.tables)
    ranges = Ranges(plant.evaluator, algebra, plant.box, signs=True)
    _check_jumps(plant, entries)
    if plant.balls:
        prove_balls(plant, algebra, ranges)
    for state, node in zip(plant.states, plant.f, strict=True):
        ranges.prove_continuous(node, f"the equation of {state.name}")
    for k, node in enumerate(plant.outputs):
        ranges.prove_continuous(node, f"output {k + 1}")
    if plant.mass is not None:
        for entry in {node for row in plant.mass for node in row}:
            ranges.prove_defined(entry, "the mass matrix")
        determinant = _determinant(plant, plant.mass)
        ranges.prove_nonzero(determinant, "the determinant of the mass matrix")
    _check_identities(plant, algebra, entries)
    return ranges


def _check_jumps(plant: PlantNodes, entries: Mapping[str, Entries]) -> None:
    """Refuse a premise that jumps at v = 0, as |v|/v, in another column than that of the state v.

    In that column it is multiplied by 0 there.
    """
    for premise in plant.premises:
        jumping = jumps(plant.graph, with_signs(plant.graph, premise.node))
        if not jumping:
            continue
        for letter, rows in entries.items():
            for row in rows:
                for column, entry in enumerate(row):
                    carried = letter in "AC" and jumping == {plant.states[column].symbol}
                    if not carried and any(premise.name in members for members in entry):
                        at = ", ".join(sorted(jumping - {""})) or "a zero"
                        raise Refused(
                            f"premise {premise.name} jumps at {at} = 0 and stands in {letter}, in "
                            "a column of another variable"
                        )


def _check_identities(plant: PlantNodes, algebra: Algebra, entries: Mapping[str, Entries]) -> None:
    g = plant.graph
    premise_nodes = {p.name: p.node for p in (*plant.premises, *plant.numbers)}
    rates = [g.constant(0)] * len(plant.states)
    output_sums = [g.constant(0)] * len(plant.outputs)
    for letter, rows in entries.items():
        columns = {"B": plant.inputs, "D": plant.inputs, "E": plant.disturbances}.get(
            letter, plant.states
        )
        totals = output_sums if letter in "CD" else rates
        for i, row in enumerate(rows):
            for entry, variable in zip(row, columns, strict=True):
                term = g.multiply(entry_node(g, entry, premise_nodes), g.variable(variable.symbol))
                totals[i] = g.add(totals[i], term)
    if plant.sample_time is not None:
        rates = [g.add(v.rest, rate) for v, rate in zip(plant.states, rates, strict=True)]
    rates, equations = plant.times_mass(rates), plant.f
    if plant.balls:
        pairs = zip(equations, residuals(plant), strict=True)
        equations = [g.subtract(node, residual) for node, residual in pairs]
    solved: dict[str, int] | None = None
    for state, rate, node in zip(plant.states, rates, equations, strict=True):
        if algebra.equal(rate, node):
            continue
        # What the equations at rest say of the rests that were solved for is put in.
        solved = relations(plant, algebra) if solved is None else solved
        if not algebra.equal(substituted(g, rate, solved), substituted(g, node, solved)):
            raise Refused(f"the entries do not give the equation of {state.name}")
    for k, (output_sum, node) in enumerate(zip(output_sums, plant.outputs, strict=True)):
        if not algebra.equal(output_sum, g.subtract(node, plant.at_rest(node))):
            raise Refused(f"the entries do not give output {k + 1}")


def _determinant(plant: PlantNodes, mass: Rows) -> int:
    """Return det M by Laplace's expansion, row by row; a minor is computed once for its columns."""
    g, size = plant.graph, len(mass)
    zero = g.constant(0)
    minors: dict[frozenset[int], int] = {frozenset(): g.constant(1)}
    for row in mass:
        larger: dict[frozenset[int], int] = {}
        for columns, minor in minors.items():
            for j, entry in enumerate(row):
                if j in columns or entry == zero or minor == zero:
                    continue
                # Expanded along the last row: the sign counts the columns to the right of j.
                odd = sum(column > j for column in columns) % 2
                term = g.multiply(g.negative(entry) if odd else entry, minor)
                key = columns | {j}
                larger[key] = g.add(larger.get(key, zero), term)
        if len(larger) > MOST_MINORS:
            raise Refused("a mass matrix with too many minors")
        minors = larger
    return minors.get(frozenset(range(size)), zero)
