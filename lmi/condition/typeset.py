"""Write a condition in LaTeX or Markdown, from the same terms that are solved."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from takagi.lmi.condition.statements import StatedCondition, condition_of
from takagi.lmi.condition.term import LMI, Condition, Constant, Equality, Position, Term
from takagi.lmi.condition.unknown import Unknown


class _Piece(NamedTuple):
    """One summand of a block: what multiplies it, and the product with its sign."""

    factor: str
    text: str


def latex(condition: StatedCondition) -> str:
    """Return the condition as an ``align*`` environment (amsmath): objective, then one LMI a line.

    He(X) stands for X + X^T, an asterisk for the block that symmetry implies.
    """
    lines = formula_lines(condition_of(condition, "latex"))
    body = " \\\\\n".join(rf"{label} \quad & {formula}" for label, formula in lines)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}"


def markdown(condition: StatedCondition) -> str:
    r"""Return the condition for a Markdown page: each line's name, then its formula as a block.

    The blocks are fences of the language ``math``, which GitHub and GitLab render. Formulas between
    dollar signs would not do: Markdown reads them first, and turns every ``\\`` into one backslash.
    """
    blocks = []
    for label, formula in formula_lines(condition_of(condition, "markdown")):
        blocks.append(f"{plain_label(label)}:\n\n```math\n{formula}\n```")
    return "\n\n".join(blocks) + "\n"


def lmi_latex(lmi: LMI) -> str:
    """Return one LMI, e.g. ``He(P A_i) + 2 alpha P < 0``; a block matrix when it has blocks."""
    size = len(lmi.blocks)
    if size == 1:
        positions: tuple[Position | None, ...] = ((0, 0), None)
        right_side = _below(lmi) if any(term.at in positions for term in lmi.terms) else []
        left_side = _block(lmi, positions, without=right_side)
        return f"{left_side} {_relation(lmi)} {_negative(right_side)}"
    rows = [
        " & ".join(_block(lmi, ((i, j),)) if i <= j else r"\ast" for j in range(size))
        for i in range(size)
    ]
    matrix = r" \\ ".join(rows)
    full_size = _block(lmi, (None,))
    total = _sum(
        [rf"\begin{{bmatrix}} {matrix} \end{{bmatrix}}", *([] if full_size == "0" else [full_size])]
    )
    return f"{total} {_relation(lmi)} 0"


def plain_label(label: str) -> str:
    """Return a label of ``formula_lines`` without its LaTeX."""
    return label.removeprefix(r"\text{").removesuffix("}").removesuffix(":")


def formula_lines(condition: Condition) -> list[tuple[str, str]]:
    """Return (label, formula) of the objective, the unknowns, and each LMI."""
    unknowns = r",\; ".join(_declared(unknown, condition) for unknown in condition.unknowns)
    lines = [(r"\text{find}", unknowns)]
    if condition.objective:
        cost = [
            _cost(unknown, condition.objective[unknown.name])
            for unknown in condition.unknowns
            if unknown.name in condition.objective
        ]
        lines = [(r"\text{minimise}", _sum(cost)), (r"\text{over}", unknowns)]
    for lmi in condition.lmis:
        span = _range(lmi.index)
        formula = lmi_latex(lmi) + (rf", \quad {span}" if span else "")
        lines.append((rf"\text{{{lmi.name}:}}", formula))
    for equality in condition.equalities:
        span = _range(equality.index)
        formula = _equation(equality) + (rf", \quad {span}" if span else "")
        lines.append((rf"\text{{{equality.name}:}}", formula))
    return lines


def _equation(equality: Equality) -> str:
    """Return the block that vanishes, with what is written with a minus on the other side."""
    frame = equality.frame()
    positions: tuple[Position | None, ...] = ((0, 1),)
    right_side = _below(frame) if equality.terms else []
    return f"{_block(frame, positions, without=right_side)} = {_negative(right_side)}"


def _relation(lmi: LMI) -> str:
    strict = lmi.strict
    if lmi.size == 1:
        return {(1, True): ">", (1, False): r"\ge", (-1, True): "<"}.get((lmi.sign, strict), r"\le")
    if lmi.sign > 0:
        return r"\succ" if strict else r"\succeq"
    return r"\prec" if strict else r"\preceq"


def _range(index: str) -> str:
    r"""Return an index range without the dots of one or two: ``i = 1, \dots, 2`` is i = 1, 2."""
    index = re.sub(r"(\w) = 1, \\dots, 2\b", r"\1 = 1, 2", index)
    return "" if re.fullmatch(r"\w = 1, \\dots, 1", index) else index


def _declared(unknown: Unknown, condition: Condition) -> str:
    if unknown.scalar:
        space = r"\mathbb{R}"
    elif unknown.symmetric:
        space = rf"\mathbb{{S}}^{{{unknown.rows}}}"
    else:
        space = rf"\mathbb{{R}}^{{{unknown.rows} \times {unknown.cols}}}"
    symbol = unknown.symbol
    if unknown.count == 1:
        return rf"{symbol} \in {space}"
    written = {
        re.sub(r"[{}]", "", term.symbol)
        for lmi in condition.lmis
        for term in lmi.terms
        if term.unknown == unknown
    }
    if pairs := sorted(name for name in written if re.search(r"_([a-z])(?!\1)[a-z]$", name)):
        # Members with two indices are named by these, not by their running number.
        return rf"{symbol}_{{{pairs[0][-2:]}}} \in {space}"
    dots = ", " if unknown.count == 2 else r", \dots, "
    first, last = (_indexed(symbol, number) for number in ("1", f"{{{unknown.count}}}"))
    return rf"{first}{dots}{last} \in {space}"


def _indexed(symbol: str, index: str) -> str:
    r"""Return X_1, and \tau_{k,1} for a symbol that has an index already."""
    match = re.fullmatch(r"(.*)_(?:(\w)|\{([^{}]*)\})", symbol)
    if match is None:
        return f"{symbol}_{index}"
    return f"{match[1]}_{{{match[2] or match[3]},{index.strip('{}')}}}"


def _cost(unknown: Unknown, weight: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    symbol = unknown.symbol
    first = weight[0] if unknown.count == 1 or (weight == weight[:1]).all() else None
    over, symbol = ("", symbol) if unknown.count == 1 else (r"\textstyle\sum_k ", f"{symbol}_k")
    if first is not None and (first == first[0, 0] * np.eye(len(first), first.shape[1])).all():
        number = "" if abs(first[0, 0]) == 1 else f"{abs(first[0, 0]):.6g}"
        trace = symbol if unknown.scalar else rf"\operatorname{{trace}} {symbol}"
        return f"{'-' if first[0, 0] < 0 else ''}{over}{_times(number, trace)}"
    index = "" if first is not None else "_k"
    name = rf"C_{{{unknown.symbol}}}" if not index else rf"C_{{{unknown.symbol},k}}"
    return rf"{over}\langle {name}, {symbol} \rangle"


def _below(lmi: LMI) -> list[Constant]:
    """Return the constants that are written with a minus: they go to the right-hand side."""
    return [constant for constant in lmi.constants if constant.latex.startswith("-")]


def _negative(constants: Sequence[Constant]) -> str:
    pieces = [_Piece(constant.factor, constant.latex[1:].lstrip()) for constant in constants]
    return _sum(_grouped(pieces)) if pieces else "0"


def _block(
    lmi: LMI, positions: tuple[Position | None, ...], without: Sequence[Constant] = ()
) -> str:
    """Return the sum in one block; what is kept below the diagonal is written transposed."""
    mirrors = [
        position[::-1]
        for position in positions
        if position is not None and position[0] != position[1]
    ]
    he: list[_Piece] = []
    plain: list[_Piece] = []
    turned: list[_Piece] = []
    for term in lmi.terms:
        piece = _Piece(term.factor, _product(term))
        if term.at in positions:
            (he if term.plus_transpose else plain).append(piece)
        elif term.at in mirrors:
            same = term.unknown.symmetric and term.latex == ("", "")
            (plain if same else turned).append(piece)
    for constant in lmi.constants:
        piece = _Piece(constant.factor, constant.latex or "C")
        if constant.at in positions and constant not in without:
            plain.append(piece)
        elif constant.at in mirrors:
            turned.append(piece)
    summands = [rf"\mathrm{{He}}\left({_sum(_grouped(he))}\right)"] if he else []
    return _sum([*summands, *_transposed(turned), *_grouped(plain)]) or "0"


def _product(term: Term) -> str:
    before, behind = term.latex
    symbol = term.symbol or term.unknown.symbol
    text = " ".join(factor for factor in (before, symbol, behind) if factor)
    return re.sub(r"^- (?=\S)", "-", text)


def _grouped(pieces: Iterable[_Piece]) -> list[str]:
    """Return the summands, those with a common factor in one bracket."""
    groups: dict[str, list[str]] = {}
    for piece, times in Counter(pieces).items():
        text = piece.text if times == 1 else _times(str(times), piece.text)
        groups.setdefault(piece.factor, []).append(text)
    summands = []
    for factor, texts in groups.items():
        if not factor:
            summands += texts
        elif len(texts) == 1 or any(re.match(r"-?\d", text) for text in texts):
            summands += [_times(factor, text) for text in texts]
        else:
            summands.append(rf"{factor} \left({_sum(texts)}\right)")
    return summands


def _times(factor: str, text: str) -> str:
    """Return factor times text: the sign of the text in front, two numbers multiplied."""
    if not factor:
        return text
    if text.startswith("-"):
        return f"-{_times(factor, text[1:].lstrip())}"
    number = re.match(r"\d+(\.\d+)?", text)
    if number and re.fullmatch(r"\d+(\.\d+)?", factor):
        product = f"{float(factor) * float(number[0]):.6g}"
        return f"{'' if product == '1' else product}{text[number.end() :]}".strip() or "1"
    glue = "" if re.fullmatch(r"\d+(\.\d+)?", factor) and not number else " "
    return f"{factor}{glue}{text}"


def _transposed(pieces: Iterable[_Piece]) -> list[str]:
    """Return the transposed summands, those with a common factor in one bracket."""
    groups: dict[str, list[str]] = {}
    for piece in pieces:
        groups.setdefault(piece.factor, []).append(piece.text)
    return [_times(factor, _transpose(texts)) for factor, texts in groups.items()]


def _transpose(texts: Sequence[str]) -> str:
    r"""Return the transpose of a sum; a symbol alone, or its transpose, needs no bracket."""
    text = _sum(texts)
    if len(texts) == 1 and text.startswith("-"):
        return f"-{_transpose([text[1:].lstrip()])}"
    simple = r"(\\\w+ ?)?\{?\w+\}?(_\{?\w+\}?)?"
    if re.fullmatch(simple, text):
        return rf"{text}^\top"
    if re.fullmatch(simple + r"\^\\top", text):
        return text.removesuffix(r"^\top")
    return rf"({text})^\top"


def _sum(summands: Sequence[str]) -> str:
    text = ""
    for summand in summands:
        if not text:
            text = summand
        elif summand.startswith("-"):
            text += f" - {summand[1:].lstrip()}"
        else:
            text += f" + {summand}"
    return text
