"""A table as a function in sympy expressions, with its derivatives."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from hashlib import sha256
from typing import Any, ClassVar, TypeVar

import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.splines.exact_spline import MAX_ORDER
from takagi.models.splines.spline import Curve, Surface

Result = TypeVar("Result")


class TableFunction(sp.Function):  # type: ignore[misc]  # sympy carries no type annotations
    """A partial derivative of a spline, as a function of sympy expressions.

    Made by ``table_function``; one subclass for each table and order of differentiation.  Two
    functions of the same name, numbers and units are equal, also when read from two files.

    Attributes
    ----------
    table : ``Curve`` of one argument, or ``Surface`` of two.
    orders : of differentiation, one for each argument; 0, 1 or 2.
    value_unit, argument_units : SI, of the table itself (orders 0).
    """

    table: ClassVar[Curve | Surface]
    orders: ClassVar[tuple[int, ...]]
    value_unit: ClassVar[str]
    argument_units: ClassVar[tuple[str, ...]]
    title: ClassVar[str]

    @classmethod
    def eval(cls, *arguments: sp.Expr) -> sp.Expr | None:
        """Return the exact value at a rational point of the table; anything else stays as it is."""
        if not all(argument.is_Rational for argument in arguments):
            return None
        point = [Fraction(int(a.p), int(a.q)) for a in arguments]
        if not cls._covers(point):
            return None
        return sp.Rational(*cls.value_at(*point).as_integer_ratio())

    @classmethod
    def value_at(cls, *point: Fraction) -> Fraction:
        """Return the value at a rational point, exactly; ModelError outside the table."""
        return _of_any_shape(cls.table.exact, point, cls.orders)

    @classmethod
    def bounds(cls, *sides: Interval) -> Interval:
        """Return a rigorous enclosure over a box of arguments (the Bernstein hull).

        Raises
        ------
        ModelError : the box leaves the table.
        """
        return _of_any_shape(cls.table.bounds, sides, cls.orders)

    @classmethod
    def _covers(cls, point: list[Fraction]) -> bool:
        sides = zip(table_ranges(cls.table), point, strict=True)
        return all(side.lower <= value <= side.upper for side, value in sides)

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the derivative by one argument: the same table, one order higher."""
        orders = list(self.orders)
        orders[argindex - 1] += 1
        if max(orders) > MAX_ORDER:
            raise ModelError(
                f"{self}: a third derivative of the table {self.title} was asked; its spline is "
                "twice continuously differentiable"
            )
        return _class_of(
            self.title, self.table, tuple(orders), self.value_unit, self.argument_units
        )(*self.args)

    def _eval_is_real(self) -> bool | None:
        return True if all(argument.is_real for argument in self.args) else None

    def _eval_evalf(self, prec: int) -> sp.Expr | None:
        values = [argument._eval_evalf(prec) for argument in self.args]
        if not all(value is not None and value.is_Float for value in values):
            return None
        point = [Fraction(*map(int, sp.Rational(value).as_numer_denom())) for value in values]
        if not self._covers(point):
            return None
        value_there = self.value_at(*point)
        return sp.Rational(*value_there.as_integer_ratio())._eval_evalf(prec)

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        arguments = ", ".join(printer._print(argument) for argument in self.args)
        head = printer._print(sp.Symbol(self.title))
        if any(self.orders):
            head = f"{head}^{{({','.join(map(str, self.orders))})}}"
            head = head if exp is None else rf"\left({head}\right)"
        power = "" if exp is None else f"^{{{exp}}}"
        return rf"{head}{power}\left({arguments}\right)"


def table_function(
    name: str,
    table: Curve | Surface,
    *,
    unit: str = "-",
    argument_units: tuple[str, ...] | None = None,
) -> type[TableFunction]:
    """Return f with f(x) or f(x, y) the value of the spline, for use in sympy expressions.

    Parameters
    ----------
    unit : SI unit of the value.
    argument_units : SI unit of each argument; None for pure numbers.

    Derivatives in sympy are those of the spline, up to the second in each argument.  At a
    rational point inside the table the value is exact; ``lambdify`` evaluates it with numpy and
    refuses points outside.

    Raises
    ------
    ModelError : as many units as arguments are needed.
    """
    count = len(table_ranges(table))
    units = ("-",) * count if argument_units is None else tuple(argument_units)
    if len(units) != count:
        raise ModelError(f"table {name}: {len(units)} argument units for {count} arguments")
    return _class_of(name, table, (0,) * count, unit, units)


def table_ranges(table: Curve | Surface) -> tuple[Interval, ...]:
    """Return the range of each argument that the table covers."""
    if isinstance(table, Curve):
        return (Interval.of(*table.x_range),)
    return Interval.of(*table.x_range), Interval.of(*table.y_range)


_CLASSES: dict[tuple[object, ...], type[TableFunction]] = {}


def _class_of(
    title: str,
    table: Curve | Surface,
    orders: tuple[int, ...],
    unit: str,
    argument_units: tuple[str, ...],
) -> type[TableFunction]:
    """Return the one class for this content: sympy compares functions by their class."""
    key = (title, _digest(table), orders, unit, argument_units)
    if key not in _CLASSES:
        name = title if not any(orders) else f"{title}_d{''.join(map(str, orders))}"
        members = {
            "__module__": __name__,
            "nargs": len(orders),
            "table": table,
            "orders": orders,
            "value_unit": unit,
            "argument_units": argument_units,
            "title": title,
            "_imp_": staticmethod(_numeric(table, orders)),  # what sympy.lambdify calls
        }
        metaclass: Any = type(TableFunction)
        _CLASSES[key] = metaclass(name, (TableFunction,), members)
    return _CLASSES[key]


def _of_any_shape(
    method: Callable[..., Result], arguments: tuple[object, ...], orders: tuple[int, ...]
) -> Result:
    """Return method(x, dx) or method(x, y, dx, dy)."""
    return method(*arguments, *orders)


def _numeric(table: Curve | Surface, orders: tuple[int, ...]) -> Callable[..., Any]:
    def value(*point: Any) -> Any:
        return table(*point, *orders)

    return value


def _digest(table: Curve | Surface) -> str:
    if isinstance(table, Curve):
        arrays = [table.knots, table.coefficients]
    else:
        arrays = [table.x_knots, table.y_knots, table.coefficients]
    digest = sha256()
    for array in arrays:
        digest.update(f"{array.shape}".encode())
        digest.update((array + 0.0).tobytes())  # -0.0 becomes 0.0: the same number
    return digest.hexdigest()
