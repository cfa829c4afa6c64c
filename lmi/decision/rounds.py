"""LMIs of very many items or vertices: the solver gets few, all are checked, the worst are added.

A no for some items is a no for all, and a least objective over some is below that over all; a yes
counts when every item was evaluated.  Items that are never given to the solver cost an eigenvalue.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.answer import Try
from takagi.lmi.condition.evaluate import (
    SMALLEST_MARGIN,
    holds,
    lmi_value,
    shares,
    smallest_eigenvalues,
)
from takagi.lmi.condition.statements import StatedCondition, condition_of
from takagi.lmi.condition.term import LMI, Condition, selected_items
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide, improve, optimise
from takagi.lmi.decision.outcome import Outcome
from takagi.models.arrays import Floats, Indices

# Up to so many items of an LMI are given to the solver at once: quicker than rounds.
ALL_AT_ONCE = 48
FIRST, ADDED, ROUNDS = 12, 12, 60
# Unknowns will do when the items left out keep this share of the margin of those given.
ENOUGH = 0.5
# Numbers in one piece of the items that are evaluated together; bounds the memory.
ENTRIES_AT_ONCE = 1_000_000


def decide_by_rounds(condition: Condition, *, rows: Mapping[str, float] | None = None) -> Outcome:
    """Return the unknowns with about the largest margin t <= 1 over all items.

    As ``decide``, but where items were left out the margin may be down to half the largest.
    Multipliers of items left out are zero.

    ``rows`` : as for ``decide``.
    """
    some = _Some.of(condition)
    return some.filled(_decided(some, rows))


def decide_some(condition: Condition, *, most: int = 99) -> tuple[Condition, Outcome]:
    """Return the condition with the items of the last round, and ``decide_by_rounds`` of them.

    The outcome's margin is over all items.  ``most`` : as for ``decide``, for each round.
    """
    some = _Some.of(condition)
    outcome = _decided(some, None, most)
    return (some.condition() if some.pieces else condition), outcome


def _decided(some: _Some, rows: Mapping[str, float] | None, most: int = 99) -> Outcome:
    """Return the outcome of the last round, its margin over all items."""
    tries: list[Try] = []
    for _ in range(ROUNDS):
        outcome = decide(some.condition(), rows=rows, most=most)
        tries += outcome.tries
        if outcome.status != "candidate":
            return replace(outcome, tries=tuple(tries))
        margins = some.margins(outcome.values)
        worst = _worst(margins, outcome.margin)
        if not some.add(margins, ENOUGH * outcome.margin):
            break
    outcome_of_all: Outcome = replace(outcome, margin=worst, tries=tuple(tries))
    return outcome_of_all if holds(some.whole, worst) else replace(outcome_of_all, status="unknown")


def optimise_by_rounds(condition: StatedCondition, *, slack: float = 1e-6) -> Outcome:
    """Return unknowns whose objective is near the least over all items, centred as ``optimise``.

    ``least`` is the bound for the items that were given to the solver, so it holds for all.

    ``slack`` : as for ``optimise``.
    """
    posed = condition_of(condition, "optimise_by_rounds")
    some = _Some.of(posed)
    tries: list[Try] = []
    for _ in range(ROUNDS):
        outcome = optimise(some.condition(), slack=slack)
        tries += outcome.tries
        if outcome.status == "unbounded" and some.add_next():
            # The items that were left out may bound it.
            continue
        if outcome.status != "candidate":
            break
        margins = some.margins(outcome.values)
        worst = _worst(margins, outcome.margin)
        outcome = replace(outcome, margin=worst)
        if holds(posed, worst) or not some.add(margins, SMALLEST_MARGIN):
            break
    if outcome.status == "candidate" and not holds(posed, outcome.margin):
        outcome = replace(outcome, status="unknown", settled=False)
    return some.filled(replace(outcome, tries=tuple(tries)))


def improve_by_rounds(condition: Condition, start: Outcome) -> Outcome:
    """Return the same as ``improve``, from the items that ``start`` was decided with.

    ``start`` : of ``decide_by_rounds``, whose multipliers are zero for the items that it left out.
    """
    some = _Some.of(condition)
    for k in some.chosen:
        carried = np.abs(start.multipliers[condition.lmis[k].name]).max(axis=(1, 2)) > 0
        some.chosen[k] = np.union1d(some.chosen[k], np.flatnonzero(carried))
    tries = start.tries
    for _ in range(ROUNDS):
        outcome = improve(some.condition(), replace(start, tries=()))
        tries += outcome.tries
        margins = some.margins(outcome.values)
        if not some.add(margins, 0.49 * start.margin):
            return replace(outcome, margin=_worst(margins, outcome.margin), tries=tries)
    return replace(start, tries=tries)


@dataclass(slots=True, eq=False)
class _Some:
    """The condition with some items of its long LMIs.

    whole : with all items.
    pieces : number of a long LMI -> all of it, in pieces.
    chosen : number of a long LMI -> the items that are given to the solver.
    """

    whole: Condition
    pieces: Mapping[int, tuple[LMI, ...]]
    chosen: dict[int, Indices]

    @classmethod
    def of(cls, condition: Condition) -> _Some:
        """Choose the items to begin with."""
        long = [k for k, lmi in enumerate(condition.lmis) if lmi.count > ALL_AT_ONCE]
        pieces = {k: tuple(_pieces(condition.lmis[k])) for k in long}
        some = cls(condition, pieces, {})
        some.chosen = {k: _first(condition, pieces[k]) for k in long}
        return some

    def condition(self) -> Condition:
        """Return the condition with the chosen items."""
        lmis = [
            selected_items(lmi, self.chosen[k]) if k in self.chosen else lmi
            for k, lmi in enumerate(self.whole.lmis)
        ]
        return replace(self.whole, lmis=tuple(lmis))

    def margins(self, values: Mapping[str, Floats]) -> dict[int, Floats]:
        """Return the margin of every item of the long LMIs, relative to their weights.

        Of a non-strict LMI: inf where the item holds, else the share of its size that it misses.
        """
        return {
            k: np.concatenate([_margins(self.whole, piece, values) for piece in pieces])
            for k, pieces in self.pieces.items()
        }

    def add(self, margins: Mapping[int, Floats], enough: float) -> bool:
        """Add the worst items of each LMI that are not chosen; return whether there were any."""
        added = False
        for k, item_margins in margins.items():
            required = enough if self.whole.lmis[k].strict else 0.0
            violated = np.flatnonzero(item_margins < required)
            violated = violated[~np.isin(violated, self.chosen[k])]
            worst = violated[np.argsort(item_margins[violated])[:ADDED]]
            self.chosen[k] = np.concatenate([self.chosen[k], worst])
            added = added or len(worst) > 0
        return added

    def add_next(self) -> bool:
        """Double the items, evenly over those left; return whether there were any."""
        added = False
        for k, chosen in self.chosen.items():
            remaining = np.setdiff1d(np.arange(self.whole.lmis[k].count), chosen)
            some = remaining[
                np.linspace(0, len(remaining) - 1, min(len(remaining), len(chosen))).astype(np.intp)
            ]
            self.chosen[k] = np.concatenate([chosen, np.unique(some)])
            added = added or len(some) > 0
        return added

    def filled(self, outcome: Outcome) -> Outcome:
        """Return the outcome with a multiplier for every item, zero where it was left out."""
        multipliers = dict(outcome.multipliers)
        for k, chosen in self.chosen.items():
            lmi = self.whole.lmis[k]
            if lmi.name in multipliers:
                every = np.zeros((lmi.count, lmi.size, lmi.size))
                every[chosen] = multipliers[lmi.name]
                multipliers[lmi.name] = every
        return replace(outcome, multipliers=multipliers)


def _margins(condition: Condition, lmi: LMI, values: Mapping[str, Floats]) -> Floats:
    if lmi.strict:
        return np.asarray(smallest_eigenvalues(condition, lmi, values) / lmi.weight)
    share = shares(condition, lmi, values)
    return np.where(share >= -lmi.tolerance, np.inf, share)


def _worst(margins: Mapping[int, Floats], others: float) -> float:
    return min([others, *(float(item_margins.min()) for item_margins in margins.values())])


def _pieces(lmi: LMI) -> Iterator[LMI]:
    step = max(1, ENTRIES_AT_ONCE // lmi.size**2)
    for start in range(0, lmi.count, step):
        yield selected_items(lmi, range(start, min(start + step, lmi.count)))


def _first(condition: Condition, pieces: tuple[LMI, ...]) -> Indices:
    """Return the items to begin with: worst at a round guess, and farthest from the mean.

    The guess is I for symmetric unknowns and 0 for the others; distance is seen through the LMI
    at fixed random unknowns, so it needs no knowledge of what the items are made of.
    """
    random = np.random.default_rng(1)
    guess = {X.name: _identity(X) for X in condition.unknowns}
    probe = {X.name: _random(X, random) for X in condition.unknowns}
    eigenvalues = np.concatenate(
        [smallest_eigenvalues(condition, piece, guess) for piece in pieces]
    )
    mean = lmi_value(pieces[0], probe, condition.parameters).mean(axis=0)
    distances = np.concatenate(
        [
            np.abs(lmi_value(piece, probe, condition.parameters) - mean).sum(axis=(1, 2))
            for piece in pieces
        ]
    )
    half = FIRST // 2
    return np.unique(
        np.concatenate([np.argsort(eigenvalues)[:half], np.argsort(-distances)[:half]])
    )


def _identity(X: Unknown) -> Floats:
    eye = np.eye(X.rows) if X.symmetric or X.scalar else np.zeros((X.rows, X.cols))
    return np.broadcast_to(eye, (X.count, X.rows, X.cols))


def _random(X: Unknown, random: np.random.Generator) -> Floats:
    value = random.normal(size=(X.count, X.rows, X.cols))
    return value + value.transpose(0, 2, 1) if X.symmetric else value


# Bounds the memory of the batched eigenvalues.
CHUNK = 20_000


def first_vertices(A: Floats) -> Indices:
    """Return which vertices to begin with: the slowest and the farthest from the mean."""
    if len(A) <= ALL_AT_ONCE:
        return np.arange(len(A))
    symmetric = A + A.transpose(0, 2, 1)
    slowest = np.argsort(-_largest(symmetric))[: FIRST // 2]
    distance = np.abs(A - A.mean(axis=0)).sum(axis=(1, 2))
    return np.unique(np.concatenate([slowest, np.argsort(-distance)[: FIRST // 2]]))


def _largest(symmetric: Floats) -> Floats:
    chunks = [
        np.linalg.eigvalsh(symmetric[k : k + CHUNK])[:, -1] for k in range(0, len(symmetric), CHUNK)
    ]
    return np.concatenate(chunks)
