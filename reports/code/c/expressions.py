"""A formula of a program in C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import TypeAlias

from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import Constant, Row, Spline
from takagi.reports.code.formula import Call, Formula, Name, Number, Operation

# A text of C, and the precedence of its last operation: a higher number binds more strongly.
Expression: TypeAlias = tuple[str, int]

_BINDS = {"+": 1, "-": 1, "*": 2, "/": 2}
_SIGNED, _ATOM = 3, 4
_PI = Decimal("3.14159265358979323846")
# The largest and the smallest normal float (FLT_MAX, FLT_MIN), and the largest double (DBL_MAX).
_LARGEST, _SMALLEST = Decimal("3.4028234663852886E+38"), Decimal("1.1754943508222875E-38")
_LARGEST_DOUBLE = Decimal("1.7976931348623157E+308")
# Functions that gain files and <math.h> name differently.
_MATH = {"abs": "fabs"}


def literal(value: Decimal, suffix: str) -> str:
    """Return a number as C writes it: the file's digits, with a point and the type's suffix.

    Raises
    ------
    ModelError : the number is not finite, or the type cannot hold it.
    """
    if not value.is_finite():
        raise ModelError(f"{value} stands in the file where a finite number is needed")
    size = abs(value)
    if suffix and size and not _SMALLEST <= size <= _LARGEST:
        raise ModelError(
            f"the number {value} does not fit a float; give --precision double for this law"
        )
    if size > _LARGEST_DOUBLE:
        raise ModelError(f"the number {value} does not fit a double")
    text = str(value)
    return text + ("" if "." in text or "E" in text else ".0") + suffix


class Expressions:
    """Writes formulas in C; records the helpers that they need and the weights of rules.

    Attributes
    ----------
    helpers : names of the helper functions that were needed so far.
    before : lines that must stand before the next statement; ``taken_before`` returns them.
    """

    def __init__(
        self,
        names: Mapping[str, str],
        constants: Mapping[str, Constant],
        prefix: str,
        suffix: str,
        *,
        widened: bool = False,
    ) -> None:
        self.names, self.constants = names, constants
        self.prefix, self.suffix = prefix, suffix
        self._widened = widened
        self.helpers: set[str] = set()
        self.before: list[str] = []
        self._weights: dict[tuple[str, ...], str] = {}
        self._count = 0

    def text(self, formula: Formula) -> str:
        """Return a formula as C."""
        return self._written(formula)[0]

    def in_double(self, formulas: Sequence[Formula]) -> Expressions | None:
        """Return a writer that computes formulas of float names in double.

        None where a formula needs a helper function, since helpers have one type.
        """
        wide = Expressions(self.names, self.constants, self.prefix, "", widened=True)
        for formula in formulas:
            wide.text(formula)
        return None if wide.helpers else wide

    def factor(self, formula: Formula) -> str:
        """Return a formula as C that can be an operand of a comparison."""
        return self._bound(formula, 1)

    def taken_before(self) -> list[str]:
        """Return the lines that must stand before the statement, and forget them."""
        lines, self.before = self.before, []
        return lines

    def forget(self) -> None:
        """Forget the weights: the C block that declares them has ended."""
        self._weights.clear()

    def _written(self, formula: Formula) -> Expression:
        match formula:
            case Number(value):
                return literal(value, self.suffix), _ATOM
            case Name("pi"):
                return literal(_PI, self.suffix), _ATOM
            case Name(name):
                if name in self.constants and not isinstance(self.constants[name].value, Decimal):
                    raise ModelError(f"{name!r} is a row or table; a formula needs a number there")
                cast = "(double)" if self._widened else ""
                return f"{cast}{self.names[name]}", _ATOM
            case Operation("^", left, right):
                assert left is not None
                return self._power(left, right)
            case Operation(_, None, right):
                return f"-{self._bound(right, _ATOM)}", _SIGNED
            case Operation(sign, left, right):
                assert left is not None
                binds = _BINDS[sign]
                # Equal signs on the right keep their parentheses: a - (b - c).
                text = f"{self._bound(left, binds)} {sign} {self._bound(right, binds + 1)}"
                return text, binds
            case Call(function, arguments):
                return self._call(function, arguments)

    def _bound(self, formula: Formula, least: int) -> str:
        text, binds = self._written(formula)
        return text if binds >= least else f"({text})"

    def _power(self, base: Formula, exponent: Formula) -> Expression:
        if isinstance(exponent, Number) and exponent.value in (2, 3, 4) and not self._widened:
            return self._helped(f"power_{int(exponent.value)}", self.text(base)), _ATOM
        return f"pow{self._f}({self.text(base)}, {self.text(exponent)})", _ATOM

    @property
    def _f(self) -> str:
        return self.suffix.lower()

    def _helped(self, helper: str, *arguments: str) -> str:
        self.helpers.add(helper)
        return f"{self.prefix}{helper}({', '.join(arguments)})"

    def _call(self, function: str, arguments: tuple[Formula, ...]) -> Expression:
        if function == "choose":
            d, a, b = arguments
            zero = literal(Decimal(0), self.suffix)
            return f"({self.factor(d)} < {zero} ? {self.text(a)} : {self.text(b)})", _ATOM
        if function in ("min", "max", "limit"):
            return self._helped(function, *map(self.text, arguments)), _ATOM
        if function in ("first", "last"):
            row = self._row(arguments[0])
            place = 0 if function == "first" else len(row) - 1
            return f"{self._table(arguments[0])}[{place}]", _ATOM
        if function in ("line", "slope", "hold"):
            return self._between(function, arguments), _ATOM
        if function == "spline":
            return self._spline(arguments), _ATOM
        if function == "mix":
            return self._mix(arguments), _ATOM
        return f"{_MATH.get(function, function)}{self._f}({self.text(arguments[0])})", _ATOM

    def _between(self, function: str, arguments: tuple[Formula, ...]) -> str:
        x, nodes, values = arguments
        count, found = len(self._row(nodes)), len(self._row(values))
        if count < 2 or not (found == count or (function == "hold" and found == count - 1)):
            raise ModelError(f"{function} has {count} nodes and {found} values")
        return self._helped(
            function, self.text(x), self._table(nodes), self._table(values), str(count)
        )

    def _spline(self, arguments: tuple[Formula, ...]) -> str:
        table = self._constant(arguments[-1])
        name = self._table(arguments[-1])
        if not isinstance(table, Spline) or len(table.knots) != len(arguments) - 1:
            raise ModelError(f"{name!r} is no spline of {len(arguments) - 1} arguments")
        rows = len(table.knots)
        sizes = (1, len(table.coefficients[0])) if rows == 1 else (
            len(table.coefficients), len(table.coefficients[0])
        )  # fmt: skip
        wanted = tuple(len(row) - 4 for row in table.knots)
        if min(wanted) < 4 or sizes[-rows:] != wanted:
            raise ModelError(f"{name!r} has {sizes} coefficients for its knots, not {wanted}")
        parts = [self.text(one) for one in arguments[:-1]]
        for k, knots in enumerate(table.knots, start=1):
            parts += [f"{name}_knots_{k}", str(len(knots))]
        return self._helped("spline" if rows == 1 else "spline_2", *parts, name)

    def _mix(self, arguments: tuple[Formula, ...]) -> str:
        rules, values = arguments[:2]
        count = len(self._row(values))
        if count == 1:
            return f"{self._table(values)}[0]"
        table = self._constant(rules)
        premises = len(arguments) - 2
        if not (
            isinstance(table, tuple)
            and len(table) == count
            and all(isinstance(row, tuple) and len(row) == premises for row in table)
        ):
            raise ModelError(f"mix has {count} values, and rules of another size")
        if not all(one in (0, 1) for row in table if isinstance(row, tuple) for one in row):
            raise ModelError("rules of a mix have numbers other than 0 and 1")
        return self._helped(
            "mix", self._weights_of(rules, arguments[2:], count), self._table(values), str(count)
        )

    def _weights_of(self, rules: Formula, premises: tuple[Formula, ...], count: int) -> str:
        texts = tuple(map(self.text, premises))
        key = (self._table(rules), *texts)
        if key not in self._weights:
            self._count += 1
            name, w = f"{self.prefix}weights_{self._count}", f"{self.prefix}premises_{self._count}"
            self.before += [
                f"{self.prefix}real {w}[{len(texts)}];",
                f"{self.prefix}real {name}[{count}];",
                *(f"{w}[{k}] = {text};" for k, text in enumerate(texts)),
                f"{self._helped('weigh', name, key[0], str(count), w, str(len(texts)))};",
            ]
            self._weights[key] = name
        return self._weights[key]

    def _constant(self, formula: Formula) -> object:
        if isinstance(formula, Name) and formula.name in self.constants:
            return self.constants[formula.name].value
        raise ModelError("a row or table of the file is needed in a formula, by its name")

    def _table(self, formula: Formula) -> str:
        self._constant(formula)
        assert isinstance(formula, Name)
        return self.names[formula.name]

    def _row(self, formula: Formula) -> Row:
        row = self._constant(formula)
        if isinstance(row, tuple) and row and all(isinstance(one, Decimal) for one in row):
            return row
        raise ModelError(
            f"the gain file is damaged: {self._table(formula)!r} is no row of numbers; give the "
            "gains.json that `takagi design` has written"
        )
