"""Draws what OpenFAST measured of the default law and of others, and prints the tables of it.

    python benchmarks/openfast_table.py            docs/figures/openfast-table.svg
    python benchmarks/openfast_table.py --table    the tables of docs/openfast.md, printed

The numbers stand in docs/figures/openfast-table.csv, one row for each mean wind and controller;
OpenFAST itself is run by hand, see docs/openfast.md.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
# Colours of Okabe and Ito, told apart by the colour-blind; a marker of its own for each.
LINES = {
    "takagi": ("#0072B2", "o", "-"),
    "ROSCO": ("#D55E00", "s", "--"),
    "reference": ("#000000", "^", ":"),
}
AXES = {
    "tower_del_MNm": "tower-base fatigue\nDEL [MN m]",
    "pitch_travel_deg": "pitch travel\nin 600 s [deg]",
    "power_kW": "mean power over that of\nthe reference controller [%]",
}
COMPARED = "reference"
# What a cell of the tables holds, in this order, and the columns of each table.
CELL = ("takagi", "ROSCO", "ROSCO with peak shaving", "reference")
TABLES = (
    {
        "power_kW": "power [kW]",
        "peak_power_percent": "peak power [% of rated]",
        "largest_speed_rpm": "largest speed [rpm]",
        "pitch_travel_deg": "pitch travel [deg]",
    },
    {
        "tower_del_MNm": "tower-base DEL [MN m]",
        "blade_del_MNm": "blade root DEL [MN m]",
        "shaft_del_MNm": "shaft DEL [MN m]",
    },
)

Row = dict[str, str]


def measured() -> list[Row]:
    """Return the rows of the file, with their numbers as they are written there."""
    with (FIGURES / "openfast-table.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def table(rows: list[Row], columns: dict[str, str]) -> str:
    """Return the rows as a table in Markdown: a line a wind, in a cell one number a controller."""
    lines = [
        f"| mean wind [m/s] | {' | '.join(columns.values())} |",
        "|" + "---|" * (len(columns) + 1),
    ]
    for wind in dict.fromkeys(row["mean_wind_mps"] for row in rows):
        at = {row["controller"]: row for row in rows if row["mean_wind_mps"] == wind}
        cells = [" / ".join(at[name][column] for name in CELL) for column in columns]
        lines.append(f"| {wind} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def draw(rows: list[Row]) -> None:
    """Draw a panel for each quantity over the mean wind."""
    import matplotlib as mpl

    mpl.use("svg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"svg.hashsalt": "openfast", "font.size": 9, "svg.fonttype": "none"})
    figure, axes = plt.subplots(1, len(AXES), figsize=(9.0, 2.9), layout="constrained")
    for axis, (column, title) in zip(axes, AXES.items(), strict=True):
        for name, (colour, marker, style) in LINES.items():
            own = [row for row in rows if row["controller"] == name]
            x = [float(row["mean_wind_mps"]) for row in own]
            y = [float(row[column]) for row in own]
            if column == "power_kW":
                other = [float(row[column]) for row in rows if row["controller"] == COMPARED]
                y = [100 * (a / b - 1) for a, b in zip(y, other, strict=True)]
            axis.plot(x, y, color=colour, marker=marker, ls=style, ms=4, label=name)
        axis.set_xlabel("mean wind [m/s]")
        axis.set_ylabel(title)
        if column != "power_kW":
            axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    axes[1].legend(frameon=False)
    figure.savefig(FIGURES / "openfast-table.svg", metadata={"Date": None})


def main() -> None:
    """Print the table, or draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--table", action="store_true", help="print the table, draw nothing")
    if parser.parse_args().table:
        print("\n".join(table(measured(), columns) for columns in TABLES), end="")
    else:
        draw(measured())


if __name__ == "__main__":
    main()
