"""What a search for gains takes, by numbers that were measured, before it is begun.

With g gains the double sum has N inequalities of n (n + 1) / 2 numbers each, over n (n + 1) / 2 +
g m n unknowns v.  A premise that both vertices and gains depend on triples N, because the pairs
(low, high) and (high, low) of its corners are one; with one gain for all rules it doubles N.

Measured on a plant with 8 premises, 4 states, 3 inputs, 4 to 128 rules (two 2 GHz cores, one
of them in use, Clarabel): one largest ellipsoid takes 0.3 s + 4 ms N + 5 us N n (n + 1) / 2 v; the
process takes 150 MB + 16 bytes N n (n + 1) / 2 v.  The proof takes some 50 ms for each inequality.
Other machines differ, by a factor of three say: these numbers choose a way, they decide nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.models.plant.design_settings import PlantSettings
    from takagi.models.ts.model import TSModel

# Problems that are solved where no decay rate is asked for, and for the largest one.
RATES, SEARCHED = 8, 20
# Measured (docs/plants.md): seconds for a problem, for an inequality in it, for an inequality
# times unknowns times entries, and for the proof of an inequality; then MB at the start, and MB for
# the same product.
FIXED, EACH, SOLVED, PROVED = 0.3, 4e-3, 5e-6, 0.05
BASE, STORED = 150.0, 16e-6


@dataclass(frozen=True, slots=True)
class WorkEstimate:
    """Size of a search for gains, the time of search and proof [s], and memory [MB]."""

    inequalities: int
    unknowns: int
    seconds: float
    megabytes: float

    @property
    def time(self) -> str:
        """The time to one or two digits, with its unit."""
        return _time(self.seconds)

    @property
    def words(self) -> str:
        """Time and memory to one or two digits."""
        return f"about {self.time} and {_memory(self.megabytes)}"


def work_of(
    rules: int, sizes: tuple[int, int], asked: PlantSettings, *, one_gain: bool, merged: bool = True
) -> WorkEstimate:
    """Return the estimate.

    Parameters
    ----------
    sizes : states n and inputs m.
    one_gain : for all rules, in the place of a gain for each.
    merged : whether rules are all corners of premises, whose pairs are partly one.
    """
    n, m = sizes
    premises = int(round(np.log2(rules)))
    if one_gain:
        inequalities = rules
    elif merged and 2**premises == rules:
        inequalities = 3**premises
    else:
        inequalities = rules * (rules + 1) // 2
    entries = n * (n + 1) // 2
    unknowns = entries + (1 if one_gain else rules) * m * n
    problems = {None: RATES, "max": SEARCHED}.get(asked.decay_rate, 1)  # type: ignore[arg-type]
    product = inequalities * entries * unknowns
    seconds = problems * (FIXED + EACH * inequalities + SOLVED * product) + PROVED * inequalities
    return WorkEstimate(inequalities, unknowns, seconds, BASE + STORED * product)


def effects(model: TSModel) -> Floats:
    """Return how much each premise moves the vertices, (p,): mean change over the sum of sizes.

    States are in units of their box, inputs in units of theirs, so that the units of the file do
    not matter where there are ranges.
    """
    s, tau = (_half_widths(model, names) for names in (model.states, model.inputs))
    whole = np.concatenate([model.A * s / s[:, None], model.B * tau / s[:, None]], axis=2)
    rules = np.array(model.rules)
    size = np.abs(whole).mean(axis=0).max() or 1.0
    found = []
    for k in range(len(model.premises)):
        ends = [whole[rules[:, k] == corner] for corner in (0, 1)]
        moved = ends[1].mean(axis=0) - ends[0].mean(axis=0) if len(ends[1]) else np.zeros(1)
        found.append(float(np.abs(moved).max() / size))
    return np.array(found)


def _half_widths(model: TSModel, names: tuple[str, ...]) -> Floats:
    """Return half of each range; of a blend's or a free variable's, 1."""
    ranges = [model.box.get(name) for name in names]
    return np.array([1.0 if ends is None else float(ends[1] - ends[0]) / 2 for ends in ranges])


def _time(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            count = seconds / size
            return f"{count:.0f} {unit}" if count >= 10 else f"{count:.2g} {unit}"
    return f"{max(seconds, 1.0):.0f} s"


def _memory(megabytes: float) -> str:
    return f"{megabytes / 1000:.2g} GB" if megabytes >= 1000 else f"{round(megabytes, -1):.0f} MB"
