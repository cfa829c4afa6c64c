"""A condition as a formula with letters for its sizes, from the object that is solved."""

from __future__ import annotations

import re
from dataclasses import replace

from catalogue.entry import Sizes
from takagi.lmi import LMI, Condition, latex

# A line that every condition has, and the head of the page mentions once: V > 0, and its scale.
UNDERSTOOD = re.compile(
    r"^\\text\{(?:(\w) positive definite:\} \\quad & \1 \\succ 0"
    r"|scale of \w:\} \\quad & \w \\preceq (?:1000 )?I)(?: \\\\)?$"
)

# A double sum by all pairs of rules: the head of the page says what its two lines are.
RULE = re.compile(r"(rule:\} \\quad & )")
PAIR = re.compile(r"pair:\} \\quad & ")
# A line with i holds for every rule.
EVERY_RULE = re.compile(r", \\quad i = 1, (?:\\dots, r|2)(?= \\\\$|$)", re.MULTILINE)

# LMIs that come once for each corner of the rates, or for each next rule.
REPEATED = re.compile(r"^(?:rates|next rule|step) (\d+)\b")


def counts(condition: Condition) -> tuple[int, int]:
    """Return how many LMIs (cones) and how many scalar variables a condition has."""
    return (
        sum(lmi.count for lmi in condition.lmis),
        sum(unknown.length for unknown in condition.unknowns),
    )


def formula(condition: Condition, sizes: Sizes) -> str:
    """Return the body of a display: objective, unknowns, and one LMI a line.

    Raises
    ------
    ValueError : a size that has no letter.
    """
    return body(condition, sizes, declare=True)


def body(condition: Condition, sizes: Sizes, *, declare: bool) -> str:
    """Return ``formula``, or the LMIs alone."""
    shown, repeats = _first_of_each(condition.lmis)
    text = latex(replace(condition, lmis=shown)).replace("align*", "aligned")
    if not declare:
        text = re.sub(r"^\\text\{find\}.*\n", "", text, flags=re.MULTILINE)
    text = _without_the_understood(text)
    if declare:
        text = _without_pairs(text)
    if repeats:
        lines = text.splitlines()
        lines[-2:-1] = [lines[-2] + r" \\", rf"& \quad \text{{and so on for each of {repeats}}}"]
        text = "\n".join(lines)
    text = _with_letters(text, sizes)
    return EVERY_RULE.sub("", text) if declare else text


def changes(text: str, first: str) -> str:
    """Return the body with the lines alone that the first one has not."""
    rows = " \\\\\n".join(line for line in _lines(text) if line not in _lines(first))
    return f"\\begin{{aligned}}\n{rows}\n\\end{{aligned}}"


def _lines(text: str) -> list[str]:
    return [line.removesuffix(r" \\") for line in text.splitlines()[1:-1]]


def _without_the_understood(text: str) -> str:
    """Return the text without V > 0 and its scale."""
    lines = [line for line in text.splitlines() if not UNDERSTOOD.match(line)]
    # The last line of LMIs ends without a new line.
    lines[-2] = lines[-2].removesuffix(r" \\")
    return "\n".join(lines)


def _without_pairs(text: str) -> str:
    r"""Return the text with \Theta_{ii} in the line of a rule, and no line for the pairs."""
    lines: list[str] = []
    for line in text.splitlines():
        if PAIR.search(line) and RULE.search(lines[-1]):
            lines[-1] = RULE.sub(r"\1\\Theta_{ii} = ", lines[-1])
        else:
            lines.append(line)
    # The last line of LMIs ends without a new line.
    lines[-2] = lines[-2].removesuffix(r" \\")
    return "\n".join(lines)


def _first_of_each(lmis: tuple[LMI, ...]) -> tuple[tuple[LMI, ...], str]:
    """Return the LMIs without repetitions, and how many of what there are."""
    shown, last, what = [], 0, ""
    for lmi in lmis:
        found = REPEATED.match(lmi.name)
        if found and int(found[1]) > 1:
            last, what = max(last, int(found[1])), found[0].removesuffix(f" {found[1]}")
            continue
        shown.append(lmi)
    names = {"rates": "corners of the rates", "next rule": "next rules", "step": "steps"}
    return tuple(shown), f"the {last} {names[what]}" if last else ""


def _with_letters(text: str, sizes: Sizes) -> str:
    letters = sizes.letters

    def lettered(found: re.Match[str]) -> str:
        numbers = re.sub(r"\d+", lambda one: _letter(int(one[0]), letters), found[2])
        return f"{found[1]}{numbers}{found[3]}"

    text = re.sub(r"(\\mathbb\{[SR]\}\^\{)([^}]*)(\})", lettered, text)
    text = re.sub(r"(\\dots, (?:\S*?_\{(?:\d+,)?)?)(\d+)()", lettered, text)
    return re.sub(r"(j \\le )(\d+)()", lettered, text)


def _letter(number: int, letters: dict[int, str]) -> str:
    if number <= 2:
        return str(number)
    if number not in letters:
        raise ValueError(f"{number} has no letter; name it in Sizes.letters")
    return letters[number]
