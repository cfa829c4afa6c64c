r"""Problems as text: SDPA's sparse format and the Conic Benchmark Format, and CSDP's solutions.

SDPA (``.dat-s``):

    minimise  c'x   subject to   sum_i x_i F_i - F_0  positive semidefinite

Lines of comment begin with " or *; then the numbers of variables and of blocks, the sizes of the
blocks (negative for a diagonal one), c, and entries "i block row column value" of the upper halves.

A solution of CSDP has x in its first line, and lines "2 block row column value" of the multiplier Y
(those that begin with 1 are of the slack, which is computed anew).

Source: Fujisawa, Kojima, Nakata, Yamashita (2002), SDPA User's Manual, section 4; Borchers (1999),
CSDP, a C library for semidefinite programming, Optimization Methods and Software 11.

The Conic Benchmark Format (``.cbf``): variables in cones (``VAR``, ``PSDVAR``), constraints in
cones (``CON``, ``PSDCON``), coefficients as lists of coordinates.  A semidefinite variable becomes
its lower triangle, one variable an entry; off the diagonal a coefficient of it counts twice.
Integer variables, rotated and exponential cones are refused.

Source: Friberg (2016), CBLIB 2014: a benchmark library for conic mixed-integer and continuous
optimization, Mathematical Programming Computation 8; the format's technical reference, version 3.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from takagi.lmi.problem_files.problem import (
    NONNEGATIVE,
    SECOND_ORDER,
    SEMIDEFINITE,
    ZERO,
    Block,
    ConicProblem,
    Decimals,
    Solution,
    require,
    triangle_position,
)
from takagi.models.errors import ModelError

PUNCTUATION = re.compile(r"[,(){}]")


def read_sdpa(text: str, source: str) -> ConicProblem:
    """Return the problem of a ``.dat-s`` file.

    Raises
    ------
    ModelError : a line that is not as the format has it; the line is named.
    """
    lines = [
        (number, PUNCTUATION.sub(" ", line))
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and line.lstrip()[0] not in '"*'
    ]
    require(len(lines) >= 4, source, "four lines are needed before the entries")
    variables, count = (
        _integer(next(iter(line.split()), ""), number, source) for number, line in lines[:2]
    )
    sizes = [int(word) for word in lines[2][1].split()[:count] if re.fullmatch(r"[+-]?\d+", word)]
    require(len(sizes) == count > 0, source, f"line {lines[2][0]}: {count} sizes of blocks")
    require(all(sizes), source, f"line {lines[2][0]}: a block has the size 0")
    decimals, at = Decimals(source), 3
    objective: list[float] = []
    while len(objective) < variables and at < len(lines):
        objective += [decimals(word) for word in lines[at][1].split()]
        at += 1
    require(len(objective) == variables > 0, source, f"{variables} numbers of the objective")
    blocks = [Block(SEMIDEFINITE if n > 1 else NONNEGATIVE, abs(n)) for n in sizes]
    for number, line in lines[at:]:
        words = line.split()
        require(len(words) == 5, source, f"line {number}: five numbers are needed")
        index, block, row, column = (_integer(word, number, source) for word in words[:4])
        fits = 0 <= index <= variables and 1 <= block <= count
        require(fits, source, f"line {number}: matrix {index} or block {block} does not exist")
        place = blocks[block - 1]
        inside = 1 <= min(row, column) and max(row, column) <= place.size
        require(inside, source, f"line {number}: row {row}, column {column} is outside the block")
        if place.cone == NONNEGATIVE:
            require(row == column, source, f"line {number}: off the diagonal of a diagonal block")
        position = _position(place, row, column)
        require((index, position) not in place.entries, source, f"line {number}: entry given twice")
        value = decimals(words[4])
        place.add(index, position, -value if index == 0 else value)
    return ConicProblem(source, np.array(objective), 0.0, False, tuple(blocks), decimals.rounded)


def read_solution(text: str, problem: ConicProblem, source: str) -> Solution:
    """Return the solution of a ``.dat-s`` problem as CSDP writes it.

    Raises
    ------
    ModelError : another number of variables, or an entry outside the blocks.
    """
    lines, decimals = text.splitlines(), Decimals(source)
    x = np.array([decimals(word) for word in (lines[0].split() if lines else [])])
    variables = len(problem.objective)
    require(len(x) == variables, source, f"the first line needs {variables} numbers, x")
    parts = [np.zeros(block.length) for block in problem.blocks]
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        if not words or words[0] == "1":
            continue
        require(
            len(words) == 5 and words[0] == "2", source, f"line {number}: 2 block row column value"
        )
        block, row, column = (_integer(word, number, source) for word in words[1:4])
        fits = 1 <= block <= len(parts)
        require(fits, source, f"line {number}: block {block} does not exist")
        place = problem.blocks[block - 1]
        inside = 1 <= min(row, column) and max(row, column) <= place.size
        require(inside, source, f"line {number}: row {row}, column {column} is outside the block")
        parts[block - 1][_position(place, row, column)] = decimals(words[4])
    y = np.concatenate(parts)
    return Solution(x, y if y.any() else None)


def _position(block: Block, row: int, column: int) -> int:
    if block.cone == NONNEGATIVE:
        return row - 1
    return triangle_position(row - 1, column - 1)


def _integer(word: str, number: int, source: str) -> int:
    require(
        re.fullmatch(r"[+-]?\d+", word) is not None,
        source,
        f"line {number}: {word!r} is no integer",
    )
    return int(word)


# Sections of coordinates -> how many indices stand before the value.
COORDINATES = {
    "OBJFCOORD": 3,
    "OBJACOORD": 1,
    "OBJBCOORD": 0,
    "FCOORD": 4,
    "ACOORD": 2,
    "BCOORD": 1,
    "HCOORD": 4,
    "DCOORD": 3,
}
# Cone of the format -> its name here, and the sign of its values.
CONES = {"F": ("", 1), "L+": (NONNEGATIVE, 1), "L-": (NONNEGATIVE, -1), "L=": (ZERO, 1)} | {
    "Q": (SECOND_ORDER, 1)
}


class _Reader:
    """Lines of the file one after another, with their numbers for messages."""

    def __init__(self, text: str, source: str) -> None:
        self.source, self.number, self.decimals = source, 0, Decimals(source)
        lines = enumerate(text.splitlines(), start=1)
        self._lines = ((n, line.split()) for n, line in lines if line.split("#")[0].strip())

    def __iter__(self) -> Iterator[list[str]]:
        return self

    def __next__(self) -> list[str]:
        self.number, words = next(self._lines)
        return words

    def words(self, count: int) -> list[str]:
        """Return the next line, which has this many words."""
        words = next(self, [])
        self.require(len(words) == count, f"{count} words are needed")
        return words

    def integer(self, word: str) -> int:
        self.require(word.isdecimal(), f"{word!r} is no number of something")
        return int(word)

    def require(self, holds: bool, needed: str) -> None:
        require(holds, f"{self.source}: line {self.number}", needed)


def read_cbf(text: str, source: str) -> ConicProblem:
    """Return the problem of a ``.cbf`` file.

    Raises
    ------
    ModelError : a line that is not as the format has it, or a cone that is not supported.
    """
    reader = _Reader(text, source)
    sense, scalars, matrices = "MIN", 0, []
    own: list[tuple[str, int]] = []
    cones: list[tuple[str, int]] = []
    semidefinite: list[int] = []
    listed: dict[str, list[tuple[list[int], float]]] = {name: [] for name in COORDINATES}
    sections: set[str] = set()
    for section, *_ in reader:
        reader.require(section not in sections, f"the section {section} is there twice")
        sections.add(section)
        if section == "VER":
            reader.words(1)
        elif section == "OBJSENSE":
            (sense,) = reader.words(1)
            reader.require(sense in ("MIN", "MAX"), f"MIN or MAX is needed, not {sense!r}")
        elif section in ("VAR", "CON"):
            total, count = map(reader.integer, reader.words(2))
            rows = [reader.words(2) for _ in range(count)]
            pairs = [(name, reader.integer(size)) for name, size in rows]
            for name, _ in pairs:
                reader.require(name in CONES, f"the cone {name!r} is not supported")
            reader.require(sum(n for _, n in pairs) == total, f"cones of {total} rows are needed")
            if section == "VAR":
                scalars, own = total, pairs
            else:
                cones = pairs
        elif section in ("PSDVAR", "PSDCON"):
            (count,) = map(reader.integer, reader.words(1))
            sizes = [reader.integer(reader.words(1)[0]) for _ in range(count)]
            if section == "PSDVAR":
                matrices = sizes
            else:
                semidefinite = sizes
        elif section in COORDINATES:
            listed[section] = _coordinates(reader, section)
        else:
            raise ModelError(f"{source}: line {reader.number}: {section!r} is not supported")
    return _assembled(reader, sense, scalars, own, matrices, cones, semidefinite, listed)


def _coordinates(reader: _Reader, section: str) -> list[tuple[list[int], float]]:
    indices = COORDINATES[section]
    count = 1 if indices == 0 else reader.integer(reader.words(1)[0])
    rows = [reader.words(indices + 1) for _ in range(count)]
    listed = [([reader.integer(w) for w in row[:-1]], reader.decimals(row[-1])) for row in rows]
    # Of a symmetric matrix one triangle is given; an entry of the other one would count again.
    symmetric = section[0] in "FHD" or section == "OBJFCOORD"
    places = [(*at[:-2], *sorted(at[-2:])) if symmetric else (*at,) for at, _ in listed]
    reader.require(len({*places}) == len(places), f"an entry of {section} is given twice")
    return listed


def _assembled(
    reader: _Reader,
    sense: str,
    scalars: int,
    own: list[tuple[str, int]],
    matrices: list[int],
    cones: list[tuple[str, int]],
    semidefinite: list[int],
    listed: dict[str, list[tuple[list[int], float]]],
) -> ConicProblem:
    """Return the problem: scalar variables first, then the triangles of the matrices."""
    source = reader.source
    starts = np.cumsum([scalars, *(n * (n + 1) // 2 for n in matrices)]).tolist()

    def matrix_entry(matrix: int, row: int, column: int, value: float) -> tuple[int, float]:
        fits = matrix < len(matrices) and max(row, column) < matrices[matrix]
        require(fits, source, f"entry ({row}, {column}) of matrix {matrix} does not exist")
        at = starts[matrix] + triangle_position(row, column)
        return at, value if row == column else 2.0 * value

    sign = -1.0 if sense == "MAX" else 1.0
    objective = np.zeros(starts[-1])
    for (j,), value in listed["OBJACOORD"]:
        require(j < scalars, source, f"OBJACOORD: variable {j} does not exist")
        objective[j] += sign * value
    for (matrix, row, column), value in listed["OBJFCOORD"]:
        at, weighted = matrix_entry(matrix, row, column, value)
        objective[at] += sign * weighted
    offset = sign * sum(value for _, value in listed["OBJBCOORD"])
    blocks = _own_cones(own, 0)
    for start, size in zip(starts, matrices, strict=False):
        block = Block(SEMIDEFINITE, size)
        for k in range(block.length):
            block.add(1 + start + k, k, 1.0)
        blocks.append(block)
    rows: list[tuple[Block, int, int]] = []
    for name, size in cones:
        cone, direction = CONES[name]
        block = Block(cone, size)
        rows += [(block, k, direction) for k in range(size)]
        if cone and size:
            blocks.append(block)
    for section in ("ACOORD", "FCOORD", "BCOORD"):
        for (row, *indices), value in listed[section]:
            require(row < len(rows), source, f"{section}: constraint {row} does not exist")
            block, position, direction = rows[row]
            index, weighted = -1, value
            if section == "ACOORD":
                (index,) = indices
                require(index < scalars, source, f"ACOORD: variable {index} does not exist")
            elif section == "FCOORD":
                matrix, i, j = indices
                index, weighted = matrix_entry(matrix, i, j, value)
            block.add(index + 1, position, direction * weighted)
    places = [Block(SEMIDEFINITE, size) for size in semidefinite]
    for section in ("HCOORD", "DCOORD"):
        for (number, *indices), value in listed[section]:
            index = -1 if section == "DCOORD" else indices.pop(0)
            row, column = indices
            fits = number < len(places) and index < scalars
            fits = fits and max(row, column) < places[number].size
            require(fits, source, f"{section}: an index of constraint {number} does not exist")
            places[number].add(index + 1, triangle_position(row, column), value)
    return ConicProblem(
        source, objective, offset, sense == "MAX", tuple(blocks + places), reader.decimals.rounded
    )


def _own_cones(own: list[tuple[str, int]], first: int) -> list[Block]:
    """Return a block for each cone in which variables lie; a free variable has none."""
    blocks = []
    for name, size in own:
        cone, direction = CONES[name]
        block = Block(cone, size)
        for k in range(size):
            block.add(1 + first + k, k, float(direction))
        if cone and size:
            blocks.append(block)
        first += size
    return blocks
