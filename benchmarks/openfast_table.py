"""Draws what OpenFAST measured of the default law and of others: docs/figures/openfast-table.svg.

    python benchmarks/openfast_table.py

The numbers stand in docs/figures/openfast-table.csv, one row for each mean wind and controller, as
docs/openfast.md has them; OpenFAST itself is run by hand, see there.
"""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")

import matplotlib.pyplot as plt  # noqa: E402

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
# Colours of Okabe and Ito, told apart by the colour-blind; a marker of its own for each.
LINES = {
    "takagi": ("#0072B2", "o", "-"),
    "ROSCO": ("#D55E00", "s", "--"),
    "published": ("#000000", "^", ":"),
}
AXES = {
    "tower_del_MNm": "tower-base fatigue\nDEL [MN m]",
    "pitch_travel_deg": "pitch travel\nin 600 s [deg]",
    "power_kW": "mean power over that of\nthe published controller [%]",
}
COMPARED = "published"


def main() -> None:
    """Read the rows and draw a panel for each quantity over the mean wind."""
    with (FIGURES / "openfast-table.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
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


if __name__ == "__main__":
    main()
