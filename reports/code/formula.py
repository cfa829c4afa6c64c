"""A formula of a gain file's program as a tree, which every target writes in its own language."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from decimal import Decimal
from typing import TypeAlias

from takagi.models.errors import ModelError

# Function -> (least, most) number of its arguments; None means any number.
FUNCTIONS: dict[str, tuple[int, int | None]] = {
    **dict.fromkeys(
        ("abs", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan",
         "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "first", "last"),
        (1, 1),
    ),
    "min": (2, 2), "max": (2, 2), "limit": (3, 3), "choose": (3, 3),
    "line": (3, 3), "slope": (3, 3), "hold": (3, 3), "spline": (2, 3), "mix": (2, None),
}  # fmt: skip

OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "^",
}


@dataclass(frozen=True, slots=True)
class Number:
    """A number as it is written in the file."""

    value: Decimal


@dataclass(frozen=True, slots=True)
class Name:
    """The name of a constant, a kept value, a signal or a step's result; or ``pi``."""

    name: str


@dataclass(frozen=True, slots=True)
class Operation:
    """``left sign right`` with one of + - * / ^; -x has the sign - and None as ``left``."""

    sign: str
    left: Formula | None
    right: Formula


@dataclass(frozen=True, slots=True)
class Call:
    """A function of ``FUNCTIONS`` and its arguments."""

    function: str
    arguments: tuple[Formula, ...]


Formula: TypeAlias = Number | Name | Operation | Call


def parsed(text: str, tables: Collection[str] = ()) -> Formula:
    """Return the tree of a formula in the language of gain files.

    Operators have the precedence of Python, with ^ for a power: -x^2 is -(x^2), 2^3^2 is 2^(3^2).

    Parameters
    ----------
    tables : names that plant files call as functions: ``name(x)`` is ``spline(x, name)``.

    Raises
    ------
    ModelError : the text has a part that the language does not have.
    """
    try:
        tree = ast.parse(text.replace("^", "**").strip(), mode="eval").body
        if tables:
            tree = _Tables(tables).visit(tree)
        return _formula(tree, text)
    except (SyntaxError, RecursionError, MemoryError) as error:
        raise ModelError(f"formula {text!r} cannot be read; see `language` in the file") from error


class _Tables(ast.NodeTransformer):
    def __init__(self, tables: Collection[str]) -> None:
        self.tables = tables

    def visit_Call(self, node: ast.Call) -> ast.Call:
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id in self.tables:
            spline = ast.Name("spline", ast.Load())
            return ast.Call(spline, [*node.args, ast.Name(node.func.id, ast.Load())], node.keywords)
        return node


def names_of(formula: Formula) -> Iterator[str]:
    """Yield the names in a formula, from left to right, without those of functions and pi."""
    match formula:
        case Name(name):
            if name != "pi":
                yield name
        case Operation(_, left, right):
            if left is not None:
                yield from names_of(left)
            yield from names_of(right)
        case Call(_, arguments):
            for argument in arguments:
                yield from names_of(argument)


def _formula(tree: ast.expr, text: str) -> Formula:
    match tree:
        case ast.Constant(value=int() | float()):
            # The decimals as they are written, not those of the nearest float.
            written = ast.get_source_segment(text.replace("^", "**").strip(), tree)
            return Number(Decimal(str(written).replace("_", "")))
        case ast.Name(id=name):
            return Name(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return Operation("-", None, _formula(operand, text))
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _formula(operand, text)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in OPERATORS:
            sign = OPERATORS[type(operator)]
            return Operation(sign, _formula(left, text), _formula(right, text))
        case ast.Call(func=ast.Name(id=function), args=arguments, keywords=[]):
            return _call(function, tuple(_formula(one, text) for one in arguments), text)
    raise ModelError(
        f"formula {text!r}: {ast.unparse(tree)!r} is not in the language of gain files"
    )


def _call(function: str, arguments: tuple[Formula, ...], text: str) -> Call:
    if function not in FUNCTIONS:
        raise ModelError(f"formula {text!r}: function {function!r} is not known")
    least, most = FUNCTIONS[function]
    if len(arguments) < least or (most is not None and len(arguments) > most):
        raise ModelError(
            f"formula {text!r}: {function} has {len(arguments)} arguments; it takes "
            f"{least if most == least else f'{least} or more'}"
        )
    return Call(function, arguments)
