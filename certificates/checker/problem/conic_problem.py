r"""A conic problem with exact numbers, and what it means that values lie in its cones.

    minimise  c'x + c_0   subject to   S_k(x) = B_k + sum_i x_i A_ik  in  K_k

K_k is ``zero`` (S = 0), ``nonnegative`` (S >= 0), ``second-order`` (S_1 >= |(S_2, ..., S_q)|), or
``semidefinite`` (S symmetric, v'Sv >= 0 for all v), whose values are the lower triangle of S, row
by row.  ``scaled``: the values off the diagonal are those of S times sqrt(2), as solvers keep them.

The dual cone of ``zero`` is everything, every other cone is its own.  The inner product of a
semidefinite block is trace(S Y): off the diagonal a value counts twice, if it is not scaled.

In the file ``model`` has ``objective`` c, ``offset`` c_0, ``sense`` ("minimise", or "maximise" for
the problem of the opposite objective) and ``blocks``: ``cone``, ``size`` (rows of S, or values) and
``entries`` [i, position, value], where i = 0 is B_k and i >= 1 is A_ik.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isqrt, lcm
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.definite import MOST_WORK
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused

KIND = "conic-problem"
CONES = ("zero", "nonnegative", "second-order", "semidefinite")
SENSES = ("minimise", "maximise")
MOST_VARIABLES, MOST_ENTRIES, LARGEST_BLOCK = 2_000, 500_000, 200
# Of all blocks together: a block of many values needs few characters in the file.
MOST_VALUES = 200_000
# Values with many digits are rounded to this unit before an elimination, which allows for it.
UNIT = Fraction(1, 10**40)
# 1 / sqrt(2) is this number to within UNIT.
HALF_ROOT = Fraction(isqrt(2 * 10**90), 2 * 10**45)
Vector = dict[int, Fraction]
# The key of a line's right side, the work of an operation beside its digits, and that of a look
# into a line.
RIGHT, SMALL_WORK, LOOK_WORK = -1, 200, 4


class Work:
    """Counts the work of exact arithmetic: a hostile file could block the checker otherwise."""

    def __init__(self) -> None:
        self._spent = 0

    def spend(self, value: Fraction) -> None:
        """Count the operation that gave this value; its common divisor takes bits^2 steps.

        Raises
        ------
        Refused : all operations together were too much.
        """
        bits = value.numerator.bit_length() + value.denominator.bit_length()
        self.add(SMALL_WORK + bits + bits * bits // 2**15)

    def add(self, work: int) -> None:
        """Count this much work.

        Raises
        ------
        Refused : all operations together were too much.
        """
        self._spent += work
        if self._spent > MOST_WORK // 10:
            raise Refused("numbers with too many digits: too much work")


def limited_sum(terms: Iterable[Fraction]) -> Fraction:
    """Return the sum.

    Raises
    ------
    Refused : numbers with too many digits.
    """
    total, work = Fraction(0), Work()
    for term in terms:
        total += term
        work.spend(total)
    return total


@dataclass(frozen=True)
class Block:
    """One cone with B_k (``constant``) and A_ik (``columns``, by i), as values by position."""

    cone: str
    size: int
    scaled: bool
    constant: Vector
    columns: dict[int, Vector]

    @property
    def length(self) -> int:
        """The number of values."""
        return self.size * (self.size + 1) // 2 if self.cone == "semidefinite" else self.size

    def weight(self, position: int) -> int:
        """Return how often a value counts in the inner product."""
        twice = self.cone == "semidefinite" and not self.scaled
        return 1 if not twice or _on_diagonal(position) else 2

    def product(self, values: Vector, other: Sequence[Fraction]) -> Fraction:
        """Return the inner product of sparse values with a full vector."""
        return limited_sum(self.weight(k) * value * other[k] for k, value in values.items())


@dataclass(frozen=True)
class ConicProblem:
    """The problem of the module; ``objective`` is c."""

    objective: tuple[Fraction, ...]
    offset: Fraction
    maximised: bool
    blocks: tuple[Block, ...]

    @property
    def homogeneous(self) -> ConicProblem:
        """The problem with c_0 = 0 and every B_k = 0, whose points are the directions."""
        blocks = tuple(replace(block, constant={}) for block in self.blocks)
        return replace(self, offset=Fraction(0), blocks=blocks)

    def values(self, x: Sequence[Fraction]) -> list[list[Fraction]]:
        """Return S_k(x) of every block."""
        stacked, work = [], Work()
        for block in self.blocks:
            values = [block.constant.get(k, Fraction(0)) for k in range(block.length)]
            for i, column in block.columns.items():
                for k, value in column.items():
                    values[k] += x[i] * value
                    work.spend(values[k])
            stacked.append(values)
        return stacked


def read_problem(data: Any, where: str) -> ConicProblem:
    """Return the problem of a file.

    Raises
    ------
    CertificateError : a model of another kind, a member that is malformed, or too many numbers.
    """
    model = data["model"]
    if reader.text(model, "kind", "model") != KIND:
        raise CertificateError(f"{where}: a claim about a {KIND}; model.kind is {model['kind']!a}")
    objective = tuple(reader.numbers(model, "objective", "model"))
    if len(objective) > MOST_VARIABLES:
        raise CertificateError(f"model.objective: at most {MOST_VARIABLES} variables")
    blocks = reader.listed(model, "blocks", "model", 1, MOST_ENTRIES)
    listed = [_read_block(block, f"model.blocks[{k}]", len(objective))
              for k, block in enumerate(blocks)]  # fmt: skip
    if sum(block.length for block in listed) > MOST_VALUES:
        raise CertificateError(f"model.blocks: at most {MOST_VALUES} values")
    sense = _choice(model, "sense", "model", SENSES)
    return ConicProblem(
        objective, reader.number(model, "offset", "model"), sense == "maximise", tuple(listed)
    )


def _read_block(block: Any, where: str, variables: int) -> Block:
    cone = _choice(block, "cone", where, CONES)
    size = reader.integer(block, "size", where)
    largest = LARGEST_BLOCK if cone == "semidefinite" else MOST_ENTRIES
    if not 1 <= size <= largest:
        raise CertificateError(f"{where}.size: 1 to {largest} is needed")
    scaled = block.get("scaled", False)
    if not isinstance(scaled, bool):
        raise CertificateError(f"{where}.scaled: true or false is needed")
    read = Block(cone, size, scaled, {}, {})
    entries = reader.listed(block, "entries", where, 0, MOST_ENTRIES)
    for entry in entries:
        index, position, value = reader.numbers({"entries": entry}, "entries", where, 3)
        if not (0 <= index <= variables and 0 <= position < read.length):
            raise CertificateError(f"{where}.entries: an index or a position is out of its range")
        if index.denominator != 1 or position.denominator != 1:
            raise CertificateError(f"{where}.entries: index and position are whole numbers")
        values = read.columns.setdefault(int(index) - 1, {}) if index else read.constant
        if int(position) in values:
            raise CertificateError(f"{where}.entries: one entry is given twice")
        values[int(position)] = value
    return read


def _choice(owner: Any, key: str, where: str, choices: Sequence[str]) -> str:
    value = reader.text(owner, key, where)
    if value not in choices:
        raise CertificateError(f"{where}.{key}: one of {', '.join(choices)} is needed")
    return value


def inside_cones(
    blocks: Sequence[Block], stacked: Sequence[Sequence[Fraction]], subject: str
) -> Obligations:
    """Yield what puts values into the cones other than ``zero``.

    Parameters
    ----------
    subject : what the values are, for the reason where one is outside.
    """
    work = 0
    for number, (block, values) in enumerate(zip(blocks, stacked, strict=True), start=1):
        failure = f"{subject} is not in cone {number} ({block.cone})"
        if block.cone == "nonnegative":
            for value in values:
                yield nonnegative(value, failure)
        elif block.cone == "second-order":
            yield nonnegative(values[0], failure)
            rest = limited_sum(value**2 for value in values[1:])
            yield nonnegative(values[0] ** 2 - rest, failure)
        elif block.cone == "semidefinite":
            matrix, error = _symmetric(block, values)
            # The limit of one elimination is that of all of them.
            bits = max(abs(entry).bit_length() for row in matrix.reduced().rows for entry in row)
            work += block.size**4 * bits
            if work > MOST_WORK:
                raise Refused(f"{subject}: the semidefinite cones are too large together")
            if error:
                # |S - matrix| <= error in every entry: by Gershgorin the eigenvalues differ by
                # at most size * error.
                margin = [error * block.size] * block.size
                yield positive(matrix - Matrix.diagonal(margin), failure)
            else:
                yield nonnegative(matrix, failure)


def _symmetric(block: Block, values: Sequence[Fraction]) -> tuple[Matrix, Fraction]:
    """Return S with entries of few digits, and a bound of what was rounded off every entry."""
    error, size = Fraction(0), block.size
    rows = [[Fraction(0)] * size for _ in range(size)]
    for i, j, position in triangle(size):
        value = values[position]
        if block.scaled and i != j and value:
            # |value / sqrt(2) - value * HALF_ROOT| <= |value| UNIT
            error = max(error, abs(value) * UNIT)
            value *= HALF_ROOT
        rows[i][j] = rows[j][i] = value
    if lcm(*(value.denominator for row in rows for value in row)) > 10**60:
        rows = [[Fraction(round(value / UNIT)) * UNIT for value in row] for row in rows]
        error += UNIT
    # A bound of few digits, for it enters the elimination.
    error = Fraction(-((-error / UNIT**2) // 1)) * UNIT**2 if error else error
    return Matrix.of(rows), error


def triangle(size: int) -> Iterator[tuple[int, int, int]]:
    """Yield (row, column, position) of the lower triangle, row by row."""
    position = 0
    for i in range(size):
        for j in range(i + 1):
            yield i, j, position
            position += 1


def _on_diagonal(position: int) -> bool:
    # The diagonal's positions are 0, 2, 5, 9, ...: i (i + 3) / 2, where 8 p + 9 is a square.
    root = isqrt(8 * position + 9)
    return root * root == 8 * position + 9


def corrected(
    rows: Sequence[Vector], right: Sequence[Fraction], start: list[Fraction], basis: Sequence[int]
) -> list[Fraction]:
    """Return the vector next to ``start`` with rows . v = right, which differs in ``basis`` only.

    Raises
    ------
    Refused : no such vector, more than one, or numbers with too many digits.
    """
    column_of = {place: column for column, place in enumerate(basis)}
    if len(column_of) != len(basis):
        raise Refused("the basis names a place twice")
    system: list[Vector] = []
    for row, wanted in zip(rows, right, strict=True):
        line = {column_of[k]: a for k, a in row.items() if k in column_of and a}
        line[RIGHT] = wanted - sum((a * start[k] for k, a in row.items()), Fraction(0))
        system.append(line)
    solved = list(start)
    for place, change in zip(basis, _solution(system, len(basis)), strict=True):
        solved[place] += change
    return solved


def _solution(remaining: list[Vector], count: int) -> list[Fraction]:
    """Return the only solution of sparse lines, whose right sides stand at ``RIGHT``."""
    pivots: list[Vector] = []
    work = Work()
    for column in range(count):
        work.add(LOOK_WORK * (len(remaining) + len(pivots)))
        lines = [line for line in remaining if column in line]
        if not lines:
            raise Refused("the basis leaves the equations without one solution")
        pivot = min(lines, key=len)
        remaining = [line for line in remaining if line is not pivot]
        for line in [line for line in (*remaining, *pivots) if column in line]:
            factor = line[column] / pivot[column]
            for k, value in pivot.items():
                entry = line.get(k, Fraction(0)) - factor * value
                work.spend(entry)
                if entry or k == RIGHT:
                    line[k] = entry
                else:
                    del line[k]
        pivots.append(pivot)
    if any(line[RIGHT] for line in remaining):
        raise Refused("the equations contradict one another")
    return [pivot[RIGHT] / pivot[column] for column, pivot in enumerate(pivots)]
