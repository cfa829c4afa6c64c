r"""SDPA's sparse format (``.dat-s``), and a solution as CSDP writes it.

    minimise  c'x   subject to   sum_i x_i F_i - F_0  positive semidefinite

Lines of comment begin with " or *; then the numbers of variables and of blocks, the sizes of the
blocks (negative for a diagonal one), c, and entries "i block row column value" of the upper halves.

A solution has x in its first line, and lines "2 block row column value" of the multiplier Y (those
that begin with 1 are of the slack, which is computed anew).

Source: Fujisawa, Kojima, Nakata, Yamashita (2002), SDPA User's Manual, section 4; Borchers (1999),
CSDP, a C library for semidefinite programming, Optimization Methods and Software 11.
"""

from __future__ import annotations

import re

import numpy as np

from takagi.lmi.problem_files.problem import (
    NONNEGATIVE,
    SEMIDEFINITE,
    Block,
    ConicProblem,
    Decimals,
    Solution,
    require,
    triangle_position,
)

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
    variables, count = (_first_integer(*lines[k], source) for k in (0, 1))
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


def _first_integer(number: int, line: str, source: str) -> int:
    words = line.split()
    return _integer(words[0] if words else "", number, source)


def _integer(word: str, number: int, source: str) -> int:
    require(
        re.fullmatch(r"[+-]?\d+", word) is not None,
        source,
        f"line {number}: {word!r} is no integer",
    )
    return int(word)
