"""Write a condition in cvxpy, to solve it a second time or to add further constraints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from takagi.lmi.condition.statements import StatedCondition, condition_of
from takagi.lmi.condition.term import LMI, Array, Term
from takagi.lmi.condition.unknown import Unknown


@dataclass(frozen=True, slots=True, eq=False)
class Expressed:
    """A condition as cvxpy objects.

    Attributes
    ----------
    variables : unknown name -> one cvxpy variable per member.
    margin : the cvxpy variable t, or the number it was fixed to.
    expressions : LMI name -> sign F_k, one cvxpy expression per item.
    constraints : sign F_k >> t weight I, then E_k == 0 of every equality.
    objective : to be minimised; -t when the margin is free.
    """

    variables: Mapping[str, tuple[Any, ...]]
    margin: Any
    expressions: Mapping[str, tuple[Any, ...]]
    constraints: tuple[Any, ...]
    objective: Any

    def problem(self, *constraints: Any) -> Any:
        """Return the cvxpy problem with further constraints."""
        cp: Any = import_module("cvxpy")

        return cp.Problem(cp.Minimize(self.objective), [*self.constraints, *constraints])

    def values(self) -> dict[str, Array]:
        """Return unknown name -> (count, rows, cols) after the problem was solved."""
        return {
            name: np.stack([np.atleast_2d(member.value) for member in members])
            for name, members in self.variables.items()
        }


def expressed(condition: StatedCondition, *, margin: float | None = None) -> Expressed:
    """Return the condition in cvxpy.  Nothing is solved.

    ``margin`` : None asks for the largest t <= 1; a number fixes t and minimises the objective.
    """
    condition = condition_of(condition, "expressed")
    cp: Any = import_module("cvxpy")

    variables = {unknown.name: _variables(unknown) for unknown in condition.unknowns}
    t = cp.Variable(name="t") if margin is None else margin
    expressions, constraints = {}, [] if margin is not None else [t <= 1]
    for lmi in condition.lmis:
        matrices = _expressions(lmi, variables, condition.parameters)
        expressions[lmi.name] = tuple(matrices)
        for F in matrices:
            # Symmetrised here, because cvxpy would constrain the symmetric part without a warning.
            constraints.append((F + F.T) / 2 - t * lmi.weight * np.eye(lmi.size) >> 0)
    for equality in condition.equalities:
        p = equality.shape[0]
        for framed in _expressions(equality.frame(), variables, {}):
            constraints.append(framed[:p, p:] == 0)
    if margin is None:
        objective: Any = -t
    else:
        objective = cp.Constant(0)
        for name, cost in condition.objective.items():
            for member, weight in zip(variables[name], cost, strict=True):
                objective = objective + cp.sum(cp.multiply(weight, member))
    return Expressed(variables, t, expressions, tuple(constraints), objective)


def _variables(unknown: Unknown) -> tuple[Any, ...]:
    cp: Any = import_module("cvxpy")

    names = (
        [unknown.name]
        if unknown.count == 1
        else [f"{unknown.name}{k + 1}" for k in range(unknown.count)]
    )
    shape = (unknown.rows, unknown.cols)
    symmetric = unknown.symmetric and unknown.rows > 1
    return tuple(cp.Variable(shape, name=name, symmetric=symmetric) for name in names)


def _expressions(
    lmi: LMI, variables: Mapping[str, tuple[Any, ...]], parameters: Mapping[str, float]
) -> list[Any]:
    cp: Any = import_module("cvxpy")

    blocks = [
        [[cp.Constant(np.zeros((p, q))) for q in lmi.blocks] for p in lmi.blocks]
        for _ in range(lmi.count)
    ]
    summands: list[list[Any]] = [[] for _ in range(lmi.count)]
    for constant in lmi.constants:
        value = np.broadcast_to(constant.value, (lmi.count, *constant.shape)).astype(float)
        for k in range(lmi.count):
            if constant.at is None:
                summands[k].append(cp.Constant(value[k]))
            else:
                _add(blocks[k], *constant.at, cp.Constant(value[k]))
    for term in lmi.terms:
        for item, block in _contributions(term, lmi.count, variables, parameters):
            if term.at is None:
                summands[item].append(block)
            else:
                _add(blocks[item], *term.at, block)
    return [
        lmi.sign * sum(added, cp.bmat(block)) for block, added in zip(blocks, summands, strict=True)
    ]


def _add(blocks: list[list[Any]], row: int, column: int, value: Any) -> None:
    blocks[row][column] = blocks[row][column] + value
    if row != column:
        blocks[column][row] = blocks[column][row] + value.T


def _contributions(
    term: Term,
    count: int,
    variables: Mapping[str, tuple[Any, ...]],
    parameters: Mapping[str, float],
) -> list[tuple[int, Any]]:
    spread = term.spread(count)
    factor = 1.0 if term.parameter is None else float(parameters[term.parameter])
    left = np.asarray(spread.left, dtype=np.float64) * factor
    right = None if spread.right is None else np.asarray(spread.right, dtype=np.float64)
    blocks = []
    for t, (item, member) in enumerate(zip(spread.item, spread.member, strict=True)):
        X = variables[term.unknown.name][member]
        block = X[0, 0] * left[t] if right is None else left[t] @ X @ right[t]
        blocks.append((int(item), block + block.T if term.plus_transpose else block))
    return blocks
