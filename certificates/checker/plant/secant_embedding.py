r"""Claims of kind ``secant-embedding``: deviations from equilibrium are blends of the vertices.

For x' = f(x, u, w), continuously differentiable on a box that contains the rest x*, u*, w*,

    f(x, u, w) - f(x*, u*, w*) = (\int_0^1 Df(x* + s (x - x*), ...) ds) (x - x*, u - u*, w - w*).

If the entries of Df are affine in the premises z, the integral has the entries at the mean of z
along the segment, and this mean keeps the bounds of z.  So the loop lies in the convex hull of the
vertices, with weights that are not a function of the present state.  A law cannot evaluate these
weights: gains that differ between rules are treated as gains with their own weights.  The checker
proves:

1. f and its derivatives are defined on the box, without |.|, and f vanishes at the equilibrium.
2. Df = (A(z(x)), B(z(x)), E(z(x))), entry by entry as in ``sector_embedding``; outputs likewise.
3. lower <= z_k <= upper on the box; every entry is affine in the premises.

Signals p marked ``unknown`` (uncertain parameters) may have columns of 0 in E where f(x*, u*, p)
does not move with them, the other signals at rest.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 4.3, global linearization (recalled).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kernel.reader import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.balls import prove_balls
from takagi.certificates.checker.plant.derivative import derivative, substituted
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import PlantClaim
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, Variable
from takagi.certificates.checker.plant.sector_embedding import Entries, premises_in_bounds
from takagi.certificates.checker.plant.trim import compared_trim
from takagi.certificates.checker.plant.vertices import entry_node, multi_affine_entries
from takagi.certificates.checker.words.embedding import embedding_in_words


@dataclass(frozen=True)
class SecantEmbedding(PlantClaim):
    """Deviations from the equilibrium are blends of the vertices; see the module."""

    form: ClassVar[str] = "secant"

    def obligations(self) -> Obligations:
        plant, gains = self.plant, self.gains
        if plant.mass is not None:
            raise CertificateError(
                f"{self.where}: a secant embedding is of x' = f, without a mass matrix"
            )
        entries = multi_affine_entries(plant)
        compared_trim(plant, gains)
        if gains is not None and any(v.unknown for v in plant.disturbances):
            _check_one_gain(gains)
        yield from secants(plant, entries, self.removable)
        if isinstance(gains, dict) and "references" in gains:
            # Imported here: most laws follow no reference.
            from takagi.certificates.checker.plant.references import check_followed

            check_followed(self.model, plant, gains, Algebra(plant.graph, plant.tables))

    def sentence(self) -> str:
        off = compared_trim(self.plant, self.gains)
        return embedding_in_words(self.plant, self.removable, off)


def _check_one_gain(gains: Any) -> None:
    K = read_stack(gains, "K", "gains")
    if any(matrix != K[0] for matrix in K):
        raise Refused("gains differ, and the law does not know an uncertain parameter")


def secants(
    plant: PlantNodes,
    entries: Mapping[str, Entries],
    removable: set[str],
    *,
    resting: bool = True,
) -> Obligations:
    """Yield the obligations: differences from the equilibrium are blends of the vertices.

    Parameters
    ----------
    removable : gets the variables at whose zero a quotient means its limit.
    resting : whether the point of rest has to be an equilibrium; differences between two points of
        the box are blends of the vertices without that.

    Raises
    ------
    CertificateError : an entry has a product of premises.
    Refused : a step could not be proved.
    """
    for matrix in entries.values():
        if any(len(members) > 1 for line in matrix for entry in line for members in entry):
            raise CertificateError("model: an entry has a product of premises")
    g, algebra = plant.graph, Algebra(plant.graph, plant.tables)
    ranges = Ranges(plant.evaluator, algebra, plant.box)
    discrete = plant.sample_time is not None
    if plant.balls:
        prove_balls(plant, algebra, ranges)
    at_rest = plant.f if resting and not plant.balls else []
    for state, row in zip(plant.states, at_rest, strict=bool(at_rest)):
        value = state.rest if discrete else g.constant(0)
        if not algebra.equal(plant.at_rest(row), value):
            raise Refused(f"{state.name} is not shown to be at rest at the point of rest")
    groups: list[tuple[str, list[int], list[Variable]]] = [
        ("A", plant.f, plant.states),
        ("B", plant.f, plant.inputs),
        ("E", plant.f, plant.disturbances),
        ("C", plant.outputs, plant.states),
        ("D", plant.outputs, plant.inputs),
    ]
    premise_nodes = {p.name: p.node for p in plant.premises}
    fixed_signals = _still(plant, entries)
    if fixed_signals:
        _check_still(plant, algebra, fixed_signals)
    for letter, rows, columns in groups:
        for i, row in enumerate(rows):
            for j, variable in enumerate(columns):
                if letter == "E" and j in fixed_signals:
                    continue
                slope = _slope(plant, ranges, row, variable)
                if not algebra.equal(slope, entry_node(g, entries[letter][i][j], premise_nodes)):
                    raise Refused(f"{letter}[{i}][{j}] is not the slope in {variable.name}")
    for row in plant.outputs:
        for variable in plant.disturbances:
            if not algebra.vanishes(_slope(plant, ranges, row, variable)):
                raise Refused(f"an output depends on {variable.name}")
    yield from premises_in_bounds(plant.premises, ranges)
    removable |= ranges.removable


def _still(plant: PlantNodes, entries: Mapping[str, Entries]) -> list[int]:
    """Return the places of the unknown signals with a column of 0 in E."""
    rows = entries.get("E", [])
    unknown = [k for k, v in enumerate(plant.disturbances) if v.unknown]
    return [k for k in unknown if not any(row[k] for row in rows)]


def _check_still(plant: PlantNodes, algebra: Algebra, fixed_signals: list[int]) -> None:
    """Refuse a row whose value at rest moves with these signals, all of them together.

    Where it does not move, f(x, u, p) - f(x*, u*, p) is f(x, u, p) - f* for all p in the ranges,
    and slopes in states and inputs alone give it.
    """
    g = plant.graph
    moving = {plant.disturbances[k].symbol for k in fixed_signals}
    at_rest = {v.symbol: g.constant(0) for v in plant.variables if v.symbol not in moving}
    zero = {symbol: g.constant(0) for symbol in moving}
    for state, row in zip(plant.states, plant.f, strict=True):
        moving_row = substituted(g, row, at_rest)
        if not algebra.equal(moving_row, substituted(g, moving_row, zero)):
            raise Refused(f"{state.name} rests elsewhere with a signal whose column of E is 0")


def _slope(plant: PlantNodes, ranges: Ranges, row: int, variable: Variable) -> int:
    """Return a partial derivative after proving that it is defined on the whole box."""
    g = plant.graph
    slope = derivative(g, row, variable.symbol)
    for node in (row, slope):
        if any(_has_kink(plant, number) for number in g.below([node])):
            raise Refused("an absolute value has a kink; slopes are of smooth functions")
        ranges.prove_defined(node, f"the slope in {variable.name}")
    return slope


def _has_kink(plant: PlantNodes, number: int) -> bool:
    node = plant.graph[number]
    return node.op == "sign" or (node.op == "call" and node.name == "abs")
