"""Measures one step of exported laws in C, and writes a table into docs/benchmarks.md.

    python benchmarks/c_step.py GAINS...

compiles each gain file's law, and the baseline law of the NREL 5-MW turbine, with ``cc -O2`` in
double and in float, and calls it with inputs that wander through their ranges.  The median is of
batches of 100 steps.  The longest is of single steps, less what an empty call with its clock takes,
and so holds what else the machine did; 99.9 % of the steps were shorter than the last column says.
Nothing is asserted.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measure import PAGE, placed, reduced, table

from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.c.source import c_source, wave
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import ExportSettings, Precision

HARNESS = r"""
#define _POSIX_C_SOURCE 199309L
#include HEADER
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#define JOIN2(a, b) a##b
#define JOIN(a, b) JOIN2(a, b)
#define F(name) JOIN(W, name)
#define STEPS 400000
#define BATCH 100

static double given[ROWS][INPUTS] = { GIVEN };
static double single[STEPS];
static double batches[STEPS / BATCH];

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static int order(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static union { F(_inputs) values; F(_real) each[INPUTS]; } in[ROWS];

int main(void)
{
    F(_state) state;
    F(_outputs) out;
    double empty[1001];
    volatile double sink = 0;
    int j, k;
    for (k = 0; k < ROWS; k++) {
        for (j = 0; j < INPUTS; j++) {
            in[k].each[j] = (F(_real))given[k][j];
        }
    }
    for (k = 0; k < 1001; k++) {
        const double start = now();
        empty[k] = now() - start;
    }
    qsort(empty, 1001, sizeof *empty, order);
    F(_init)(&state, (F(_real))TIME);
    for (k = 0; k < STEPS; k++) {
        const double start = now();
        F(_step)(&state, &in[k % ROWS].values, &out);
        single[k] = now() - start - empty[500];
        sink += (double)*(F(_real) *)&out;
    }
    for (k = 0; k < STEPS / BATCH; k++) {
        const double start = now();
        for (j = 0; j < BATCH; j++) {
            F(_step)(&state, &in[j % ROWS].values, &out);
        }
        batches[k] = (now() - start) / BATCH;
        sink += (double)*(F(_real) *)&out;
    }
    qsort(single, STEPS, sizeof *single, order);
    qsort(batches, STEPS / BATCH, sizeof *batches, order);
    printf("%.1f %.1f %.1f\n", batches[STEPS / BATCH / 2], single[STEPS - 1 - STEPS / 1000],
           single[STEPS - 1]);
    return 0;
}
"""
ROWS = 100


def main(paths: list[str]) -> None:
    """Measure, print the table and write it into the page."""
    programs = [baseline_program(load_turbine("nrel5mw"))]
    programs += [read_controller(Path(path)) for path in paths]
    rows = [row for program in programs for row in _rows(program)]
    heads = ("law", "numbers", "median [ns]", "times a Python step", "longest [ns]", "99.9 % [ns]")
    text = table(heads, rows)
    print(text)
    short = reduced(text, (0, 2, 5), ("double",))
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "c-step", short), encoding="utf-8")


def _rows(program: ControllerProgram) -> list[tuple[str, ...]]:
    python = _python_step(program)
    found: list[tuple[str, ...]] = []
    for precision in ("double", "float"):
        median, most, longest = _measured(program, precision)
        found.append(
            (
                program.name,
                precision,
                f"{median:.0f}",
                f"1/{python / median:.0f}",
                f"{longest:.0f}",
                f"{most:.0f}",
            )
        )
    return found


def _given(program: ControllerProgram) -> list[dict[str, float]]:
    return [
        {one.name: wave(one, k, j) for j, one in enumerate(program.inputs)} for k in range(ROWS)
    ]


def _python_step(program: ControllerProgram) -> float:
    """Return the time of a step of the same program in Python [ns]."""
    run, given = ProgramRun(program), _given(program)
    run.sample(0.02, given[0])
    start = time.perf_counter_ns()
    for one in given:
        run.sample(0.02, one)
    return (time.perf_counter_ns() - start) / len(given)


def _measured(program: ControllerProgram, precision: Precision) -> list[float]:
    c = c_source(program, ExportSettings(precision))
    rows = ",\n".join(
        "{" + ", ".join(repr(value) for value in one.values()) + "}" for one in _given(program)
    )
    harness = HARNESS.replace("GIVEN", rows)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, text in ((f"{c.word}.h", c.header), (f"{c.word}.c", c.source),
                           ("harness.c", harness)):  # fmt: skip
            (folder / name).write_text(text, encoding="utf-8")
        subprocess.run(
            ["cc", "-std=c99", "-O2", "-ffp-contract=off", f"-DW={c.word}",
             f'-DHEADER="{c.word}.h"', f"-DROWS={ROWS}", f"-DINPUTS={len(program.inputs)}",
             f"-DTIME={c.sample_time}", f"{c.word}.c", "harness.c", "-o", "harness", "-lm"],
            cwd=folder, check=True,
        )  # fmt: skip
        done = subprocess.run([str(folder / "harness")], capture_output=True, text=True, check=True)
    return [float(word) for word in done.stdout.split()]


if __name__ == "__main__":
    main(sys.argv[1:])
