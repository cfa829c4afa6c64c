"""What tests of the code's shape ask of a source file; each file is parsed and walked once."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Syntax:
    """What a file imports, defines and calls, wherever it stands in the file.

    Attributes
    ----------
    imports : (module, name) of each import; the name of ``import x`` is empty.
    relative : whether an import is relative.
    functions : (name, how many parameters a caller may give).
    calls : (line, what is called, how many arguments are given by position), of those that give
        more than one.
    classes : (name, how many fields of a data class a caller may give by position).
    """

    imports: tuple[tuple[str, str], ...]
    relative: bool
    functions: tuple[tuple[str, int], ...]
    calls: tuple[tuple[int, ast.expr, int], ...]
    classes: tuple[tuple[str, int], ...]


@cache
def syntax(path: Path) -> Syntax:
    """Return what a file imports, defines and calls."""
    imports: list[tuple[str, str]] = []
    relative = False
    functions, calls, classes = [], [], []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            imports += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            relative = relative or node.level > 0
            imports += [(node.module or "", alias.name) for alias in node.names]
        elif isinstance(node, ast.FunctionDef):
            functions.append((node.name, parameters(node)))
        elif isinstance(node, ast.Call) and len(node.args) > 1:
            calls.append((node.lineno, node.func, len(node.args)))
        elif isinstance(node, ast.ClassDef):
            classes.append((node.name, fields_by_position(node)))
    return Syntax(tuple(imports), relative, tuple(functions), tuple(calls), tuple(classes))


def parameters(function: ast.FunctionDef) -> int:
    """Return how many parameters a caller may give."""
    named = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return sum(1 for one in named if one.arg not in ("self", "cls"))


def fields_by_position(item: ast.ClassDef) -> int:
    """Return how many fields of a data class a caller may give by position."""
    decorators = " ".join(ast.unparse(one) for one in item.decorator_list)
    own_order = any(
        isinstance(one, ast.FunctionDef) and one.name == "__init__" for one in item.body
    )
    if "dataclass" not in decorators or "kw_only=True" in decorators or own_order:
        return 0
    fields = [one for one in item.body if isinstance(one, ast.AnnAssign)]
    kinds = [ast.unparse(one.annotation) for one in fields]
    last = kinds.index("KW_ONLY") if "KW_ONLY" in kinds else len(kinds)
    return sum(1 for kind in kinds[:last] if not kind.startswith("ClassVar"))
