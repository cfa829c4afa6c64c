"""What a change of one line of the checker is: which there are, and the module with one of them.

A comparison is turned or loses its equality, a sign, an operator or a constant changes, a guard is
left out, ``and`` becomes ``or``, ``min`` becomes ``max``, a transpose is dropped.  Words, types,
imports and constants of a module stay.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from itertools import islice, pairwise
from pathlib import Path
from typing import NamedTuple

TURNED: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OTHER: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.Pow: ast.Mult,
}
# A size that is compared with its limit, and the same with or without its equality.
OF_SIZE = re.compile(
    r"(<=?|>=?) ((?:\w+ (?:\*|\*\*) )?(?:MOST|LARGEST|LONGEST|DEEPEST)\w*)(?! \*)\b"
)
SWAPPED = {"min": "max", "max": "min", "all": "any", "any": "all", "at_least": "at_most"}
SWAPPED |= {"at_most": "at_least", "exp_below": "exp_above", "exp_above": "exp_below"}
SWAPPED |= {"is_positive_definite": "is_symmetric", "is_positive_semidefinite": "is_symmetric"}


class Change(NamedTuple):
    """One change of a module.

    Attributes
    ----------
    module : the file.
    owner : the outermost function or method that holds it, or "" beside all functions.
    at : its number in the module.
    line, last : the statement's lines; of a compound one, those of its head.
    what : before and after.
    of_size : whether only the count changes that is compared with a limit of size.
    """

    module: Path
    owner: str
    at: int
    line: int
    last: int
    what: str
    of_size: bool = False

    @property
    def is_of_size(self) -> bool:
        """Whether only a limit of size moves: its equality, or how is counted what it bounds.

        A limit that is turned, or left out, is none of these.
        """
        if self.of_size:
            return True
        before, after = self.what.split("  ->  ")
        found = OF_SIZE.search(before)
        if not found:
            return False
        sign = found[1].rstrip("=") if found[1].endswith("=") else f"{found[1]}="
        return f"{before[: found.start()]}{sign} {before[found.start(2) :]}" == after


def changes_of(module: Path) -> list[Change]:
    """Return every change that is known for a module, in order."""
    tree = ast.parse(module.read_text(encoding="utf-8"))
    owners, spans, counted_sizes = _owners(tree), _spans(tree), _of_size(tree)
    changes = []
    for at, (node, what) in enumerate(_sites(tree)):
        before = ast.unparse(node).splitlines()[0]
        restored = _changed(node, what)
        after = ast.unparse(node).splitlines()[0]
        restored()
        line, last = spans.get(id(node), (getattr(node, "lineno", 1),) * 2)
        words = f"{before}  ->  {after}"
        of_size = id(node) in counted_sizes
        changes.append(Change(module, owners.get(id(node), ""), at, line, last, words, of_size))
    return changes


def broken_tree(module: Path, at: int) -> ast.Module:
    """Return the module with its change number ``at``."""
    tree = ast.parse(module.read_text(encoding="utf-8"), str(module))
    node, what = next(islice(_sites(tree), at, None))
    _changed(node, what)
    return ast.fix_missing_locations(tree)


def _owners(tree: ast.Module) -> dict[int, str]:
    """Return for every node in a function's body the outermost function by its name."""
    owners: dict[int, str] = {}

    def enter(node: ast.AST, names: tuple[str, ...]) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                enter(child, (*names, child.name))
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                name = ".".join((*names, child.name))
                for statement in child.body:
                    owners.update((id(n), name) for n in ast.walk(statement))

    enter(tree, ())
    return owners


def _spans(tree: ast.Module) -> dict[int, tuple[int, int]]:
    """Return for every node the lines of its innermost statement, without a body of its own."""
    found: dict[int, tuple[int, int]] = {}
    for statement in ast.walk(tree):
        if isinstance(statement, ast.stmt):
            body = getattr(statement, "body", None)
            last = statement.end_lineno or statement.lineno
            if isinstance(body, list) and body:
                last = max(statement.lineno, body[0].lineno - 1)
            # Inner statements come later in the walk, and take their nodes over.
            found.update((id(n), (statement.lineno, last)) for n in ast.walk(statement))
    return found


def _of_size(tree: ast.Module) -> set[int]:
    """Return the nodes that only count what a limit of size bounds."""
    found: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            for one, limit in pairwise((node.left, *node.comparators)):
                if OF_SIZE.search(f"< {ast.unparse(limit)}"):
                    found.update(id(n) for part in (one, limit) for n in ast.walk(part))
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id.strip("_") == "bounded":
                found.update(id(n) for part in node.args for n in ast.walk(part))
    return found


def _sites(tree: ast.AST) -> Iterator[tuple[ast.AST, str]]:
    """Yield (node, change) in order."""
    for node in _reached(tree):
        if isinstance(node, ast.Compare):
            yield from (
                (node, f"compare {i} {j}")
                for i, op in enumerate(node.ops)
                for j in range(len(TURNED.get(type(op), ())))
            )
        elif isinstance(node, ast.BinOp) and type(node.op) in OTHER:
            yield node, "operator"
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            yield node, "order"
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
            yield node, "sign"
        elif isinstance(node, ast.BoolOp):
            yield node, "junction"
        elif isinstance(node, ast.Constant) and type(node.value) in (int, bool):
            yield node, "constant"
        elif isinstance(node, ast.If):
            yield node, "guard"
        elif isinstance(node, ast.Name) and node.id in SWAPPED and isinstance(node.ctx, ast.Load):
            yield node, "name"
        elif isinstance(node, ast.Attribute) and (node.attr == "T" or node.attr in SWAPPED):
            yield node, "attribute"


def _reached(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that decide something: no annotations, no words, no limits of size.

    Nor ``strict=True`` of a ``zip``: the lengths of a file's lists are compared where it is read,
    so that it only guards the program against itself.  Nor to how many digits a number is shown.
    """
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        if isinstance(node, ast.Raise) or isinstance(value, ast.JoinedStr):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, (ast.JoinedStr, ast.Raise, ast.Import, ast.ImportFrom)):
                continue
            if isinstance(child, ast.Assign) and isinstance(node, ast.Module):
                continue
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("at_least", "at_most"):
                if child is not node.func and child is not node.args[0]:
                    continue
            if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
                continue
            if isinstance(child, ast.AST):
                yield child
                yield from _reached(child)


def _changed(node: ast.AST, what: str) -> Callable[[], None]:
    """Make one change of a node; return what takes it back."""
    before = {name: getattr(node, name) for name in node._fields}
    before = {n: list(v) if isinstance(v, list) else v for n, v in before.items()}
    _change(node, what)

    def restore() -> None:
        for name, value in before.items():
            setattr(node, name, value)

    return restore


def _change(node: ast.AST, what: str) -> None:
    if isinstance(node, ast.Compare):
        i, j = (int(word) for word in what.split()[1:])
        node.ops[i] = TURNED[type(node.ops[i])][j]()
    elif isinstance(node, ast.BinOp):
        if what == "order":
            node.left, node.right = node.right, node.left
        else:
            node.op = OTHER[type(node.op)]()
    elif isinstance(node, ast.UnaryOp):
        # Twice is never: matrices have no unary plus.
        node.operand = ast.UnaryOp(type(node.op)(), node.operand)
    elif isinstance(node, ast.BoolOp):
        node.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    elif isinstance(node, ast.Constant):
        node.value = not node.value if isinstance(node.value, bool) else int(str(node.value)) + 1
    elif isinstance(node, ast.If):
        node.test = ast.Constant(False)
    elif isinstance(node, ast.Name):
        node.id = SWAPPED[node.id]
    elif isinstance(node, ast.Attribute):
        if node.attr == "T":
            node.value = ast.Attribute(node.value, "T", ast.Load())
        else:
            node.attr = SWAPPED[node.attr]
