"""Measures how processor time and memory of the LMI layer grow with states, rules and vertices.

    python benchmarks/lmi_growth.py        writes docs/figures/lmi-growth.svg and .csv, and a table

Each point is a process of its own, on one thread, so that its peak memory is its own; a straight
line is fitted in the logarithms of the upper half of each series: its slope is the exponent.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402  the threads are counted when numpy is loaded
from measure import PAGE, placed, reduced, table  # noqa: E402
from problems import scattered_rules, stable_vertices  # noqa: E402

from takagi.reports.figures.style import (  # noqa: E402
    COLOURS,
    figure_to_svg,  # noqa: E402
    house_style,
    new_figure,
)

FIGURES = Path(__file__).resolve().parents[1] / "docs" / "figures"
SEED = 1
# Small enough that gains exist for sixteen states too.
SPREAD = 2e-3


class Series(NamedTuple):
    """What grows: the sizes, and what else is fixed."""

    name: str
    axis: str
    sizes: tuple[int, ...]
    fixed: dict[str, int]


SERIES = (
    Series(
        "common Lyapunov, n = 6",
        "vertices",
        (64, 256, 1024, 4096, 16_384, 65_536),
        {"states": 6},
    ),
    Series("common Lyapunov, 64 vertices", "states", (4, 6, 8, 12, 16, 24), {"vertices": 64}),
    Series("PDC, all pairs, n = 4, m = 2", "rules", (4, 8, 16, 32, 64), {"states": 4}),
    Series("PDC, all pairs, 8 rules, m = 2", "states", (4, 6, 8, 12, 16), {"rules": 8}),
)


def main() -> None:
    """Measure every point; write figure, data and table."""
    if len(sys.argv) == 3 and sys.argv[1] == "--child":
        print(json.dumps(point(json.loads(sys.argv[2]))))
        return
    rows = []
    for series in SERIES:
        for size in series.sizes:
            given = {**series.fixed, series.axis: size}
            command = [sys.executable, __file__, "--child", json.dumps(given)]
            ran = subprocess.run(command, check=True, capture_output=True, text=True)
            found = json.loads(ran.stdout.splitlines()[-1])
            rows.append((series, size, found["seconds"], found["peak"]))
            print(f"  {series.name}, {size} {series.axis}: {found['seconds']:.3f} s", flush=True)
    _write_data(rows)
    (FIGURES / "lmi-growth.svg").write_text(_figure(rows), encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    found = _table(rows)
    short = reduced(found, (0, 1, 2, 3))
    PAGE.write_text(placed(text, "layer growth", short), encoding="utf-8")
    print(found)


def point(given: dict[str, int]) -> dict[str, float]:
    """Return the public call's processor time [s], and the peak memory above the start."""
    import resource

    from takagi.lmi import common_lyapunov, pdc
    from takagi.models import TSModel

    def peak() -> float:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    if "vertices" in given:
        A = stable_vertices(given["vertices"], given["states"], SEED)
        common_lyapunov(A[:2])
        before, began = peak(), time.process_time()
        answer: Any = common_lyapunov(A)
    else:
        model = TSModel(*scattered_rules(given["rules"], given["states"], 2, SEED, SPREAD))
        pdc(TSModel(model.A[:2], model.B[:2]), decay_rate=0.1)
        before, began = peak(), time.process_time()
        answer = pdc(model, decay_rate=0.1)
    spent = time.process_time() - began
    assert answer.found, f"{given}: {answer.status}"
    return {"seconds": spent, "peak": peak() - before}


def exponent(sizes: list[int], values: list[float]) -> float:
    """Return the slope of the logarithms over the upper half of the sizes."""
    half = len(sizes) // 2
    x, y = np.log(sizes[half - 1 :]), np.log(np.maximum(values[half - 1 :], 1e-9))
    return float(np.polyfit(x, y, 1)[0])


def _of(rows: list[Any], series: Series) -> tuple[list[int], list[float], list[float]]:
    mine = [row for row in rows if row[0] is series]
    return [row[1] for row in mine], [row[2] for row in mine], [row[3] for row in mine]


def _write_data(rows: list[Any]) -> None:
    with (FIGURES / "lmi-growth.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("question", "what grows", "size", "time [s]", "memory above start [MiB]"))
        for series, size, spent, peak in rows:
            writer.writerow((series.name, series.axis, size, f"{spent:.4g}", f"{peak:.4g}"))


def _table(rows: list[Any]) -> str:
    lines = []
    for series in SERIES:
        sizes, spent, peak = _of(rows, series)
        large = peak[-1] > 20
        lines.append(
            (
                f"{series.name}: {sizes[0]} to {sizes[-1]} {series.axis}",
                f"{spent[0]:.3g} to {spent[-1]:.3g} s",
                f"{exponent(sizes, spent):.1f}",
                f"{peak[-1]:.0f} MiB",
                f"{exponent(sizes, peak):.1f}" if large else "-",
            )
        )
    heads = (
        "what grows",
        "processor time",
        "exponent of time",
        "memory, largest",
        "exponent of memory",
    )
    return table(heads, lines)


def _figure(rows: list[Any]) -> str:
    with house_style():
        figure, axes = new_figure(2, 2, height=6.0)
        for series, colour, ax in zip(SERIES, COLOURS, axes, strict=False):
            sizes, spent, peak = _of(rows, series)
            label = f"time, exponent {exponent(sizes, spent):.1f}"
            ax.loglog(sizes, spent, "o-", color=colour, label=label)
            ax.set_title(series.name)
            ax.set_xlabel(f"{series.axis} [-]")
            ax.set_ylabel("time [s]")
            beside = ax.twinx()
            beside.loglog(sizes, np.maximum(peak, 0.1), "s--", color="#666666", label="memory")
            beside.set_ylabel("memory above start [MiB]")
            beside.grid(False)
            # Last: the second axis sets the ticks that both share anew.
            ax.set_xticks(sizes, [str(size) for size in sizes])
            ax.minorticks_off()
            beside.minorticks_off()
            lines = [*ax.get_lines(), *beside.get_lines()]
            ax.legend(lines, [str(line.get_label()) for line in lines], loc="upper left")
        return figure_to_svg(
            figure,
            name="lmi-growth",
            description="Time and memory of the LMI layer against vertices, rules and states",
        )


if __name__ == "__main__":
    main()
