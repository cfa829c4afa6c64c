"""The picture of floors and rooms in docs/architecture.md."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from graphlib import TopologicalSorter
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Each may import those that stand after it.
FLOORS = ("cli", "reports", "certificates", "lmi", "models")
# Folders of files that are no code of their own.
DATA = ("templates", "data")

WIDTH, EDGE, GAP = 720, 6, 6
LETTER, PAD, LINE, BOX = 6.5, 8, 22, 24
INK, PAPER, FRAME = "#1a1a1a", "#ffffff", "#8a8a8a"
# One fill for each floor, by Paul Tol's "pale" scheme, which colour-blind readers can tell apart.
FILLS = dict(zip(FLOORS, ("#eeeebb", "#ffcccc", "#bbccee", "#ccddaa", "#dddddd"), strict=True))


@dataclass(frozen=True, slots=True)
class Room:
    """A folder of code.

    Attributes
    ----------
    path : from the root, e.g. ``lmi/gains/decay``.
    about : the first line of its ``__init__`` docstring.
    """

    path: str
    about: str


def rooms(floor: str) -> list[Room]:
    """Return a floor and its rooms, each before those inside it."""
    found = []
    for init in sorted((ROOT / floor).rglob("__init__.py"), key=lambda path: path.parent.parts):
        folder = init.parent
        if folder.name in DATA:
            continue
        about = (ast.get_docstring(ast.parse(init.read_text(encoding="utf-8"))) or "").split("\n")
        found.append(Room(folder.relative_to(ROOT).as_posix(), about[0]))
    return found


def picture() -> str:
    """Return the floors as bands of an SVG; a room stands above all rooms that it imports."""
    parts: list[str] = []
    top = EDGE
    for floor in FLOORS:
        band, height = _band(floor, top)
        parts += band
        top += height + GAP
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {top + EDGE - GAP}" '
        'font-family="sans-serif" role="img" aria-label="Floors and rooms of takagi: '
        'a floor imports those below it, a room those that stand lower in its floor">'
    )
    return "\n".join([head, *parts, "</svg>"]) + "\n"


def _band(floor: str, top: int) -> tuple[list[str], int]:
    """Return a floor's shapes and its height."""
    boxes: list[str] = []
    line = top + LINE + GAP
    for level in reversed(_levels(imports_within(floor))):
        left = EDGE + 2 * PAD
        for room in sorted(level):
            label, count = _label(floor, room)
            wide = round((len(label) + len(count)) * LETTER) + 2 * PAD
            if left + wide > WIDTH - EDGE - PAD:
                left, line = EDGE + 2 * PAD, line + BOX + GAP
            boxes.append(_box(left, line, wide, label, count))
            left += wide + GAP
        line += BOX + GAP
    height = line - top
    frame = (
        f'<rect x="{EDGE}" y="{top}" width="{WIDTH - 2 * EDGE}" height="{height}" rx="4" '
        f'fill="{FILLS[floor]}" stroke="{FRAME}"/>'
    )
    about = rooms(floor)[0].about
    title = (
        f'<text x="{EDGE + PAD}" y="{top + 19}" font-size="13" fill="{INK}">'
        f'<tspan font-weight="bold">{floor}</tspan>  {escape(about)}</text>'
    )
    return [frame, title, *boxes], height


def _box(left: int, top: int, wide: int, label: str, count: str) -> str:
    return (
        f'<rect x="{left}" y="{top}" width="{wide}" height="{BOX}" rx="3" fill="{PAPER}" '
        f'stroke="{FRAME}"/>'
        f'<text x="{left + wide / 2:g}" y="{top + 16}" font-size="12" text-anchor="middle" '
        f'fill="{INK}">{label}<tspan font-size="10">{count}</tspan></text>'
    )


def _label(floor: str, room: str) -> tuple[str, str]:
    """Return a room's name and the number of modules in it and inside; a module's file name."""
    folder = ROOT / floor / room
    if not folder.is_dir():
        return f"{room}.py", ""
    return room, f" {sum(1 for path in folder.rglob('*.py') if path.name != '__init__.py')}"


def _levels(graph: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Return the rooms in levels, lowest first: each imports only rooms of lower levels."""
    height: dict[str, int] = {}
    for room in TopologicalSorter(graph).static_order():
        height[room] = 1 + max((height[below] for below in graph[room]), default=-1)
    levels: list[list[str]] = [[] for _ in range(1 + max(height.values()))]
    for room, level in height.items():
        levels[level].append(room)
    return levels


def imports_within(floor: str) -> dict[str, set[str]]:
    """Return room -> the other rooms of its floor that it imports, anywhere, also for types alone.

    A module in the floor's root counts as a room.
    """
    graph: dict[str, set[str]] = {}
    for module, imported in modules(floor).items():
        room = module.split(".")[2]
        used = {name.split(".")[2] for name in imported}
        graph.setdefault(room, set()).update(used - {room})
    return graph


@cache
def modules(floor: str) -> dict[str, set[str]]:
    """Return module -> modules of the same floor that it imports; ``__init__`` files aside."""
    paths = {
        ".".join(("takagi", *path.relative_to(ROOT).with_suffix("").parts)): path
        for path in sorted((ROOT / floor).rglob("*.py"))
        if path.name != "__init__.py"
    }
    return {
        module: {name for name in _imported(path) if name in paths and name != module}
        for module, path in paths.items()
    }


def _imported(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            # `from takagi.lmi.gains import observer` may name a module.
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
