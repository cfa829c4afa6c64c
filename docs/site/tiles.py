"""Write docs/gallery.md and its pictures from designs: python docs/site/tiles.py

One tile a built-in plant: the proved set in the plane of two states, with simulated motions.
Designs are read from build/tiles; those that are not there are made first (ten minutes for all).
"""

from __future__ import annotations

import subprocess
import sys
from html import escape
from pathlib import Path

import numpy as np
import numpy.typing as npt

from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.files.library import built_in_kinds, built_in_models
from takagi.models.plant.plant import file_unit
from takagi.reports.design_folder import read_design
from takagi.reports.figures.plant.proved_set import ellipse, planes, section
from takagi.reports.loops.plant_loop import PlantLoop, plant_loop
from takagi.reports.loops.plant_motion import around, motions

ROOT = Path(__file__).resolve().parents[2]
DESIGNS = ROOT / "build" / "tiles"
PICTURES = ROOT / "docs" / "figures" / "tiles"
PAGE = ROOT / "docs" / "gallery.md"
FIRST, LAST = "<!-- tiles: made by docs/site/tiles.py -->\n", "<!-- end tiles -->"

WIDTH, HEIGHT, EDGE = 320, 220, 22
POINTS = 70  # of a motion
MOTIONS = 8
Points = npt.NDArray[np.float64]


def main() -> None:
    """Design what is not designed, then write the pictures and the page."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    kinds = built_in_kinds()
    tiles = []
    for name, about in sorted(built_in_models()):
        if kinds[name] == "plant":
            design = designed(name)
            (PICTURES / f"{name}.svg").write_text(picture(design), encoding="utf-8")
            tiles.append(tile(name, about, design))
    text = PAGE.read_text(encoding="utf-8")
    before, _, remaining = text.partition(FIRST)
    _, _, after = remaining.partition(LAST)
    PAGE.write_text(f"{before}{FIRST}\n" + "\n".join(tiles) + f"\n{LAST}{after}", encoding="utf-8")


def designed(name: str) -> PlantDesign:
    """Return the design of a built-in plant."""
    folder = DESIGNS / name
    if not (folder / "design.json").is_file():
        command = [
            str(Path(sys.executable).parent / "takagi"),
            "design",
            name,
            "--out",
            str(folder),
        ]
        subprocess.run([*command, "--no-report"], check=False, stdout=subprocess.DEVNULL)
    design = read_design(folder)
    assert isinstance(design, PlantDesign)
    return design


def tile(name: str, about: str, design: PlantDesign) -> str:
    """Return one tile of the page, in Markdown."""
    first, second = drawn_states(plant_loop(design))
    alt = f"Motions and set: {first}, {second}"
    verdict = "PROVED" if design.proved else "not proved"
    return (
        f"-   [![{alt}](figures/tiles/{name}.svg)](../models/data/{name}.toml)\n\n"
        f"    **{design.plant.name}**, `{name}`, {verdict}.\n    {about}.\n"
    )


def drawn_states(loop: PlantLoop) -> tuple[str, str]:
    """Return the two states of the picture, with units."""
    i, j = planes(loop)[0]
    units = [file_unit(loop.plant.states[k])[1] for k in (i, j)]
    return f"{loop.names[i]} [{units[0]}]", f"{loop.names[j]} [{units[1]}]"


def picture(design: PlantDesign) -> str:
    """Return the tile's SVG: safe starts filled, the set dashed, motions, ranges dotted."""
    loop = plant_loop(design)
    pair = planes(loop)[0]
    sizes = np.array([[file_unit(loop.plant.states[k])[0]] for k in pair])
    drawn = motions(loop, around(loop, MOTIONS))
    shown = [shortened(motion.state[:, pair].T / sizes) for motion in drawn]
    borders = []
    if loop.bounded:
        P, level = loop.ellipsoid
        starts, _ = loop.start_ellipsoid
        borders = [section(starts, level, pair) / sizes, ellipse(P, level, pair) / sizes]
    reach = np.max([np.abs(points).max(axis=1) for points in (*shown, *borders)], axis=0)
    scale = np.array([(WIDTH - 2 * EDGE) / 2, (HEIGHT - 2 * EDGE) / 2]) / (1.06 * reach)

    def path(points: Points, **style: str) -> str:
        x = WIDTH / 2 + scale[0] * points[0]
        y = HEIGHT / 2 - scale[1] * points[1]
        words = " ".join(f'{key.replace("_", "-")}="{value}"' for key, value in style.items())
        spots = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        return f'<polyline points="{spots}" {words}/>'

    parts = []
    if borders:
        parts += [
            path(borders[0], fill="#CFE3F1", stroke="#0072B2", stroke_width="2"),
            path(
                borders[1], fill="none", stroke="#D55E00", stroke_width="2", stroke_dasharray="7 4"
            ),
        ]
    parts += [path(p, fill="none", stroke="#333333", stroke_width="1") for p in shown]
    words = drawn_states(loop)
    parts += [
        f'<circle cx="{WIDTH / 2:g}" cy="{HEIGHT / 2:g}" r="3" fill="#000000"/>',
        f'<text x="{WIDTH - 6}" y="{HEIGHT - 7}" text-anchor="end">{escape(words[0])}</text>',
        f'<text x="6" y="15">{escape(words[1])}</text>',
    ]
    title = escape(f"{design.plant.name}: {words[0]} and {words[1]}")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'font-family="sans-serif" font-size="13" fill="#1a1a1a"><title>{title}</title>'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>\n'
        + "\n".join(parts)
        + "</svg>\n"
    )


def shortened(state: Points) -> Points:
    """Return a few points of a motion (2, samples), evenly apart on the picture."""
    steps = np.hypot(*(np.diff(state) / np.abs(state).max(axis=1, keepdims=True)))
    length = np.concatenate([[0.0], np.cumsum(steps)])
    places = np.searchsorted(length, np.linspace(0.0, length[-1], POINTS))
    return np.asarray(state[:, np.unique(np.minimum(places, state.shape[1] - 1))])


if __name__ == "__main__":
    main()
