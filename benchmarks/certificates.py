"""Measures what a proof costs beside the solve, and how fast the checker is.

    python benchmarks/certificates.py        writes a table into docs/benchmarks.md

``proof`` is one replay of the claim by the checker, the reading of model and gains included;
``file`` is to write it; ``check`` is to read the file and replay it.  ``share`` is proof and file
over the solve that found the gains, or the function where there are none.  Nothing is asserted:
times depend on the machine.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402  the threads are counted when numpy is loaded
from measure import PAGE, placed, reduced, table  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

from takagi.certificates import certify  # noqa: E402
from takagi.certificates.checker import check  # noqa: E402
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import max_decay_rate, pdc  # noqa: E402
from takagi.models import Premise, TSModel  # noqa: E402

Floats = NDArray[np.float64]
SEED = 1
REPEATS = 5


class Case(NamedTuple):
    """A loop, and the solve whose result is proved: it returns the gains."""

    name: str
    model: TSModel
    solve: Callable[[TSModel], Floats | None]


def main() -> None:
    """Measure, and write the table into the page; print it too."""
    rows = [measured(case) for case in cases()]
    heads = ("loop", "inequalities", "solve", "proof", "file", "share", "check", "size")
    found = table(heads, rows)
    print(found)
    short = reduced(found, (0, 2, 3, 6, 7))
    text = placed(PAGE.read_text(encoding="utf-8"), "certificates", short)
    PAGE.write_text(text, encoding="utf-8")


def cases() -> list[Case]:
    """Return the loops: a design without and with premises, and many vertices of an analysis."""
    rng = np.random.default_rng(SEED)
    n = 6
    A = np.diag(np.ones(n - 1), 1) + rng.normal(size=(n, n)) * 0.1
    A = A + rng.normal(size=(16, n, n)) * 0.02
    B = np.eye(n)[:, -1:] + rng.normal(size=(16, n, 1)) * 0.02
    premises = [Premise(f"z{k}", "-1", "1") for k in range(1, 5)]
    many = rng.normal(size=(1024, 8, 8)) * 0.05 + rng.normal(size=(8, 8)) * 0.3 - 3 * np.eye(8)
    return [
        Case("16 rules, n = 6", TSModel(A, B), designed),
        Case("16 rules of 4 premises, n = 6", TSModel(A, B, premises=premises), designed),
        Case("1024 vertices, n = 8", TSModel(many), analysed),
    ]


def designed(model: TSModel) -> Floats | None:
    return pdc(model, decay_rate=0.1).require()[0]


def analysed(model: TSModel) -> Floats | None:
    max_decay_rate(model)
    return None


def measured(case: Case) -> tuple[str, ...]:
    """Return a row of the table: medians of the repeats."""
    start = time.perf_counter()
    gains = case.solve(case.model)
    solve = time.perf_counter() - start
    certificate = certify(case.model, gains, decay_rate=0.05)
    claim = certificate.document["claims"][0]
    loop = ClaimedLoop.of(case.model, gains)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "certificate.json"
        proof = median(lambda: ClaimedLoop.of(case.model, gains).replay(claim))
        file = median(lambda: certificate.save(path))
        checked = median(lambda: check(path))
        size = path.stat().st_size
    return (
        f"{case.name}: {certificate.verdict.name}",
        str(len(loop.sizes)),
        f"{solve:.2f} s",
        f"{1e3 * proof:.0f} ms",
        f"{1e3 * file:.1f} ms",
        f"{100 * (proof + file) / solve:.0f} %",
        f"{1e3 * checked:.0f} ms",
        f"{size / 1000:.0f} kB",
    )


def median(run: Callable[[], object]) -> float:
    """Return the median time of repeated runs [s]."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


if __name__ == "__main__":
    main()
