"""Write a condition in LaTeX, from the same terms that are solved."""

from __future__ import annotations

from collections.abc import Sequence

from takagi.lmi.term import LMI, Condition, Position, Term
from takagi.lmi.unknown import Unknown

__all__ = ["latex", "lmi_latex"]


def latex(condition: Condition) -> str:
    """Return the condition as an ``align*`` environment (amsmath): objective, then one LMI a line.

    He(X) stands for X + X^T, an asterisk for the block that symmetry implies.
    """
    lines = [rf"\text{{find}} \quad & {', '.join(_declared(u) for u in condition.unknowns)}"]
    if condition.objective:
        cost = " + ".join(_cost(u) for u in condition.unknowns if u.name in condition.objective)
        lines.insert(0, rf"\text{{minimise}} \quad & {cost}")
        lines[1] = lines[1].replace("find", "over")
    lines += [
        rf"{_label(lmi)} \quad & {lmi_latex(lmi)}" + (rf", \quad {lmi.index}" if lmi.index else "")
        for lmi in condition.lmis
    ]
    body = " \\\\\n".join(lines)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}"


def lmi_latex(lmi: LMI) -> str:
    """Return one LMI, e.g. ``He(P A_i) + 2 alpha P < 0``; a block matrix when it has blocks."""
    relation = _relation(lmi)
    size = len(lmi.blocks)
    if size == 1:
        return f"{_block(lmi, ((0, 0), None))} {relation} 0"
    rows = [
        " & ".join(_block(lmi, ((i, j),)) if i <= j else r"\ast" for j in range(size))
        for i in range(size)
    ]
    matrix = r" \\ ".join(rows)
    whole = _block(lmi, (None,))
    total = _sum(
        [rf"\begin{{bmatrix}} {matrix} \end{{bmatrix}}", *([] if whole == "0" else [whole])]
    )
    return f"{total} {relation} 0"


def _relation(lmi: LMI) -> str:
    strict = lmi.weight > 0
    if lmi.sign > 0:
        return r"\succ" if strict else r"\succeq"
    return r"\prec" if strict else r"\preceq"


def _label(lmi: LMI) -> str:
    return rf"\text{{{lmi.name}:}}"


def _declared(unknown: Unknown) -> str:
    if unknown.scalar:
        space = r"\mathbb{R}"
    elif unknown.symmetric:
        space = rf"\mathbb{{S}}^{{{unknown.rows}}}"
    else:
        space = rf"\mathbb{{R}}^{{{unknown.rows} \times {unknown.cols}}}"
    many = "" if unknown.count == 1 else rf"_1, \dots, {unknown.symbol}_{{{unknown.count}}}"
    return rf"{unknown.symbol}{many} \in {space}"


def _cost(unknown: Unknown) -> str:
    if unknown.scalar and unknown.count == 1:
        return unknown.symbol
    return rf"\langle C_{{{unknown.symbol}}}, {unknown.symbol} \rangle"


def _block(lmi: LMI, places: tuple[Position | None, ...]) -> str:
    """Return the sum in one block; a block kept below the diagonal is written transposed."""
    mirrors = [place[::-1] for place in places if place is not None and place[0] != place[1]]
    he: list[str] = []
    plain: list[str] = []
    for term in lmi.terms:
        if term.at in places:
            (he if term.plus_transpose else plain).append(_product(term))
        elif term.at in mirrors:
            plain.append(_transposed(term))
    for constant in lmi.constants:
        if constant.at in places:
            plain.append(constant.latex or "C")
        elif constant.at in mirrors:
            plain.append(rf"({constant.latex or 'C'})^\top")
    parts = [rf"\mathrm{{He}}\left({_sum(he)}\right)"] if he else []
    return _sum([*parts, *plain]) if parts or plain else "0"


def _product(term: Term) -> str:
    before, behind = term.latex
    symbol = term.symbol or term.unknown.symbol
    return " ".join(part for part in (before, symbol, behind) if part)


def _transposed(term: Term) -> str:
    before, behind = term.latex
    symbol = term.symbol or term.unknown.symbol
    if not before and not behind:
        return symbol if term.unknown.symmetric else rf"{symbol}^\top"
    return rf"({_product(term)})^\top"


def _sum(parts: Sequence[str]) -> str:
    text = ""
    for part in parts:
        if not text:
            text = part
        elif part.startswith("-"):
            text += f" - {part[1:].lstrip()}"
        else:
            text += f" + {part}"
    return text
